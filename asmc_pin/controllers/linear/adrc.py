"""ADRC: a linear extended state observer per joint, from position alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import BETA, KS, MBAR, OWN, PERIOD, surface
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.parameters import Scalar


class ExtendedState(NamedTuple):
    """What the observer remembers, after the last reading; each (batch, nv).

    Attributes:
        position: ẑ₁, rad.
        velocity: ẑ₂, rad/s.
        load: ẑ₃, the acceleration that the torque does not explain, rad/s².
        ticks: Number of ticks taken.
    """

    position: Array
    velocity: Array
    load: Array
    ticks: int


FIRST, SECOND, THIRD = range(OWN, OWN + 3)
Z1, Z2, Z3 = range(3)


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    for i in range(command.size):
        z1, z2, z3 = memory[Z1, i], memory[Z2, i], memory[Z3, i]
        if tick.ticks > 0:
            period, pushed = law[PERIOD, i], tick.torque[i] / law[MBAR, i] + z3
            ahead = z1 + period * z2 + 0.5 * period * period * pushed
            miss = tick.q[i] - ahead
            z1, z2, z3 = (
                ahead + law[FIRST, i] * miss,
                z2 + period * pushed + law[SECOND, i] * miss,
                z3 + law[THIRD, i] * miss,
            )
            memory[Z1, i], memory[Z2, i], memory[Z3, i] = z1, z2, z3
        rate = tick.v_ref[i] - z2
        wanted = (
            tick.a_ref[i] + law[KS, i] * rate + law[BETA, i] * surface(law[KS, i], z1, z2, tick.q_ref[i], tick.v_ref[i])
        )
        command[i] = law[MBAR, i] * (wanted - z3)


@law("adrc")
@dataclass(frozen=True, kw_only=True, eq=False)
class Adrc(TdeLaw):
    r"""τ = M̄ (q̈_d + (K_s + β)(q̇_d − ẑ₂) + β K_s (q_d − ẑ₁) − ẑ₃), with ẑ of an extended state observer.

    The observer predicts over a period with M̄⁻¹ times the torque that was applied, and corrects by the angle that is
    read now (current form): ẑ⁻ = A ẑ + B M̄⁻¹τ(t−L), ẑ = ẑ⁻ + l (q − ẑ⁻₁), with A, B of a double integrator and a
    constant load, and l such that all three poles of the observer are z_o = exp(−2π f L). Of velocities it sees only
    that of t = 0; `acceleration`, `filter_hz` and `pairing` are without effect.

    Attributes:
        observer_hz: f, the observer's bandwidth, above 0, Hz; inf for a deadbeat one, whose load is that of
            time-delay estimation from position, with the torques of two periods.
    """

    title: ClassVar[str] = "active disturbance rejection control, from position only"
    equation: ClassVar[str] = "τ = M̄ (q̈_d + (K_s + β)(q̇_d − ẑ₂) + β K_s (q_d − ẑ₁) − ẑ₃), ẑ of an observer of q"
    estimates: ClassVar[bool] = False
    reference: ClassVar[str] = "Gao (2003), American Control Conf.; current form as Miklosovic, Radke, Gao (2006)"
    oracle: ClassVar[str] = "the observer's error obeys (z − z_o)³ = 0; deadbeat its load is the mean of the last two"
    claim: ClassVar[str] = "A load is estimated and taken out from position alone."
    fails: ClassVar[str] = "A slow observer adds lag to the velocity too: K_s + β has to stay well below 2πf."
    typical: ClassVar[Mapping[str, float | str]] = {"observer_hz": 100.0}

    observer_hz: Scalar = Scalar("bandwidth of the observer; inf for a deadbeat one", "Hz", above=0.0, infinite=True)

    @property
    def observer_pole(self) -> Any:
        """z_o, the threefold pole of the observer, at least 0 and below 1."""
        return np.exp(-2.0 * np.pi * self.observer_hz * self.period)

    @property
    def observer_gains(self) -> tuple[Any, Any, Any]:
        """l, for which (ẑ − z_o)³ = 0: 1, 1/s and 1/s²."""
        pole, length = self.observer_pole, self.period
        rest = 1.0 - pole
        return 1.0 - pole**3, 1.5 / length * rest**2 * (1.0 + pole), rest**3 / length**2

    def init(self, sample: Sample) -> ExtendedState:
        """State before the first tick: at rest, or moving on unaccelerated, under the torque that is held."""
        self.start(sample)
        return ExtendedState(sample.q.copy(), sample.v.copy(), -sample.torque / self.mbar, 0)

    row_meanings: ClassVar[Mapping[str, str]] = {
        "first": "gain of the observer on the angle, no unit",
        "second": "gain of the observer on the velocity, 1/s",
        "third": "gain of the observer on the load, 1/s²",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """The observer's gains l."""
        return self.observer_gains

    trial_step: ClassVar[TrialStep | None] = _step
