"""Arms whose statements cover a range of the payload's place, all that lies between its ends included.

M is affine in a payload's mass, first moment m c and second moments m c cᵀ. For c between the corners c_v of its range
weights λ_v that are products of one factor an axis give c = Σ λ_v c_v and

    c cᵀ = Σ λ_v c_v c_vᵀ − diag(s),    s_i = (c_i − lo_i)(hi_i − c_i),  so 0 ≤ s_i ≤ (hi_i − lo_i)²/4.

So M(c) is a mix of the M(c_v), less the inertia of second moments m diag(s). What is affine in M and holds at all
corners c_v with every s_i at 0 and at its most, holds at every place between (docs/condition.md, Ranges).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.payload_ranges import has_places

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition.domain.arm_ranges import Case
    from asmc_pin.rigid_body.tree import Tree

_ROUNDING = 1e-12
"""Share by which second moments are larger, for the rounding of the range's width and its square."""


@dataclass(frozen=True, eq=False)
class Corner:
    """An arm that a statement is proven of.

    Attributes:
        case: Index of the case with the payload at this corner.
        tree: Its arm, with as much inertia taken off as stands for the places between.
        least: Whether no other with the payload there has less inertia: enough for what only asks for more.
        most: Whether no other has more: enough for what only asks for less.
    """

    case: int
    tree: Tree
    least: bool = True
    most: bool = True


def corners(cases: Sequence[Case]) -> list[Corner]:
    """The arms whose statements cover all that is between those of the cases."""
    loads = [case.domain.arm.payload for case in cases]
    if not has_places(loads):
        return [Corner(index, case.domain.arm.tree) for index, case in enumerate(cases)]
    places = np.array([load.com for load in loads if load is not None and load.mass > 0.0])
    low, high = places.min(axis=0), places.max(axis=0)
    most = (1.0 + _ROUNDING) * (0.5 * (high - low)) ** 2
    found = []
    for index, (case, load) in enumerate(zip(cases, loads, strict=True)):
        arm = case.domain.arm
        if load is None or load.mass == 0.0:
            found.append(Corner(index, arm.tree))
            continue
        at = np.array(load.com)
        if not np.all((at == low) | (at == high)):
            continue  # what is looked at between the corners is covered by them
        for share in product(*((0.0, 1.0) if width > 0.0 else (0.0,) for width in most)):
            tree = _less(arm, load.mass * np.array(share) * most)
            found.append(
                Corner(index, tree, least=bool(np.all((most == 0.0) | (np.array(share) == 1.0))), most=not any(share))
            )
    return found


def _less(arm: Arm, second: Array) -> Tree:
    """An arm's tree without the inertia of second moments along the axes of its payload's link, shape (3,), kg·m²."""
    payload, tree = arm.payload, arm.tree
    assert payload is not None
    links = (frame for frame in arm.model.frames if frame.type.name == "BODY")
    frame = next(frame for frame in links if frame.name == payload.link)
    turn = frame.placement.rotation
    inertia = np.array(tree.inertia)
    inertia[frame.parentJoint - 1] -= turn @ np.diag(second.sum() - second) @ turn.T
    inertia.setflags(write=False)
    return replace(tree, inertia=inertia)
