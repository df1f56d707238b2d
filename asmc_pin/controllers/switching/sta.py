"""STA: super-twisting, whose torque is continuous because its switching stands under an integral."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import TdeLaw, TdeState, signed
from asmc_pin.parameters import PerJoint, Scalar

_ROUNDING = 1e-12
"""Of a torque: a drive that gives as much less than it was told as this has given what it was told."""


class SuperTwistingState(NamedTuple):
    """What the law remembers.

    Attributes:
        tde: What the estimation remembers.
        integral: ϖ, (batch, nv), rad/s².
        scale: a, what both gains are multiplied by, (batch, nv).
        told: The torque asked for at the last tick, (batch, nv), N·m.
    """

    tde: TdeState
    integral: Array
    scale: Array
    told: Array


@law("sta")
@dataclass(frozen=True, kw_only=True, eq=False)
class Sta(TdeLaw):
    r"""τ = PPC + M̄ (a k₁ √|s| sgn(s) + ϖ),  dϖ/dt = a k₂ sgn(s), ϖ(0) = 0.

    With fixed gains a = 1. With `rate` > 0 they adapt, in the ratio that they have: da/dt = rate·sgn(|s| − threshold),
    never below `floor`; the source lets a rise at a constant rate where it is below.

    The integral is conditioned: where the drive fell short of the torque asked for by more than all of the
    proportional part, in the direction of s, ϖ goes back, so that no limit winds it up. An ideal drive never does.

    Attributes:
        k1: Gain on √|s|, scalar or nv values, at least 0, (rad/s³)^½.
        k2: Gain of the integral, scalar or nv values, at least 0, rad/s³.
        rate: How fast a adapts, at least 0, 1/s; 0 for fixed gains.
        threshold: Size of s above which a grows, above 0, rad/s.
        floor: Least a, above 0.
    """

    title: ClassVar[str] = "super-twisting sliding mode control"
    equation: ClassVar[str] = (
        "τ = PPC + M̄ (a k₁ √|s| sgn(s) + ϖ);  dϖ/dt = a k₂ sgn(s);  da/dt = rate·sgn(|s| − threshold)"
    )
    reference: ClassVar[str] = (
        "Levant (1993), Int. J. Control 58(6); with TDE: Kali et al. (2018), Nonlinear Dyn. 93(2); adaptive: Shtessel, "
        "Taleb, Plestan (2012), Automatica 48(5); conditioned: Seeber, Reichhartinger (2020), Automatica 116"
    )

    k1: PerJoint = PerJoint("k₁, gain on √|s|", "(rad/s³)^½", at_least=0.0)
    k2: PerJoint = PerJoint("k₂, gain of the integral", "rad/s³", at_least=0.0)
    rate: Scalar = Scalar("how fast both gains adapt, over k₁ and k₂; 0: fixed", "1/s", at_least=0.0, default=0.0)
    threshold: Scalar = Scalar("|s| above which they grow", "rad/s", above=0.0, default=0.01)
    floor: Scalar = Scalar("least of them, over k₁ and k₂", above=0.0, default=0.01)

    def init(self, sample: Sample) -> SuperTwistingState:
        """State before the first tick."""
        zero = np.zeros_like(sample.q)
        return SuperTwistingState(self.start(sample), zero, np.maximum(zero + 1.0, self.floor), sample.torque.copy())

    def step(self, state: SuperTwistingState, sample: Sample, setpoint: Setpoint) -> tuple[Array, SuperTwistingState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        torque, s, tde = self.pole_placement(state.tde, sample, setpoint)
        scale = self.adapt(state.scale, s)
        size = scale * self.k1 * np.sqrt(np.abs(s))
        sign = np.copysign(1.0, s + 0.0)
        short = sign * (state.told - sample.torque)
        slack = _ROUNDING * np.abs(state.told)
        way = np.where(short > self.mbar * size + slack, -sign, sign)
        integral = state.integral + self.period * (scale * self.k2) * way
        told = torque + self.mbar * (signed(size, s) + integral)
        return told, SuperTwistingState(tde, integral, scale, told)

    def adapt(self, scale: Array, s: Array) -> Array:
        """a_k from a_{k−1} and s_k; all (batch, nv), s in rad/s."""
        change = self.period * self.rate
        return np.maximum(scale + np.where(np.abs(s) >= self.threshold, change, -change), self.floor)
