"""DOB: time-delay estimation with the whole estimate low-passed, which is a disturbance observer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

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
    WANTED,
    tde_terms,
)
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import TdeLaw, TdeState
from asmc_pin.parameters import Scalar


class ObserverState(NamedTuple):
    """What the law remembers.

    Attributes:
        tde: What the estimation remembers.
        load: Γ̂ of the last tick, low-passed, (batch, nv), rad/s².
    """

    tde: TdeState
    load: Array


WEIGHT, LOAD = OWN, OWN_MEMORY


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    tde_terms(tick, law, memory, work)
    for i in range(command.size):
        newest = work[PAST_ACCELERATION, i] - work[PAST_TORQUE, i] / law[MBAR, i]
        memory[LOAD, i] += law[WEIGHT, i] * (newest - memory[LOAD, i])
        command[i] = law[MBAR, i] * (work[WANTED, i] - memory[LOAD, i])


@law("dob")
@dataclass(frozen=True, kw_only=True, eq=False)
class Dob(TdeLaw):
    r"""τ = M̄ (q̈_d + K_s ė + β s − Γ̂),  Γ̂_k = Γ̂_{k−1} + c (q̈̂_k − M̄⁻¹ τ(t−L) − Γ̂_{k−1}),  c = 1 − exp(−2π f L).

    `filter_hz` low-passes q̈ alone and leaves the torque as it is; here both sides of the estimate are. On a joint of
    constant inertia the estimation error shrinks by 1 − c a instead of 1 − a, a = m̄/m: the condition on M̄ becomes one
    on cM̄, so that the stiffness of the feedback (M̄) and the bandwidth of the estimate (c) are chosen apart.

    Attributes:
        cutoff_hz: f, the corner of the low-pass, above 0, Hz; inf for none, which is PPC.
    """

    title: ClassVar[str] = "disturbance observer (TDE with the whole estimate low-passed)"
    equation: ClassVar[str] = "τ = M̄ (q̈_d + K_s ė + β s − Γ̂);  Γ̂ = Γ̂(t−L) + c (q̈(t−L) − M̄⁻¹τ(t−L) − Γ̂(t−L))"
    reference: ClassVar[str] = "Umeno, Hori (1991), IEEE Trans. Ind. Electron., in the form of (6)"
    oracle: ClassVar[str] = "N_k = (1 − c a)N_{k−1} + (1 − a)(u_{k−1} − u_k) − Δh/m; the edge is c·a = 2"
    claim: ClassVar[str] = (
        "The condition on M̄ is that on cM̄, so that stiffness and bandwidth of the estimate are chosen apart."
    )
    fails: ClassVar[str] = "A low corner follows the load late: under a drifting load the error is that of PPC over c."
    separates: ClassVar[bool] = True
    typical: ClassVar[Mapping[str, float | str]] = {"cutoff_hz": 50.0}

    cutoff_hz: Scalar = Scalar("corner of the low-pass on Γ̂; inf for none", "Hz", above=0.0, infinite=True)

    @property
    def estimate_weight(self) -> Any:
        """c, the share of the newest Γ̂ in a step of its low-pass, above 0 and at most 1."""
        return -np.expm1(-2.0 * np.pi * self.cutoff_hz * self.period)

    def init(self, sample: Sample) -> ObserverState:
        """State before the first tick; Γ̂ is that of the torque held at rest, −M̄⁻¹ τ(0)."""
        return ObserverState(self.start(sample), -sample.torque / self.mbar)

    row_meanings: ClassVar[Mapping[str, str]] = {
        "weight": "c, weight of the newest Γ̂ in its low-pass, no unit",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """The weight c."""
        return (self.estimate_weight,)

    trial_step: ClassVar[TrialStep | None] = _step
