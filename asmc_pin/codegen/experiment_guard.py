"""The limits and faults of an exported law, from an experiment and what the caller asks for."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.codegen.exported_code import guard_arrays, ramp_ticks
from asmc_pin.codegen.guarded_law import Guard
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.plant import Plant
from asmc_pin.words.choices import RealType


def experiment_guard(
    experiment: Experiment,
    plant: Plant,
    rate: ArrayLike | None,
    safe: ArrayLike,
    ramp: float,
    fault_ticks: int,
    real: RealType,
) -> Guard:
    """What stands around an exported law: the plant's limits, tighter where the robot that is named takes less.

    Args:
        experiment: Which robot it names, and how fast the torque may change.
        plant: Its plant.
        rate: Torque-rate limit in the place of the experiment's, a scalar or (nv,), N·m/s.
        safe: Where a fault leads to, a scalar or (nv,), N·m.
        ramp: Time from a fault to there, s.
        fault_ticks: Ticks in a row that are not in order and make a fault.
        real: Type of the numbers in C.

    Raises:
        ExperimentError: a joint has no torque limit.
        ParameterError: a value has a wrong size or sign.
    """
    nv, period = plant.arm.nv, experiment.period
    robot = experiment.robot_limits
    limit = np.array(np.broadcast_to(np.atleast_2d(plant.effort_limit)[0], (nv,)), dtype=np.float64)
    if robot is not None and robot.torque is not None:
        limit = np.minimum(limit, robot.torque.values)
    unlimited = [name for name, value in zip(plant.arm.joint_names, limit, strict=True) if not math.isfinite(value)]
    if unlimited:
        raise ExperimentError(
            "plant.effort_limit",
            f"joint '{unlimited[0]}' has no torque limit, and nothing is exported without; give [plant] effort_limit",
        )
    rates = _per_joint("torque_rate", experiment.torque_rate_limit if rate is None else rate, nv)
    if robot is not None and robot.torque_rate is not None:
        rates = np.minimum(rates, robot.torque_rate.values)
    if not (rates > 0.0).all():
        raise ParameterError("torque_rate", f"{rates.tolist()} given; expected values above 0 N·m/s, or inf")
    safes = _per_joint("safe_torque", safe, nv)
    if not (np.abs(safes) <= limit).all():
        raise ParameterError(
            "safe_torque", f"{safes.tolist()} given; expected values within the torque limits {limit.tolist()} N·m"
        )
    if not (math.isfinite(ramp) and ramp > 0.0):
        raise ParameterError("ramp", f"{ramp!r} given; expected a time above 0 s")
    if isinstance(fault_ticks, bool) or int(fault_ticks) != fault_ticks or not 1 <= fault_ticks <= 10_000:
        raise ParameterError("fault_ticks", f"{fault_ticks!r} given; expected a whole number from 1 to 10000")
    limits, step = guard_arrays(limit, rates, period, real)
    ticks = ramp_ticks(ramp, period)
    if ticks > 100_000:
        raise ParameterError("ramp", f"{ramp:g} s are {ticks} periods; expected at most 100000")
    return Guard(period, limits, step, safes, int(fault_ticks), ticks)


def _per_joint(name: str, value: ArrayLike, nv: int) -> Array:
    try:
        return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (nv,)))
    except ValueError:
        raise ParameterError(name, f"{value!r} given; expected one number, or {nv} of them") from None
