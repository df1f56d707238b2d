"""Ground truth: Pinocchio's dynamics with set-valued joint friction and drives, for a batch of trials in lockstep."""

from __future__ import annotations

from asmc_pin.plant.friction import Friction
from asmc_pin.plant.integrators import INTEGRATORS
from asmc_pin.plant.motion import Motion
from asmc_pin.plant.plant import Plant

__all__ = ["INTEGRATORS", "Friction", "Motion", "Plant"]
