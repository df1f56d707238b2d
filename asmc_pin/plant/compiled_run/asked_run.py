"""A run whose law is asked in Python at every tick: commands in, samples out, and a log that is spread now and then."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.plant.compiled_run.one_tick import GAIN, LOG_TICKS, LOGGED, spread
from asmc_pin.plant.compiled_run.run_state import CompiledRun
from asmc_pin.plant.plant_state import Motion


class AskedRun(CompiledRun):
    """See `CompiledRun`.

    Args:
        motion: The trials as they begin.
        wanted: The reference, fields of shape (T, nv).
        histories: What is written, by the names of `Histories`; complete after `finish`.
        ks: K_s with which s is logged, a scalar or (nv,); None where it is not.
    """

    def __init__(self, motion: Motion, wanted: Setpoint, histories: dict[str, Array], ks: Array | None) -> None:
        super().__init__(motion, wanted, histories)
        batch, nv = motion.q.shape
        self._log = np.empty((LOG_TICKS, batch, LOGGED, nv))
        self._command = np.empty((batch, nv))
        self._ks = np.zeros(nv) if ks is None else np.array(np.broadcast_to(ks, (nv,)))
        self._done = self._spread = 0
        self.running = int(self.active.sum())
        """How many trials run."""

    def follow_command(self, command: Array, gain: Array | None) -> None:
        """Hold a command, (batch, nv) N·m, over the period of the next tick, and look at the one after it.

        Args:
            command: What the law asks for.
            gain: What its state calls ``gain``, (batch, nv), to be logged.
        """
        k = self._done
        if k - self._spread == LOG_TICKS:
            self._flush()
        self._regroup(k)
        self._command[:] = command
        self.running = self._look(k, self._command, self._log, self._ks)
        if gain is not None:
            self._log[k % LOG_TICKS, :, GAIN] = gain
        self._done = k + 1

    def finish(self) -> None:
        """Write what is not written yet; of a trial that stopped, NaN from the tick at which it did."""
        self._flush()
        self._blank_stopped()

    def _flush(self) -> None:
        spread(self._log, self._spread, self._done, self.stopped_at, self._histories)
        self._spread = self._done
