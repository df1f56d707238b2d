"""Is M̄ allowed? Samples and a search over the joint box, along a motion, or in a tube around one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.clock import Clock
from asmc_pin.condition.condition_report import ConditionReport
from asmc_pin.condition.domain.along_motion import (
    FollowedMotion,
    check_units,
    motion_of,
    norms_along,
    tube,
    worst_in_tube,
)
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, Case, LockChoices, PayloadRange, cases
from asmc_pin.condition.domain.joint_box import BoxLike, idle_note
from asmc_pin.condition.domain.recorded_motion import Recording, read_recording, tde_error
from asmc_pin.condition.hypotheses import Where
from asmc_pin.condition.norm.two_conditions import Condition, check_condition, check_mbar
from asmc_pin.condition.premises import hypotheses_of
from asmc_pin.condition.search.samples import NORM
from asmc_pin.condition.search.what_would_help import what_would_help
from asmc_pin.condition.search.worst_case import SAMPLES, STARTS, maximise
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


_NAMED = 8  # cases that a note lists; a payload whose place is a range has dozens


class _Seen(NamedTuple):
    """The worst of one case."""

    norm: float
    q: Array
    armature: Array
    case: Case
    when: float | None


class _Outcome(NamedTuple):
    """What was seen over all cases: the norms at every sample, and along a motion the largest at each time."""

    where: Where
    seen: list[_Seen]
    cloud: Array
    configurations: int
    boxes: list[tuple[Array, Array]]
    method: str
    times: Array | None = None
    norms: Array | None = None
    motion: Array | None = None


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

    The norm is evaluated at low-discrepancy samples of the joint box, and maximised locally from the best of them. A
    counter-example refutes. Where none is found the verdict is ``unrefuted``, since samples never prove.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        condition: ``lemma1``: ‖I − M⁻¹M̄‖₂ < 1. ``weighted``: max|1 − λ(M⁻¹M̄)| < 1.
        box: {joint: (lo, hi)} in rad (m where prismatic); the other joints keep the arm's own range.
        payload: A payload, or a tuple of two: every mass between (same centre) is covered by its ends.
        armature: Values, or ranges as (lo, hi), covered by their ends; see `ArmatureRange`.
        lock: Joint to angle or to several angles, each of which is verified.
        along: An experiment, a reference, or recorded data (a `Recording`, or the path of its CSV file): the norm along
            it in place of the whole box. Recorded torque also gives the TDE error that M̄ would have made, on the
            first of the arms where there are ranges.
        tube_width: With `along`: also every configuration within this of the motion in the same time slice, rad (m).
        slices: Time slices of the tube.
        period: Spacing along a reference, and L of the TDE error, s; default the experiment's, else 1 ms, and the
            spacing of recorded data.
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
    clock = Clock()
    condition = check_condition(condition)
    all_cases = cases(arm, box, payload, armature, lock)
    first = all_cases[0].domain
    values = check_mbar(mbar, first.arm.nv)
    if along is None and tube_width is not None:
        raise ParameterError("tube_width", "is around a motion; give the motion with along")
    for name, count, least in (("starts", starts, 0), ("threads", threads, 1)):
        if not isinstance(count, int | np.integer) or count < least:
            raise ParameterError(name, f"{count!r} given, a whole number of at least {least} expected")
    error = None
    if along is None:
        outcome = _over_box(all_cases, values, condition, samples, starts, seed, threads)
    else:
        if isinstance(along, str | Path):
            if not Path(along).exists():
                raise ParameterError("along", f"{along}: no such file; an experiment goes as load_experiment(…)")
            along = read_recording(along, first.arm)
        motion = motion_of(along, first.arm.nv, period=period, duration=duration)
        check_units(first.arm, along, motion)
        if tube_width is None:
            outcome = _along_motion(all_cases, values, condition, motion)
        else:
            reach = (tube_width, slices)
            outcome = _in_tube(all_cases, values, condition, motion, reach, samples, starts, seed)
        if isinstance(along, Recording) and along.torque is not None:
            error = tde_error(first.arm, values, along, period=period)
    worst = max(outcome.seen, key=lambda item: item.norm)
    remedy = None
    if worst.norm >= 1.0:
        at = worst.case, worst.q, worst.armature
        over_box = outcome.where == "box"
        remedy = what_would_help(all_cases, condition, values, *at, over_box=over_box, seed=seed)
    return ConditionReport(
        hypotheses=hypotheses_of(all_cases, values, condition, where=outcome.where, boxes=outcome.boxes),
        verdict="violated" if worst.norm >= 1.0 else "unrefuted",
        kind="sampled",
        lower=worst.norm,
        upper=None,
        worst_q=worst.q,
        configurations=outcome.configurations,
        seconds=clock.seconds(),
        smallest=float(outcome.cloud.min()),
        worst_armature=worst.armature,
        samples=outcome.cloud,
        notes=tuple(_notes(all_cases, condition, worst.norm, outcome.where)),
        worst_case=worst.case.label,
        subject=worst.case.domain.arm,
        times=outcome.times,
        norms=outcome.norms,
        motion=outcome.motion,
        worst_time=worst.when,
        tde_error=error,
        method=(outcome.method,),
        remedy=remedy,
    )


def _over_box(
    all_cases: Sequence[Case], mbar: Array, condition: Condition, samples: int, starts: int, seed: int, threads: int
) -> _Outcome:
    kind = NORM[condition]
    found = [
        maximise(kind, case.domain, mbar, samples=samples, starts=starts, seed=seed, threads=threads)
        for case in all_cases
    ]
    box = all_cases[0].domain.box
    return _Outcome(
        "box",
        [_Seen(f.value, f.q, f.armature, case, None) for f, case in zip(found, all_cases, strict=True)],
        np.concatenate([f.samples for f in found]),
        sum(f.configurations for f in found),
        [(box.lower, box.upper)],
        f"{samples} scrambled Sobol samples of the joint box (seed {seed}), then local maximisation with exact "
        f"gradients from {starts} of them and more",
    )


def _along_motion(all_cases: Sequence[Case], mbar: Array, condition: Condition, motion: FollowedMotion) -> _Outcome:
    seen, tracks = [], []
    for case in all_cases:
        domain = case.domain
        ends = domain.armature_lower, domain.armature_upper
        norms, armature = norms_along(domain.arm, mbar, condition, motion.q, *ends)
        at = int(np.argmax(norms))
        seen.append(_Seen(float(norms[at]), motion.q[at], armature[at], case, float(motion.times[at])))
        tracks.append(norms)
    largest = np.max(tracks, axis=0)
    return _Outcome(
        "motion",
        seen,
        np.concatenate(tracks),
        motion.times.size * len(all_cases),
        [(motion.q.min(axis=0), motion.q.max(axis=0))],
        f"the norm at {motion.times.size} instants of {motion.name}",
        motion.times,
        largest,
        motion.q,
    )


def _in_tube(
    all_cases: Sequence[Case],
    mbar: Array,
    condition: Condition,
    motion: FollowedMotion,
    reach: tuple[float | Sequence[float] | Array, int],
    samples: int,
    starts: int,
    seed: int,
) -> _Outcome:
    parts = tube(motion, *reach, all_cases[0].domain.arm.joint_kinds)
    each = max(256, samples // len(parts))
    seen, tops, clouds, configurations = [], [], [], 0
    for case in all_cases:
        found = worst_in_tube(case, mbar, condition, parts, samples=each, starts=max(8, starts // 4), seed=seed)
        tops.append([item.value for item in found])
        at = int(np.argmax(tops[-1]))
        seen.append(_Seen(tops[-1][at], found[at].q, found[at].armature, case, parts[at].start))
        configurations += sum(item.configurations for item in found)
        clouds += [item.samples for item in found]
    return _Outcome(
        "tube",
        seen,
        np.concatenate(clouds),
        configurations,
        [(part.lower, part.upper) for part in parts],
        f"{each} samples (seed {seed}) and local maximisation in each of {len(parts)} time slices around {motion.name}",
        np.array([part.start for part in parts]),
        np.max(tops, axis=0),
    )


def _notes(all_cases: Sequence[Case], condition: Condition, norm: float, where: Where) -> list[str]:
    domain = all_cases[0].domain
    arm = domain.arm
    notes = []
    idle = idle_note(arm, domain.box)
    if where != "motion" and idle:
        notes.append(f"{idle}; held at the middle of the range")
    if condition == "lemma1" and len(set(arm.joint_kinds)) > 1:
        notes.append(
            "revolute and prismatic joints: the 2-norm adds rad to m, and its value depends on the units; "
            "the weighted condition does not"
        )
    if norm < 1.0:
        notes.append("sampled and searched, not proven: a sample can refute the condition but never prove it")
    if len(all_cases) > 1:
        named = [case.label for case in all_cases[:_NAMED]]
        rest = len(all_cases) - len(named)
        notes.append(f"{len(all_cases)} cases: " + "; ".join(named) + (f"; and {rest} more" if rest else ""))
    if np.any(domain.armature_upper > domain.armature_lower):
        notes.append("armature range: covered by its ends, since the condition is affine in the armature")
    return notes
