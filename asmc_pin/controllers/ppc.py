"""PPC: pole-placement control with time-delay estimation, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import plain_step
from asmc_pin.controllers.one_trial.trial_step import TrialStep
from asmc_pin.controllers.tde import TdeLaw


@law("ppc")
@dataclass(frozen=True, kw_only=True, eq=False)
class Ppc(TdeLaw):
    """Baek 2016 (7): τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + K_s ė + β s). Parameters: those of `TdeLaw`."""

    title: ClassVar[str] = "pole placement with time-delay estimation (PPC)"
    equation: ClassVar[str] = "τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + K_s ė + β s)"
    reference: ClassVar[str] = "Baek, Jin, Han (2016), eq. (7)"
    oracle: ClassVar[str] = "N_k = (1 − a)N_{k−1} + (1 − a)(u_{k−1} − u_k) − Δh/m on one joint"
    claim: ClassVar[str] = "The TDE error stays bounded where ‖I − M⁻¹M̄‖ < 1 (Lemma 1)."
    fails: ClassVar[str] = (
        "Where a is small against the gains, sampled; where velocity is a difference and its torque is not the "
        "mean of two; under a drifting load it keeps the error L ḣ/(m̄βk_s)."
    )

    trial_step: ClassVar[TrialStep | None] = plain_step

    def switching_term(self, s: Array, gain: Array) -> Array:
        """Nothing is added to PPC: 0 at every tick; see `TdeLaw.switching_term`."""
        return np.zeros_like(s)
