"""A proof that the plain sampled loop, frozen at every configuration of a joint box, is stable.

With K_s = k_s I the loop without gravity is stable exactly where every eigenvalue of M⁻¹M̄ lies between two numbers of
β, k_s and L (docs/stability.md), and that all of them do is two statements that the certificate's prover takes. Where
the eigenvalues are proven to keep away from these ends, a small gain covers gravity about rest too. The arm that moves
and whatever is not linear are no part of it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import fields
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin.clock import Clock
from asmc_pin.condition.certificate.proof_progress import ProofProgress
from asmc_pin.condition.certificate.stopping import GAP_MET, INTERRUPTED, OUT_OF_TIME
from asmc_pin.condition.certificate.walk import get_ready
from asmc_pin.condition.certificate.writing import seen
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, Case, LockChoices, PayloadRange, cases
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.condition.domain.payload_ranges import has_places
from asmc_pin.condition.inertia_bounds.eigenvalue_prover import EigenvalueProver
from asmc_pin.condition.inertia_bounds.extreme_eigenvalue import Extreme
from asmc_pin.condition.inertia_bounds.outward import above, below
from asmc_pin.condition.premises import ends_of, premises_of
from asmc_pin.controllers.law_registry import law_name
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.proof.gravity_proof import GravityForms, pieces_of, stiffness_bound
from asmc_pin.sampled.proof.loop_proof import LoopProof
from asmc_pin.sampled.sampled_loop import SampledLoop

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_SAMPLES, _STARTS = 2**12, 16

_CLOSE = 0.05
"""How near to what was seen the eigenvalues' range is to be proven for gravity's sake."""


def certify_loop(
    arm: Arm,
    loop: SampledLoop,
    *,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    budget: float = 60.0,
    threads: int = 2,
    seed: int = 0,
    progress: Callable[[ProofProgress], None] | None = None,
) -> LoopProof:
    """Prove or refute that the plain loop, frozen at every configuration, is stable; about rest under gravity too.

    Args:
        arm: The arm.
        loop: K_s = k_s I and one β, the velocity estimate, no filter and no delay.
        box: Joint box; the arm's own by default.
        payload: A payload, or a tuple of two: every mass between (same centre) is covered by its ends.
        armature: Values, or ranges as (lo, hi), covered by their ends, kg·m².
        lock: Joint to angle or to several angles, each of which is covered.
        budget: Wall time after which to stop, s.
        threads: Worker threads.
        seed: Of the search.
        progress: Called some times a second.

    Returns:
        What is proven; `LoopProof.save` writes it to a file.

    Raises:
        ParameterError: The loop is not of that form, or a range is malformed.
        NotPositiveDefinite: M(q) is not positive definite somewhere.
    """
    check_plain(loop)
    all_cases = tuple(cases(arm, box, payload, armature, lock))
    if loop.nv != (joints := all_cases[0].domain.arm.nv):
        raise ParameterError("loop", f"M̄ of {loop.nv} values given, {joints} expected, one per moving joint")
    get_ready()
    clock, began = Clock(), time.monotonic()
    least = Extreme(all_cases, loop.mbar, "least", samples=_SAMPLES, starts=_STARTS, seed=seed)
    largest = Extreme(all_cases, loop.mbar, "largest", samples=_SAMPLES, starts=_STARTS, seed=seed)
    began += clock.compiling()
    inverse_high, inverse_low = ends_of_stability(float(loop.ks[0]), float(loop.beta[0]), loop.period)
    limits = above(inverse_high), below(inverse_low)
    provers = [
        EigenvalueProver(all_cases, loop.mbar, extreme, began=began, budget=budget, threads=threads, progress=progress)
        for extreme in (least, largest)
    ]
    magnitude = float(np.linalg.norm(arm.gravity_vector))
    reason, pieces, no_gravity = INTERRUPTED, None, INTERRUPTED

    def refuted() -> bool:
        return Fraction(least.value) <= inverse_high or Fraction(largest.value) >= inverse_low

    try:
        for prover, limit in zip(provers, limits, strict=True):
            if refuted():
                break
            outcome = prover.try_bound(limit)
            if outcome != "proven":
                reason = OUT_OF_TIME if outcome == "stopped" else prover.why_not(limit)
                break
        else:
            reason = ""
            placed = has_places([case.domain.arm.payload for case in all_cases])
            if magnitude > 0.0 and not arm.mimics and not placed:
                pieces, no_gravity = _under_gravity(all_cases, loop, provers, (least, largest), magnitude)
            else:
                unknown = "range of the payload's place" if placed else "joints that mimic others"
                no_gravity = "there is none" if magnitude == 0.0 else f"its proof knows no {unknown}"
    except KeyboardInterrupt:
        pass
    verdict: Literal["stable", "unstable", "undecided"] = "undecided"
    if refuted():
        verdict, pieces = "unstable", None
    elif not reason:
        verdict = "stable"
    proofs = [proof for prover in provers for proof in prover.proofs.get("scale", ())] if verdict == "stable" else []
    first = all_cases[0].domain
    return LoopProof(
        about=premises_of(
            [case.domain.arm for case in all_cases], [ends_of(first.box)], (first.armature_lower, first.armature_upper)
        ),
        loop=loop,
        verdict=verdict,
        gravity=None if pieces is None else magnitude,
        stable_between=(above(1 / inverse_low), below(1 / inverse_high)),
        seen_between=(1.0 / largest.value, 1.0 / least.value),
        boxes=sum(proof.boxes for proof in proofs),
        seconds=clock.seconds(),
        reason=reason if verdict == "undecided" else "",
        no_gravity=no_gravity if verdict == "stable" else "",
        seen_at=(seen(least.q, least.armature, least.case), seen(largest.q, largest.armature, largest.case)),
        cases=all_cases,
        proofs=tuple(proofs),
        pieces=pieces,
    )


def _under_gravity(
    all_cases: Sequence[Case],
    loop: SampledLoop,
    provers: Sequence[EigenvalueProver],
    extremes: tuple[Extreme, Extreme],
    magnitude: float,
) -> tuple[GravityForms | None, str]:
    """Forms that prove it at rest under gravity, after a closer proof of the eigenvalues' range; or why none do."""
    stiffness = max(
        stiffness_bound(domain.arm.tree, domain.box.lower, domain.box.upper, loop.mbar, magnitude)
        for domain in (case.domain for case in all_cases)
    )
    gains = float(loop.ks[0]), float(loop.beta[0]), loop.period, stiffness
    least, largest = extremes
    # What does not hold where the search has been need not be tried over a wider range.
    if pieces_of(*gains, 1.0 / largest.value, 1.0 / least.value) is None:
        return None, "the small gain is too weak even between the eigenvalues found"
    for prover in provers:
        prover.raise_scale(_CLOSE)
    most, fewest = (prover.bound for prover in provers)
    assert most is not None
    assert fewest is not None
    pieces = pieces_of(*gains, below(1 / Fraction(fewest)), above(1 / Fraction(most)))
    if pieces is not None:
        return pieces, ""
    # Both met their gap, or one of them has something to say.
    stopped = next((prover.reason for prover in provers if prover.reason != GAP_MET), "")
    why = f"; it was proven no closer because: {stopped}" if stopped else f", proven to {_CLOSE:.0%}"
    return None, f"the small gain is too weak over the range of the eigenvalues{why}"


