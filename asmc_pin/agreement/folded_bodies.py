"""Links that are no rigid body alone, folded into what they are fixed to: MuJoCo judges every link by itself.

What moves may be possible although a dummy in it is not. The folding is done here by the definition of inertia, so that
MuJoCo's reading of poses and its recursions stay independent of what it is compared with.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from asmc_pin._typing import Array

_IMPOSSIBLE = 1e-9
"""Of the largest moment: what is beyond a rounding."""


def fold_impossible(spec: Any) -> None:
    """Fold rigid groups that contain an impossible link into one body each; what stands still gets a harmless one.

    Args:
        spec: MuJoCo's specification, locked joints removed; changed.
    """
    bodies = [body for body in spec.bodies if body.name != "world"]
    heads: dict[str, Any] = {}
    for body in bodies:  # parents come first
        heads[body.name] = body if body.joints else heads.get(body.parent.name)
    groups: dict[str, list[Any]] = {}
    for body in bodies:
        head = heads[body.name]
        if head is not None:
            groups.setdefault(head.name, []).append(body)
        elif _is_impossible(body):
            _set(body, 1.0, np.zeros(3), np.eye(3))  # whatever stands still has no part in the dynamics
    for group in groups.values():
        if any(_is_impossible(body) for body in group):
            _fold(group)


def _is_impossible(body: Any) -> bool:
    tensor = _tensor(body)
    moments = np.linalg.eigvalsh(tensor)
    slack = _IMPOSSIBLE * float(np.abs(moments).max())
    return bool(moments[0] < -slack or moments[2] > moments[0] + moments[1] + slack)


def _fold(group: list[Any]) -> None:
    """Put the inertia of a rigid group into its first body, and none into the others."""
    poses = {group[0].name: (np.eye(3), np.zeros(3))}
    parts = []
    for body in group:
        if body.name not in poses:
            turn, place = poses[body.parent.name]
            poses[body.name] = (turn @ _rotation(body.quat), place + turn @ np.array(body.pos))
        turn, place = poses[body.name]
        own = turn @ _rotation(body.iquat)
        parts.append((float(body.mass), place + turn @ np.array(body.ipos), own @ _tensor(body) @ own.T))
    mass = sum(m for m, _, _ in parts)
    if not mass > 0.0:
        return
    com = sum((m * c for m, c, _ in parts), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for m, c, about in parts:
        arm = c - com
        tensor += about + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    _set(group[0], mass, com, tensor)
    for body in group[1:]:
        _set(body, 0.0, np.zeros(3), np.full((3, 3), np.nan))
        body.explicitinertial = False


def _set(body: Any, mass: float, com: Array, tensor: Array) -> None:
    body.mass, body.ipos, body.iquat = mass, com, [1.0, 0.0, 0.0, 0.0]
    body.fullinertia = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]


def _tensor(body: Any) -> Array:
    full = np.array(body.fullinertia)
    if not np.all(np.isfinite(full)):
        return np.zeros((3, 3))
    xx, yy, zz, xy, xz, yz = full
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _rotation(quaternion: Any) -> Array:
    w, *xyz = np.array(quaternion) / np.linalg.norm(quaternion)
    x, y, z = xyz
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross)
