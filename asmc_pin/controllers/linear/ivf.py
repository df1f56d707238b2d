"""IVF: time-delay estimation with ideal velocity feedback, an integral of what the estimate misses."""

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
)
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import TdeLaw, TdeState
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import PerJoint


class IdealVelocityState(NamedTuple):
    """What the law remembers.

    Attributes:
        tde: What the estimation remembers.
        load: Γ̂ of the last tick, (batch, nv), rad/s².
        ahead: z, ideal velocity less the velocity, (batch, nv), rad/s.
    """

    tde: TdeState
    load: Array
    ahead: Array


GAIN, LOAD, AHEAD = OWN, OWN_MEMORY, OWN_MEMORY + 1


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    tde_terms(tick, law, memory, work)
    for i in range(command.size):
        load = work[PAST_ACCELERATION, i] - work[PAST_TORQUE, i] / law[MBAR, i]
        # At the first tick Γ̂ is that of the held torque, so that z starts from 0.
        fading = (1.0 - law[PERIOD, i] * law[GAIN, i]) * memory[AHEAD, i]
        memory[AHEAD, i] = fading - law[PERIOD, i] * (load - memory[LOAD, i])
        memory[LOAD, i] = load
        command[i] = law[MBAR, i] * (work[WANTED, i] + law[GAIN, i] * memory[AHEAD, i] - load)


@law("ivf")
@dataclass(frozen=True, kw_only=True, eq=False)
class Ivf(TdeLaw):
    r"""τ = PPC + M̄ G z,  z = ∫ (what (7) asks for) dt − q̇, which is ideal velocity less velocity.

    With the TDE error N the velocity leaves the ideal one by −∫(N + G z) dt, so that z_{k+1} = (1 − LG) z_k − L N_k: N
    reaches the motion through s/(s + G), and a load that drifts steadily leaves no error.

    What (7) asked for in a period, less G z, is M̄⁻¹τ + Γ̂ of its tick, and so z follows from Γ̂ alone, with the torque
    that was really applied: z_k = (1 − LG) z_{k−1} − L (Γ̂_k − Γ̂_{k−1}). Without limits that is the integral above, to
    the last term; within them nothing winds up, for what the drive did not give is not asked for again.

    Attributes:
        gain: G, at least 0 and below 2/L, 1/s; scalar or nv values.

    Raises:
        ParameterError: as of `TdeLaw`, or G ≥ 2/L, with which z would grow without bound.
    """

    title: ClassVar[str] = "time-delay control with ideal velocity feedback"
    equation: ClassVar[str] = "τ = PPC + M̄ G z;  z = ∫ (q̈_d + K_s ė + β s) dt − q̇"
    reference: ClassVar[str] = "Jin, Kang, Chang (2008), IEEE Trans. Ind. Electron."
    oracle: ClassVar[str] = "z_{k+1} = (1 − LG) z_k − L N_k; a steadily drifting load leaves no error"
    claim: ClassVar[str] = "The TDE error reaches the motion through s/(s + G)."
    fails: ClassVar[str] = "G adds lag: large G with small a is unstable, which `asmc-pin stability --law ivf` tells."
    typical: ClassVar[Mapping[str, float | str]] = {"gain": 5.0}

    gain: PerJoint = PerJoint("G", "1/s", at_least=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.any(self.period * self.gain >= 2.0):
            raise ParameterError(
                "gain", f"got {self.gain.tolist()}; with a period of {self.period:g} s it must be below 2/L 1/s"
            )

    def init(self, sample: Sample) -> IdealVelocityState:
        """State before the first tick; z₀ = 0."""
        return IdealVelocityState(self.start(sample), -sample.torque / self.mbar, np.zeros_like(sample.q))

    row_meanings: ClassVar[Mapping[str, str]] = {
        "gain": "G, 1/s",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """The gain G."""
        return (self.gain,)

    trial_step: ClassVar[TrialStep | None] = _step
