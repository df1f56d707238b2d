"""The existing adaptive sliding mode control: one gain for all joints, growing and shrinking in proportion to ‖s‖."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import AdaptiveState, TdeLaw, signed
from asmc_pin.parameters import Scalar, ScalarOrWord


@law("plestan2010")
@dataclass(frozen=True, kw_only=True, eq=False)
class Plestan2010(TdeLaw):
    """τ = PPC + M̄ k̂ sgn(s) with one k̂ ≥ μ shared by all joints.

    Plestan, Shtessel, Bregeault, Poznyak (2010), "New methodologies for adaptive sliding mode control",
    Int. J. Control 83(9), as Baek 2016 compares with it (reference [27] there).

    Attributes:
        rate: k̄, at least 0, rad/s² per rad: k̂ changes at the rate k̄ ‖s‖₂.
        epsilon: ε, the size of ‖s‖₂ below which k̂ shrinks, above 0, rad/s; or ``"4KL"``, the authors' own choice for a
            sampled law whose plant is nominally inverted, as TDE does: 4 k̂_{k−1} L. By how much k̂ switches s within a
            period it can then tell from s itself.
        floor: μ, the least k̂ and its value at the start, above 0, rad/s²; at the floor k̂ grows at μ per second.
    """

    title: ClassVar[str] = "existing adaptive sliding mode control"
    equation: ClassVar[str] = (
        "τ = PPC + M̄ k̂ sgn(s);  dk̂/dt = k̄ ‖s‖₂ sgn(‖s‖₂ − ε) if k̂ > μ, else μ;  ε a number, or 4 k̂ L"
    )
    reference: ClassVar[str] = "Plestan, Shtessel, Bregeault, Poznyak (2010)"

    rate: Scalar = Scalar("k̄", "1/s²", at_least=0.0)
    epsilon: ScalarOrWord = ScalarOrWord("ε, or the authors' 4 k̂ L", "rad/s", words=("4KL",), above=0.0)
    floor: Scalar = Scalar("μ", "rad/s²", above=0.0)

    def init(self, sample: Sample) -> AdaptiveState:
        """State before the first tick, from the sample of t = 0; k̂₀ = μ."""
        return AdaptiveState(self.start(sample), np.full(sample.q.shape, self.floor))

    def step(self, state: AdaptiveState, sample: Sample, setpoint: Setpoint) -> tuple[Array, AdaptiveState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        torque, s, tde = self.pole_placement(state.tde, sample, setpoint)
        gain = self.adapt(state.gain, s)
        return torque + self.mbar * signed(gain, s), AdaptiveState(tde, gain)

    def switching_term(self, s: Array, gain: Array) -> Array:
        """The term w = k̂ sgn(s) at the ticks of a run; see `TdeLaw.switching_term`."""
        return signed(gain, s)

    def adapt(self, gain: Array, s: Array) -> Array:
        """k̂_k from k̂_{k−1}, both (batch, nv) with equal columns, rad/s², and s_k, (batch, nv), rad/s.

        k̂_k = max(μ, k̂_{k−1} + L k̄ ‖s‖ sgn(‖s‖ − ε)) if k̂_{k−1} > μ, else k̂_{k−1} + L μ; sgn(0) = +1.
        ε = 4 k̂_{k−1} L if it is ``"4KL"``.
        """
        size = np.sqrt(np.add.reduce(s * s, axis=-1, keepdims=True))
        epsilon = 4.0 * self.period * gain if isinstance(self.epsilon, str) else self.epsilon
        change = (self.period * self.rate) * np.where(size >= epsilon, size, -size)
        return np.where(gain > self.floor, np.maximum(self.floor, gain + change), gain + self.period * self.floor)
