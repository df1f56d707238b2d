"""How a user's variant of an arm is read: locked joints, reflected inertia, mounting."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.reading import Robot
from asmc_pin.arms.registry import nearest
from asmc_pin.errors import ParameterError

GRAVITY = (0.0, 0.0, -9.81)
Lock = Mapping[str, "float | str | None"]


def resolve_locks(robot: Robot, default: Mapping[str, float], lock: Lock | None) -> dict[str, float]:
    """Which joints stand still, and where.

    Args:
        robot: The checked URDF.
        default: Locks of the registry's entry.
        lock: The user's: joint to value (rad, m); None or ``"free"`` frees a joint that is locked by default.

    Returns:
        Joint to value, joints that mimic a locked one included.

    Raises:
        ParameterError: An unknown joint, or a value that is not a finite number.
    """
    locked: dict[str, float] = dict(default)
    freed = set()
    for name, value in (lock or {}).items():
        if name in robot.fixed:
            raise ParameterError("lock", f"joint '{name}' is fixed in the URDF already; leave it out")
        if name not in robot.joints:
            raise ParameterError(
                "lock", f"no joint '{name}' in {robot.document.path.name}; {nearest(name, list(robot.joints))}"
            )
        if value is None or value == "free":
            locked.pop(name, None)
            freed.add(name)
            continue
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number):
            unit = "m" if robot.joints[name].kind == "prismatic" else "rad"
            raise ParameterError("lock", f"joint '{name}': {value!r} given, a number in {unit} or \"free\" expected")
        locked[name] = number
    given = set(lock or {})
    for name, joint in robot.joints.items():
        if joint.mimic is None or name in given:
            continue
        master = joint.mimic.joint
        if master in locked:
            locked[name] = joint.mimic.multiplier * locked[master] + joint.mimic.offset
    return locked


def resolve_armature(
    joints: Sequence[str],
    default: Mapping[str, float],
    armature: float | Sequence[float] | Array | Mapping[str, float] | None,
) -> Array:
    """Reflected rotor inertia of each moving joint, kg·m².

    Args:
        joints: Names of the moving joints.
        default: Values of the registry's entry.
        armature: What the user sets in their place: one value for all, one per joint, or a mapping that leaves the others alone.

    Returns:
        Shape (nv,).

    Raises:
        ParameterError: A wrong size, an unknown joint, a negative or non-finite value.
    """
    values = np.array([default.get(name, 0.0) for name in joints])
    if isinstance(armature, Mapping):
        for name, value in armature.items():
            if name not in joints:
                raise ParameterError("armature", f"no moving joint '{name}'; {nearest(name, list(joints))}")
            values[list(joints).index(name)] = value
    elif armature is not None:
        given = _numbers("armature", armature)
        if given.shape not in ((), (1,), (len(joints),)):
            raise ParameterError(
                "armature", f"{given.size} values given, 1 or {len(joints)} expected ({', '.join(joints)})"
            )
        values[:] = given
    if not np.all(np.isfinite(values)) or np.any(values < 0.0):
        raise ParameterError("armature", f"{values.tolist()} given, finite values of zero or more expected, kg·m²")
    return values


def resolve_gravity(gravity: Sequence[float] | Array | None) -> Array:
    """Acceleration of gravity in the base frame, shape (3,), m/s²."""
    value = _numbers("gravity", GRAVITY if gravity is None else gravity)
    if value.shape != (3,) or not np.all(np.isfinite(value)):
        raise ParameterError(
            "gravity",
            f"{gravity!r} given, three finite numbers expected: the acceleration in the base frame, m/s², such as "
            "(0, 0, 9.81) for an arm on the ceiling or (9.81, 0, 0) on a wall",
        )
    return value


def _numbers(parameter: str, value: Any) -> Array:
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(parameter, f"{value!r} given, numbers expected") from None
