"""Barrier-function adaptive sliding mode control: a gain that is as large as s needs it, and no larger."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import AdaptiveState, TdeLaw, signed
from asmc_pin.parameters import Scalar


@law("barrier")
@dataclass(frozen=True, kw_only=True, eq=False)
class Barrier(TdeLaw):
    r"""τ = PPC + M̄ k̂ sgn(s),  k̂ = min(U, |s|/(ε − |s|) rad/s²) where |s| < ε, else U.

    The positive semi-definite barrier function, with a unit gain of 1 rad/s². There is no rate to tune and no gain is
    over-estimated: a load n (rad/s²) that stands is met at |s| = ε n/(1 + n). In continuous time |s| < ε is kept for
    ever once reached; sampled, only where U, L and ε fit each other.

    Attributes:
        width: ε, above 0, rad/s.
        limit: U, the largest k̂, above 0, rad/s².
    """

    title: ClassVar[str] = "barrier-function adaptive sliding mode control"
    equation: ClassVar[str] = "τ = PPC + M̄ k̂ sgn(s);  k̂ = min(U, |s|/(ε − |s|)) if |s| < ε, else U"
    reference: ClassVar[str] = (
        "Obeid, Fridman, Laghrouche, Harmouche (2018), Automatica 93; sampled: Ovalle et al. (2025)"
    )

    width: Scalar = Scalar("ε", "rad/s", above=0.0)
    limit: Scalar = Scalar("U, the largest k̂", "rad/s²", above=0.0)

    def init(self, sample: Sample) -> AdaptiveState:
        """State before the first tick; k̂ is that of s = 0."""
        return AdaptiveState(self.start(sample), np.zeros(sample.q.shape))

    def step(self, state: AdaptiveState, sample: Sample, setpoint: Setpoint) -> tuple[Array, AdaptiveState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        torque, s, tde = self.pole_placement(state.tde, sample, setpoint)
        gain = self.gain_at(s)
        return torque + self.mbar * signed(gain, s), AdaptiveState(tde, gain)

    def gain_at(self, s: Array) -> Array:
        """k̂ at s, (batch, nv), rad/s²."""
        size = np.abs(s)
        room = self.width - size
        # |s| < U (ε − |s|) is where the quotient is below U; it is taken there alone.
        return np.divide(size, room, out=np.where(np.isnan(s), s, self.limit), where=size < self.limit * room)

    def switching_term(self, s: Array, gain: Array) -> Array:
        """The term w = k̂ sgn(s) at the ticks of a run; see `TdeLaw.switching_term`."""
        return signed(gain, s)
