"""How large is M(q)? Eigenvalues, condition number and velocity forces, proven over a joint box."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.clock import Clock
from asmc_pin.condition.certificate.proof_progress import ProofProgress
from asmc_pin.condition.certificate.stopping import INTERRUPTED
from asmc_pin.condition.certificate.walk import get_ready
from asmc_pin.condition.certificate.writing import Proof, seen
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, Case, LockChoices, PayloadRange, cases
from asmc_pin.condition.domain.joint_box import BoxLike, idle_note
from asmc_pin.condition.domain.payload_ranges import has_places
from asmc_pin.condition.inertia_bounds.bounds_report import Bound, BoundsReport
from asmc_pin.condition.inertia_bounds.eigenvalue_prover import EigenvalueProver
from asmc_pin.condition.inertia_bounds.extreme_eigenvalue import Extreme, Side
from asmc_pin.condition.inertia_bounds.outward import above, below, products
from asmc_pin.condition.inertia_bounds.seen import largest_condition_number, largest_velocity_forces
from asmc_pin.condition.inertia_bounds.velocity_force_bound import velocity_force_bound
from asmc_pin.condition.premises import ends_of, premises_of
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_SAMPLES, _STARTS = 2**12, 16
_SIDES: tuple[Side, Side] = ("least", "largest")


def bounds(
    arm: Arm,
    *,
    scaling: Any = 1.0,
    gap: float = 0.01,
    budget: float = 60.0,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    threads: int = 2,
    seed: int = 0,
    progress: Callable[[ProofProgress], None] | None = None,
) -> BoundsReport:
    """Prove m₁ I ⪯ S M(q) S ⪯ m₂ I over a joint box, and bounds of its condition number and of the velocity forces.

    Each of m₁ and m₂ is brought to within `gap` of the value that a search finds. Whenever it stops, by its budget or
    by an interrupt from the keyboard, the report says what is proven.

    Args:
        arm: The arm.
        scaling: Diagonal of S, one value or nv of them: q̇ = S x. With different units or sizes of joints the
            eigenvalues of M alone mean little.
        gap: Relative distance of proven and found at which to stop, in (0, 1).
        budget: Wall time for the proofs, s, half of it for each; compiling, once after installation, is not counted.
        box: {joint: (lo, hi)} in rad (m where prismatic); the other joints keep the arm's own range.
        payload: A payload, or a tuple of two: every mass between (same centre) is covered by its ends.
        armature: Values, or ranges as (lo, hi), covered by their ends, kg·m².
        lock: Joint to angle or to several angles, each of which is covered.
        threads: Worker threads.
        seed: Of the searches.
        progress: Called some times a second, with the bound proven and the value found in place of scales.

    Returns:
        What is proven and what was found; `BoundsReport.save` writes the proofs to a file.

    Raises:
        ParameterError: Wrong sizes, signs, NaN, empty ranges, unknown joints.
        ArmError: A prismatic joint has no range.
        NotPositiveDefinite: M(q) is not positive definite somewhere.
    """
    for name, value, most in (("gap", gap, 1.0), ("budget", budget, np.inf)):
        if not (isinstance(value, int | float | np.number) and 0.0 < value < most):
            expected = "a number between 0 and 1" if name == "gap" else "a positive number of seconds"
            raise ParameterError(name, f"{value!r} given, {expected} expected")
    all_cases = tuple(cases(arm, box, payload, armature, lock))
    first = all_cases[0].domain
    scale = _checked(scaling, first.arm.nv)
    weights = 1.0 / scale**2
    get_ready()
    clock = Clock()
    extremes = [Extreme(all_cases, weights, side, samples=_SAMPLES, starts=_STARTS, seed=seed) for side in _SIDES]
    proven: list[float | None] = [None, None]
    reasons = [INTERRUPTED, INTERRUPTED]
    proofs: list[Proof] = []
    tests = sum(extreme.evaluations for extreme in extremes)
    try:
        for k, extreme in enumerate(extremes):
            prover = EigenvalueProver(
                all_cases,
                weights,
                extreme,
                began=time.monotonic(),
                budget=0.5 * budget,
                threads=threads,
                progress=progress,
            )
            try:
                prover.raise_scale(gap)
            finally:
                proven[k], reasons[k] = prover.bound, prover.reason or INTERRUPTED
                proofs += prover.proofs.get("scale", ())
                tests += prover.tests
    except KeyboardInterrupt:
        pass
    exact = products(weights.tolist(), scale.tolist())
    low = None if proven[0] is None else below(Fraction(proven[0]) * min(exact))
    high = None if proven[1] is None else above(Fraction(proven[1]) * max(exact))
    least, largest = extremes
    return BoundsReport(
        about=premises_of(
            [case.domain.arm for case in all_cases], [ends_of(first.box)], (first.armature_lower, first.armature_upper)
        ),
        scaling=scale,
        lower=Bound(low, least.value, least.q),
        upper=Bound(high, largest.value, largest.q),
        condition_number=_condition_number(all_cases, scale, low, high, np.stack((least.q, largest.q)), seed),
        coriolis=_coriolis(all_cases, scale, high, seed),
        boxes=sum(proof.boxes for proof in proofs),
        tests=tests,
        seconds=clock.seconds(),
        reasons=(reasons[0], reasons[1]),
        notes=_notes(all_cases, scale),
        seen_at=(seen(least.q, least.armature, least.case), seen(largest.q, largest.armature, largest.case)),
        cases=all_cases,
        proofs=tuple(proofs),
    )


def _checked(scaling: Any, nv: int) -> Array:
    try:
        values = np.array(np.broadcast_to(np.asarray(scaling, dtype=np.float64), (nv,)))
    except (TypeError, ValueError):
        raise ParameterError("scaling", f"{scaling!r} given, one number or {nv} numbers expected") from None
    if not np.all(np.isfinite(values) & (values >= 1e-6) & (values <= 1e6)):
        raise ParameterError("scaling", f"{values.tolist()} given, numbers from 1e-6 to 1e6 expected")
    return values


def _condition_number(
    all_cases: Sequence[Case], scaling: Array, low: float | None, high: float | None, also: Array, seed: int
) -> Bound:
    """No eigenvalue is above m₂ and none below m₁; nothing closer is proven."""
    seen_largest = largest_condition_number(all_cases, scaling, also, seed)
    proven = None if low is None or high is None else above(Fraction(high) / Fraction(low))
    return Bound(proven, seen_largest.value, seen_largest.q)


def _coriolis(all_cases: Sequence[Case], scaling: Array, high: float | None, seed: int) -> Bound:
    seen_largest = largest_velocity_forces(all_cases, scaling, seed)
    if has_places([case.domain.arm.payload for case in all_cases]) or all_cases[0].domain.arm.mimics:
        return Bound(None, seen_largest.value, seen_largest.q)
    # Velocity forces are affine in a payload's mass, and a norm is convex: the ends of a range cover it.
    proven = max(
        velocity_force_bound(domain.arm.tree, domain.box.lower, domain.box.upper, scaling, high)
        for domain in (case.domain for case in all_cases)
    )
    return Bound(proven, seen_largest.value, seen_largest.q)


def _notes(all_cases: Sequence[Case], scaling: Array) -> tuple[str, ...]:
    domain = all_cases[0].domain
    notes = []
    idle = idle_note(domain.arm, domain.box)
    if idle:
        notes.append(idle)
    if len(set(domain.arm.joint_kinds)) > 1 and np.all(scaling == 1.0):
        notes.append("revolute and prismatic joints: eigenvalues add kg·m² to kg; give a scaling of the joints")
    if has_places([case.domain.arm.payload for case in all_cases]):
        notes.append("velocity forces: no c is proven over a range of the payload's place; ask for each place alone")
    if domain.arm.mimics:
        notes.append(
            "velocity forces: no c is proven where joints mimic others, for the proof is one of joints that move "
            "freely; what was found is what a search saw"
        )
    return tuple(notes)
