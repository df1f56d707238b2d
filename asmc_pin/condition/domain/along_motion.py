"""The condition along a motion, and in a tube around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.arm_ranges import Case
from asmc_pin.condition.domain.base_branches import branch_of, branches
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import NORM, Domain, figures_at
from asmc_pin.condition.search.worst_case import Found, maximise
from asmc_pin.errors import ParameterError
from asmc_pin.words.units import check_motion, check_reach

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

PERIOD = 1e-3


@dataclass(frozen=True, eq=False)
class FollowedMotion:
    """Configurations in time.

    Attributes:
        times: Shape (T,), s.
        q: Shape (T, nv), rad (m where prismatic).
        name: What it is, in words.
    """

    times: Array
    q: Array
    name: str


@dataclass(frozen=True, eq=False)
class Slice:
    """One time slice of a tube around a motion.

    Attributes:
        start: s.
        end: s.
        lower: Lower ends of the joint box, shape (nv,).
        upper: Upper ends, shape (nv,).
    """

    start: float
    end: float
    lower: Array
    upper: Array


def motion_of(along: Any, nv: int, *, period: float | None = None, duration: float | None = None) -> FollowedMotion:
    """The configurations of a motion, sampled at control ticks.

    Args:
        along: An experiment (its reference at its ticks), a reference, or recorded data with ``time`` and ``q``.
        nv: Joints of the arm.
        period: Spacing of the ticks, s; default the experiment's, else 1 ms.
        duration: s; default the experiment's, else the reference's.

    Returns:
        The motion.

    Raises:
        ParameterError: Another number of joints, or a motion that never ends and no duration.
    """
    if hasattr(along, "time") and hasattr(along, "q"):
        motion = FollowedMotion(np.asarray(along.time), np.asarray(along.q), getattr(along, "name", "recorded data"))
    else:
        name = getattr(along, "name", None)
        if hasattr(along, "build_reference"):
            period, duration = period or along.period, duration or along.duration
            along = along.build_reference()
        if not hasattr(along, "evaluate"):
            raise ParameterError(
                "along", f"{type(along).__name__} given; an experiment, a reference or recorded data expected"
            )
        duration = along.duration if duration is None else duration
        if not np.isfinite(duration) or duration <= 0.0:
            raise ParameterError("along", "the reference goes on for ever; give a duration in s")
        times = np.arange(round(duration / (period or PERIOD)) + 1) * (period or PERIOD)
        motion = FollowedMotion(times, along.evaluate(times).q, f"the reference of '{name}'" if name else "a reference")
    if motion.q.ndim != 2 or motion.q.shape[1] != nv:
        raise ParameterError("along", f"{motion.name} moves {motion.q.shape[-1]} joints, and the arm has {nv}")
    return motion


def check_units(arm: Arm, along: Any, motion: FollowedMotion) -> None:
    """Ask about a motion whose angles look like degrees.

    Args:
        arm: Whose joints move.
        along: What the motion was made of.
        motion: The motion.

    Raises:
        ParameterError: They are hardly meant in rad.
    """
    recorded = not hasattr(along, "evaluate") and not hasattr(along, "build_reference")
    check_motion("along", arm, motion.name, motion.times, motion.q, getattr(along, "v", None), recorded=recorded)


def norms_along(
    arm: Arm, mbar: Array, condition: Condition, q: Array, lower: Array, upper: Array
) -> tuple[Array, Array]:
    """The norm at each configuration, the largest over the ends of an armature range.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, shape (nv,).
        condition: ``lemma1`` or ``weighted``.
        q: Shape (T, nv).
        lower: Least armature, shape (nv,).
        upper: Largest armature, shape (nv,).

    Returns:
        The norms, shape (T,), and the armature that gives each, shape (T, nv).
    """
    largest = np.full(len(q), -np.inf)
    worst = np.empty_like(q)
    # Branch by branch: the blocks of M(q) have the ends of their own joints only.
    for joints in branches(arm.tree):
        tree, mine = branch_of(arm.tree, joints), np.ascontiguousarray(q[:, joints])
        best = np.full(len(q), -np.inf)
        for armature in armature_ends(lower[joints], upper[joints]):
            values = figures_at(NORM[condition], tree, mine, mbar[joints], armature)
            higher = values > best
            best[higher], worst[np.ix_(higher, joints)] = values[higher], armature
        largest = np.maximum(largest, best)
    return largest, worst


def armature_ends(lower: Array, upper: Array) -> Array:
    """Corners of an armature range, shape (2^ranged, nv): convexity makes one of them the worst."""
    corners = lower[None, :].copy()
    for joint in np.flatnonzero(upper > lower):
        other = corners.copy()
        other[:, joint] = upper[joint]
        corners = np.concatenate((corners, other))
    return corners


def tube(
    motion: FollowedMotion, width: float | Sequence[float] | Array, slices: int = 50, kinds: Sequence[str] = ()
) -> list[Slice]:
    """A tube around a motion: the joint box of each time slice, widened on both sides.

    Args:
        motion: The motion.
        width: How far from it, rad (m where prismatic); one value or one per joint.
        slices: Number of time slices.
        kinds: Whether each joint is ``revolute`` or ``prismatic``; all turn when omitted.

    Returns:
        The slices; neighbours share a tick, so that no configuration between two is left out.

    Raises:
        ParameterError: A width that is not one or nv non-negative numbers, or that is a turn or more; or no slice.
    """
    nv = motion.q.shape[1]
    reach = np.array(width, dtype=np.float64)
    if reach.shape not in ((), (nv,)) or not np.all(np.isfinite(reach)) or np.any(reach < 0.0):
        raise ParameterError("tube", f"{width!r} given, one or {nv} finite widths of zero or more expected")
    slides = np.array([kind == "prismatic" for kind in kinds or [""] * nv])
    check_reach("tube", np.broadcast_to(reach, (nv,)), slides)
    if slices < 1:
        raise ParameterError("slices", f"{slices} given, at least 1 expected")
    edges = np.unique(np.linspace(0, len(motion.times) - 1, slices + 1).round().astype(int))
    if edges.size == 1:
        edges = np.array([0, 0])
    found = []
    for first, last in pairwise(edges):
        part = motion.q[first : last + 1]
        box = part.min(axis=0) - reach, part.max(axis=0) + reach
        found.append(Slice(float(motion.times[first]), float(motion.times[last]), *box))
    return found


def worst_in_tube(
    case: Case, mbar: Array, condition: Condition, slices: Sequence[Slice], *, samples: int, starts: int, seed: int
) -> list[Found]:
    """Search every slice of a tube, each with its own samples; what was found in each."""
    found = []
    for part in slices:
        box = resolve_box(case.domain.arm, (part.lower, part.upper))
        domain = Domain(case.domain.arm, box, case.domain.armature_lower, case.domain.armature_upper)
        found.append(maximise(NORM[condition], domain, mbar, samples=samples, starts=starts, seed=seed))
    return found
