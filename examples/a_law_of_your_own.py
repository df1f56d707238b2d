"""A control law of your own, super-twisting on top of PPC, run on an arm that it never sees."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import asmc_pin
from asmc_pin import PerJoint, TdeLaw, TdeState, signed


class State(NamedTuple):
    """The state of the time-delay estimation, and the integral part, (batch, nv), rad/s²."""

    tde: TdeState
    w: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class SuperTwisting(TdeLaw):
    """τ = PPC + M̄ (k₁ √|s| sgn(s) + w),  dw/dt = k₂ sgn(s)."""

    k1: PerJoint = PerJoint("gain on √|s|", "(rad/s³)^½", at_least=0.0)
    k2: PerJoint = PerJoint("integral gain", "rad/s³", at_least=0.0)

    def init(self, sample):
        """The state before the first tick."""
        return State(self.start(sample), np.zeros_like(sample.q))

    def step(self, state, sample, setpoint):
        """One tick: the torque to hold, and the next state."""
        torque, s, tde = self.pole_placement(state.tde, sample, setpoint)
        w = state.w + self.period * signed(self.k2, s)
        return torque + self.mbar * (signed(self.k1 * np.sqrt(np.abs(s)), s) + w), State(tde, w)


plant = asmc_pin.Plant(asmc_pin.load_arm("two_link"), friction=asmc_pin.Friction(coulomb=2.0, viscous=0.5))
motion = asmc_pin.REFERENCES["quintic"](start=[0.0, 0.0], targets=[0.5, -0.4], move=1.0)
shared = {"mbar": 0.02, "ks": 20.0, "beta": 20.0, "period": 0.001}
for law in (asmc_pin.CONTROLLERS["ppc"](**shared), SuperTwisting(**shared, k1=1.0, k2=2.0)):
    run = asmc_pin.rollout(plant, law, motion, duration=1.2)
    assert run.status == ("ok",)
    print(f"{type(law).__name__}: RMS error {np.degrees(asmc_pin.METRICS['rms_error'](run)[0]).round(4)} deg")
