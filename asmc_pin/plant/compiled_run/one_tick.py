"""One tick of all trials under commands that are given, compiled: for a law in numpy, which is asked at every tick.

What crosses from Python is arrays alone, as few as can be: numba looks at a tuple's every member, which takes longer
than the tick of a trial. The log of some ticks stays together until it is spread over the histories, a trial's at a
time: a tick that writes to each history by itself touches another page of memory for each trial and history.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.controllers.one_trial.compiled_tde import surface
from asmc_pin.numerics.short_loops import inlined, short_loops, with_room
from asmc_pin.plant.compiled_run.one_period import advance, hold, observe, within
from asmc_pin.plant.compiled_run.run_rows import (
    BEGAN_Q,
    BEGAN_V,
    EXTERNAL,
    FRICTION,
    SCRATCH_ROWS,
    SQUARES,
    TORQUE,
    Q,
    Setup,
    V,
)
from asmc_pin.plant.compiled_run.run_ticks import Histories
from asmc_pin.rigid_body.dynamics import ROOM

LOGGED = len(Histories._fields)
"""Rows of a trial's log at a tick: those of `Histories`, in their order."""

GAIN = Histories._fields.index("gain")
"""The row that a law's gain is written to, from outside."""

LOG_TICKS = 16
"""Ticks of a log: few enough for a cache, enough for the histories to be written in runs."""


@inlined
def _setup_of(numbers: Array) -> Setup:
    """The scalars of a plant, from an array of them."""
    return Setup(
        numbers[0],
        numbers[1],
        int(numbers[2]),
        int(numbers[3]),
        numbers[4] != 0.0,
        numbers[5] != 0.0,
        numbers[6] != 0.0,
        numbers[7] != 0.0,
        numbers[8] != 0.0,
        numbers[9],
        numbers[10] != 0.0,
        numbers[11] != 0.0,
        numbers[12],
        numbers[13],
        numbers[14],
        numbers[15],
    )


@inlined
def _note(
    log: Array, q: Array, v: Array, seen: Array, state: Array, ks: Array, q_ref: Array, v_ref: Array, k: int
) -> None:
    """What happened in a period, in the rows of `Histories`."""
    for i in range(q.size):
        log[0, i], log[1, i], log[2, i], log[3, i] = q[i], v[i], state[TORQUE, i], state[FRICTION, i]
        log[4, i], log[5, i], log[6, i] = seen[0, i], seen[1, i], seen[2, i]
        log[7, i] = state[EXTERNAL, i]
        log[8, i] = surface(ks[i], seen[0, i], seen[1, i], q_ref[k, i], v_ref[k, i])


@inlined
def _one_trial(
    k: int,
    command: Array,
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    q_ref: Array,
    v_ref: Array,
    older_share: Array,
    loads: Array,
    own_loads: Array,
    noise: Array,
    plant: Array,
    state: Array,
    drive: Array,
    sensor: Array,
    seen: Array,
    log: Array,
    ks: Array,
    scratch: Array,
    room: Array,
    squares: Array,
    signs: IntArray,
) -> int:
    """One trial of `run_commands`; the tick at which it stops, −1 for none."""
    if k >= 0:
        if not hold(plant, scratch, command):
            return k
        q, v = scratch[BEGAN_Q], scratch[BEGAN_V]
        for i in range(command.size):
            q[i], v[i] = state[Q, i], state[V, i]
        advance(
            setup, parent, body, gravity, older_share, loads, own_loads, 0,
            plant, state, drive, scratch, room, squares, signs,
        )  # fmt: skip
        _note(log, q, v, seen, state, ks, q_ref, v_ref, k)
    if k + 1 < len(q_ref):
        if not within(setup, state, q_ref, k + 1):
            return k + 1
        observe(setup, k < 0, plant, state, sensor, noise, seen)
    return -1


@with_room
def run_commands(
    k: int,
    command: Array,
    numbers: Array,
    parent: IntArray,
    body: Array,
    gravity: Array,
    q_ref: Array,
    v_ref: Array,
    older_share: Array,
    loads: Array,
    own_loads: Array,
    noise: Array,
    plant: Array,
    state: Array,
    drive: Array,
    sensor: Array,
    seen: Array,
    active: BoolArray,
    stopped_at: IntArray,
    log: Array,
    ks: Array,
    rows: IntArray,
) -> int:
    """Carry trials over the period of tick k under given commands, (batch, nv), and look at the next tick.

    For k = −1 only tick 0 is looked at. The log is (LOG_TICKS, batch, LOGGED, nv), of which tick k writes its own;
    `numbers` are the fields of `Setup`; the other arguments are fields of what `run_law` takes, the noise that of the
    next tick.

    Returns:
        How many of the trials run.
    """
    nv = command.shape[1]
    scratch, room, nothing = np.empty((SCRATCH_ROWS, nv)), np.empty((nv, ROOM)), np.zeros((3, nv))
    squares, signs = np.zeros((SQUARES, nv, nv)), np.empty((2, nv), np.int64)
    setup, at, running = _setup_of(numbers), k % LOG_TICKS, 0
    for trial in rows:
        if active[trial]:
            stop = _one_trial(
                k, command[trial], setup, parent, body, gravity, q_ref, v_ref, older_share, loads,
                own_loads[trial] if own_loads.size else nothing[:0], noise[trial, 0] if noise.size else nothing,
                plant[trial], state[trial], drive[trial], sensor[trial], seen[trial], log[at, trial], ks,
                scratch, room, squares, signs,
            )  # fmt: skip
            if stop < 0:
                running += 1
            else:
                active[trial] = False
                stopped_at[trial] = stop
                state[trial] = 0.0
                seen[trial] = 0.0
    return running


@short_loops
def _spread_one(log: Array, row: int, trial: int, history: Array, begin: int, end: int) -> None:
    """One history of one trial."""
    for k in range(begin, end):
        for i in range(history.shape[2]):
            history[trial, k, i] = log[k - begin, trial, row, i]


@short_loops
def spread(log: Array, begin: int, end: int, stopped_at: IntArray, histories: Histories) -> None:
    """Write the log of ticks from `begin` on to the histories; of a trial that stopped, the ticks before it."""
    for trial in range(log.shape[1]):
        last = min(end, stopped_at[trial])
        for row, history in enumerate(histories):
            if history.size:
                _spread_one(log, row, trial, history, begin, last)
