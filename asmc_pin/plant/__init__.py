"""Ground truth: Pinocchio's dynamics with friction, drives, sensors and a world, for a batch of trials in lockstep.

Takes torques at control ticks; gives motion and samples. May import `arms`, `rigid_body`, `parameters`, and of the
controllers what it exchanges with them.
"""

from __future__ import annotations

from asmc_pin.plant.arms_under_way import MovingArm, moving_arms
from asmc_pin.plant.drive.drive_parameters import Drive
from asmc_pin.plant.friction.friction_parameters import Friction, VelocityTerm
from asmc_pin.plant.integrators import INTEGRATORS, ORDERS
from asmc_pin.plant.plant import Plant
from asmc_pin.plant.plant_parameters import PlantParameters
from asmc_pin.plant.plant_state import Motion
from asmc_pin.plant.sensor.sensor_parameters import Sensor
from asmc_pin.plant.world.end_stops import EndStops
from asmc_pin.plant.world.spread import Spread
from asmc_pin.plant.world.world_parameters import Disturbance, PayloadChange

__all__ = [
    "INTEGRATORS",
    "ORDERS",
    "Disturbance",
    "Drive",
    "EndStops",
    "Friction",
    "Motion",
    "MovingArm",
    "PayloadChange",
    "Plant",
    "PlantParameters",
    "Sensor",
    "Spread",
    "VelocityTerm",
    "moving_arms",
]
