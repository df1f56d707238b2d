"""Angles, velocities, accelerations and torques of a log, on one clock and within one band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from asmc_pin._typing import Array, IntArray
from asmc_pin.errors import ParameterError
from asmc_pin.logs.joint_log import JointLog
from asmc_pin.logs.resampling import at_equal_steps, differentiated, low_passed, white_noise

CUTOFFS = (60.0, 40.0, 30.0, 20.0, 15.0, 10.0, 7.0, 5.0)
"""Hz, of which the highest is taken whose accelerations are clean enough."""

FIT_BAND = 10.0
"""Hz at most; above it there is little of an arm's motion and much of what shakes it."""

_CLEAN = 0.03  # of the acceleration's RMS
_PER_CUTOFF = 7.0  # samples in a period of the cutoff's frequency
_PER_BAND = 5.0


@dataclass(frozen=True, eq=False)
class FilteredMotion:
    """A log's motion at equal steps.

    Attributes:
        time: Shape (N,), s.
        step: s.
        q: Low-passed at `cutoff`, shape (N, nv), rad.
        v: Its derivative, rad/s.
        a: Its second, rad/s².
        torque: As logged, a spline over time, to be read at shifted times; low-passed at `band`.
        cutoff: Hz, of the angles.
        band: Hz, of everything that is fitted.
        rows: Which of `time` are fitted: `band` needs no more.
        raw_q: Unfiltered angles at the same times, shape (N, nv).
        noise_q: White part of the angles, shape (nv,), rad.
        noise_v: Of the velocities, rad/s; None where they are not logged.
        from_velocity: Whether v and a come of logged velocities, as the angles are too coarse.
        lag: By how much the logged velocities lag behind the angles, s; 0 where they are not logged.
        told: What was done, a sentence each.
    """

    time: Array
    step: float
    q: Array
    v: Array
    a: Array
    torque: CubicSpline
    cutoff: float
    band: float
    rows: IntArray
    raw_q: Array
    noise_q: Array
    noise_v: Array | None
    from_velocity: bool
    lag: float
    told: tuple[str, ...]

    def fitted(self, values: Array) -> Array:
        """A quantity at `time` within `band`, at the rows that are fitted, first axis."""
        flat = low_passed(values.reshape(len(values), -1), self.step, self.band)
        return flat.reshape(values.shape)[:: self.stride]

    @property
    def stride(self) -> int:
        """Rows of `time` for each one that is fitted."""
        return max(1, int(1.0 / (_PER_BAND * self.band * self.step)))


def filter_log(log: JointLog, cutoff: float | None = None) -> FilteredMotion:
    """Bring a log to equal steps and differentiate it.

    Args:
        log: With torque.
        cutoff: Of the angles' low-pass, Hz; chosen by the noise of the log when omitted.

    Raises:
        ParameterError: No torque, or too short.
    """
    if log.torque is None:
        raise ParameterError("log", f"{log.name} has no torque; add columns tau1 … in N·m, or name them")
    noise_q = np.maximum(white_noise(log.time, log.q), 1e-12)
    noise_v = None if log.v is None else white_noise(log.time, log.v)
    grid, q = at_equal_steps(log.time, log.q, log.step)
    if grid[-1] < 2.0:
        raise ParameterError("log", f"{log.name} is {grid[-1]:.3g} s long; at least 2 s expected")
    _, torque = at_equal_steps(log.time, log.torque, log.step)
    v = None if log.v is None else at_equal_steps(log.time, log.v, log.step)[1]
    chosen, from_velocity = _choice(grid, q, log.step, noise_q, noise_v, cutoff)
    smooth = low_passed(q, log.step, chosen)
    first, second = differentiated(grid, smooth)
    lag = 0.0 if v is None else velocity_lag(grid, first, low_passed(v, log.step, chosen))
    if from_velocity:
        assert v is not None
        shifted = CubicSpline(grid, low_passed(v, log.step, chosen))(np.clip(grid + lag, grid[0], grid[-1]))
        first, second = shifted, differentiated(grid, shifted)[0]
    band = min(FIT_BAND, 0.5 * chosen)
    every = max(1, int(1.0 / (_PER_CUTOFF * chosen * log.step)))
    step = every * log.step
    inner = slice(None, None, every)
    told = _told(log, chosen, band, step, from_velocity, lag)
    motion = FilteredMotion(
        time=grid[inner],
        step=step,
        q=smooth[inner],
        v=first[inner],
        a=second[inner],
        torque=CubicSpline(grid, low_passed(torque, log.step, band)),
        cutoff=chosen,
        band=band,
        rows=np.arange(0, dtype=np.int64),
        raw_q=q[inner],
        noise_q=noise_q,
        noise_v=noise_v,
        from_velocity=from_velocity,
        lag=lag,
        told=told,
    )
    object.__setattr__(motion, "rows", np.arange(len(motion.time), dtype=np.int64)[:: motion.stride])
    return motion


def velocity_lag(time: Array, derivative: Array, logged: Array) -> float:
    """By how much logged velocities lag behind the derivative of the angles, s, by least squares over all joints."""
    slope = np.gradient(derivative, time, axis=0)
    # The joints by their own size, or the fastest alone would say it.
    size = np.maximum(np.std(derivative, axis=0), 1e-9)
    power = float(np.sum((slope / size) ** 2))
    return 0.0 if power == 0.0 else float(-np.sum((logged - derivative) / size * slope / size) / power)


def _choice(
    time: Array, q: Array, step: float, noise_q: Array, noise_v: Array | None, asked: float | None
) -> tuple[float, bool]:
    """The cutoff, and whether accelerations are cleaner from logged velocities."""
    usable = [f for f in CUTOFFS if f * step < 0.2] or [0.2 / step]
    for f in usable if asked is None else [asked]:
        _, second = differentiated(time, low_passed(q, step, min(f, 10.0)))
        size = np.maximum(np.sqrt(np.mean(second**2, axis=0)), 1e-9)
        # White noise of the rows, derived once or twice, within the cutoff.
        of_q = noise_q * np.sqrt(2.0 * step * (2.0 * np.pi) ** 4 * f**5 / 5.0)
        of_v = np.full_like(of_q, np.inf)
        if noise_v is not None:
            of_v = noise_v * np.sqrt(2.0 * step * (2.0 * np.pi) ** 2 * f**3 / 3.0)
        from_velocity = bool(np.median(of_v / of_q) < 0.5)
        if np.median((of_v if from_velocity else of_q) / size) < _CLEAN or f == usable[-1]:
            break
    return f, from_velocity


def _told(log: JointLog, cutoff: float, band: float, step: float, from_velocity: bool, lag: float) -> tuple[str, ...]:
    told = [
        f"resampled to {log.step:.4g} s by straight lines, angles low-passed at {cutoff:g} Hz (Butterworth of order 4, "
        f"forwards and backwards: no delay), then every {step:.4g} s",
        "velocity and acceleration are derivatives of a spline through the "
        + ("logged velocities, which are cleaner than the angles" if from_velocity else "angles"),
        f"torque and model are compared below {band:g} Hz, through one and the same filter",
    ]
    if log.v is not None and abs(lag) > 2e-4:
        told.append(f"the logged velocities lag behind the angles by {1e3 * lag:.2g} ms")
    return tuple(told)
