"""What the drives report of one trial, compiled; what it is, is said in `asmc_pin.plant.sensor.sensor_parameters`."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, Number
from asmc_pin.numerics.short_loops import short_loops

# Rows of a sensor's memory: the last reading, the velocity made of readings, then angles and velocities at the ticks,
# oldest first.
READING, SPEED, HISTORY = range(3)


@short_loops
def delayed_angle(q0: Number, v0: Number, q1: Number, v1: Number, fraction: float, period: float) -> Number:
    """The angle `fraction` of a period before tick 1: on the cubic through angles and velocities of both ticks."""
    x = 1.0 - fraction
    between: Number = fraction**2 * (1.0 + 2.0 * x) * q0 + x**2 * (1.0 + 2.0 * fraction) * q1
    at: Number = between + period * x * fraction * (fraction * v0 - x * v1)
    return at


@short_loops
def read_sensor(
    first: bool,
    period: float,
    fraction: float,
    exact_velocity: bool,
    keep: float,
    count: Array,
    noise: Array,
    q: Array,
    v: Array,
    torque: Array,
    memory: Array,
    seen: Array,
) -> None:
    """What is reported at a tick.

    Args:
        first: Whether it is the first tick.
        period: L, s.
        fraction: Age of a reading beyond whole periods.
        exact_velocity: Whether velocity is the true one, with noise.
        keep: Weight of the newest difference of readings in the velocity otherwise.
        count: Angle of one count of the encoders, (nv,), rad; 0 where readings are not rounded.
        noise: Of angle, velocity and torque, (3, nv).
        q: What the encoders see now, (nv,), rad.
        v: Velocities there, (nv,), rad/s.
        torque: Mean torque of the last period, (nv,), N·m.
        memory: Of the sensors, (HISTORY + 2 (whole age + 2), nv); written.
        seen: Written: angle, velocity and torque as reported, (3, nv).
    """
    nv = q.size
    for row in range(HISTORY, memory.shape[0] - 2):
        for i in range(nv):
            memory[row, i] = memory[row + 2, i]
    for i in range(nv):
        memory[memory.shape[0] - 2, i], memory[memory.shape[0] - 1, i] = q[i], v[i]
        position, speed = memory[HISTORY + 2, i], memory[HISTORY + 3, i]
        if fraction > 0.0:
            q0, v0 = memory[HISTORY, i], memory[HISTORY + 1, i]
            position = delayed_angle(q0, v0, position, speed, fraction, period)
            speed = fraction * v0 + (1.0 - fraction) * speed
        reading = position + noise[0, i]
        if count[i] > 0.0:
            reading = count[i] * np.rint(reading / count[i])
        difference = (reading - memory[READING, i]) / period
        before = difference if first else memory[SPEED, i]
        memory[SPEED, i] = before + keep * (difference - before)
        memory[READING, i] = reading
        seen[0, i] = reading
        seen[1, i] = speed + noise[1, i] if exact_velocity else memory[SPEED, i]
        seen[2, i] = torque[i] + noise[2, i]


@short_loops
def read_sensors(
    first: bool,
    period: float,
    fraction: float,
    exact_velocity: bool,
    keep: float,
    count: Array,
    noise: Array,
    q: Array,
    v: Array,
    torque: Array,
    memory: Array,
    seen: Array,
) -> None:
    """`read_sensor` for a batch: noise (batch, 3, nv); q, v, torque (batch, nv); memory (batch, rows, nv); seen too."""
    for trial in range(q.shape[0]):
        read_sensor(
            first, period, fraction, exact_velocity, keep, count,
            noise[trial], q[trial], v[trial], torque[trial], memory[trial], seen[trial],
        )  # fmt: skip
