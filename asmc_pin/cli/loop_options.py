"""Options of the sampled loop, and its proof, for the commands that speak of one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from asmc_pin.cli import interrupt
from asmc_pin.cli.console import note, progress_bar
from asmc_pin.cli.options import NO_CERTIFICATE
from asmc_pin.words.choices import Acceleration

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.sampled import LoopProof, SampledLoop

AccelerationOption: TypeAlias = Annotated[
    Acceleration, typer.Option("--acceleration", metavar="velocity|position", help="How q̈(t−L) is estimated.")
]
FilterOption: TypeAlias = Annotated[
    float | None, typer.Option("--filter-hz", metavar="HZ", help="First-order low-pass on that estimate.")
]
DelayOption: TypeAlias = Annotated[
    float, typer.Option("--delay", metavar="PERIODS", help="Transport delay of the torque, fractions allowed.")
]


def loop_proof_of(arm: Arm, loop: SampledLoop, certificate: str | None, **options: Any) -> LoopProof:
    """What can be proven of a loop without gravity; after Ctrl-C undecided."""
    from asmc_pin.sampled.proof.loop_certificate import certify_loop

    budget = options["budget"]
    with interrupt.stopping_short() as go_on, progress_bar() as show:

        def tell(state: Any) -> None:
            go_on()
            show(f"proving the {state.trying} of M against M̄", min(state.seconds / budget, 1.0))

        proof = certify_loop(arm, loop, progress=tell, **options)
    if certificate is not None:
        if arm.mimics:
            note(f"{NO_CERTIFICATE}; none was written to {certificate}")
        elif proof.verdict != "undecided":
            note(f"certificate: {proof.save(certificate)}")
        else:
            note(f"nothing is proven, so no certificate was written to {certificate}")
    return proof
