"""Ground truth: Pinocchio's dynamics with friction, drives, sensors and a world, for a batch of trials in lockstep."""

from __future__ import annotations

from asmc_pin.plant.disturbance import Disturbance, PayloadChange
from asmc_pin.plant.drive import Drive
from asmc_pin.plant.end_stops import EndStops
from asmc_pin.plant.friction import Friction
from asmc_pin.plant.integrators import INTEGRATORS, ORDERS
from asmc_pin.plant.motion import Motion
from asmc_pin.plant.plant import Plant
from asmc_pin.plant.sensor import Sensor
from asmc_pin.plant.spread import Spread

__all__ = [
    "INTEGRATORS",
    "ORDERS",
    "Disturbance",
    "Drive",
    "EndStops",
    "Friction",
    "Motion",
    "PayloadChange",
    "Plant",
    "Sensor",
    "Spread",
]
