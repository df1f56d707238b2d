"""STA: super-twisting, whose torque is continuous because its switching stands under an integral."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import MBAR, OWN, OWN_MEMORY, S, pole_placement, with_sign
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.promises.run_history import Promise
from asmc_pin.controllers.promises.twisting_order import TwistingOrder
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import TdeLaw, TdeState
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import PerJoint, Scalar

ROUNDING = 1e-12
"""Of a torque: a drive that gives as much less than it was told as this has given what it was told."""


class StaState(NamedTuple):
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


K1, K2, RATE, THRESHOLD, FLOOR = range(OWN, OWN + 5)
INTEGRAL, SCALE, TOLD = range(OWN_MEMORY, OWN_MEMORY + 3)


@short_loops
def adapt(scale: float, s: float, change: float, threshold: float, floor: float) -> float:
    """The scale of a joint's gains from that of the last tick, and s; `change` is what it grows or shrinks by."""
    return float(np.maximum(scale + (change if abs(s) >= threshold else -change), floor))


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    pole_placement(tick, law, memory, work, command)
    for i in range(command.size):
        s, told = work[S, i], memory[TOLD, i]
        scale = adapt(memory[SCALE, i], s, law[RATE, i], law[THRESHOLD, i], law[FLOOR, i])
        size = scale * law[K1, i] * np.sqrt(abs(s))
        sign = with_sign(1.0, s)
        # Where the drive fell short by more than all of the proportional part, the integral waits.
        if not sign * (told - tick.torque[i]) > law[MBAR, i] * size + ROUNDING * abs(told):
            memory[INTEGRAL, i] += sign * (scale * law[K2, i])
        command[i] += law[MBAR, i] * (with_sign(size, s) + memory[INTEGRAL, i])
        memory[SCALE, i], memory[TOLD, i] = scale, command[i]


@law("sta")
@dataclass(frozen=True, kw_only=True, eq=False)
class Sta(TdeLaw):
    r"""τ = PPC + M̄ (a k₁ √|s| sgn(s) + ϖ),  dϖ/dt = a k₂ sgn(s), ϖ(0) = 0.

    With fixed gains a = 1. With `rate` > 0 they adapt, in the ratio that they have: da/dt = rate·sgn(|s| − threshold),
    never below `floor`; the source lets a rise at a constant rate where it is below.

    The integral is conditional: where the drive fell short of the torque asked for by more than all of the
    proportional part, in the direction of s, ϖ waits, so that no limit winds it up. An ideal drive never does.

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
        "Levant (1993), Int. J. Control 58(6); with TDE: Kali et al. (2018), Nonlinear Dyn.; adaptive: Shtessel, "
        "Taleb, Plestan (2012), Automatica 48, 759–769"
    )
    oracle: ClassVar[str] = "k₁ = k₂ = 0 is PPC; the mean of w is −N; |s| in the limit cycle is of order L²"
    claim: ClassVar[str] = "s and ds/dt reach 0 in finite time where |dN/dt| is bounded, with a continuous torque."
    fails: ClassVar[str] = (
        "dN/dt is not bounded where friction changes its sign; sampled, s stays within what is of order L²."
    )
    typical: ClassVar[Mapping[str, float | str]] = {"k1": 2.0, "k2": 5.0}

    k1: PerJoint = PerJoint("k₁, gain on √|s|", "(rad/s³)^½", at_least=0.0)
    k2: PerJoint = PerJoint("k₂, gain of the integral", "rad/s³", at_least=0.0)
    rate: Scalar = Scalar("how fast both gains adapt, over k₁ and k₂; 0: fixed", "1/s", at_least=0.0, default=0.0)
    threshold: Scalar = Scalar("|s| above which they grow", "rad/s", above=0.0, default=0.01)
    floor: Scalar = Scalar("least of them, over k₁ and k₂", above=0.0, default=0.01)

    def init(self, sample: Sample) -> StaState:
        """State before the first tick."""
        zero = np.zeros_like(sample.q)
        return StaState(self.start(sample), zero, np.maximum(zero + 1.0, self.floor), sample.torque.copy())

    row_meanings: ClassVar[Mapping[str, str]] = {
        "k1": "k₁, (rad/s³)^½",
        "k2": "L k₂, rad/s²",
        "rate": "change of the gains' scale in a tick, no unit",
        "threshold": "|s| above which the scale grows, rad/s",
        "floor": "least scale, no unit",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """Both gains, the second over a period; what the scale changes by in a period; threshold and floor."""
        return self.k1, self.period * self.k2, self.period * self.rate, self.threshold, self.floor

    trial_step: ClassVar[TrialStep | None] = _step

    def promises(self) -> Mapping[str, Promise | str]:
        """Sliding of second order, with fixed gains; of what adapts no number is claimed."""
        if self.rate > 0.0:
            return {
                "second_order": "with gains that adapt its source claims |s| near the threshold, and no order in L",
                "gain": "its source proves that its gains are bounded, and gives no number to hold them to",
            }
        fixed = {"gain": "its gains are fixed"}
        if not (np.all(self.k1 > 0.0) and np.all(self.k2 > 0.0)):
            return {"second_order": "without both k₁ and k₂ it does not twist", **fixed}
        return {"second_order": TwistingOrder(self.k1, self.k2, self.period), **fixed}
