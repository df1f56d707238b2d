"""The 3-D page of an inspection: the arm drawn pale, with what it is computed with inside it."""

from __future__ import annotations

from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.viewer import Mark, PlayedMotion, ball, describe, draw, replay_element, replay_page, rod, with_marks

_ELLIPSOID, _CENTRE, _AXIS = (0, 114, 178), (213, 94, 0), (0, 158, 115)
_PALE, _CLEAR = 0.5, 0.25


def inspection_page(arm: Arm) -> str:
    """HTML of one page that opens offline: the joints move from one end of their ranges to the other.

    An ellipsoid is the uniform one with the body's mass and inertia: it is as large as the body should be.

    Args:
        arm: The arm.
    """
    drawn = with_marks(draw(arm), _marks(arm), _PALE)
    lower, upper = arm.box
    rest = np.clip(np.zeros(arm.nv), lower, upper)
    time, q = _tour(rest, lower, upper)
    motion = PlayedMotion(label=arm.name, colour="#0072B2", q=q)
    description: dict[str, Any] = describe(drawn, arm.joint_names, time, [motion], None)
    notes = (
        "Blue: the ellipsoid of uniform density with each body's mass and inertia. Orange: centres of mass. Green: "
        "axes. The joints move one after the other, from rest to a fifth of their ranges.",
        *drawn.notes,
    )
    return replay_page(f"{arm.name}: what is computed with", f"{arm.nv} joints", replay_element(description, notes))


def _tour(rest: Array, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Joint after joint up and back, 2 s each; times (T,), s, and configurations (T, nv)."""
    nv = rest.size
    time = np.linspace(0.0, 2.0 * nv, 60 * nv + 1)
    phase = time[:, None] - 2.0 * np.arange(nv)
    swing = np.where((phase >= 0.0) & (phase < 2.0), np.sin(np.pi * phase), 0.0)
    room = 0.2 * np.minimum(upper - lower, 2.0 * np.pi)
    return time, np.clip(rest + swing * room, lower, upper)


def _marks(arm: Arm) -> list[Mark]:
    tree = arm.tree
    reach = sum(float(np.linalg.norm(step)) for step in tree.translation) or 0.5
    size = reach / max(arm.nv, 1)
    marks = []
    for k in range(tree.mass.size):
        moments, axes = np.linalg.eigh(tree.inertia[k])
        second = np.maximum(0.5 * moments.sum() - moments, 0.0)
        # A uniform ellipsoid has the second moments m a²/5.
        half = np.clip(np.sqrt(5.0 * second / tree.mass[k]), 0.002 * reach, 3.0 * reach)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = axes * half, tree.com[k]
        marks.append(Mark(k + 1, ball(1.0, _ELLIPSOID).moved(pose), _CLEAR))
        centre = np.eye(4)
        centre[:3, 3] = tree.com[k]
        marks.append(Mark(k + 1, ball(0.06 * size, _CENTRE).moved(centre), 1.0))
        along = tree.axis[k] * 0.45 * size
        marks.append(Mark(k + 1, rod(-along, along, 0.018 * size, _AXIS), 1.0))
    return marks
