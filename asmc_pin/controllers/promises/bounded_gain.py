"""That an adaptive gain stays bounded, with the bound that the source's own proof gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.promises.kept_width import KeptWidth
from asmc_pin.controllers.promises.run_history import Findings, History, gathered, once


@dataclass(frozen=True, eq=False)
class NotOverestimated:
    """Once the barrier gain k̂ᵢ is at most the largest push on sᵢ of the run, it stays so.

    Where k̂ exceeds all that pushes s, |s| falls and k̂ with it.

    Attributes:
        width: What the law keeps; see `KeptWidth.push`.
    """

    levers: ClassVar[tuple[str, ...]] = ()

    width: KeptWidth

    def findings(self, history: History) -> Findings:
        """See `Promise`."""
        push, gain = self.width.push(history.s), history.gain
        most = np.where(np.isfinite(push), np.abs(push), 0.0).max(axis=0)
        checked = once(gain <= most) & np.isfinite(gain)
        over = gain - most * (1.0 + 1e-12)
        joint = int(np.argmax(np.max(over, axis=0, initial=-np.inf, where=checked)))
        largest = float(np.max(gain[:, joint], initial=0.0, where=checked[:, joint]))
        seen = f"nearest: joint {joint + 1}, k̂ at most {largest:.4g}, pushed by up to {most[joint]:.4g} rad/s²"
        never = "k̂ never came down to what pushes s"
        return gathered(over, checked, push, seen, never)


@dataclass(frozen=True, eq=False)
class BoundedByEnergy:
    r"""One gain for all joints, that grows by k̄‖s‖: μ ≤ k̂ ≤ K* + √(2 k̄ V_x), K* = max ‖d‖ of the run.

    V = ½‖s‖² + (k̂ − K*)²/(2k̄) falls while ‖s‖ ≥ ε, by the source's own proof: V̇ ≤ −β‖s‖² − ‖s‖(K* − ‖d‖). So k̂ is
    bounded by V_x, that of the tick at which the present stay outside began. Inside, k̂ falls; at μ it rises by μ a
    second. d is all that pushes s besides the law.

    Attributes:
        rate: k̄, 1/s².
        floor: μ, rad/s².
        epsilon: ε, rad/s; None for 4 k̂_{k−1} L.
        beta: β, 1/s.
        period: L, s.
    """

    levers: ClassVar[tuple[str, ...]] = ()

    rate: float
    floor: float
    epsilon: float | None
    beta: float
    period: float

    def findings(self, history: History) -> Findings:
        """See `Promise`."""
        s, gain = history.s, history.gain[:, 0]
        push = np.full_like(s, np.nan)
        sign = np.where(s >= 0.0, 1.0, -1.0)
        push[:-1] = -np.diff(s, axis=0) / self.period - (self.beta * s + gain[:, None] * sign)[:-1]
        size = np.sqrt(np.sum(s**2, axis=1))
        before = np.append(self.floor, gain[:-1])
        outside = size >= (4.0 * before * self.period if self.epsilon is None else self.epsilon)
        star = float(np.sqrt(np.nansum(push**2, axis=1)).max())
        bound = self.bound(size, gain, outside, star)
        known = np.isfinite(size) & np.isfinite(gain)
        over = np.maximum(gain - bound * (1.0 + 1e-12), self.floor * (1.0 - 1e-12) - gain)
        most = int(np.argmax(np.where(known, gain, -np.inf)))
        seen = f"k̂ from {np.nanmin(gain):.4g} to {gain[most]:.4g}, where its bound was {bound[most]:.4g} rad/s²"
        shape = s.shape
        return gathered(
            np.broadcast_to(over[:, None], shape),
            np.broadcast_to(known[:, None], shape),
            push,
            seen,
            "the run is too short",
        )

    def bound(self, size: Array, gain: Array, outside: BoolArray, star: float) -> Array:
        """What k̂ may be at each tick, shape (T,), rad/s²; inf where k̄ is 0 and nothing bounds what it began with."""
        bound = np.full(len(gain), np.nan)
        present = max(self.floor * (1.0 + self.period), float(gain[0]))
        for k in range(len(gain)):
            if outside[k] and (k == 0 or not outside[k - 1]):
                stored = self.rate * float(size[k]) ** 2 + (float(gain[k]) - star) ** 2
                present = max(self.floor * (1.0 + self.period), star + float(np.sqrt(stored)))
            bound[k] = present
        return bound
