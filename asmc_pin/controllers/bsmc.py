"""BSMC: sliding mode control with a boundary layer, added to PPC."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import TdeLaw, TdeState
from asmc_pin.parameters import PerJoint


@law("bsmc")
@dataclass(frozen=True, kw_only=True, eq=False)
class Bsmc(TdeLaw):
    """τ = PPC + M̄ K sat(s/Φ), sat(x) = clip(x, −1, 1); reference [43] of Baek 2016.

    Attributes:
        gain: K, scalar or nv values, at least 0, rad/s².
        boundary: Φ, the half-width of the boundary layer in s, scalar or nv values, above 0, rad/s.
    """

    title: ClassVar[str] = "boundary-layer sliding mode control (BSMC)"
    equation: ClassVar[str] = "τ = PPC + M̄ K sat(s/Φ)"
    reference: ClassVar[str] = "Baek, Jin, Han (2016), reference [43] there"

    gain: PerJoint = PerJoint("K", "rad/s²", at_least=0.0)
    boundary: PerJoint = PerJoint("Φ", "rad/s", above=0.0)

    def step(self, state: TdeState, sample: Sample, setpoint: Setpoint) -> tuple[Array, TdeState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        torque, s, state = self.pole_placement(state, sample, setpoint)
        return torque + self.mbar * self.gain * self.saturation(s), state

    def switching_term(self, s: Array, gain: Array) -> Array:
        """The term w = K sat(s/Φ) at the ticks of a run; see `TdeLaw.switching_term`."""
        return np.asarray(self.gain * self.saturation(s))

    @property
    def boundary_slope(self) -> Array:
        """K/Φ, a scalar or (nv,), 1/s."""
        return np.asarray(self.gain / self.boundary)

    def saturation(self, s: Array) -> Array:
        """sat(s/Φ), in −1…1. s is clipped before the division, which therefore cannot overflow."""
        inside: Array = np.minimum(np.maximum(s, -self.boundary), self.boundary)
        return inside / self.boundary
