"""A proof over the whole joint box, as far as it goes in the time given."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.clock import Clock
from asmc_pin.condition.certificate.certificate_result import CertificateResult, Verdict
from asmc_pin.condition.certificate.proof_progress import ProofProgress
from asmc_pin.condition.certificate.stopping import FREED, INTERRUPTED
from asmc_pin.condition.certificate.strategy import Prover
from asmc_pin.condition.certificate.walk import get_ready
from asmc_pin.condition.certificate.worst_known import Worst
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, LockChoices, PayloadRange
from asmc_pin.condition.domain.joint_box import BoxLike, idle_note
from asmc_pin.condition.domain.statement_cases import domains
from asmc_pin.condition.norm.two_conditions import Condition, check_condition, check_mbar
from asmc_pin.condition.premises import hypotheses_of
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

SAMPLES = 2**12
STARTS = 16
"""A light search: where it misses something, the proof stops there and the search goes on from that spot."""


def certify(
    arm: Arm,
    mbar: Any,
    *,
    condition: Condition = "lemma1",
    gap: float = 0.01,
    budget: float = 60.0,
    level: float | None = None,
    levels: bool = True,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    along: Any = None,
    tube_width: float | Sequence[float] | Array | None = None,
    slices: int = 50,
    period: float | None = None,
    duration: float | None = None,
    threads: int = 2,
    samples: int = SAMPLES,
    starts: int = STARTS,
    seed: int = 0,
    progress: Callable[[ProofProgress], None] | None = None,
) -> CertificateResult:
    """Prove or refute a condition over a whole joint box, or in a tube around a motion.

    A search finds a factor of M̄ at which the condition breaks. Proofs raise a factor at which it holds, until the two
    are within `gap` of each other and M̄ itself is decided. Then, where it holds, lower and lower levels γ of the norm
    are proven. Whenever it stops, by its budget or by an interrupt from the keyboard, the result says what is proven.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        condition: ``lemma1``: ‖I − M⁻¹M̄‖₂ < 1. ``weighted``: max|1 − λ(M⁻¹M̄)| < 1, that is M̄ ≺ 2M.
        gap: Relative distance of the scales proven and refuted at which to stop, in (0, 1).
        budget: Wall time after which to stop, s; compiling, once after installation, is not counted.
        level: Ask for norm < level in place of norm < 1, in (0, 1]; then nothing is said about multiples of M̄.
        levels: Whether to lower the proven bound of the norm below 1, in at most twice the time of the scale's proof.
        box: {joint: (lo, hi)} in rad (m where prismatic); the other joints keep the arm's own range.
        payload: A payload, or a tuple of two: every mass between (same centre) is covered by its ends.
        armature: Values, or ranges as (lo, hi), covered by their ends.
        lock: Joint to angle or to several angles, each of which is proven.
        along: An experiment, a reference or recorded data: a tube around it in place of the joint box.
        tube_width: The tube: all that is within this of the motion in the same time slice, rad (m).
        slices: Time slices of the tube, each with a joint box of its own.
        period: Spacing along a reference, s; default the experiment's, else 1 ms.
        duration: How long to follow the reference, s; default the experiment's, else its own.
        threads: Worker threads.
        samples: Samples of the search.
        starts: Its local climbs.
        seed: Of the samples.
        progress: Called some times a second.

    Returns:
        What is proven and what is refuted; `CertificateResult.save` writes the proof to a file.

    Raises:
        ParameterError: Wrong sizes, signs, NaN, empty ranges, unknown joints.
        ArmError: A prismatic joint has no range.
        NotPositiveDefinite: M(q) is not positive definite somewhere.
    """
    condition = check_condition(condition)
    number = int | float | np.number
    _check("gap", gap, isinstance(gap, number) and 0.0 < gap < 1.0, "a number between 0 and 1")
    _check("budget", budget, isinstance(budget, number) and budget > 0.0, "a positive number of seconds")
    _check("threads", threads, threads >= 1, "at least 1")
    if level is not None:
        _check("level", level, 0.0 < level <= 1.0, "a number above 0 and at most 1")
    all_cases, where, boxes = domains(
        arm,
        box=box,
        payload=payload,
        armature=armature,
        lock=lock,
        along=along,
        tube_width=tube_width,
        slices=slices,
        period=period,
        duration=duration,
    )
    first = all_cases[0].domain.arm
    values = check_mbar(mbar, first.nv)
    get_ready()
    clock, began = Clock(), time.monotonic()
    if where == "tube":
        samples, starts = max(256, samples // slices), max(4, starts // slices)
    worst = Worst(all_cases, values, condition, samples, starts, seed)
    began += clock.compiling()  # the search compiles too, and the budget is not for that
    prover = Prover(all_cases, values, condition, worst, began=began, budget=budget, threads=threads, progress=progress)
    asked = 1.0 if level is None else level
    try:
        if asked < 1.0:
            prover.lower_level(budget, goal=asked)
        else:
            prover.raise_scale(gap)
            if levels and prover.scale >= 1.0:
                prover.lower_level(max(2.0, 2.0 * (time.monotonic() - began)))
    except KeyboardInterrupt:
        prover.reason = INTERRUPTED
    upper = prover.level if prover.level is not None else (1.0 if prover.scale >= 1.0 else None)
    verdict: Verdict = "undecided"
    if worst.norm >= asked or (asked == 1.0 and worst.scale <= 1.0):
        verdict = "violated"
    elif upper is not None and upper <= asked:
        verdict = "holds"
    proofs = prover.proofs.get("scale", ()) + prover.proofs.get("level", ())
    counted = prover.proofs.get("scale" if asked == 1.0 else "level", ())
    return CertificateResult(
        hypotheses=hypotheses_of(all_cases, values, condition, where=where, boxes=boxes, level=asked),
        level=asked,
        verdict=verdict,
        lower=worst.norm,
        upper=upper,
        scale_proven=prover.scale,
        scale_refuted=worst.scale,
        worst_q=worst.norm_q,
        worst_armature=worst.norm_armature,
        worst_case=all_cases[worst.norm_case].label,
        worst_index=worst.norm_case,
        refuted_q=worst.scale_q,
        refuted_armature=worst.scale_armature,
        refuted_index=worst.scale_case,
        boxes=sum(proof.boxes for proof in counted),
        tests=prover.tests + worst.evaluations,
        seconds=clock.seconds(),
        history=tuple(prover.history),
        reason=prover.reason,
        notes=_notes(all_cases[0]),
        cases=all_cases,
        proofs=proofs,
    )


def _check(name: str, value: float, good: bool, expected: str) -> None:
    if not good or not np.isfinite(value):
        raise ParameterError(name, f"{value} given, {expected} expected")


def _notes(case: Any) -> tuple[str, ...]:
    said = idle_note(case.domain.arm, case.domain.box)
    notes = (said,) if said else ()
    return (*notes, FREED) if case.domain.arm.mimics else notes
