"""PD control with gravity compensation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from asmc_pin._typing import Array
from asmc_pin.baselines.model_law import ModelLaw, model_law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.parameters import PerJoint


@model_law("pd_gravity")
@dataclass(frozen=True, kw_only=True, eq=False)
class PdGravity(ModelLaw):
    """τ = K_p e + K_d ė + ĝ(q).

    Asymptotically stable at every standing reference when ĝ = g and nothing rubs (Takegaki and Arimoto); a moving one
    it follows with a lag that shrinks as the gains grow.

    Attributes:
        kp: Diagonal of K_p, scalar or nv values, above 0, N·m/rad.
        kd: Diagonal of K_d, scalar or nv values, above 0, N·m·s/rad.
    """

    title: ClassVar[str] = "PD with gravity compensation"
    equation: ClassVar[str] = "τ = K_p e + K_d ė + ĝ(q)"
    reference: ClassVar[str] = "Takegaki, Arimoto (1981), J. Dyn. Syst. Meas. Control 103(2)"
    oracle: ClassVar[str] = "at rest K_p e is the load that ĝ misses"
    claim: ClassVar[str] = "Asymptotically stable at every standing reference where ĝ = g and nothing rubs."
    fails: ClassVar[str] = (
        "A moving reference is followed with a lag, friction leaves f/k_p, and held torque bounds k_d by 2m/L."
    )
    typical: ClassVar[Mapping[str, float]] = {"kp": 200.0, "kd": 15.0}

    kp: PerJoint = PerJoint("diagonal of K_p", "N·m/rad", above=0.0)
    kd: PerJoint = PerJoint("diagonal of K_d", "N·m·s/rad", above=0.0)

    def step(self, state: None, sample: Sample, setpoint: Setpoint) -> tuple[Array, None]:
        """Torque to hold over the next period, (batch, nv), N·m, and no state."""
        error, rate = setpoint.q - sample.q, setpoint.v - sample.v
        return self.kp * error + self.kd * rate + self.gravity(sample.q), None
