"""ISM: switching about an integral surface that starts at 0, so that there is no reaching phase."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import (
    MBAR,
    OWN,
    OWN_MEMORY,
    PAST_ACCELERATION,
    PAST_TORQUE,
    PERIOD,
    WANTED,
    tde_terms,
    with_sign,
)
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import TdeLaw, TdeState
from asmc_pin.parameters import PerJoint


class IntegralSurfaceState(NamedTuple):
    """What the law remembers.

    Attributes:
        tde: What the estimation remembers.
        load: Γ̂ of the last tick, (batch, nv), rad/s².
        surface: σ less the switching term's part of the period that runs, (batch, nv), rad/s.
    """

    tde: TdeState
    load: Array
    surface: Array


GAIN, LOAD, SURFACE = OWN, OWN_MEMORY, OWN_MEMORY + 1


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    tde_terms(tick, law, memory, work)
    for i in range(command.size):
        load = work[PAST_ACCELERATION, i] - work[PAST_TORQUE, i] / law[MBAR, i]
        sigma = memory[SURFACE, i] - law[PERIOD, i] * (load - memory[LOAD, i])
        w = with_sign(law[GAIN, i], sigma)
        memory[LOAD, i], memory[SURFACE, i] = load, sigma - law[PERIOD, i] * w
        command[i] = law[MBAR, i] * (work[WANTED, i] + w - load)


@law("ism")
@dataclass(frozen=True, kw_only=True, eq=False)
class Ism(TdeLaw):
    r"""τ = PPC + M̄ K sgn(σ),  σ = ė + (K_s + β) e + β K_s ∫e, less its value at t = 0.

    Sampled as σ_k = σ_{k−1} + L (u⁰_{k−1} − q̈̂_k), with u⁰ what (7) asks for: σ_{k+1} = σ_k − L (w_k + N_k) exactly,
    from σ₀ = 0. As in `Ivf`, u⁰ of a period is M̄⁻¹τ + Γ̂ − w with the torque that was really applied, so that
    σ_k = σ_{k−1} − L w_{k−1} − L (Γ̂_k − Γ̂_{k−1}), and limits wind nothing up. K has to exceed |N|.

    Attributes:
        gain: K, scalar or nv values, at least 0, rad/s².
    """

    title: ClassVar[str] = "integral sliding mode control (TDC with switching action)"
    equation: ClassVar[str] = "τ = PPC + M̄ K sgn(σ);  σ = ∫ (q̈_d + K_s ė + β s) dt − q̇, 0 at the start"
    reference: ClassVar[str] = "Utkin, Shi (1996), IEEE Conf. Decision and Control; with TDE: Chang, Park (2003)"
    oracle: ClassVar[str] = "σ₀ = 0, σ_{k+1} = σ_k − L(w_k + N_k)"
    claim: ClassVar[str] = "No reaching phase: σ = 0 from the start where K > |N|."
    fails: ClassVar[str] = "Explicit sgn chatters: σ moves by L K a period, and the torque by 2 M̄ K."
    typical: ClassVar[Mapping[str, float | str]] = {"gain": 2.0}

    gain: PerJoint = PerJoint("K", "rad/s²", at_least=0.0)

    def init(self, sample: Sample) -> IntegralSurfaceState:
        """State before the first tick; σ₀ = 0."""
        return IntegralSurfaceState(self.start(sample), -sample.torque / self.mbar, np.zeros_like(sample.q))

    row_meanings: ClassVar[Mapping[str, str]] = {
        "gain": "K, rad/s²",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """The gain K."""
        return (self.gain,)

    trial_step: ClassVar[TrialStep | None] = _step
