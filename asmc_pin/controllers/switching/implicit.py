"""Implicit sliding mode control: K sgn(s) by backward Euler, which does not chatter whatever K is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import MBAR, OWN, S, pole_placement
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.switching.backward_euler import band_slopes, clipped
from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.parameters import PerJoint, Scalar

GAIN, OF_S, OF_RATE = range(OWN, OWN + 3)


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    pole_placement(tick, law, memory, work, command)
    for i in range(command.size):
        inside = law[OF_S, i] * work[S, i] + law[OF_RATE, i] * (tick.v_ref[i] - tick.v[i])
        command[i] += law[MBAR, i] * clipped(inside, law[GAIN, i])


@law("implicit")
@dataclass(frozen=True, kw_only=True, eq=False)
class Implicit(TdeLaw):
    r"""τ = PPC + M̄ w, w = clip(λ b/g, ±K): the set-valued K Sgn(s) of the next tick, as far as it can be known now.

    b is the s of the next tick without w and without the TDE error N; g = L (1 + K_s L/2). Inside the band, where
    λ|b| < K g, s_{k+1} = (1 − λ) b_k − g N_k: with λ = 1 the whole s of the next tick is g times the TDE error. K
    counts outside the band only, so that raising it does not feed chatter. The band is a feedback of λ/g ≈ λ/L: for
    large and for very small eigenvalues of M⁻¹M̄ it is too much, and `share` has to come down.

    Attributes:
        gain: K, scalar or nv values, at least 0, rad/s².
        share: λ, above 0, at most 1.
    """

    title: ClassVar[str] = "implicit sliding mode control (backward Euler)"
    equation: ClassVar[str] = "τ = PPC + M̄ clip(λ b/g, ±K);  b = s + L K_s ė − g (K_s ė + β s),  g = L (1 + K_s L/2)"
    reference: ClassVar[str] = "Acary, Brogliato (2010), Syst. Control Lett. 59(5); with TDE: this project"
    oracle: ClassVar[str] = "s_{k+1} = (1 − λ) b_k − g N_k inside the band, whatever K is"
    claim: ClassVar[str] = "K sgn(s) without chatter: raising K does not feed it."
    fails: ClassVar[str] = (
        "The band is a gain of λ/L: λ = 1 is unstable at a = 1.5, and barely at a = 0.0114 with K_s = 12, β = 9, "
        "L = 1 ms. Take a smaller λ; `asmc-pin stability --law implicit`."
    )
    separates: ClassVar[bool] = True
    band_remedy: ClassVar[str] = "lower its share λ"
    typical: ClassVar[Mapping[str, float | str]] = {"gain": 20.0, "share": 0.05}

    gain: PerJoint = PerJoint("K", "rad/s²", at_least=0.0)
    share: Scalar = Scalar("λ, the part of the next s that is taken away", above=0.0, at_most=1.0)

    row_meanings: ClassVar[Mapping[str, str]] = {
        "gain": "K, rad/s²",
        "of_s": "λ b/g of backward Euler per unit of s, 1/s",
        "of_rate": "λ b/g of backward Euler per unit of ė, 1/s",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """K, and λ b/g per unit of s and of ė."""
        return self.gain, *band_slopes(self, self.share)

    trial_step: ClassVar[TrialStep | None] = _step

    @property
    def resting_slope(self) -> Any:
        """Slope of λ b/g over s, 1/s; see `TdeLaw.resting_slope`."""
        return band_slopes(self, self.share)[0]
