"""Barrier-function adaptive sliding mode control: a gain that is as large as s needs it, and no larger."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import MBAR, OWN, OWN_MEMORY, S, pole_placement, with_sign
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.promises.bounded_gain import NotOverestimated
from asmc_pin.controllers.promises.kept_width import KeptWidth
from asmc_pin.controllers.promises.run_history import Promise
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import AdaptiveState, TdeLaw, signed
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import Scalar

WIDTH, LIMIT = OWN, OWN + 1
GAIN = OWN_MEMORY


@short_loops
def barrier_gain(s: float, width: float, limit: float) -> float:
    """The gain of one joint at s, rad/s²."""
    size = abs(s)
    room = width - size
    # |s| < U (ε − |s|) is where the quotient is below U; it is taken there alone. A nan has to show.
    return size / room if size < limit * room else limit + 0.0 * s


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    pole_placement(tick, law, memory, work, command)
    for i in range(command.size):
        memory[GAIN, i] = barrier_gain(work[S, i], law[WIDTH, i], law[LIMIT, i])
        command[i] += law[MBAR, i] * with_sign(memory[GAIN, i], work[S, i])


@law("barrier")
@dataclass(frozen=True, kw_only=True, eq=False)
class Barrier(TdeLaw):
    r"""τ = PPC + M̄ k̂ sgn(s),  k̂ = min(U, |s|/(ε − |s|) rad/s²) where |s| < ε, else U.

    The positive semi-definite barrier function, with a unit gain of 1 rad/s². There is no rate to tune and no gain is
    over-estimated: a load n (rad/s²) that stands is met at |s| = ε n/(1 + n). In continuous time |s| < ε is kept for
    ever once reached; sampled, only where U, L and ε fit each other.

    Attributes:
        width: ε, above 0, rad/s.
        limit: U, the largest k̂, above 0, rad/s².
    """

    title: ClassVar[str] = "barrier-function adaptive sliding mode control"
    equation: ClassVar[str] = "τ = PPC + M̄ k̂ sgn(s);  k̂ = min(U, |s|/(ε − |s|)) if |s| < ε, else U"
    reference: ClassVar[str] = "Obeid, Fridman, Laghrouche, Harmouche (2018), Automatica; sampled: Ovalle et al. (2025)"
    oracle: ClassVar[str] = "|s|/ε = n/(1 + n), n = |N| − β|s|, under a load that stands"
    claim: ClassVar[str] = "|s| < ε once it is reached, without a gain that is larger than needed."
    fails: ClassVar[str] = "Sampled it is false unless U, L and ε fit: a period moves s by up to g(U + |N|)."
    band_remedy: ClassVar[str] = "widen its ε (width)"
    typical: ClassVar[Mapping[str, float | str]] = {"width": 0.05, "limit": 20.0}

    width: Scalar = Scalar("ε", "rad/s", above=0.0)
    limit: Scalar = Scalar("U, the largest k̂", "rad/s²", above=0.0)

    def init(self, sample: Sample) -> AdaptiveState:
        """State before the first tick; k̂ is that of s = 0."""
        return AdaptiveState(self.start(sample), np.zeros(sample.q.shape))

    row_meanings: ClassVar[Mapping[str, str]] = {
        "width": "ε, rad/s",
        "limit": "U, the largest k̂, rad/s²",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """Width and limit."""
        return self.width, self.limit

    trial_step: ClassVar[TrialStep | None] = _step

    def promises(self) -> Mapping[str, Promise | str]:
        """That |s| < ε is kept, and that no gain is over-estimated."""
        kept = KeptWidth(self.width, self.limit, self.ks, self.beta, self.period)
        return {"width": kept, "gain": NotOverestimated(kept)}

    def switching_term(self, s: Array, gain: Array) -> Array:
        """The term w = k̂ sgn(s) at the ticks of a run; see `TdeLaw.switching_term`."""
        return signed(gain, s)
