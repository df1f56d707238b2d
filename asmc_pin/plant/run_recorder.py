"""Writing down a run tick by tick."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array, IntArray
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import sliding_variable

# Ticks that are gathered before they are spread to (batch, time, joint): runs of memory long enough to write, and a few
# that still fit the cache.
CHUNK = 32

TRUTH = ("q", "v", "torque", "friction_torque")
MEASURED = ("q_measured", "v_measured", "torque_measured")


def first_logged(ticks: IntArray, log_every: int) -> IntArray:
    """Which logged tick is the first from a tick on, where one in so many is logged."""
    return -(-ticks // log_every)


class Recorder:
    """The histories of a run, (batch, T, nv) for T logged ticks, filled a chunk of them at a time.

    Args:
        wanted: The reference at those ticks, fields of shape (T, nv).
        batch: Number of trials.
        ks: Diagonal of K_s, a scalar or (nv,); None if the law has none: s stays NaN.
        names: What is written at each tick: `TRUTH`, then what the run has besides. s is computed from what was
            measured, if that is written, as the law does.
    """

    def __init__(self, wanted: Setpoint, batch: int, ks: Array | None, names: Sequence[str]) -> None:
        ticks, nv = wanted.q.shape
        self._wanted, self._ks = wanted, ks
        self._done = 0
        self._written = {name: np.empty((batch, ticks, nv)) for name in names}
        absent = np.broadcast_to(np.nan, (batch, ticks, nv))
        self._computed = {"s": absent if ks is None else np.empty((batch, ticks, nv))}
        if "gain" not in names:
            self._computed["gain"] = absent
        self._chunk = np.empty((len(names), CHUNK, batch, nv))
        seen = MEASURED[:2] if MEASURED[0] in names else TRUTH[:2]
        self._seen = [tuple(names).index(name) for name in seen]

    def write(self, k: int, values: Sequence[ArrayLike]) -> None:
        """Write logged tick k; ticks come in order, values in that of `names`, each broadcast to (batch, nv)."""
        rows = self._chunk[:, k % CHUNK]
        for row, value in zip(rows, values, strict=True):
            row[:] = value
        if k % CHUNK == CHUNK - 1:
            self._flush(k + 1)

    def finish(self, written: int, stopped: IntArray) -> dict[str, Array]:
        """Spread what is still gathered, and make a trial NaN from a logged tick, (batch,), on: T for never.

        Returns:
            The histories by the names that a `Rollout` gives them, read-only from now on.
        """
        self._flush(written)
        histories = {**self._written, **self._computed}
        for history in histories.values():
            if history.flags.writeable:
                for trial in np.flatnonzero(stopped < history.shape[1]):
                    history[trial, stopped[trial] :] = np.nan
                history.setflags(write=False)
        return histories

    def _flush(self, end: int) -> None:
        span = slice(self._done, end)
        part = self._chunk[:, : end - self._done]
        for history, rows in zip(self._written.values(), part, strict=True):
            history[:, span] = rows.swapaxes(0, 1)
        if self._ks is not None:
            q_ref, v_ref, a_ref = (x[span, None] for x in (self._wanted.q, self._wanted.v, self._wanted.a))
            q, v = (part[index] for index in self._seen)
            s = sliding_variable(self._ks, Sample(q, v, v), Setpoint(q_ref, v_ref, a_ref))
            self._computed["s"][:, span] = s.swapaxes(0, 1)
        self._done = end
