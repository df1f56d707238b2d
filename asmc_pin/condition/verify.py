"""Is M̄ allowed? Samples and a search over the joint box, along a motion, or in a tube around one."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.along import motion_of, norms_along, tube, worst_in_tube
from asmc_pin.condition.box import BoxLike
from asmc_pin.condition.lemma1 import Condition, check_condition, check_mbar
from asmc_pin.condition.report import ConditionReport
from asmc_pin.condition.search import NORM, SAMPLES, STARTS, maximise
from asmc_pin.condition.variants import ArmatureRange, Case, LockChoices, PayloadRange, cases

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


class _Seen(NamedTuple):
    """The worst of one case."""

    norm: float
    q: Array
    armature: Array
    label: str
    when: float | None


def verify(
    arm: Arm,
    mbar: Any,
    *,
    condition: Condition = "lemma1",
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    along: Any = None,
    tube_width: float | Sequence[float] | Array | None = None,
    slices: int = 50,
    period: float | None = None,
    duration: float | None = None,
    samples: int = SAMPLES,
    starts: int = STARTS,
    seed: int = 0,
    threads: int = 1,
) -> ConditionReport:
    """Look for a configuration at which M̄ breaks a condition.

    Low-discrepancy samples of the joint box and local maximisation from the best of them. What is found refutes; where
    nothing is found the verdict is ``unrefuted``, since a sample never proves.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        condition: ``lemma1``: ‖I − M⁻¹M̄‖₂ < 1. ``weighted``: max|1 − λ(M⁻¹M̄)| < 1.
        box: {joint: (lo, hi)} in rad (m where prismatic); the other joints keep the arm's own range.
        payload: A payload, or a tuple of two: every mass between (same centre) is covered by its ends.
        armature: Values, or ranges as (lo, hi), covered by their ends; see `ArmatureRange`.
        lock: Joint to angle or to several angles, each of which is verified.
        along: An experiment, a reference or recorded data: the norm along it in place of the whole box.
        tube_width: With `along`: also every configuration within this of the motion in the same time slice, rad (m).
        slices: Time slices of the tube.
        period: Spacing along a reference, s; default the experiment's, else 1 ms.
        duration: How long to follow the reference, s; default the experiment's, else its own.
        samples: Samples of the box (over all slices together in a tube).
        starts: Local climbs.
        seed: Of the samples; the same seed gives the same report but for the time it took.
        threads: Worker threads of the sampling.

    Returns:
        The report.

    Raises:
        ParameterError: Wrong sizes, signs, NaN, empty ranges, unknown joints.
        ArmError: A prismatic joint has no range.
        NotPositiveDefinite: M(q) is not positive definite somewhere.
    """
    began = time.perf_counter()
    condition = check_condition(condition)
    all_cases = cases(arm, box, payload, armature, lock)
    first = all_cases[0].domain
    values = check_mbar(mbar, first.arm.nv)
    seen: list[_Seen] = []
    times = norms = None
    configurations = 0
    if along is None:
        scope = "box"
        clouds = []
        for case in all_cases:
            found = maximise(
                NORM[condition], case.domain, values, samples=samples, starts=starts, seed=seed, threads=threads
            )
            seen.append(_Seen(found.value, found.q, found.armature, case.label, None))
            configurations += found.configurations
            clouds.append(found.samples)
        cloud = np.concatenate(clouds)
        ends = first.box.lower, first.box.upper
        method = [f"{samples} scrambled Sobol samples of the joint box, and local maximisation from {starts} of them"]
    else:
        motion = motion_of(along, first.arm.nv, period=period, duration=duration)
        if tube_width is None:
            scope = "motion"
            tracks = [_along_motion(case, values, condition, motion.times, motion.q) for case in all_cases]
            seen = [track[0] for track in tracks]
            times, norms = motion.times, np.max([track[1] for track in tracks], axis=0)
            cloud, configurations = norms, len(motion.times) * len(all_cases)
            ends = motion.q.min(axis=0), motion.q.max(axis=0)
            method = [f"the norm at {len(motion.times)} instants of {motion.name}"]
        else:
            scope = "tube"
            parts = tube(motion, tube_width, slices)
            each = max(256, samples // len(parts))
            clouds, tops = [], []
            for case in all_cases:
                top, all_found = worst_in_tube(
                    case, values, condition, parts, samples=each, starts=max(8, starts // 4), seed=seed
                )
                tops.append(top)
                at = int(np.argmax(top))
                seen.append(_Seen(float(top[at]), all_found[at].q, all_found[at].armature, case.label, parts[at].start))
                configurations += sum(item.configurations for item in all_found)
                clouds += [item.samples for item in all_found]
            cloud = np.concatenate(clouds)
            times, norms = np.array([part.start for part in parts]), np.max(tops, axis=0)
            ends = np.min([p.lower for p in parts], axis=0), np.max([p.upper for p in parts], axis=0)
            method = [f"{each} samples and local maximisation in each of {len(parts)} time slices around {motion.name}"]
    worst = max(seen, key=lambda item: item.norm)
    return ConditionReport(
        arm=arm.name,
        sha256=arm.sha256,
        joints=first.arm.joint_names,
        mbar=values,
        condition=condition,
        verdict="violated" if worst.norm >= 1.0 else "unrefuted",
        kind="sampled",
        lower=worst.norm,
        upper=None,
        worst_q=worst.q,
        configurations=configurations,
        seconds=time.perf_counter() - began,
        box=ends,
        smallest=float(cloud.min()),
        worst_armature=worst.armature,
        samples=cloud,
        notes=tuple(_notes(all_cases, condition, worst.norm, scope)),
        worst_case=worst.label,
        times=times,
        norms=norms,
        worst_time=worst.when,
        scope=scope,  # type: ignore[arg-type]
        method=tuple(method),
    )


def _along_motion(case: Case, mbar: Array, condition: Condition, times: Array, q: Array) -> tuple[_Seen, Array]:
    domain = case.domain
    norms, armature = norms_along(domain.arm, mbar, condition, q, domain.armature_lower, domain.armature_upper)
    at = int(np.argmax(norms))
    return _Seen(float(norms[at]), q[at], armature[at], case.label, float(times[at])), norms


def _notes(all_cases: list[Case], condition: Condition, norm: float, scope: str) -> list[str]:
    domain = all_cases[0].domain
    arm, box = domain.arm, domain.box
    notes = []
    idle = [name for name, idles in zip(arm.joint_names, box.idle, strict=True) if idles]
    if scope != "motion" and idle:
        names = ", ".join(f"'{name}'" for name in idle)
        notes.append(
            f"M(q) does not depend on joint {names}, which carries the whole arm; it is held at the middle of its range"
        )
    if condition == "lemma1" and len(set(arm.joint_kinds)) > 1:
        notes.append(
            "revolute and prismatic joints: the 2-norm adds rad to m, and its value depends on the units; "
            "the weighted condition does not"
        )
    if norm < 1.0:
        notes.append("sampled and searched, not proven: a sample can refute the condition but never prove it")
    if len(all_cases) > 1:
        notes.append(f"{len(all_cases)} cases: " + "; ".join(case.label for case in all_cases))
    if np.any(domain.armature_upper > domain.armature_lower):
        notes.append("armature range: covered by its ends, since the condition is affine in the armature")
    return notes
