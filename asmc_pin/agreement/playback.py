"""Torques played to a plant whatever it does, along a reference that says nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Sample, Setpoint


@dataclass(frozen=True, eq=False)
class Playback:
    """A law that plays torques, shape (ticks, batch, nv), N·m, each held over a period, s; the last one goes on."""

    torque: Array
    period: float

    def init(self, sample: Sample) -> int:
        """Number of ticks taken."""
        return 0

    def step(self, state: int, sample: Sample, setpoint: Setpoint) -> tuple[Array, int]:
        """Torque of this tick, and the number of ticks taken."""
        return self.torque[min(state, len(self.torque) - 1)], state + 1


@dataclass(frozen=True)
class Nowhere:
    """A reference that rests at 0; nobody follows it."""

    nv: int
    duration: float = np.inf

    def evaluate(self, t: Array) -> Setpoint:
        """Zeros of shape (T, nv)."""
        rest = np.zeros((len(t), self.nv))
        return Setpoint(rest, rest, rest)
