"""BSMC: sliding mode control with a boundary layer, added to PPC."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array, Number
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import MBAR, OWN, S, pole_placement
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.numerics.short_loops import as_written, short_loops
from asmc_pin.parameters import PerJoint

GAIN, BOUNDARY = OWN, OWN + 1


@short_loops
def saturated(s: Number, boundary: Number) -> Number:
    """sat(s/Φ), in −1…1. s is clipped before the division, which therefore cannot overflow."""
    inside: Number = np.minimum(np.maximum(s, -boundary), boundary) / boundary
    return inside


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    pole_placement(tick, law, memory, work, command)
    for i in range(command.size):
        command[i] += law[MBAR, i] * law[GAIN, i] * saturated(work[S, i], law[BOUNDARY, i])


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
    oracle: ClassVar[str] = "inside the layer it is PPC with β + K/Φ: a drifting load leaves s = L ḣ/(m̄(β + K/Φ))"
    claim: ClassVar[str] = "Inside the boundary layer the torque is continuous; outside |s| falls where K > |N|."
    fails: ClassVar[str] = "K/Φ is a gain: too much of it is unstable, which `asmc-pin stability --law bsmc` tells."
    band_remedy: ClassVar[str] = "widen Φ or lower K"
    typical: ClassVar[Mapping[str, float | str]] = {"gain": 5.0, "boundary": 0.1}

    gain: PerJoint = PerJoint("K", "rad/s²", at_least=0.0)
    boundary: PerJoint = PerJoint("Φ", "rad/s", above=0.0)

    row_meanings: ClassVar[Mapping[str, str]] = {
        "gain": "K, rad/s²",
        "boundary": "Φ, rad/s",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """K and Φ; see `_step`."""
        return self.gain, self.boundary

    trial_step: ClassVar[TrialStep | None] = _step

    def switching_term(self, s: Array, gain: Array) -> Array:
        """The term w = K sat(s/Φ) at the ticks of a run; see `TdeLaw.switching_term`."""
        return np.asarray(self.gain * self.saturation(s))

    @property
    def boundary_slope(self) -> Array:
        """K/Φ, a scalar or (nv,), 1/s."""
        return np.asarray(self.gain / self.boundary)

    def saturation(self, s: Array) -> Array:
        """sat(s/Φ), in −1…1."""
        return np.asarray(as_written(saturated)(s, self.boundary))
