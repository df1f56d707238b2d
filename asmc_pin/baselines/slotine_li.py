"""Adaptive control after Slotine and Li: the dynamics' structure known, its inertial parameters learned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.baselines.model_law import ModelLaw, model_law
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import sliding_variable
from asmc_pin.parameters import PerJoint, Scalar


class LearnedState(NamedTuple):
    """What the law remembers.

    Attributes:
        parameters: θ̂, (batch, parameters); see `asmc_pin.arms.Arm.inertial_parameters`.
        told: Torque asked for at the last tick, (batch, nv), N·m.
    """

    parameters: Array
    told: Array


@model_law("slotine_li")
@dataclass(frozen=True, kw_only=True, eq=False)
class SlotineLi(ModelLaw):
    r"""τ = Y(q, q̇, q̇_r, q̈_r) θ̂ + K_d s,  dθ̂/dt = γ Yᵀ s,  with q̇_r = q̇_d + K_s e, s = q̇_r − q̇, which is (4).

    Y is the regressor in its two-velocity form, Y θ = M q̈_r + C(q, q̇) q̇_r + g, so that Ṁ − 2C is skew-symmetric and
    V = ½ sᵀMs + ½ θ̃ᵀθ̃/γ falls: V̇ = −sᵀK_d s, whatever θ̂ begins with. Sampled, V rises by what is of order L.
    It begins with the model's parameters, of which `mass_scale` and `payload` state the error; friction is not in it.
    While a drive falls short of the torque asked for in the direction of its s, that joint teaches nothing.

    Attributes:
        ks: Diagonal of K_s, scalar or nv values, above 0, 1/s.
        kd: Diagonal of K_d, scalar or nv values, above 0, N·m·s/rad.
        rate: γ, at least 0, the same for every parameter in SI units; 0 for a fixed model (Paden and Panja's law).
    """

    title: ClassVar[str] = "adaptive control after Slotine and Li"
    equation: ClassVar[str] = "τ = Y(q, q̇, q̇_r, q̈_r) θ̂ + K_d s;  dθ̂/dt = γ Yᵀ s;  q̇_r = q̇_d + K_s e"
    reference: ClassVar[str] = "Slotine, Li (1987), Int. J. Robotics Research 6(3), 10.1177/027836498700600303"
    oracle: ClassVar[str] = "Y θ = M q̈_r + C q̇_r + g to round-off; V = ½sᵀMs + ½θ̃ᵀθ̃/γ rises by order L at most, sampled"
    claim: ClassVar[str] = "s goes to 0 whatever the parameters begin with."
    fails: ClassVar[str] = (
        "Friction is not in the regressor: it is learned into inertial parameters, which then "
        "drift; held torque bounds k_d by 2m/L."
    )
    typical: ClassVar[Mapping[str, float]] = {"ks": 8.0, "kd": 10.0, "rate": 0.1}

    ks: PerJoint = PerJoint("diagonal of K_s", "1/s", above=0.0)
    kd: PerJoint = PerJoint("diagonal of K_d", "N·m·s/rad", above=0.0)
    rate: Scalar = Scalar("γ, how fast the parameters are learned", at_least=0.0)

    def init(self, sample: Sample) -> LearnedState:
        """State before the first tick: the model's parameters, the armature's without `mass_scale`."""
        super().init(sample)
        scale = np.full(self.model.inertial_parameters.size, self.mass_scale)
        scale[-self.model.nv :] = 1.0
        known = np.tile(scale * self.model.inertial_parameters, (len(sample.q), 1))
        return LearnedState(known, sample.torque.copy())

    def step(self, state: LearnedState, sample: Sample, setpoint: Setpoint) -> tuple[Array, LearnedState]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        s = sliding_variable(self.ks, sample, setpoint)
        velocity = sample.v + s
        acceleration = setpoint.a + self.ks * (setpoint.v - sample.v)
        regressor = self.model.regressor(sample.q, sample.v, velocity, acceleration)
        short = (state.told - sample.torque) * np.sign(s) > self.kd * np.abs(s)
        taught = np.where(short, 0.0, s)
        # Every row by itself, so that a trial's torque does not depend on the batch it runs in.
        learned = np.matmul(np.swapaxes(regressor, -1, -2), taught[..., None])[..., 0]
        parameters = state.parameters + self.period * self.rate * learned
        torque = np.matmul(regressor, parameters[..., None])[..., 0] + self.kd * s
        return torque, LearnedState(parameters, torque)
