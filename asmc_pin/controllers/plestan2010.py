"""The existing adaptive sliding mode control: one gain for all joints, growing and shrinking in proportion to ‖s‖."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import MBAR, OWN, OWN_MEMORY, S, pole_placement
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.promises.bounded_gain import BoundedByEnergy
from asmc_pin.controllers.promises.run_history import Promise
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.switching.backward_euler import band_slopes, share_scalar, switched, switching_choice
from asmc_pin.controllers.tde import AdaptiveState, TdeLaw, signed
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import Choice, Scalar, ScalarOrWord

RATE, EPSILON, EPSILON_PER_GAIN, FLOOR, RISE, EXPLICIT, OF_S, OF_RATE = range(OWN, OWN + 8)
GAIN = OWN_MEMORY


@short_loops
def adapt(law: Array, s: Array, gain: float) -> float:
    """k̂_k of all joints from k̂_{k−1}, rad/s², and s_k, rad/s.

    k̂_k = max(μ, k̂_{k−1} + L k̄ ‖s‖ sgn(‖s‖ − ε)) if k̂_{k−1} > μ, else k̂_{k−1} + L μ; sgn(0) = +1.
    ε = 4 k̂_{k−1} L if it is ``"4KL"``.
    """
    size = 0.0
    for i in range(s.size):
        size += s[i] * s[i]
    size = float(np.sqrt(size))
    if not gain > law[FLOOR, 0]:
        return gain + float(law[RISE, 0])
    outside = size >= law[EPSILON, 0] + law[EPSILON_PER_GAIN, 0] * gain
    return float(np.maximum(law[FLOOR, 0], gain + law[RATE, 0] * (size if outside else -size)))


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    pole_placement(tick, law, memory, work, command)
    gain = adapt(law, work[S], memory[GAIN, 0])
    for i in range(command.size):
        memory[GAIN, i] = gain
        inside = law[OF_S, i] * work[S, i] + law[OF_RATE, i] * (tick.v_ref[i] - tick.v[i])
        command[i] += law[MBAR, i] * switched(law[EXPLICIT, 0], gain, work[S, i], inside)


@law("plestan2010")
@dataclass(frozen=True, kw_only=True, eq=False)
class Plestan2010(TdeLaw):
    """τ = PPC + M̄ k̂ sgn(s) with one k̂ ≥ μ shared by all joints.

    Plestan, Shtessel, Bregeault, Poznyak (2010), "New methodologies for adaptive sliding mode control",
    Int. J. Control 83(9), as Baek 2016 compares with it (reference [27] there).

    Attributes:
        rate: k̄, at least 0, rad/s² per rad: k̂ changes at the rate k̄ ‖s‖₂.
        epsilon: ε, the size of ‖s‖₂ below which k̂ shrinks, above 0, rad/s; or ``"4KL"``, the authors' own choice for a
            sampled law whose plant is nominally inverted, as TDE does: 4 k̂_{k−1} L. By how much k̂ switches s within a
            period it can then tell from s itself.
        floor: μ, the least k̂ and its value at the start, above 0, rad/s²; at the floor k̂ grows at μ per second.
        switching: ``"explicit"``, k̂ sgn(s); or ``"implicit"``, the same by backward Euler, which does not chatter.
        share: λ of the implicit form, above 0, at most 1.
    """

    title: ClassVar[str] = "existing adaptive sliding mode control"
    equation: ClassVar[str] = (
        "τ = PPC + M̄ k̂ sgn(s);  dk̂/dt = k̄ ‖s‖₂ sgn(‖s‖₂ − ε) if k̂ > μ, else μ;  ε a number, or 4 k̂ L"
    )
    reference: ClassVar[str] = "Plestan, Shtessel, Bregeault, Poznyak (2010)"
    oracle: ClassVar[str] = "implicit: s_{k+1} = −g N_k inside the band; explicit: k̂ tick by tick as printed"
    claim: ClassVar[str] = "s comes into ‖s‖ < ε in finite time with a gain that can fall again."
    fails: ClassVar[str] = (
        "With a constant ε below 4 k̂ L the switching itself keeps s outside, and k̂ grows; a drive at its limit "
        "makes k̂ grow too."
    )
    typical: ClassVar[Mapping[str, float | str]] = {"rate": 50.0, "epsilon": "4KL", "floor": 0.1}

    rate: Scalar = Scalar("k̄", "1/s²", at_least=0.0)
    epsilon: ScalarOrWord = ScalarOrWord("ε, or the authors' 4 k̂ L", "rad/s", words=("4KL",), above=0.0)
    floor: Scalar = Scalar("μ", "rad/s²", above=0.0)
    switching: Choice = switching_choice()
    share: Scalar = share_scalar()

    def init(self, sample: Sample) -> AdaptiveState:
        """State before the first tick, from the sample of t = 0; k̂₀ = μ."""
        return AdaptiveState(self.start(sample), np.full(sample.q.shape, self.floor))

    row_meanings: ClassVar[Mapping[str, str]] = {
        "rate": "L k̄, 1/s",
        "epsilon": "ε where it is constant, else 0, rad/s",
        "epsilon_per_gain": "ε per unit of k̂ where it is 4 k̂ L, else 0, s",
        "floor": "μ, rad/s²",
        "rise": "L μ, what k̂ grows by in a tick at the floor, rad/s²",
        "explicit": "1: k̂ sgn(s); 0: by backward Euler; no unit",
        "of_s": "λ b/g of backward Euler per unit of s, 1/s",
        "of_rate": "λ b/g of backward Euler per unit of ė, 1/s",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """L k̄; ε, and ε per unit of k̂, of which one is 0; μ; L μ; whether explicit; λ b/g per s and per ė."""
        relative = isinstance(self.epsilon, str)
        return (
            self.period * self.rate,
            0.0 if relative else self.epsilon,
            4.0 * self.period if relative else 0.0,
            self.floor,
            self.period * self.floor,
            self.switching == "explicit",
            *band_slopes(self, self.share),
        )

    trial_step: ClassVar[TrialStep | None] = _step

    def promises(self) -> Mapping[str, Promise | str]:
        """That k̂ stays bounded."""
        if self.switching != "explicit":
            return {
                "gain": "it is proved for k̂ sgn(s), not for its implicit form, which is less than k̂ inside its band"
            }
        epsilon = None if isinstance(self.epsilon, str) else float(self.epsilon)
        return {"gain": BoundedByEnergy(self.rate, self.floor, epsilon, self.beta, self.period)}

    def switching_term(self, s: Array, gain: Array) -> Array | None:
        """The term w = k̂ sgn(s) at the ticks of a run, None if it is implicit; see `TdeLaw.switching_term`."""
        return signed(gain, s) if self.switching == "explicit" else None
