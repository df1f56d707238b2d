"""Sensors under way: readings tick by tick, and the velocities made from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Sample
from asmc_pin.plant.per_trial import row
from asmc_pin.plant.sensor.compiled_sensor import HISTORY, READING, read_sensors
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
        batch, nv = q.shape
        self.sensor, self.period = sensor, period
        self.count = sensor.count(nv, gear)
        spread = [row(x, nv, 0.0) for x in (sensor.position_noise, sensor.velocity_noise, sensor.torque_noise)]
        self._spread = np.array(spread)
        self.noisy = bool(self._spread.any())
        self._noise = NormalNoise(seed, trials, 3 * nv, SENSOR) if self.noisy else None
        whole = math.floor(sensor.delay)
        self.fraction = sensor.delay - whole
        self.exact_velocity = sensor.velocity == "exact"
        self.keep = 1.0 if sensor.velocity != "filter" else -math.expm1(-2.0 * math.pi * sensor.filter_hz * period)
        self.memory = np.zeros((batch, HISTORY + 2 * (whole + 2), nv))
        self.memory[:, READING] = self._round(q - (1.0 + sensor.delay) * period * v)
        for index, age in enumerate(range(whole + 2, 0, -1)):
            self.memory[:, HISTORY + 2 * index], self.memory[:, HISTORY + 2 * index + 1] = q - age * period * v, v
        self._first = True

    def read(self, q: Array, v: Array, torque: Array) -> Sample:
        """What the drives report at this tick.

        Args:
            q: What the encoders see now, (batch, nv), rad.
            v: Velocities there, (batch, nv), rad/s.
            torque: Mean torque that the drives applied over the last period, (batch, nv), N·m.
        """
        seen = np.empty((len(q), 3, q.shape[1]))
        read_sensors(
            self._first,
            self.period,
            self.fraction,
            self.exact_velocity,
            self.keep,
            self.count,
            self.noise(1)[:, 0],
            np.array(q, order="C"),
            np.array(v, order="C"),
            np.array(torque, order="C"),
            self.memory,
            seen,
        )
        self._first = False
        return Sample(seen[:, 0], seen[:, 1], seen[:, 2])

    def noise(self, ticks: int) -> Array:
        """Noise of the next ticks, of angles, velocities and torques: (batch, ticks, 3, nv)."""
        batch, _, nv = self.memory.shape
        if self._noise is None:
            return np.zeros((batch, ticks, 3, nv))
        return np.asarray(self._noise.ahead(ticks).reshape(batch, ticks, 3, nv) * self._spread)

    def _round(self, q: Array) -> Array:
        count = np.where(self.count > 0.0, self.count, 1.0)
        return np.where(self.count > 0.0, count * np.rint(q / count), q)
