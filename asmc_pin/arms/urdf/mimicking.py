"""Joints that mimic others: which coordinate each joint follows, and what that leaves of the coordinate's limits.

value = multiplier · master + offset holds exactly, as a rigid gear or linkage does. So a mimicking joint has no
coordinate: it brings inertia, friction and limits to the joint that it follows (docs/arms.md).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from asmc_pin.arms.urdf.faults import Fault
from asmc_pin.arms.urdf.magnitudes import LENGTH, RATIO
from asmc_pin.arms.urdf.urdf_reading import Joint, Mimic, Robot
from asmc_pin.rigid_body.coupling import Coupling

_ROUNDING = 1e-9
"""rad, m: by so much two limits may contradict each other, as written in decimals."""


@dataclass(frozen=True)
class SettledMimics:
    """The joints of an arm, settled.

    Attributes:
        coupling: Of all joints that move, in the model's order.
        driven: The joints that have a coordinate, with the friction and the limits that their followers bring.
        mimics: Name of each joint that follows to the driven joint that it follows, at the end of the way.
        notes: What followers leave of limits, in plain words.
        faults: Couplings that cannot be; the joints of these are taken as driven.
    """

    coupling: Coupling
    driven: tuple[Joint, ...]
    mimics: Mapping[str, Mimic]
    notes: tuple[str, ...]
    faults: tuple[Fault, ...] = ()


def settle_mimics(robot: Robot, joints: Sequence[Joint], lock: Collection[str]) -> SettledMimics:
    """Find what follows what.

    Args:
        robot: The checked URDF.
        joints: Joints that move, in the model's order; what follows a locked joint is not among them.
        lock: Joints that the user named; one that is freed by name follows nobody.

    Returns:
        The joints.
    """
    follows = {joint.name: joint.mimic for joint in joints if joint.mimic is not None and joint.name not in lock}
    mimics: dict[str, Mimic] = {}
    faults: dict[frozenset[str], Fault] = {}
    for name in follows:
        found = _master(robot, name, follows)
        if isinstance(found, Mimic):
            mimics[name] = found
        else:
            faults.setdefault(frozenset(found.about), found)
    numbers = {joint.name: k for k, joint in enumerate(joint for joint in joints if joint.name not in mimics)}
    own = Mimic("", 1.0, 0.0)
    coupling = Coupling(
        np.array([numbers[mimics[j.name].joint if j.name in mimics else j.name] for j in joints], dtype=np.int64),
        np.array([mimics.get(joint.name, own).multiplier for joint in joints]),
        np.array([mimics.get(joint.name, own).offset for joint in joints]),
        np.flatnonzero([joint.name not in mimics for joint in joints]),
    )
    driven, notes = [], []
    for joint in joints:
        if joint.name not in mimics:
            behind = [(other, mimics[other.name]) for other in joints if _is_followed(mimics, other, joint)]
            merged, said = _merged(joint, behind)
            driven.append(merged)
            notes += said
    return SettledMimics(coupling, tuple(driven), mimics, tuple(notes), tuple(faults.values()))


def _is_followed(mimics: Mapping[str, Mimic], other: Joint, joint: Joint) -> bool:
    return other.name in mimics and mimics[other.name].joint == joint.name


def _master(robot: Robot, name: str, follows: Mapping[str, Mimic]) -> Mimic | Fault:
    """The joint at the end of the way, and how it is followed; or why there is none."""
    place = robot.joints[name].where
    at, multiplier, offset, way = name, 1.0, 0.0, [name]
    while at in follows:
        step = follows[at]
        offset += multiplier * step.offset
        multiplier *= step.multiplier
        at = step.joint
        if at in way:
            around = way[way.index(at) :]
            ring = " → ".join(f"'{item}'" for item in [*around, at])
            return Fault(
                "mimic",
                tuple(around),
                f"{place}: joints mimic each other in a ring, {ring}, so none of them leads; mend <mimic>, or free one "
                f"by name: lock={{'{at}': 'free'}} (--lock {at}=free)",
            )
        way.append(at)
    if not (1.0 / RATIO <= abs(multiplier) <= RATIO and abs(offset) <= LENGTH):
        return Fault(
            "mimic",
            (name,),
            f"{place}: it mimics '{at}' as {multiplier:g} · '{at}' + {offset:g}; ratios from {1.0 / RATIO:g} to "
            f"{RATIO:g} are computed with; mend <mimic>",
        )
    return Mimic(at, multiplier, offset)


def _merged(joint: Joint, behind: Sequence[tuple[Joint, Mimic]]) -> tuple[Joint, list[str]]:
    """A joint with what its followers bring, and what is to be said of its limits."""
    if not behind:
        return joint, []
    lower, upper, velocity = joint.lower, joint.upper, joint.velocity
    friction, damping = joint.friction, joint.damping
    notes = []
    for other, mimic in behind:
        ends = sorted((limit - mimic.offset) / mimic.multiplier for limit in (other.lower, other.upper))
        who = f"joint '{other.name}' mimics '{joint.name}', and its limits {other.lower:g} … {other.upper:g}"
        if min(upper, ends[1]) - max(lower, ends[0]) <= _ROUNDING < upper - lower:
            # Files are written with limits that nobody reads there, zero to a turn for a joint that goes back.
            notes.append(f"{who} leave '{joint.name}' no range within {lower:g} … {upper:g}: not regarded, mend them")
        elif ends[0] > lower + _ROUNDING or ends[1] < upper - _ROUNDING:
            lower, upper = max(lower, ends[0]), min(upper, ends[1])
            notes.append(f"{who} narrow those of '{joint.name}' to {lower:.6g} … {upper:.6g}")
        velocity = min(velocity, other.velocity / abs(mimic.multiplier))
        friction += abs(mimic.multiplier) * other.friction
        damping += mimic.multiplier**2 * other.damping
    endless = joint.continuous and not (np.isfinite(lower) or np.isfinite(upper))
    merged = replace(
        joint,
        continuous=endless,
        lower=lower,
        upper=upper,
        velocity=velocity,
        friction=friction,
        damping=damping,
    )
    return merged, notes
