"""That the error is gone in finite time on a terminal surface, but for what a boundary layer leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.controllers.promises.run_history import Findings, History, gathered, once


@dataclass(frozen=True, eq=False)
class TerminalTime:
    r"""Once |σᵢ| ≤ Φᵢ it stays so, and |eᵢ| ≤ Φᵢ at most T later, T = x₀^{1−1/p} / (B^{1/p} (1 − 1/p)).

    σ = e + ⌈ė⌋^p/B. With |σ| ≤ Φ and x = |e| − Φ > 0, ⌈ė⌋^p is at most −Bx (for e > 0), so that x falls at least as
    fast as ẋ = −(Bx)^{1/p} has it, from x₀ at the entry: x^{1−1/p} falls by B^{1/p}(1 − 1/p) a second. And |σ| falls
    where K + βBΦ exceeds all that pushes e besides the law, TDE error included.

    Attributes:
        exponent: p, above 1 and below 2.
        stiffness: B, a scalar or (nv,), (rad/s)^p/rad.
        gain: K, likewise, rad/s².
        boundary: Φ, likewise, rad.
        beta: β, 1/s.
    """

    levers: ClassVar[tuple[str, ...]] = ("period",)

    exponent: float
    stiffness: Array
    gain: Array
    boundary: Array
    beta: float

    def findings(self, history: History) -> Findings:
        """See `Promise`."""
        error, rate, p = history.error, history.rate, self.exponent
        sigma = error + np.sign(rate) * np.abs(rate) ** p / self.stiffness
        slide = self.stiffness / p * np.sign(rate) * np.abs(rate) ** (2.0 - p)
        pulled = self.beta * self.stiffness * sigma + self.gain * np.clip(sigma / self.boundary, -1.0, 1.0)
        push = -history.bend - slide - pulled
        inside = np.abs(sigma) <= self.boundary
        checked = once(inside) & np.isfinite(sigma)
        entry = np.argmax(inside, axis=0)
        allowed = self.allowed(history.time, history.time[entry], np.take_along_axis(error, entry[None], axis=0)[0])
        over = np.maximum(np.abs(sigma) - self.boundary, np.abs(error) - allowed)
        over -= 1e-12 * np.abs(self.boundary)
        seen = self._words(history, checked, entry, error, push)
        never = "σ of no joint came within its boundary layer Φ"
        return gathered(over, checked, push, seen, never)

    def allowed(self, time: Array, start: Array, error: Array) -> Array:
        """What |e| may be at each tick, (T, nv), rad; `start` and `error` are those of the entries, (nv,)."""
        part = 1.0 - 1.0 / self.exponent
        first = np.maximum(np.abs(error) - self.boundary, 0.0) ** part
        fallen = self.stiffness ** (1.0 / self.exponent) * part * (time[:, None] - start)
        return np.asarray(self.boundary + np.maximum(first - fallen, 0.0) ** (1.0 / part))

    def _words(self, history: History, checked: BoolArray, entry: IntArray, error: Array, push: Array) -> str:
        if not checked.any():
            return ""
        part = 1.0 - 1.0 / self.exponent
        came = checked.any(axis=0)
        first = np.maximum(np.abs(np.take_along_axis(error, entry[None], axis=0)[0]) - self.boundary, 0.0)
        due = history.time[entry] + first**part / (self.stiffness ** (1.0 / self.exponent) * part)
        late = int(np.argmax(np.where(came, due, -np.inf)))
        felt = np.abs(np.where(checked & np.isfinite(push), push, 0.0)).max(axis=0)
        room = np.broadcast_to(self.gain + self.beta * self.stiffness * self.boundary, felt.shape)
        tight = int(np.argmax(felt / room))
        end = np.abs(error[checked.any(axis=1)][-1])
        return (
            f"within Φ from {history.time[entry[late]]:.4g} s on at joint {late + 1}, |e| ≤ Φ is due at "
            f"{due[late]:.4g} s; joint {tight + 1} is pushed by up to {felt[tight]:.4g} rad/s² besides the law, of K + "
            f"βBΦ = {room[tight]:.4g}; |e| at the end up to {np.max(end):.3g} rad"
        )
