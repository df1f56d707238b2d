"""Bodies that look invented, and joints that hardly feel any."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from asmc_pin.arms.bodies.at_a_glance import least_felt
from asmc_pin.arms.bodies.moving_bodies import MovingBody
from asmc_pin.arms.urdf.rigid_inertia import tensor_problem
from asmc_pin.inspection.subject_of_doubt import Doubt, SubjectOfDoubt, some

_ROUND = {base * 10.0**power for power in range(-6, 2) for base in (1.0, 2.0, 5.0)}
"""kg·m²: what somebody types who has no number."""

_UNFELT = 1e-3
"""m; a joint whose load has its mass within a millimetre of the axis has next to no inertia."""


def body_doubts(subject: SubjectOfDoubt, root: Any) -> Iterator[Doubt]:
    """Doubts about what moves.

    Args:
        subject: The robot.
        root: Its ``<robot>`` element.
    """
    yield from _placeholders(subject)
    yield from _unfelt(subject)
    yield from _efforts(subject, root)
    bodies = [sized.body for sized in subject.bodies]
    if bodies and not any(body.joint.friction or body.joint.damping for body in bodies):
        text = "no joint declares friction or damping: a plant has none either, unless it is given some"
        yield Doubt("friction", (), text, serious=False)


def _placeholders(subject: SubjectOfDoubt) -> Iterator[Doubt]:
    groups: dict[bytes, list[str]] = {}
    inertials = subject.parts.robot.inertials
    moving = [link for sized in subject.bodies for link in sized.body.links if link in inertials]
    heaviest = max((inertials[link].mass for link in moving), default=0.0)
    for link in moving:
        own = inertials[link]
        # A tensor of next to nothing is a point mass, and says so.
        if own.mass > 1e-3 * heaviest and np.max(np.abs(own.written)) > 1e-10 * own.mass:
            groups.setdefault(own.written.tobytes(), []).append(link)
    for links in groups.values():
        if len(links) < 2:
            continue
        tensor = inertials[links[0]].written
        masses = [inertials[link].mass for link in links]
        isotropic = bool(np.array_equal(tensor, tensor[0, 0] * np.eye(3)))
        is_round = isotropic and any(math.isclose(tensor[0, 0], value) for value in _ROUND)
        # Like links are like bodies, where the number is not one that somebody typed.
        if max(masses) > 1.1 * min(masses) or is_round:
            shape = f"{tensor[0, 0]:g} about every axis" if isotropic else "the same"
            kilograms = "" if max(masses) == min(masses) else f", at masses of {min(masses):g} to {max(masses):g} kg"
            text = f"inertia of {some(links)} is {shape}{kilograms}: looks like a placeholder"
            yield Doubt("placeholder", tuple(links), text)


def _unfelt(subject: SubjectOfDoubt) -> Iterator[Doubt]:
    parts = subject.parts
    if any(fault.kind == "axis" for fault in parts.robot.faults):
        return
    # What carries a body that cannot be feels nothing that it should.
    possible = [_is_possible(sized.body) for sized in subject.bodies]
    for index in range(parts.model.njoints - 1, 0, -1):
        if parts.model.parents[index] > 0:
            possible[parts.model.parents[index] - 1] &= possible[index - 1]
    least = least_felt(parts.model) + subject.armature
    carried = [sized.body.mass for sized in subject.bodies]
    for index in range(parts.model.njoints - 1, 0, -1):
        if parts.model.parents[index] > 0:
            carried[parts.model.parents[index] - 1] += carried[index - 1]
    found = [
        sized.body.joint.name
        for sized, inertia, mass, judged in zip(subject.bodies, least.tolist(), carried, possible, strict=True)
        if judged and sized.body.joint.kind == "revolute" and inertia < _UNFELT**2 * mass
    ]
    if found:
        text = f"next to nothing resists {some(found)}: the mass is on the axis; rotors (armature) will decide M there"
        yield Doubt("unresisted", tuple(found), text)


def _is_possible(body: MovingBody) -> bool:
    known = body.mass > 0.0 and bool(np.all(np.isfinite(body.inertia)))
    return known and not tensor_problem(body.mass, body.inertia)


def _efforts(subject: SubjectOfDoubt, root: Any) -> Iterator[Doubt]:
    moving = {sized.body.joint.name for sized in subject.bodies}
    zero: dict[str, list[str]] = {"effort": [], "velocity": []}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if joint.get("name") not in moving or limit is None:
            continue
        for what, names in zero.items():
            if limit.get(what) is not None and float(limit.get(what)) == 0.0:
                names.append(joint.get("name"))
    for what, names in zero.items():
        if names:
            text = f"{what} limit zero at {some(names)}: taken as undeclared"
            yield Doubt(f"zero {what}", tuple(names), text, serious=False)
