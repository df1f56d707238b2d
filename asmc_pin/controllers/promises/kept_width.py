"""That |s| stays below ε for good under a barrier gain, and when a sampled loop can keep it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.promises.run_history import Findings, History, gathered, once

_HALVINGS = 60
_LIMITS = 400


@dataclass(frozen=True, eq=False)
class KeptWidth:
    """Once |sᵢ| < ε, it stays so.

    Let d be all that pushes s besides β and the law's own w = min(U, |s|/(ε − |s|)) sgn(s), TDE error included:

        s_{k+1} = (1 − gβ) s_k − g (w(s_k) + d_k),   g = L (1 + K_s L/2),

    by which d is defined at every tick of a run. For every |d| ≤ D the set |s| < ε is kept exactly where the largest
    and the least value of that over 0 ≤ s < ε, with d = −D and D, lie within ±ε (`kept`). In continuous time
    D < U + βε is enough; sampled, g (U + D + βε) has to be below 2ε too, and the gain not too steep about 0.

    Attributes:
        width: ε, rad/s.
        limit: U, rad/s².
        ks: Diagonal of K_s, shape (nv,) or a scalar, 1/s.
        beta: β, 1/s.
        period: L, s.
    """

    levers: ClassVar[tuple[str, ...]] = ("period", "limit")

    width: float
    limit: float
    ks: Array
    beta: float
    period: float

    def findings(self, history: History) -> Findings:
        """See `Promise`."""
        s = history.s
        push = self.push(s)
        inside = np.abs(s) < self.width
        checked = once(inside) & np.isfinite(s)
        over = np.abs(s) - self.width
        over = np.where(inside, over, np.maximum(over, np.finfo(float).tiny))
        never = f"|s| of no joint came below ε = {self.width:g}"
        return gathered(
            over, checked, push, self._words(s, checked, np.where(checked, np.nan_to_num(push), 0.0)), never
        )

    def push(self, s: Array) -> Array:
        """d, shape (T, nv), rad/s²; NaN at the last tick."""
        reach, push = self._reach(self.period), np.full_like(s, np.nan)
        size = np.abs(s[:-1])
        push[:-1] = (s[:-1] - s[1:]) / reach - self.beta * s[:-1] - np.sign(s[:-1]) * self._term(size, self.limit)
        return push

    def kept(self, push: float, limit: float, period: float, ks: float) -> bool:
        """Whether |s| < ε is kept against every |d| ≤ `push`, with this limit and period."""
        width, beta, reach = self.width, self.beta, period * (1.0 + 0.5 * ks * period)
        if reach * beta >= 1.0 or push >= limit + beta * width:
            return False
        capped = width * limit / (1.0 + limit)  # where the gain reaches its limit
        steepest = width - math.sqrt(reach * width / (1.0 - reach * beta))  # where the next s is largest
        places = np.array([0.0, min(max(steepest, 0.0), capped), capped])
        ahead = (1.0 - reach * beta) * places - reach * self._term(places, limit)
        # From there to the edge the gain stays and s grows: the next s is never less.
        return bool(ahead.max() + reach * push < width and ahead.min() - reach * push > -width)

    def longest_period(self, push: float, limit: float, ks: float) -> float:
        """Longest L at which `kept` holds, s; 0 where none does."""
        low, high = 0.0, 1.0
        if not self.kept(push, limit, 1e-12, ks):
            return 0.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.kept(push, limit, middle, ks) else (low, middle)
        return low

    def limits(self, push: float, ks: float) -> tuple[float, float] | None:
        """Least and largest U at which `kept` holds at this period, of a grid; None where none does."""
        least, most = max(push - self.beta * self.width, 1e-6), 2.0 * self.width / self._reach(self.period).min()
        tried: Sequence[float] | Array = [] if least >= most else np.geomspace(least, most, _LIMITS)
        found = [float(limit) for limit in tried if self.kept(push, float(limit), self.period, ks)]
        return (found[0], found[-1]) if found else None

    def _words(self, s: Array, checked: BoolArray, push: Array) -> str:
        """What was seen, and the period and the limits at which the claim holds, of the joint that is worst off."""
        ratio = np.max(np.abs(s), axis=0, initial=0.0, where=checked) / self.width
        joint = int(np.argmax(ratio))
        slope = float(np.broadcast_to(self.ks, ratio.shape)[joint])
        felt = float(np.abs(push[:, joint]).max())
        text = f"|s|/ε up to {ratio[joint]:.3g} at joint {joint + 1}, pushed by up to {felt:.4g} rad/s² besides the law"
        longest, range_ = self.longest_period(felt, self.limit, slope), self.limits(felt, slope)
        if longest == 0.0:
            return f"{text}, more than U + βε = {self.limit + self.beta * self.width:.4g}"
        text += f". Any push of that size is held with U = {self.limit:g} for L up to {_down(longest)} s"
        if range_ is None:
            return f"{text}, at L = {self.period:g} s with no U"
        between = f"from {range_[0]:.3g} to" if felt > self.beta * self.width else "up to"
        return f"{text}, at L = {self.period:g} s with U {between} {range_[1]:.3g} rad/s²"

    def _term(self, size: Array, limit: float) -> Array:
        room = self.width - size
        capped = ~(size < limit * room)
        return np.asarray(np.where(capped, limit, size / np.where(capped, 1.0, room)))

    def _reach(self, period: float) -> Array:
        return np.asarray(period * (1.0 + 0.5 * self.ks * period))


def _down(value: float) -> str:
    """Three digits, never more than the value."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.floor(value / step * (1.0 + 1e-12)) * step:.3g}"
