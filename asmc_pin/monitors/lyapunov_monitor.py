r"""The Lyapunov function (12) along a run of `baek2016`, and what the sampled loop makes of (16) and Theorem 1.

With Γ* = max over the run of |N|, ω = α/φ, and k̂_k the gain that acts in period k,

    V_k = ½ ‖s_k‖² + ½ Σ ω (Γ* − k̂_k)²                                                                        (12)
    V̇_k = (V_{k+1} − V_k)/L,     claimed: V̇ ≤ −β ‖s‖² while ‖s‖_∞ ≥ ε                                          (16)

which is judged in the periods at both ends of which ‖s‖_∞ ≥ ε: where s enters, (11) shrinks the gains already.

Let σ = (s_{k+1} − s_k)/L and κ = (k̂_{k+1} − k̂_k)/L. From ā = u + r + N (signals.py) follows

    σ = −β s − k̂ sgn(s) − N − r + δ,

where δ is what q̈_d + K_s ė, held at its value of t_k, misses in the period. Expanding the two squares gives exactly

    V̇_k + β ‖s_k‖² = −Σ (Γ* |s| + s N)                             at most 0: the paper's estimate
                     + s·δ                                          reference and ė held over the period
                     − Σ ω (Γ* − k̂)(κ − |s|/ω)                     the gain adapts at the next tick, by s_{k+1}
                     + ½ L (‖σ‖² + Σ ω κ²)                          the step is finite: s overshoots, sgn(s) is held
                     − s·r                                          torque limits, sensors, drive

The first three additions are sampling: they vanish as L → 0. The last one has the three parts of r.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers import Baek2016
from asmc_pin.monitors.law_signals import Signals

SAMPLING = "sampling"


@dataclass(frozen=True, eq=False)
class Lyapunov:
    """One trial; shapes (T,) or as said, NaN where not defined.

    Attributes:
        value: V, rad²/s².
        excess: V̇ + β‖s‖², rad²/s³; (16) says at most 0 where `claimed`.
        parts: What `excess` is made of besides the paper's estimate, by cause: sampling and the parts of r.
        round_off: What `excess` may be off by rounding.
        decay: β‖s‖², rad²/s³.
        s_size: ‖s‖₂, rad/s.
        outside: Whether ‖s‖_∞ ≥ ε; bool.
        claimed: Whether (16) speaks of the period that begins here; bool.
        crossing: Whether s of a joint changes its sign within the period; bool.
        gain_bound: What (16) allows k̂ to be, shape (T, nv), rad/s²; see `gain_bounds`.
        s_bound: √(nε² + k̃_M) of Theorem 1 (21), rad/s.
    """

    value: Array
    excess: Array
    parts: Mapping[str, Array]
    round_off: Array
    decay: Array
    s_size: Array
    outside: BoolArray
    claimed: BoolArray
    crossing: BoolArray
    gain_bound: Array
    s_bound: float


def lyapunov_of(signals: Signals, gain: Array, law: Baek2016, star: Array, trial: int) -> Lyapunov:
    """Evaluate (12), (16), Lemma 2 and (21) along one trial.

    Args:
        signals: See `signals_of`.
        gain: k̂ of each tick, shape (batch, T, nv), rad/s².
        law: Its α, φ, β, ε and period.
        star: Γ*, shape (batch, nv), rad/s².
        trial: Which.
    """
    s, error, k_hat, most = signals.s[trial], signals.error[trial], gain[trial], star[trial]
    nv, period = s.shape[1], law.period
    weight = np.broadcast_to(law.alpha / law.phi, (nv,))
    room = most - k_hat
    stored = np.sum(weight * room**2, axis=1)
    s_squared = np.sum(s**2, axis=1)
    value = 0.5 * (s_squared + stored)

    slope, change = _rate(s, period), _rate(k_hat, period)
    rise = np.sum(s * slope - weight * room * change, axis=1)
    rise += 0.5 * period * np.sum(slope**2 + weight * change**2, axis=1)
    decay = law.beta * s_squared
    parts = {name: -np.sum(s * part[trial], axis=1) for name, part in signals.shortfall.items()}
    estimate = -np.sum(most * np.abs(s) + s * error, axis=1)
    parts = {SAMPLING: rise + decay - estimate - sum(parts.values()), **parts}
    outside = np.abs(s).max(axis=1) >= law.epsilon
    crossing = np.zeros(len(s), dtype=np.bool_)
    crossing[:-1] = np.any((s[1:] >= 0.0) != (s[:-1] >= 0.0), axis=1)
    return Lyapunov(
        value=value,
        excess=rise + decay,
        parts=parts,
        round_off=64.0 * np.finfo(float).eps / period * np.maximum(value, np.append(value[1:], np.nan)),
        decay=decay,
        s_size=np.sqrt(s_squared),
        outside=outside,
        claimed=outside & np.append(outside[1:], False),
        crossing=crossing,
        gain_bound=gain_bounds(value, k_hat, outside, law, most),
        s_bound=float(np.sqrt(nv * law.epsilon**2 + np.fmax.reduce(stored))),
    )


def gain_bounds(value: Array, gain: Array, outside: BoolArray, law: Baek2016, star: Array) -> Array:
    """What k̂ can be if (16) holds; Lemma 2 itself says only that a bound exists.

    While ‖s‖_∞ ≥ ε, V does not grow beyond its value V_x at the tick where that began, so that
    ω (Γ* − k̂)² ≤ 2V_x and k̂ ≤ Γ* + √(2V_x φ/α). Inside, no gain grows but one that counts as 0, to at most
    threshold + L φ ε/α: the bound there is the larger of that and the last one outside.

    Args:
        value: V, shape (T,).
        gain: k̂, shape (T, nv), rad/s².
        outside: Shape (T,), bool.
        law: Its α, φ, ε, threshold and period.
        star: Γ*, shape (nv,), rad/s².

    Returns:
        Shape (T, nv), rad/s²; NaN after a divergence.
    """
    steep = np.sqrt(law.phi / law.alpha)
    idle = law.threshold + law.period * law.phi * law.epsilon / law.alpha
    bound = np.full_like(gain, np.nan)
    present = np.maximum(idle, gain[0])
    for k in np.flatnonzero(np.isfinite(value)):
        if outside[k] and (k == 0 or not outside[k - 1]):
            present = np.maximum(idle, star + steep * np.sqrt(2.0 * value[k]))
        bound[k] = present
    return bound


def _rate(values: Array, period: float) -> Array:
    rate = np.full_like(values, np.nan)
    rate[:-1] = np.diff(values, axis=0) / period
    return rate
