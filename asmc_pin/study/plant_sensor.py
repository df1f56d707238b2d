"""The plant's sensors and drives as the analysis of the sampled loop takes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.plant import Plant
from asmc_pin.sampled.noise.sensor_model import LoopSensor, loop_sensor


def sensor_of_plant(plant: Plant) -> LoopSensor:
    """How the plant's velocities are made, and the noise of what it reports."""
    sensor, nv = plant.sensor, plant.nv
    if sensor is None:
        return loop_sensor(nv)
    gear = np.ones(()) if plant.drive is None else np.asarray(plant.drive.gear)

    def each(value: ArrayLike) -> Array:
        return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (nv,)))

    return LoopSensor(
        count=each(sensor.count(nv, gear)),
        angle_noise=each(sensor.position_noise),
        rate_noise=each(sensor.velocity_noise),
        torque_noise=each(sensor.torque_noise),
        velocity="measured" if sensor.velocity == "exact" else "difference",
        velocity_filter_hz=sensor.filter_hz if sensor.velocity == "filter" else None,
        reading_delay=sensor.delay,
    )
