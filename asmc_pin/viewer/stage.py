"""Where the ground lies, what the camera must see and what a base stands on, from the motions themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.viewer.drawing.drawn_bodies import DrawnArm

_DIRECTIONS = np.array([d for d in product((-1, 0, 1), repeat=3) if any(d)], dtype=np.float64)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


@dataclass(frozen=True)
class Stage:
    """The surroundings of one arm, upright, m.

    Attributes:
        low: Lower corner of the box that the motions sweep, shape (3,).
        high: Its upper corner, shape (3,).
        outline: Points of the sweep that lie furthest out, shape (n, 3): what the camera must see.
        centre: Middle of the base on the ground, shape (2,).
        radius: Of a circle that holds the base.
        azimuth: Direction from which it is looked at, about the vertical from the x axis, rad.
        pedestal: Height of the base's underside, where a pedestal should carry it; None where it stands on the
            ground, or where the arm moves under it.
    """

    low: Array
    high: Array
    outline: Array
    centre: Array
    radius: float
    azimuth: float
    pedestal: float | None

    @property
    def ground(self) -> float:
        """Height of the ground: the base's own, or lower where the arm reaches below."""
        return float(min(0.0, self.low[2]))


def stage(arm: DrawnArm, motions: Sequence[Array]) -> Stage:
    """The surroundings that some motions of an arm need.

    Args:
        arm: The arm.
        motions: Joint positions, each of shape (T, nv), rad or m; some hundred frames of all are looked at.
    """
    instants = np.concatenate([q[:: max(1, len(q) // 60)] for q in motions])
    poses = arm.upright @ arm.poses(instants)
    swept = []
    for index, body in enumerate(arm.bodies):
        if len(body.mesh.vertices):
            rotation, translation = poses[:, index, :3, :3], poses[:, index, None, :3, 3]
            swept.append(_furthest(body.mesh.vertices) @ np.swapaxes(rotation, -1, -2) + translation)
        else:
            swept.append(poses[:, index, None, :3, 3])
    base = swept[0].reshape(-1, 3)
    points = np.concatenate([points.reshape(-1, 3) for points in swept])
    low, high = points.min(axis=0), points.max(axis=0)
    reach = float((high - low).max())
    centre = (base.min(axis=0) + base.max(axis=0))[:2] / 2
    radius = float(np.linalg.norm(base[:, :2] - centre, axis=1).max())
    under = float(base[:, 2].min())
    moving = np.concatenate([points.reshape(-1, 3) for points in swept[1:]])
    in_the_way = (moving[:, 2] < under) & (np.linalg.norm(moving[:, :2] - centre, axis=1) < 1.5 * radius)
    floating = under - min(0.0, low[2]) > 0.01 * reach and not in_the_way.any()
    return Stage(
        low=low,
        high=high,
        outline=_furthest(points),
        centre=centre,
        radius=max(radius, 0.05 * reach),
        azimuth=_azimuth(arm, poses),
        pedestal=under if floating else None,
    )


def _azimuth(arm: DrawnArm, poses: Array) -> float:
    """From the front and a little from the side; a motion in one upright plane is looked at across that plane."""
    axes = np.stack([poses[:, k, :3, :3] @ body.axis for k, body in enumerate(arm.bodies) if body.joint >= 0], axis=1)
    first = axes[0, 0]
    if np.abs(axes @ first).min() < 0.99 or abs(first[2]) > 0.3 or any(body.prismatic for body in arm.bodies):
        return -0.62
    front = first if first @ np.array([0.3, -1.0, 0.0]) > 0 else -first
    return float(np.arctan2(front[1], front[0])) + 0.28


def _furthest(points: Array) -> Array:
    return np.asarray(points[np.unique(np.argmax(points @ _DIRECTIONS.T, axis=0))])
