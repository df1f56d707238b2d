"""Computed torque: the arm's own dynamics cancelled, and a linear error equation left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.baselines.model_law import ModelLaw, model_law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import sliding_variable
from asmc_pin.parameters import PerJoint, Scalar


@model_law("computed_torque")
@dataclass(frozen=True, kw_only=True, eq=False)
class ComputedTorque(ModelLaw):
    """τ = M̂(q)(q̈_d + K_s ė + β s) + Ĉ(q, q̇)q̇ + ĝ(q) + f̂.

    With an exact model in continuous time the error obeys ë + (K_s + βI) ė + βK_s e = 0: equation (8) of Baek 2016
    without its estimation error, so with the same K_s and β it is what PPC would be if it knew Γ.

    Attributes:
        ks: Diagonal of K_s, scalar or nv values, above 0, 1/s.
        beta: β, above 0, 1/s.
        coulomb: Coulomb friction of the model, scalar or nv values, at least 0, N·m; 0 for a model without. Its sign is
            that of the desired velocity, 0 at rest: the measured one would switch it at random where a joint sticks.
        viscous: Viscous friction of the model, scalar or nv values, at least 0, N·m·s/rad, at the measured velocity.
    """

    title: ClassVar[str] = "computed torque"
    equation: ClassVar[str] = "τ = M̂(q)(q̈_d + K_s ė + β s) + Ĉ q̇ + ĝ + coulomb·sgn(q̇_d) + viscous·q̇"
    reference: ClassVar[str] = "Siciliano, Sciavicco, Villani, Oriolo (2009), Robotics"
    oracle: ClassVar[str] = "with a true model ë + (K_s + β) ė + β K_s e = 0, sampled but for order L"
    claim: ClassVar[str] = "What PPC would be if it knew Γ: the error dies as its poles say, whatever the motion."
    fails: ClassVar[str] = "A model error enters as a load M̂⁻¹(ΔM q̈ + Δh) that nothing learns or estimates."
    typical: ClassVar[Mapping[str, float]] = {"ks": 40.0, "beta": 40.0}

    ks: PerJoint = PerJoint("diagonal of K_s", "1/s", above=0.0)
    beta: Scalar = Scalar("β", "1/s", above=0.0)
    coulomb: PerJoint = PerJoint("Coulomb friction of the model", "N·m", at_least=0.0, default=0.0)
    viscous: PerJoint = PerJoint("viscous friction of the model", "N·m·s/rad", at_least=0.0, default=0.0)

    def step(self, state: None, sample: Sample, setpoint: Setpoint) -> tuple[Array, None]:
        """Torque to hold over the next period, (batch, nv), N·m, and no state."""
        s = sliding_variable(self.ks, sample, setpoint)
        wanted = setpoint.a + self.ks * (setpoint.v - sample.v) + self.beta * s
        friction = self.coulomb * np.sign(setpoint.v) + self.viscous * sample.v
        return self.inertial_torque(sample.q, wanted) + self.bias(sample.q, sample.v) + friction, None
