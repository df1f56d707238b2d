"""A run whose law is asked in Python at every tick: commands in, samples out, and a log that is spread now and then."""

from __future__ import annotations

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.plant.compiled_run.one_tick import spread
from asmc_pin.plant.compiled_run.run_state import CompiledRun
from asmc_pin.plant.plant_state import Motion
from asmc_pin.plant.run_recorder import first_logged

LOG_NUMBERS = 600_000
"""Numbers in the log of all trials, 4.8 MB: about what a cache holds, and enough to be given in large pages. It is
written in the order in which trials are gone through; a history is not, and the shorter the runs in which it is
written, the more pages are looked up. With 0.5 MB, and with 20 MB, a tick of 256 trials took a tenth longer."""


class AskedRun(CompiledRun):
    """See `CompiledRun`.

    Args:
        motion: The trials as they begin.
        wanted: The reference, fields of shape (T, nv).
        histories: What is written, by the names of `Histories`; complete after `finish`.
        log_every: One tick in how many is logged.
        ks: K_s with which s is logged, a scalar or (nv,); None where it is not.
    """

    def __init__(
        self, motion: Motion, wanted: Setpoint, histories: dict[str, Array], log_every: int, ks: Array | None
    ) -> None:
        in_a_tick, logged = len(histories) * motion.q.size, len(histories["q"][0])
        super().__init__(motion, wanted, histories, log_every, ks, max(4, min(logged, LOG_NUMBERS // in_a_tick)))
        self._done, self._logged, self._full = 0, 0, len(self._log)
        self._changes = frozenset(motion.changes)
        self.running = int(self.active.sum())
        """How many trials run."""

    def follow_command(self, command: Array, gain: Array | None) -> None:
        """Hold a command, (batch, nv) N·m, over the period of the next tick, and look at the one after it.

        Args:
            command: What the law asks for.
            gain: What its state calls ``gain``, (batch, nv), to be logged.
        """
        k = self._done
        if k in self._changes:
            self._regroup(k)
        self._command[:] = command
        if gain is not None:
            self._gain[:] = gain
        self.running = self._look(k)
        self._done = k + 1
        if k % self._setup.log_every == 0:
            self._logged += 1
            if self._logged == self._full:
                self._spread()
                self._full += len(self._log)

    def finish(self) -> None:
        """Write what is not written yet; of a trial that stopped, NaN from the tick at which it did."""
        self._spread()
        self._blank_stopped()

    def _spread(self) -> None:
        begin = self._full - len(self._log)
        stopped = first_logged(self.stopped_at, self._setup.log_every)
        spread(self._log, self._places, begin, self._logged, stopped, self._histories)
