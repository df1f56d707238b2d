"""Proofs that an option asks for: made under a progress bar, kept short by Ctrl-C, and written to their file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from asmc_pin.cli import interrupt
from asmc_pin.cli.console import note, progress_bar
from asmc_pin.cli.options import check_output
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import BoundsReport, ConditionReport
    from asmc_pin.sampled import LoopProof, SampledLoop


Left = TypeVar("Left")


class Provable(Protocol):
    """What a proof leaves."""

    @property
    def cases(self) -> Sequence[Any]: ...  # noqa: D102
    def save(self, path: str | Path) -> Path: ...  # noqa: D102


def check_proof_options(certify: bool, certificate: str | None) -> None:
    """A certificate is what a proof leaves."""
    if certificate is not None and not certify:
        raise ParameterError("--certificate", "is what --certify proves: add --certify")
    check_output(certificate)


def condition_proof(
    arm: Arm, mbar: float | list[float], found: ConditionReport, certificate: str | None, **options: Any
) -> ConditionReport:
    """Join a search's report with a proof of the same statement; after Ctrl-C with what is proven by then."""
    from asmc_pin.condition.certificate import certify
    from asmc_pin.condition.certificate.search_and_proof import certified

    def doing(state: Any) -> str:
        return f"proven M̄ × {state.proven:.4g}, refuted × {state.refuted:.4g}, {state.trying}"

    result = _under_a_bar(lambda tell: certify(arm, mbar, progress=tell, **options), doing, options["budget"])
    _keep(result, certificate, proven=bool(result.proofs))
    return certified(found, result)


def loop_proof(arm: Arm, loop: SampledLoop, certificate: str | None, **options: Any) -> LoopProof:
    """What can be proven of a loop without gravity; after Ctrl-C undecided."""
    from asmc_pin.sampled.proof.loop_certificate import certify_loop

    def doing(state: Any) -> str:
        return f"proving the {state.trying} of M against M̄"

    proof = _under_a_bar(lambda tell: certify_loop(arm, loop, progress=tell, **options), doing, options["budget"])
    _keep(proof, certificate, proven=proof.verdict != "undecided")
    return proof


def inertia_proof(arm: Arm, certificate: str | None, **options: Any) -> BoundsReport:
    """How large M(q) is over the box, proven; after Ctrl-C as far as it got."""
    from asmc_pin.condition import bounds

    def doing(state: Any) -> str:
        return f"{state.trying}: found {state.refuted:.4g}, proven {state.proven:.4g}"

    report = _under_a_bar(lambda tell: bounds(arm, progress=tell, **options), doing, 0.5 * options["budget"])
    _keep(report, certificate, proven=bool(report.proofs))
    return report


def _under_a_bar(proof: Callable[[Callable[[Any], None]], Left], doing: Callable[[Any], str], seconds: float) -> Left:
    """Run a proof with its progress on standard error; Ctrl-C ends it where it is."""
    with interrupt.stopping_short() as go_on, progress_bar() as show:

        def tell(state: Any) -> None:
            go_on()
            show(doing(state), min(state.seconds / seconds, 1.0))

        return proof(tell)


def _keep(result: Provable, certificate: str | None, *, proven: bool) -> None:
    """Write a proof to the file that was named, or say why there is none."""
    if certificate is None:
        return
    from asmc_pin.condition.certificate.writing import unwritable

    if why := unwritable(result.cases):
        note(f"{why}; none was written to {certificate}")
    elif proven:
        note(f"certificate: {result.save(certificate)}")
    else:
        note(f"nothing is proven, so no certificate was written to {certificate}")
