"""Writing down a run tick by tick."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array, IntArray
from asmc_pin.controllers.base import Sample, Setpoint
from asmc_pin.controllers.tde import sliding_variable

# Ticks that are gathered before they are spread to (batch, time, joint): runs of memory long enough to write, and a few
# that still fit the cache.
CHUNK = 32


class Recorder:
    """The histories of a run, (batch, T, nv), filled a chunk of ticks at a time.

    Args:
        wanted: The reference, fields of shape (T, nv).
        batch: Number of trials.
        ks: Diagonal of K_s, a scalar or (nv,); None if the law has none: s stays NaN.
        adaptive: Whether the law has gains; they stay NaN if not.
    """

    def __init__(self, wanted: Setpoint, batch: int, ks: Array | None, adaptive: bool) -> None:
        ticks, nv = wanted.q.shape
        self._wanted, self._ks, self._adaptive = wanted, ks, adaptive
        self._done = 0
        self.q, self.v, self.torque, self.friction_torque = (np.empty((batch, ticks, nv)) for _ in range(4))
        absent = np.broadcast_to(np.nan, (batch, ticks, nv))
        self.s = absent if ks is None else np.empty((batch, ticks, nv))
        self.gain = np.empty((batch, ticks, nv)) if adaptive else absent
        self._chunk = np.empty((4 + adaptive, CHUNK, batch, nv))

    def write(self, k: int, sample: Sample, torque: Array, friction_torque: Array, gain: ArrayLike | None) -> None:
        """Write tick k; ticks come in order. Shapes (batch, nv), the gain's broadcasts to it."""
        row = self._chunk[:, k % CHUNK]
        row[0] = sample.q
        row[1] = sample.v
        row[2] = torque
        row[3] = friction_torque
        if self._adaptive:
            row[4] = gain
        if k % CHUNK == CHUNK - 1:
            self._flush(k + 1)

    def finish(self, written: int, stopped_at: IntArray) -> None:
        """Spread what is still gathered, and make a trial NaN from the tick, (batch,), at which it stopped."""
        self._flush(written)
        for trial in np.flatnonzero(stopped_at < self.q.shape[1]):
            for history in (self.q, self.v, self.torque, self.friction_torque, self.s, self.gain):
                if history.flags.writeable:
                    history[trial, stopped_at[trial] :] = np.nan

    def histories(self) -> dict[str, Array]:
        """The histories by the names that a `Rollout` gives them, read-only from now on."""
        found = {name: getattr(self, name) for name in ("q", "v", "torque", "friction_torque", "s", "gain")}
        for history in found.values():
            history.setflags(write=False)
        return found

    def _flush(self, end: int) -> None:
        span = slice(self._done, end)
        part = self._chunk[:, : end - self._done]
        histories = [self.q, self.v, self.torque, self.friction_torque] + [self.gain] * self._adaptive
        for history, rows in zip(histories, part, strict=True):
            history[:, span] = rows.swapaxes(0, 1)
        if self._ks is not None:
            q_ref, v_ref, a_ref = (x[span, None] for x in (self._wanted.q, self._wanted.v, self._wanted.a))
            s = sliding_variable(self._ks, Sample(*part[:3]), Setpoint(q_ref, v_ref, a_ref))
            self.s[:, span] = s.swapaxes(0, 1)
        self._done = end
