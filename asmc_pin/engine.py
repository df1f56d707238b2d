"""Running a control law on the plant, trials in lockstep: the engine under every comparison, tuning and sweep."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Controller, Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Plant
from asmc_pin.plant.compiled_run.coverage import not_compiled
from asmc_pin.plant.following import follow_by_pinocchio, follow_compiled
from asmc_pin.plant.joint_reach import outside_limits
from asmc_pin.plant.per_trial import per_trial
from asmc_pin.plant.run_record import LimitViolation, Rollout
from asmc_pin.references.reference import Reference
from asmc_pin.words.units import check_delay, check_period

__all__ = ["LimitViolation", "Rollout", "rollout"]


def rollout(
    plant: Plant,
    controller: Controller,
    reference: Reference,
    duration: float,
    *,
    period: float | None = None,
    batch: int = 1,
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    progress: Callable[[int, int], None] | None = None,
    trials: Sequence[int] | None = None,
    log_every: int = 1,
) -> Rollout:
    """Run a law on a plant along a reference.

    At a tick, t_k = k·period, the drives report a `Sample`, the law computes a torque, the drives hold it within their
    limits, and the plant moves on. A trial's result is the same to the last bit in whatever batch it runs. A trial
    diverges when a state or the law's torque is not finite, or beyond the plant's ``speed_bound`` or
    ``error_bound``: it stops, and the others go on untouched. Numerical trouble in the law is such a result, so numpy's
    floating-point warnings are silent in here; an exception in the law is raised.

    Args:
        plant: The ground truth.
        controller: The law; see `asmc_pin.controllers.Controller`.
        reference: What to follow; see `asmc_pin.references`.
        duration: Length of the run, s, rounded to whole periods.
        period: Control period, s; None for the law's own ``period``.
        batch: Number of trials.
        q0: q(0), (nv,) or (batch, nv), rad; None for the reference's.
        v0: v(0), (nv,) or (batch, nv), rad/s; None for the reference's.
        progress: Called now and then with the ticks done and their total.
        trials: Numbers of the trials in a larger study, which with the plant's seed determine their noise and scatter;
            0, 1, … when omitted.
        log_every: One tick in how many is logged, to save memory. Nothing else changes: all ticks are run, and whether
            a trial diverged or left its limits is judged at each. Metrics and monitors refuse a run that lacks ticks.

    Returns:
        The run, with round(duration/period) + 1 ticks, of which those are in it whose number `log_every` divides.

    Raises:
        ParameterError: a parameter has a wrong size, sign or value, or the law returns a torque of another shape than
            (batch, nv).
    """
    period = _period_of(controller, period)
    check_period(period)
    for part, name in ((plant.drive, "drive.delay"), (plant.sensor, "sensor.delay")):
        if part is not None:
            check_delay(part.delay, period, name)
    ticks = _ticks(duration, period)
    if isinstance(batch, bool) or int(batch) != batch or batch < 1:
        raise ParameterError("batch", f"{batch!r} given; expected a whole number of trials, at least 1")
    log_every = _log_rate(log_every, ticks)
    time = np.multiply(np.arange(ticks), period, dtype=np.float64)
    wanted = _evaluate(reference, time, plant.nv)
    q = _initial("q0", wanted.q[0] if q0 is None else q0, batch, plant.nv)
    v = _initial("v0", wanted.v[0] if v0 is None else v0, batch, plant.nv)
    trials = _trials(trials, batch)
    plant = plant.for_trials(trials)
    motion = plant.begin(q, v, period, trials)
    held = motion.torque
    compiled = plant.engine == "compiled" and not_compiled(plant) is None
    follow = follow_compiled if compiled else follow_by_pinocchio
    with np.errstate(all="ignore"):
        followed = follow(controller, motion, wanted, log_every, progress)

    end_time = time[np.minimum(followed.stopped_at, ticks - 1)]
    logged = [time, wanted.q, wanted.v, wanted.a]
    if log_every > 1:
        logged = [array[::log_every].copy() for array in logged]
    for array in (*logged, end_time, held):
        array.setflags(write=False)
    return Rollout(
        time=logged[0],
        **followed.histories,
        held_torque=held,
        q_ref=logged[1],
        v_ref=logged[2],
        a_ref=logged[3],
        status=tuple("diverged" if tick < ticks else "ok" for tick in followed.stopped_at),
        end_time=end_time,
        joint_names=tuple(plant.arm.joint_names),
        period=period,
        limit_violations=outside_limits(tuple(plant.arm.joint_names), period, followed.reach),
        log_every=log_every,
    )


def _log_rate(log_every: int, ticks: int) -> int:
    whole = isinstance(log_every, (int, np.integer)) and not isinstance(log_every, bool)
    if not (whole and 1 <= log_every < ticks):
        raise ParameterError(
            "log_every",
            f"{log_every!r} given; expected a whole number of ticks, 1 to log each of them, at most {ticks - 1}: more "
            "would log the start alone",
        )
    return int(log_every)


def _trials(trials: Sequence[int] | None, batch: int) -> Sequence[int]:
    if trials is None:
        return range(batch)
    numbers = tuple(trials)
    if len(numbers) != batch or any(isinstance(n, bool) or int(n) != n or n < 0 for n in numbers):
        raise ParameterError("trials", f"{numbers!r} given; expected {batch} whole numbers, 0 or more")
    return tuple(int(n) for n in numbers)


def _period_of(controller: Controller, period: float | None) -> float:
    own = getattr(controller, "period", None)
    given = own if period is None else period
    if given is None:
        raise ParameterError(
            "period", f"{type(controller).__name__} has no period of its own; give period=… in seconds"
        )
    seconds = _seconds("period", given)
    if own is not None and own != seconds:
        raise ParameterError(
            "period", f"{period} s given, but the law computes with {own} s; leave it out, or make them equal"
        )
    return seconds


def _ticks(duration: float, period: float) -> int:
    periods = round(_seconds("duration", duration) / period)
    if periods < 1:
        raise ParameterError("duration", f"{duration} s is less than one control period of {period} s; make it longer")
    return periods + 1


def _seconds(name: str, value: float) -> float:
    try:
        seconds = float(value)
    except (TypeError, ValueError):
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise ParameterError(name, f"{value!r} given; expected a positive number of seconds")
    return seconds


def _evaluate(reference: Reference, time: Array, nv: int) -> Setpoint:
    setpoint = reference.evaluate(time)
    fields = []
    for name in ("q", "v", "a"):
        field = np.array(getattr(setpoint, name), dtype=np.float64, order="C")
        if field.shape != (len(time), nv):
            raise ParameterError(
                "reference",
                f"gives {name} of shape {field.shape}; expected {(len(time), nv)}: times by the plant's joints",
            )
        if not np.isfinite(field).all():
            bad = time[~np.isfinite(field).all(axis=1)][0]
            raise ParameterError(
                "reference", f"{name} is not finite at t = {bad:.6g} s; every value has to be a number"
            )
        fields.append(field)
    return Setpoint(*fields)


def _initial(name: str, value: ArrayLike, batch: int, nv: int) -> Array:
    array = per_trial(name, value, batch, nv)
    if not np.isfinite(array).all():
        raise ParameterError(name, f"{array.tolist()} given; every value has to be finite")
    return array
