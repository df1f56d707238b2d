"""A run in compiled code while it goes on: the numbers of a plant's trials, made from a `Motion` that has not moved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.numerics.array_table import ArrayTable
from asmc_pin.plant.compiled_run.held_dynamics import held_bodies
from asmc_pin.plant.compiled_run.one_tick import LOADS, NOISE, OWN_LOADS, run_commands
from asmc_pin.plant.compiled_run.run_arrays import Histories, Inputs, Trials
from asmc_pin.plant.compiled_run.run_rows import (
    SCRATCH_ROWS,
    SQUARES,
    STATE_ROWS,
    TORQUE,
    Q,
    V,
)
from asmc_pin.plant.compiled_run.run_setup import plant_rows, setup_of
from asmc_pin.plant.compiled_run.run_ticks import run_law
from asmc_pin.plant.joint_reach import no_reach
from asmc_pin.plant.plant_state import Motion
from asmc_pin.plant.run_recorder import first_logged
from asmc_pin.plant.sensor.compiled_sensor import HISTORY
from asmc_pin.rigid_body.dynamics import ROOM, Bodies

# Trials a thread is worth starting for.
TRIALS_PER_THREAD = 8

_NO_ROWS: Array = np.zeros((0, 1))
_NO_TRIALS: Array = np.zeros((0, 1, 1))
_NO_NOISE: Array = np.zeros((0, 1, 3, 1))


class CompiledRun:
    """The trials of a run.

    Args:
        motion: The trials as they begin.
        wanted: The reference, fields of shape (T, nv).
        histories: What is written, by the names of `Histories`; the others are not.
        log_every: One tick in how many is logged.
        ks: K_s with which s is logged where the law is asked at every tick, a scalar or (nv,).
        log_ticks: How many logged ticks there are then before they are spread over the histories.
    """

    def __init__(
        self,
        motion: Motion,
        wanted: Setpoint,
        histories: dict[str, Array],
        log_every: int = 1,
        ks: Array | None = None,
        log_ticks: int = 0,
    ) -> None:
        self._motion, self._wanted = motion, wanted
        self._pool: ThreadPoolExecutor | None = None
        batch, nv = motion.q.shape
        self._ticks = len(wanted.q)
        self._histories = Histories(*(histories.get(name, _NO_TRIALS) for name in Histories._fields))
        self._setup = setup_of(motion, log_every)
        sensing, actuator = motion.sensing, motion.actuator
        state = np.zeros((batch, STATE_ROWS, nv))
        state[:, Q], state[:, V], state[:, TORQUE] = motion.q, motion.v, motion.torque
        on_their_way = 0 if motion.plant.drive is None else 2 + int(motion.plant.drive.delay)
        self._trials = Trials(
            plant_rows(motion),
            state,
            np.repeat(motion.torque[:, None], 1 + on_their_way, axis=1),
            np.zeros((batch, HISTORY, nv)) if sensing is None else sensing.memory,
            np.zeros((batch, 3, nv)),
            np.ones(batch, dtype=np.bool_),
            np.full(batch, self._ticks),
            no_reach(motion.plant, batch),
        )
        self._shares = np.zeros(self._setup.substeps) if actuator is None else np.array(actuator.older_share)
        self._command, self._gain = np.zeros((2, batch, nv))
        self._places, self._log = _log_of(self._histories, log_ticks, batch, nv)
        self._common = [
            np.array(self._setup, dtype=np.float64),
            self._command,
            self._gain,
            np.zeros(nv) if ks is None else np.array(np.broadcast_to(ks, (nv,))),
            wanted.q,
            wanted.v,
            self._shares,
            _NO_ROWS,
            _NO_TRIALS,
            _NO_TRIALS,
            *self._trials[:5],
            self._trials.stopped_at,
            self._trials.reach,
            self._log,
            self._places,
        ]
        self._changing = motion.loads is not None or (sensing is not None and sensing.noisy)
        self._groups: list[tuple[Bodies, IntArray]] = []
        self._tables: list[ArrayTable] = []
        self._regroup(0)
        self._shape = 3, batch, nv
        self._look(-1)
        self._trials.active[:] = self.active
        self._blank_stopped()

    @property
    def active(self) -> BoolArray:
        """Trials that run, (batch,)."""
        running: BoolArray = self.stopped_at == self._ticks
        return running

    @property
    def stopped_at(self) -> IntArray:
        """Tick at which a trial stopped, (batch,); the number of ticks where it did not."""
        return self._trials.stopped_at

    @property
    def reach(self) -> Array:
        """How far the joints came at any tick, see `asmc_pin.plant.joint_reach`."""
        return self._trials.reach

    def sample(self) -> Sample:
        """What the drives report at this tick; read-only."""
        self._told.setflags(write=False)
        return Sample(*self._told)

    def follow_law(
        self, step: int, law: Array, memory: Array, gain: int | None, ks: Array | None, begin: int, end: int
    ) -> int:
        """Run a compiled law over ticks, not beyond one where the arms change.

        Args:
            step: Address of the law's step.
            law: Its parameters, (1 or batch, rows, nv).
            memory: What it remembers, (batch, rows, nv); written.
            gain: Row of that which is logged.
            ks: K_s with which s is logged.
            begin: First tick.
            end: Tick before which to stop.

        Returns:
            The tick that comes next.
        """
        self._regroup(begin)
        end = min([end, *(tick for tick in self._motion.changes if tick > begin)])
        nv = law.shape[2]
        row = -1 if gain is None else gain
        ks = np.zeros(nv) if ks is None else np.array(np.broadcast_to(ks, (nv,)))
        inputs = self._inputs(begin, end - begin, ahead=False)
        numbers = (step, begin, end, law, memory, row, ks, self._setup)
        given = (inputs, self._trials, self._histories)
        self._on_threads(run_law, [(*numbers, *bodies, *given, rows) for bodies, rows in self._jobs()])
        return end

    def _look(self, k: int) -> int:
        """Hold the command over the period of tick k, and look at the next one: `run_commands`; how many trials run."""
        if not self._tables:
            self._tables = [self._table_of(*job) for job in self._jobs()]
        if self._changing:
            inputs = self._inputs(k, 1, ahead=True)
            for row, array in ((LOADS, inputs.loads), (OWN_LOADS, inputs.own_loads), (NOISE, inputs.noise[:, 0])):
                if array.size:
                    self._hand_over(row, array)
        self._told = told = np.empty(self._shape)  # anew at every tick, since a law may keep what it was told
        if len(self._tables) == 1:
            running: int = run_commands(k, self._tables[0].rows, told)
            return running
        return sum(self._on_threads(run_commands, [(k, table.rows, told) for table in self._tables]))

    def _hand_over(self, row: int, array: Array) -> None:
        """Write what comes from outside in a period where the tables have it."""
        if self._common[row].shape == array.shape:
            self._common[row][...] = array
            return
        self._common[row] = np.array(array, order="C")
        for table in self._tables:
            table.put(row, self._common[row])

    def _table_of(self, bodies: Bodies, rows: IntArray) -> ArrayTable:
        """What `run_commands` takes for the trials of one arm."""
        nv = self._command.shape[1]
        room = np.empty((SCRATCH_ROWS, nv)), np.empty((nv, ROOM)), np.zeros((SQUARES, nv, nv))
        return ArrayTable([*self._common, *bodies, rows, *room, np.empty((2, nv), np.int64)])

    def _blank_stopped(self) -> None:
        """Make the histories of a trial that stopped NaN from that tick on."""
        stopped = first_logged(self.stopped_at, self._setup.log_every)
        for trial in np.flatnonzero(self.stopped_at < self._ticks):
            for history in self._histories:
                if history.size:
                    history[trial, stopped[trial] :] = np.nan

    def _jobs(self) -> list[tuple[Bodies, IntArray]]:
        """Arms with the trials that have them, cut for the plant's threads."""
        threads, jobs = self._motion.plant.threads, []
        if threads == 1:
            return self._groups
        for bodies, rows in self._groups:
            count = max(1, min(threads, len(rows) // TRIALS_PER_THREAD))
            jobs += [(bodies, part) for part in (np.array_split(rows, count) if count > 1 else [rows])]
        return jobs

    def _on_threads(self, run: Callable[..., Any], jobs: Sequence[tuple[Any, ...]]) -> list[Any]:
        """What `run` returns for every job, run on the plant's threads."""
        if len(jobs) == 1 or self._motion.plant.threads == 1:
            return [run(*job) for job in jobs]
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._motion.plant.threads)
        return list(self._pool.map(lambda job: run(*job), jobs))

    def _inputs(self, k: int, ticks: int, ahead: bool) -> Inputs:
        """What comes from outside in some ticks from k on; `ahead` if they end with a look at the tick after them."""
        wanted, motion = self._wanted, self._motion
        noise, loads, own = _NO_NOISE, _NO_ROWS, _NO_TRIALS
        if motion.sensing is not None and motion.sensing.noisy:
            looked_at = k == 0 and not ahead  # as the run began
            noise = motion.sensing.noise(ticks - looked_at)
            if looked_at:
                noise = np.concatenate([np.zeros_like(noise[:, :1]), noise], axis=1) if ticks > 1 else noise
        if motion.loads is not None and k >= 0:
            loads, own = motion.loads.over(k, ticks, self._setup.period, self._setup.substeps)
        return Inputs(wanted.q, wanted.v, wanted.a, self._shares, loads, own, noise)

    def _regroup(self, k: int) -> None:
        """Trials with the same arm together, as the arms are at tick k."""
        if self._groups and k not in self._motion.changes:
            return
        arms = self._motion.plant.arms_at(k * self._setup.period, self._setup.period)
        members: dict[int, list[int]] = {}
        for trial in range(len(self.active)):
            members.setdefault(id(arms[trial % len(arms)]), []).append(trial)
        self._tables = []
        self._groups = [
            (held_bodies(arms[rows[0] % len(arms)]), np.array(rows, dtype=np.int64)) for rows in members.values()
        ]


def _log_of(histories: Histories, ticks: int, batch: int, nv: int) -> tuple[IntArray, Array]:
    """Where each history stands in the log of `run_commands`, −1 for one that is not written; and that log."""
    written = np.array([history.size > 0 for history in histories])
    return np.where(written, np.cumsum(written) - 1, -1), np.empty((max(ticks, 1), batch, int(written.sum()), nv))