def ends_of_stability(ks: float, beta: float, period: float) -> tuple[Fraction, Fraction]:
    """1/a_hi and 1/a_lo exactly: the mode with eigenvalue a of M⁻¹M̄ is stable where 1/a lies between them."""
    k, b, length = Fraction(ks), Fraction(beta), Fraction(period)
    return Fraction(1, 2) + (b + k) * length / 4, Fraction(1, 2) + (b + k) / (b * k * length)


def check_plain(loop: SampledLoop) -> None:
    """The proof is of the plain loop only.

    Raises:
        ParameterError: It is another one; the message says what a proof needs.
    """
    odd = not_plain(loop)
    if odd is not None:
        raise ParameterError(*odd)


def not_plain(loop: SampledLoop) -> tuple[str, str] | None:
    """What of a loop no proof is made for, and why; None for the plain loop."""
    if loop.law is not None:
        said = f"a proof is of PPC's loop, not of that of {law_name(loop.law)}"
        if not getattr(loop.law, "estimates", False):
            return "law", said
        which = "" if loop.law.estimate_weight == 1.0 else ", which is that for cM̄"
        return "law", f"{said}; of this law the condition on M̄ can be proven{which}"
    if not loop.modal:
        return "ks", "a proof needs one k_s and one β for all joints: only then do the modes separate"
    gains_and_pair = ("mbar", "ks", "beta", "period", "pairing")
    plain = SampledLoop(loop.mbar, loop.ks, loop.beta, loop.period)
    for name in (item.name for item in fields(SampledLoop) if item.name not in gains_and_pair):
        given, expected = getattr(loop, name), getattr(plain, name)
        if given != expected:
            return name, f"{given!r} given; a proof is of the plain loop, with {expected!r}"
    return ("pairing", "a proof is of the plain loop, with the last torque") if loop.averages_torque else None
