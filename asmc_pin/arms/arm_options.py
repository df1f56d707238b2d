"""How a user's variant of an arm is read: locked joints, reflected inertia, mounting, payload."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.payload import Payload, as_payload
from asmc_pin.arms.published_armature import PUBLISHED, PUBLISHED_ARMATURE, how_to_measure
from asmc_pin.arms.registry import ArmEntry
from asmc_pin.arms.urdf.magnitudes import GRAVITY as LARGEST_GRAVITY
from asmc_pin.arms.urdf.magnitudes import INERTIA, LENGTH
from asmc_pin.arms.urdf.urdf_reading import Robot
from asmc_pin.errors import ParameterError
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.provisos import PUBLISHED_ARMATURE_USED, SIMULATED_ARMATURE_USED, Proviso
from asmc_pin.words.text import printable
from asmc_pin.words.units import check_angle, check_gravity

GRAVITY = (0.0, 0.0, -9.81)
Load = float | str | Payload | Mapping[str, Any]
Armature = float | Sequence[float] | Array | Mapping[str, float] | Literal["published"]
Lock = Mapping[str, "float | str | None"]
Gravity = Sequence[float] | Array
ChainEnds = tuple[str, str]


class Unchanged:
    """Stands for an option of `Arm.replace` that was not given; None means "as if it had never been given"."""


UNCHANGED = Unchanged()


@dataclass(frozen=True)
class Variant:
    """The options of `load_arm`, copied, so that nobody changes them afterwards; None is what was not given."""

    payload: Payload | None = None
    armature: Array | dict[str, float] | Literal["published"] | None = None
    lock: dict[str, float | str | None] | None = None
    gravity: Array | None = None
    repair: bool | None = None
    chain: ChainEnds | None = None


def read_variant(
    *,
    payload: Load | None = None,
    armature: Armature | None = None,
    lock: Lock | None = None,
    gravity: Gravity | None = None,
    repair: bool | None = None,
    chain: ChainEnds | None = None,
) -> Variant:
    """Copy and check what can be checked without the arm.

    Raises:
        ParameterError: Something is not a number, or has the wrong size.
    """
    if lock is not None and not isinstance(lock, Mapping):
        raise ParameterError("lock", f"{lock!r} given, joint to angle expected, as a dictionary")
    return Variant(
        payload=as_payload(payload),
        armature=_armature(armature),
        lock=dict(lock) if lock is not None else None,
        gravity=_gravity(gravity),
        repair=_switch("repair", repair),
        chain=_ends(chain),
    )


def resolve_locks(robot: Robot, default: Mapping[str, float], lock: Lock | None) -> dict[str, float]:
    """Which joints stand still, and where.

    Args:
        robot: The checked URDF.
        default: Locks of the registry's entry.
        lock: The user's: joint to value (rad, m); None or ``"free"`` frees a joint that is locked by default.

    Returns:
        Joint to value; a joint that mimics a locked or fixed one, or nothing of it (multiplier 0), is locked at the
        value that follows.

    Raises:
        ParameterError: An unknown joint, or a value that is not a finite number.
    """
    locked = dict(default)
    for name, value in (lock or {}).items():
        if name in robot.fixed:
            raise ParameterError("lock", f"joint '{name}' is fixed in {robot.path.name} already; leave it out")
        if name not in robot.joints:
            raise ParameterError("lock", f"no joint '{name}' in {robot.path.name}; {nearest(name, list(robot.joints))}")
        if value is None or value == "free":
            locked.pop(name, None)
            continue
        unit = "m" if robot.joints[name].kind == "prismatic" else "rad"
        try:
            locked[name] = float(value)
        except (TypeError, ValueError, OverflowError):
            locked[name] = math.nan
        if not math.isfinite(locked[name]):
            raise ParameterError("lock", f"joint '{name}': {value!r} given, a number in {unit} or \"free\" expected")
        if abs(locked[name]) > LENGTH:
            raise ParameterError("lock", f"joint '{name}': {value!r} given, at most {LENGTH:g} {unit} expected")
        joint = robot.joints[name]
        if joint.kind == "revolute":
            check_angle("lock", name, locked[name], joint.lower, joint.upper, joint.continuous)
    followers = {name: j.mimic for name, j in robot.joints.items() if j.mimic and name not in (lock or {})}
    # A follower may follow a follower; each pass settles at least one more link of such a chain.
    for _ in followers:
        for name, mimic in followers.items():
            if mimic.multiplier == 0.0 or mimic.joint in locked or mimic.joint in robot.fixed:
                locked[name] = mimic.multiplier * locked.get(mimic.joint, 0.0) + mimic.offset
                if not abs(locked[name]) <= LENGTH:
                    where = robot.joints[name].where
                    raise ParameterError("lock", f"{where}: follows '{mimic.joint}' to {locked[name]:g}; mend <mimic>")
    return locked


def resolve_armature(
    joints: Sequence[str],
    default: Mapping[str, float],
    armature: Array | Mapping[str, float] | None,
    followers: Sequence[str] = (),
) -> Array:
    """Reflected rotor inertia of each moving joint, kg·m².

    Args:
        joints: Names of the driven joints.
        default: Values of the registry's entry.
        armature: What the user sets in their place: one value for all driven joints, one per driven joint, or a mapping
            that leaves the other joints alone.
        followers: Names of the joints that mimic them; a mapping may give their own, at their own axis.

    Returns:
        Of the driven joints, then of the followers, shape (n,).

    Raises:
        ParameterError: A wrong size, an unknown joint, a negative or non-finite value.
    """
    values = np.array([default.get(name, 0.0) for name in (*joints, *followers)])
    if isinstance(armature, Mapping):
        for name, value in armature.items():
            if name not in joints and name not in followers:
                raise ParameterError("armature", f"no moving joint '{name}'; {nearest(name, list(joints))}")
            number = _numbers(f"armature.{name}", value)
            if number is None or number.shape != ():
                raise ParameterError(f"armature.{name}", f"{value!r} given, one number expected, kg·m²")
            values[[*joints, *followers].index(name)] = number
    elif armature is not None:
        if armature.shape not in ((), (1,), (len(joints),)):
            expected = f"1 or {len(joints)} expected ({', '.join(joints)})"
            raise ParameterError("armature", f"{armature.size} values given, {expected}")
        values[: len(joints)], values[len(joints) :] = armature, 0.0
    if not np.all(np.isfinite(values)) or np.any(values < 0.0):
        raise ParameterError("armature", f"{values.tolist()} given, finite values of zero or more expected, kg·m²")
    if np.any(values > INERTIA):
        raise ParameterError("armature", f"{values.tolist()} given, values of at most {INERTIA:g} expected, kg·m²")
    return values


def _armature(armature: Armature | None) -> Array | dict[str, float] | Literal["published"] | None:
    if isinstance(armature, Mapping):
        return dict(armature)
    if isinstance(armature, str):
        if armature != PUBLISHED:
            raise ParameterError("armature", f"{armature!r} given, numbers in kg·m² or '{PUBLISHED}' expected")
        return "published"
    return _numbers("armature", armature)


def published_for(entry: ArmEntry | None, name: str, joints: Sequence[str]) -> tuple[dict[str, float], Proviso]:
    """What is published of an arm's rotors.

    Args:
        entry: The registry's, where the arm was asked for by name; a file of one's own may be another robot.
        name: Of the arm, for messages.
        joints: Names of its moving joints.

    Returns:
        Joint to reflected inertia, kg·m²; and from where it is.

    Raises:
        ParameterError: Nothing is; the message says how it can be measured.
    """
    found = None if entry is None else PUBLISHED_ARMATURE.get(entry.name)
    if found is None:
        own = f"; {entry.name} has its own already, leave it out" if entry is not None and entry.armature else ""
        raise ParameterError(
            "armature",
            f"no published rotor inertia is known for {printable(name)} (for {', '.join(PUBLISHED_ARMATURE)} there is)"
            f"{own or f'. {how_to_measure(name)}'}",
        )
    values = {joint: value for joint, value in found.armature.items() if joint in joints}
    said = f"from {found.source}. How sure: {found.certainty}"
    return values, Proviso(SIMULATED_ARMATURE_USED if found.simulated else PUBLISHED_ARMATURE_USED, said)


def _gravity(gravity: Gravity | None) -> Array | None:
    value = _numbers("gravity", gravity)
    if value is not None and (value.shape != (3,) or not np.all(np.isfinite(value))):
        raise ParameterError(
            "gravity",
            f"{gravity!r} given, three finite numbers expected: the acceleration in the base frame, m/s², such as "
            "(0, 0, 9.81) for an arm on the ceiling or (9.81, 0, 0) on a wall",
        )
    if value is not None and np.any(np.abs(value) > LARGEST_GRAVITY):
        raise ParameterError("gravity", f"{gravity!r} given, at most {LARGEST_GRAVITY:g} m/s² expected")
    if value is not None:
        check_gravity(value)
    return value


def _ends(value: Any) -> ChainEnds | None:
    if value is None:
        return None
    if isinstance(value, str) or len(value) != 2 or not all(isinstance(name, str) for name in value):
        raise ParameterError("chain", f"{value!r} given, two links expected: the base and the tip")
    return value[0], value[1]


def _switch(parameter: str, value: Any) -> bool | None:
    if value is not None and not isinstance(value, bool):
        raise ParameterError(parameter, f"{value!r} given, True or False expected")
    return value


def _numbers(parameter: str, value: Any) -> Array | None:
    try:
        return None if value is None else np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(parameter, f"{value!r} given, numbers expected") from None
