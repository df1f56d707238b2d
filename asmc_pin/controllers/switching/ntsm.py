"""NTSM: nonsingular terminal sliding mode control, which reaches e = 0 in a finite time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import TdeLaw, TdeState, signed
from asmc_pin.parameters import PerJoint, Scalar


@law("ntsm")
@dataclass(frozen=True, kw_only=True, eq=False)
class Ntsm(TdeLaw):
    r"""τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + (B/p) ⌈ė⌋^{2−p} + β B σ + K sat(σ/Φ)),  σ = e + (1/B) ⌈ė⌋^p.

    ⌈x⌋^p = |x|^p sgn x. On σ = 0 the error obeys ė = −(B e)^{1/p}: |e|^{1−1/p} falls linearly, to 0 at
    t = |e₀|^{1−1/p} / (B^{1/p} (1 − 1/p)). With p = 1 the law is PPC with K_s = B. The logged s is that of (4), with
    `ks`; σ is not a velocity.

    Attributes:
        exponent: p, at least 1, below 2; between odd numbers' ratios such as 9/7 and 5/3 it is commonly chosen.
        stiffness: B, scalar or nv values, above 0, with e in rad and ė in rad/s; 1/s for p = 1.
        gain: K, scalar or nv values, at least 0, rad/s².
        boundary: Φ, the half-width of the boundary layer in σ, scalar or nv values, above 0, rad.
    """

    title: ClassVar[str] = "nonsingular terminal sliding mode control"
    equation: ClassVar[str] = (
        "τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + (B/p) ⌈ė⌋^{2−p} + β B σ + K sat(σ/Φ));  σ = e + ⌈ė⌋^p / B"
    )
    reference: ClassVar[str] = (
        "Feng, Yu, Man (2002), Automatica 38(12); with TDE: Jin, Lee, Chang, Choi (2009), IEEE TIE 56(9)"
    )

    exponent: Scalar = Scalar("p", at_least=1.0, below=2.0, default=5.0 / 3.0)
    stiffness: PerJoint = PerJoint("B", "(rad/s)^p/rad", above=0.0)
    gain: PerJoint = PerJoint("K", "rad/s²", at_least=0.0)
    boundary: PerJoint = PerJoint("Φ", "rad", above=0.0)

    def step(self, state: TdeState, sample: Sample, setpoint: Setpoint) -> tuple[Array, TdeState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        load, state = self.load_estimate(state, sample)
        rate = setpoint.v - sample.v
        surface = self.surface(setpoint.q - sample.q, rate)
        slide = self.stiffness / self.exponent * signed(np.abs(rate) ** (2.0 - self.exponent), rate)
        inside = np.minimum(np.maximum(surface, -self.boundary), self.boundary) / self.boundary
        w = self.beta * self.stiffness * surface + self.gain * inside
        return self.mbar * (setpoint.a + slide + w - load), state

    def surface(self, error: Array, rate: Array) -> Array:
        """σ = e + ⌈ė⌋^p / B, rad."""
        return error + signed(np.abs(rate) ** self.exponent, rate) / self.stiffness
