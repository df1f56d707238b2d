"""Sensors under way: readings tick by tick, and the velocities made from them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Sample
from asmc_pin.plant.per_trial import row
from asmc_pin.plant.sensor.sensor_parameters import Sensor
from asmc_pin.plant.sensor.trial_noise import SENSOR, NormalNoise


class Sensing:
    """The sensors of a batch; `read` once per control tick.

    Args:
        sensor: The parameters.
        gear: Turns of the motor per turn of the joint, () or (nv,).
        q: What the encoders see of the angles at t = 0, (batch, nv), rad.
        v: Velocities there, (batch, nv), rad/s. Before t = 0 the joints are taken to have moved at v(0).
        period: Control period, s.
        seed: Seed of the experiment.
        trials: Number of each trial.
    """

    def __init__(
        self, sensor: Sensor, gear: Array, q: Array, v: Array, period: float, seed: int, trials: Sequence[int]
    ) -> None:
        nv = q.shape[1]
        self._sensor, self._period = sensor, period
        self._count = sensor.count(nv, gear)
        self._rounded = bool(self._count.any())
        spread = [row(x, nv, 0.0) for x in (sensor.position_noise, sensor.velocity_noise, sensor.torque_noise)]
        self._spread = np.array(spread)
        noisy = bool(self._spread.any())
        self._noise = NormalNoise(seed, trials, 3 * nv, SENSOR) if noisy else None
        self._whole = math.floor(sensor.delay)
        self._fraction = sensor.delay - self._whole
        ages = range(self._whole + 2, 0, -1)
        self._states = deque([(q - age * period * v, v) for age in ages], maxlen=self._whole + 2)
        self._keep = 1.0 if sensor.velocity != "filter" else -math.expm1(-2.0 * math.pi * sensor.filter_hz * period)
        self._last = self._round(q - (1.0 + sensor.delay) * period * v)
        self._velocity: Array | None = None

    def read(self, q: Array, v: Array, torque: Array) -> Sample:
        """What the drives report at this tick.

        Args:
            q: What the encoders see now, (batch, nv), rad.
            v: Velocities there, (batch, nv), rad/s.
            torque: Mean torque that the drives applied over the last period, (batch, nv), N·m.
        """
        self._states.append((q, v))
        noise = self._spread[:, None] * 0.0 if self._noise is None else self._scaled_noise(len(q))
        position, speed = self._delayed()
        reading = self._round(position + noise[0])
        if self._sensor.velocity == "exact":
            velocity = speed + noise[1]
        else:
            difference = (reading - self._last) / self._period
            before = difference if self._velocity is None else self._velocity
            velocity = before + self._keep * (difference - before)
            self._velocity = velocity
        self._last = reading
        return Sample(reading, velocity, torque + noise[2])

    def _scaled_noise(self, batch: int) -> Array:
        assert self._noise is not None
        normal = self._noise.next().reshape(batch, 3, -1)
        return np.asarray(normal.transpose(1, 0, 2) * self._spread[:, None])

    def _round(self, q: Array) -> Array:
        if not self._rounded:
            return q
        count = np.where(self._count > 0.0, self._count, 1.0)
        return np.where(self._count > 0.0, count * np.rint(q / count), q)

    def _delayed(self) -> tuple[Array, Array]:
        """The state `delay` periods ago: between two ticks the cubic through both angles and velocities."""
        (q0, v0), (q1, v1) = self._states[0], self._states[1]
        x = 1.0 - self._fraction
        if x == 1.0:
            return q1, v1
        step, rest = self._period, self._fraction
        q = rest**2 * (1.0 + 2.0 * x) * q0 + x**2 * (1.0 + 2.0 * rest) * q1
        return q + step * x * rest * (rest * v0 - x * v1), rest * v0 + x * v1
