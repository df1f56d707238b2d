"""Switching by backward Euler: the value of a set-valued sgn that brings s to 0 at the next tick, or as near as it can.

With held torque, an ideal drive and a reference acceleration that is constant within a period,

    s_{k+1} = s_k + L K_s ė_k + g (q̈_d − ā_k),   ā_k = q̈_d + K_s ė_k + β s_k + w_k + N_k,   g = L (1 + K_s L/2),

so that without w and N the next s is b_k = s_k + L K_s ė_k − g (K_s ė_k + β s_k), and with w = clip(λ b/g, ±K) inside
the band, where λ|b| < K g, s_{k+1} = (1 − λ) b_k − g N_k exactly.

Source: Acary, Brogliato (2010), Syst. Control Lett. 59(5), for a surface; the prediction is that of time-delay
estimation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.one_trial.compiled_tde import with_sign
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import Choice, Scalar

if TYPE_CHECKING:
    from asmc_pin.controllers.tde import TdeLaw


def switching_choice() -> Choice:
    """The parameter `switching` of an adaptive law."""
    return Choice("how k̂ sgn(s) is sampled", ("explicit", "implicit"), default="explicit")


def share_scalar() -> Scalar:
    """The parameter `share` of an adaptive law."""
    return Scalar("λ, the part of the next s that implicit switching takes away", above=0.0, at_most=1.0, default=1.0)


def band_slopes(law: TdeLaw, share: Array | float) -> tuple[Array, Array]:
    """Slopes of λ b/g over s, 1/s, and over ė, 1/s; each a scalar or (nv,).

    Args:
        law: Its K_s, β and period are read.
        share: λ, above 0 and at most 1.
    """
    reach = law.period * (1.0 + 0.5 * law.ks * law.period)
    slope = share / reach
    return np.asarray(slope * (1.0 - reach * law.beta)), np.asarray(slope * (law.period - reach) * law.ks)


@short_loops
def clipped(value: float, gain: float) -> float:
    """A value within ±gain; a gain that is nan shows."""
    return float(np.minimum(np.maximum(value, -gain), gain))


@short_loops
def switched(explicit: float, gain: float, s: float, inside: float) -> float:
    """The switching term of one joint, rad/s²: K sgn(s), or by backward Euler where `explicit` is 0.

    Args:
        explicit: 1 or 0.
        gain: K, at least 0, rad/s².
        s: Sliding variable (4), rad/s.
        inside: λ b/g, rad/s².
    """
    return with_sign(gain, s) if explicit != 0.0 else clipped(inside, gain)
