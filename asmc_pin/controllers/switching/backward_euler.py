"""Switching by backward Euler: the value of a set-valued sgn that brings s to 0 at the next tick, or as near as it can.

With held torque, an ideal drive and a reference acceleration that is constant within a period,

    s_{k+1} = s_k + L K_s ė_k + g (q̈_d − ā_k),   ā_k = q̈_d + K_s ė_k + β s_k + w_k + N_k,   g = L (1 + K_s L/2),

so that without w and N the next s is b_k = s_k + L K_s ė_k − g (K_s ė_k + β s_k), and inside the band
s_{k+1} = (1 − λ) b_k − g N_k exactly.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.one_trial.compiled_tde import BETA, KS, PERIOD, with_sign
from asmc_pin.controllers.one_trial.trial_step import Tick
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import Choice, Scalar

SHARE_MEANING = "λ, the part of the next s that implicit switching takes away"


def switching_choice() -> Choice:
    """The parameter `switching` of an adaptive law."""
    return Choice("how k̂ sgn(s) is sampled", ("explicit", "implicit"), default="explicit")


def share_scalar() -> Scalar:
    """The parameter `share` of an adaptive law."""
    return Scalar(SHARE_MEANING, above=0.0, at_most=1.0, default=1.0)


@short_loops
def implicit_switching(law: Array, i: int, gain: float, share: float, s: float, rate: float) -> float:
    """The term clip(λ b/g, ±K) of joint i, rad/s².

    Args:
        law: Parameters of a TDE law, (rows, nv).
        i: The joint.
        gain: K, at least 0, rad/s².
        share: λ, the part of b that is taken away in a period, above 0 and at most 1.
        s: Sliding variable (4), rad/s.
        rate: ė, rad/s.

    Source: Acary, Brogliato (2010), Syst. Control Lett. 59(5), for a surface; the prediction is that of time-delay
    estimation.
    """
    ks, period = law[KS, i], law[PERIOD, i]
    reach = period * (1.0 + 0.5 * ks * period)
    ahead = s + period * ks * rate - reach * (ks * rate + law[BETA, i] * s)
    # A gain that is nan has to show.
    return np.minimum(np.maximum(share / reach * ahead, -gain), gain)


@short_loops
def switched(law: Array, i: int, implicit: float, gain: float, share: float, s: float, rate: float) -> float:
    """The switching term K sgn(s) of joint i, rad/s²; by backward Euler where `implicit` is not 0."""
    return implicit_switching(law, i, gain, share, s, rate) if implicit != 0.0 else with_sign(gain, s)


@short_loops
def rate_error(tick: Tick, i: int) -> float:
    """ė of joint i, rad/s."""
    return tick.v_ref[i] - tick.v[i]
