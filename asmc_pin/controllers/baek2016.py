"""The proposed adaptive sliding mode control of Baek, Jin and Han (2016)."""

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
from asmc_pin.controllers.promises.run_history import Promise
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.switching.backward_euler import band_slopes, share_scalar, switched, switching_choice
from asmc_pin.controllers.tde import AdaptiveState, TdeLaw, signed
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import Choice, PerJoint, Scalar

GROWTH, DROP, EPSILON, THRESHOLD, EXPLICIT, OF_S, OF_RATE = range(OWN, OWN + 7)
GAIN = OWN_MEMORY


@short_loops
def adapt(law: Array, s: Array, gain: Array) -> None:
    """One explicit step of the adaptive law (11), over L with s held; `gain` is k̂_{k−1}, then k̂_k, never negative.

    θ = sgn(‖s‖_∞ − ε) with sgn(0) = +1. k̂ᵢ + L φᵢ|sᵢ|/αᵢ if θ = +1 or k̂ᵢ ≤ threshold, else max(0, k̂ᵢ − L φᵢαᵢ/|sᵢ|),
    which is 0 for sᵢ = 0. The branch is that of k̂_{k−1}; none is changed inside a tick.
    """
    outside = False
    for i in range(s.size):
        outside = outside or abs(s[i]) >= law[EPSILON, 0]
    for i in range(s.size):
        size = abs(s[i])
        if outside or not gain[i] > law[THRESHOLD, 0]:
            gain[i] += law[GROWTH, i] * size
        elif gain[i] * size > law[DROP, i]:
            # Divided only where something of k̂ remains. There the quotient is at most k̂, rounded too: |s| → 0 cannot
            # overflow, and the difference is never negative.
            gain[i] -= law[DROP, i] / size
        else:
            gain[i] = 0.0


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    pole_placement(tick, law, memory, work, command)
    adapt(law, work[S], memory[GAIN])
    for i in range(command.size):
        inside = law[OF_S, i] * work[S, i] + law[OF_RATE, i] * (tick.v_ref[i] - tick.v[i])
        command[i] += law[MBAR, i] * switched(law[EXPLICIT, 0], memory[GAIN, i], work[S, i], inside)


@law("baek2016")
@dataclass(frozen=True, kw_only=True, eq=False)
class Baek2016(TdeLaw):
    """Baek 2016 (9): τ = PPC + M̄ K̂ sgn(s), K̂ = diag(k̂₁ … k̂ₙ) adapted by (11).

    A gain grows with |sᵢ| while any joint is outside ε, and shrinks with 1/|sᵢ| once all are inside.

    Attributes:
        phi: φ, adaptation rate, scalar or nv values, above 0, rad/s³.
        alpha: α, the size of |sᵢ| at which growing and shrinking are equally fast, scalar or nv values, above 0, rad/s.
        epsilon: ε, scalar, above 0, rad/s; one comparison ‖s‖_∞ ≥ ε decides for all joints.
        threshold: A k̂ at or below it counts as 0, rad/s²; the paper's experiments use 1e-4.
        switching: ``"explicit"``, k̂ sgn(s); or ``"implicit"``, the same by backward Euler, which does not chatter.
        share: λ of the implicit form, above 0, at most 1.
    """

    title: ClassVar[str] = "proposed adaptive sliding mode control"
    equation: ClassVar[str] = (
        "τ = PPC + M̄ K̂ sgn(s);  dk̂ᵢ/dt = φᵢ (|sᵢ|/αᵢ)^θ θ, θ = sgn(‖s‖_∞ − ε), but +1 where k̂ᵢ = 0"
    )
    reference: ClassVar[str] = "Baek, Jin, Han (2016), eqs. (9)–(11)"
    oracle: ClassVar[str] = "implicit: s_{k+1} = −g N_k inside the band; explicit: k̂ tick by tick as (11)"
    claim: ClassVar[str] = "s is uniformly ultimately bounded (Theorem 1), in continuous time."
    fails: ClassVar[str] = (
        "Sampled, s crosses 0 within periods and (16) is broken there: `compare` shows by how much and why."
    )
    typical: ClassVar[Mapping[str, float | str]] = {"phi": 5.0, "alpha": 0.1, "epsilon": 0.05}
    theorem1: ClassVar[bool] = True

    phi: PerJoint = PerJoint("φ", "rad/s³", above=0.0)
    alpha: PerJoint = PerJoint("α", "rad/s", above=0.0)
    epsilon: Scalar = Scalar("ε", "rad/s", above=0.0)
    threshold: Scalar = Scalar("k̂ at or below it counts as 0", "rad/s²", at_least=0.0, default=0.0)
    switching: Choice = switching_choice()
    share: Scalar = share_scalar()

    def init(self, sample: Sample) -> AdaptiveState:
        """State before the first tick, from the sample of t = 0; k̂₀ = 0."""
        return AdaptiveState(self.start(sample), np.zeros(sample.q.shape))

    row_meanings: ClassVar[Mapping[str, str]] = {
        "growth": "L φ/α, growth of k̂ in a tick per unit of |s|, 1/s",
        "drop": "L φ α, loss of k̂ in a tick times |s|, rad²/s³",
        "epsilon": "ε, rad/s",
        "threshold": "k̂ at or below it counts as 0, rad/s²",
        "explicit": "1: k̂ sgn(s); 0: by backward Euler; no unit",
        "of_s": "λ b/g of backward Euler per unit of s, 1/s",
        "of_rate": "λ b/g of backward Euler per unit of ė, 1/s",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """L φ/α, growth per |s|; L φα, loss times |s|; ε; the threshold; whether explicit; λ b/g per s and per ė."""
        return (
            self.period * self.phi / self.alpha,
            self.period * self.phi * self.alpha,
            self.epsilon,
            self.threshold,
            self.switching == "explicit",
            *band_slopes(self, self.share),
        )

    trial_step: ClassVar[TrialStep | None] = _step

    def promises(self) -> Mapping[str, Promise | str]:
        """Its bounded gain is Lemma 2, which the monitors judge as such."""
        return {"gain": "Lemma 2 is this claim of it"}

    def switching_term(self, s: Array, gain: Array) -> Array | None:
        """The term w = k̂ sgn(s) at the ticks of a run, None if it is implicit; see `TdeLaw.switching_term`."""
        return signed(gain, s) if self.switching == "explicit" else None

    def adapt(self, gain: Array, s: Array) -> Array:
        """One explicit step of the adaptive law (11), over L with s held.

        Args:
            gain: k̂_{k−1}, (batch, nv), rad/s².
            s: s_k, (batch, nv), rad/s.

        Returns:
            k̂_k, (batch, nv), rad/s², never negative; see `adapt`.
        """
        adapted = np.array(gain, dtype=np.float64)
        law = self.law_rows(adapted.shape[1])
        for trial, row in enumerate(adapted):
            adapt(law[trial % len(law)], np.array(s[trial], dtype=np.float64), row)
        return adapted
