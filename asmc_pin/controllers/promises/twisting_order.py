"""That s and ṡ of super-twisting are of order L² and L once they are reached: real sliding of second order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.promises.run_history import Findings, History, gathered

SHARES = (0.5, 0.25, 0.1, 0.0)
"""Shares of k₂ up to which |dN/dt| may be supposed to go, the first with a bound that was found."""

_MARGIN = 1.25  # over the largest that the search met
_TICKS, _SETTLED, _TRIALS = 1600, 800, 96
_TOO_FAR = 10.0
_STEEPEST = 1e6  # k₂/k₁² from which on a map is far from settled when the search ends
_SETTLES = 1.1  # a map that is settled does not go further by so much in the last quarter than in the one before


@dataclass(frozen=True, eq=False)
class TwistingOrder:
    r"""Once reached, |sᵢ| ≤ c₁ L² and |ṡᵢ| ≤ c₂ L while the push on s changes by at most ρ k₂ a second.

    The sampled loop s_{k+1} = s_k − L (k₁√|s_k| sgn(s_k) + ϖ_k + d_k) with ϖ_k = ϖ_{k−1} + L k₂ sgn(s_k) has, in units
    of k₁²L² for s and k₁²L for ṡ, no parameter but k₂/k₁² and how fast d changes: so s is of order L² and ṡ of order L.
    c₁ and c₂ are the largest that a search of that map met (`reach_of`), and a quarter more: searched, not proven. d is
    all that is not the law's, TDE error and β s included; it is reckoned from s itself, with ϖ from the run's start.

    Reached is where s changes its sign with |ṡ| ≤ c₂ L, anew after each tick at which d changed faster.

    Attributes:
        k1: k₁, a scalar or (nv,), (rad/s³)^½.
        k2: k₂, likewise, rad/s³.
        period: L, s.
    """

    levers: ClassVar[tuple[str, ...]] = ()

    k1: Array
    k2: Array
    period: float

    def findings(self, history: History) -> Findings:
        """See `Promise`."""
        s, length = history.s, self.period
        k1, k2 = (np.broadcast_to(x, s.shape[1:]) for x in (self.k1, self.k2))
        speed, jerk = np.full_like(s, np.nan), np.full_like(s, np.nan)
        speed[:-1] = np.diff(s, axis=0) / length
        sign = np.where(s >= 0.0, 1.0, -1.0)
        term = k1 * np.sqrt(np.abs(s)) * sign + np.cumsum(length * k2 * sign, axis=0)
        push = -speed - term
        jerk[1:] = np.diff(push, axis=0) / length
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # of a k₁ that is next to nothing
            ratio = k2 / k1**2
        over, checked = np.full_like(s, -np.inf), np.zeros(s.shape, dtype=np.bool_)
        told: list[str] = []
        for i in range(s.shape[1]):
            share, far, fast = bounds_of(float(ratio[i]))
            if not np.isfinite(far):
                told.append(f"of joint {i + 1} no bound was found, k₁² is too small for k₂")
                continue
            far, fast = far * k1[i] ** 2 * length**2, fast * k1[i] ** 2 * length
            calm = np.abs(np.nan_to_num(jerk[:, i], nan=0.0)) <= share * k2[i]
            turns = np.append(sign[1:, i] != sign[:-1, i], False) & (np.abs(speed[:, i]) <= fast)
            checked[:, i] = _reached(turns, calm) & np.isfinite(speed[:, i])
            over[:, i] = np.maximum(np.abs(s[:, i]) / far, np.abs(speed[:, i]) / fast) - 1.0
            told.append(_words(i, s[:, i], speed[:, i], checked[:, i], calm, (share, far, fast), length))
        untested = "s was never reached so, or the push on it changed too fast all the time: " + "; ".join(told)
        return gathered(over, checked, jerk, "; ".join(told), untested, of_rate=True)


def _reached(turns: BoolArray, calm: BoolArray) -> BoolArray:
    """Where a turn has come since the last tick that was not calm."""
    ticks = np.arange(len(turns))
    last_turn = np.maximum.accumulate(np.where(turns & calm, ticks, -1))
    last_jump = np.maximum.accumulate(np.where(calm, -1, ticks))
    return np.asarray(last_turn > last_jump)


def _words(
    joint: int,
    s: Array,
    speed: Array,
    checked: BoolArray,
    calm: BoolArray,
    found: tuple[float, float, float],
    length: float,
) -> str:
    share, far, fast = found
    ticks = int(checked.sum())
    calmly = f"the push on s changed by at most {share:g} k₂ a second in {int(calm.sum())} of {len(calm)} ticks"
    if not ticks:
        return f"joint {joint + 1} is never there: {calmly}"
    most = [float(np.max(np.abs(x), initial=0.0, where=checked)) for x in (s, speed)]
    return (
        f"joint {joint + 1}: |s| to {most[0] / length**2:.3g} L² (bound {far / length**2:.3g}), |ṡ| to "
        f"{most[1] / length:.3g} L (bound {fast / length:.3g}), in {ticks} ticks; {calmly}"
    )


def bounds_of(ratio: float) -> tuple[float, float, float]:
    """Share ρ of k₂, and the bounds of s/(k₁²L²) and ṡ/(k₁²L), for k₂/k₁²; inf where no share has a bound."""
    for share in SHARES if ratio < _STEEPEST else ():
        far, fast = reach_of(round(ratio, 12), share)
        if np.isfinite(far):
            return share, _MARGIN * far, _MARGIN * fast
    return 0.0, np.inf, np.inf


@lru_cache(maxsize=256)
def reach_of(ratio: float, share: float) -> tuple[float, float]:
    """Largest |x| and |y − √|x| sgn(x)| of the map in its own units, after it has settled; inf where it still grows.

    x⁺ = x + y − √|x| sgn(x), y⁺ = y − κ (sgn(x⁺) − ρu), |u| ≤ 1, with the u that helps x out and back in, with u at
    random, and with mixtures of both.

    Args:
        ratio: κ = k₂/k₁².
        share: ρ.
    """
    rng = np.random.default_rng(0)
    scale = 1.0 + ratio
    x, y = rng.uniform(-scale, scale, (2, _TRIALS))
    worst = np.linspace(0.0, 1.0, _TRIALS)  # how often u is the one that does most harm
    far = fast = before = late = 0.0
    for tick in range(_TICKS):
        root = np.sign(x) * np.sqrt(np.abs(x))
        speed = y - root
        if tick >= _SETTLED:
            far, fast = max(far, float(np.abs(x).max())), max(fast, float(np.abs(speed).max()))
            if tick < (_SETTLED + _TICKS) // 2:
                before = far
            else:
                late = max(late, float(np.abs(x).max()))
        x = x + speed
        harm = np.where(x * speed >= 0.0, 1.0, -1.0) * np.where(x >= 0.0, 1.0, -1.0)
        u = np.where(rng.random(_TRIALS) < worst, harm, np.sign(rng.standard_normal(_TRIALS)))
        y = y - ratio * (np.where(x >= 0.0, 1.0, -1.0) - share * u)
        if not np.abs(x).max() < _TOO_FAR * scale**2:
            return np.inf, np.inf
    return (far, fast) if late <= _SETTLES * before else (np.inf, np.inf)
