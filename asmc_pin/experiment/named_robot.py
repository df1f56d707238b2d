"""``plant.limits``: the robot whose published limits a run is held against, and an export kept within."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, WithJsonSchema

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.robot_limits import LIMITED_QUANTITIES, ROBOT_LIMITS, RobotLimits
from asmc_pin.experiment.constructors import Mistake
from asmc_pin.metrics import Trip, TripLimits
from asmc_pin.words.nearest_name import nearest


def _known(value: Any) -> Any:
    if not isinstance(value, str) or value not in ROBOT_LIMITS:
        raise ValueError(
            f"must be a robot whose limits are known, got {value!r}: {nearest(str(value), ROBOT_LIMITS)} The table of "
            "them is in docs/plant.md"
        )
    return value


RobotName = Annotated[str | None, BeforeValidator(_known), WithJsonSchema({"enum": list(ROBOT_LIMITS)})]
"""Of a robot in `ROBOT_LIMITS`."""


def robot_problems(name: str | None, arm: Arm) -> list[Mistake]:
    """Whether a robot can be this arm: it has as many joints, and all of them turn."""
    if name is None:
        return []
    joints, sliding = ROBOT_LIMITS[name].joints, arm.joint_kinds.count("prismatic")
    if joints == arm.nv and not sliding:
        return []
    fitting = [known for known, limits in ROBOT_LIMITS.items() if limits.joints == arm.nv and not sliding]
    mend = f"name one with as many ({', '.join(fitting)})" if fitting else "leave it out"
    own = f"{arm.nv} joint{'s' * (arm.nv != 1)}" + (f", of which {sliding} slide" if sliding else "")
    return [Mistake("plant.limits", f"'{name}' has {joints} joints that turn, but {arm.name} has {own}; {mend}")]


def tighter_rate(robot: RobotLimits | None, asked: ArrayLike, given: bool) -> Array:
    """How fast the torque may change, a scalar or (nv,), N·m/s.

    Args:
        robot: The robot, if one is named.
        asked: ``metrics.torque_rate_limit``.
        given: Whether that stands in the file: then it may tighten what is published, and never loosens it.
    """
    limit = np.asarray(asked, dtype=np.float64)
    if robot is None or robot.torque_rate is None:
        return limit
    published = np.array(robot.torque_rate.values)
    return np.minimum(limit, published) if given else published


def trip_limits(robot: RobotLimits | None, rate: Array) -> TripLimits:
    """What stops a robot; infinite where nothing is published, or no robot is named.

    Args:
        robot: The robot, if one is named.
        rate: See `tighter_rate`.
    """
    published = {} if robot is None else {name: np.array(limit.values) for name, limit in robot.published.items()}
    if "torque_rate" in published:
        published["torque_rate"] = rate
    return TripLimits(**published)


def trip_words(name: str, joints: Sequence[str], trip: Trip) -> str:
    """What would have stopped a robot, where and when; the same words in every warning.

    Args:
        name: Of the robot, as ``plant.limits`` has it.
        joints: Names of the arm's joints.
        trip: What happened.
    """
    published = ROBOT_LIMITS[name].published[trip.quantity]
    what, unit = LIMITED_QUANTITIES[trip.quantity]
    own = published.values[trip.joint]
    tighter = f", tightened from {own:g}" if trip.limit < own else ""
    value = f"{trip.value:.4g}"
    value = value if float(value) > trip.limit else f"{trip.value:.12g}"  # what is beyond by little has to look so
    return (
        f"{name} would have tripped at t = {trip.time:.3f} s: joint '{joints[trip.joint]}', {what} "
        f"{value} {unit} beyond {trip.limit:g} {unit}{tighter} (source: {published.source})"
    )
