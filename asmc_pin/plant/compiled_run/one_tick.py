"""One tick of all trials under commands that are given, compiled: for a law in numpy, which is asked at every tick.

What crosses from Python is the number of the tick and one table of arrays, which are made once: numba looks at all that
it is handed, which for these arrays takes longer than the tick of a trial. The log of some ticks stays together until
it is spread over the histories, a trial's at a time: a tick that writes to each history by itself touches another page
of memory for each trial and history.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.controllers.one_trial.compiled_tde import surface
from asmc_pin.numerics.array_table import floats1, floats2, floats3, floats4, whole1, whole2
from asmc_pin.numerics.short_loops import inlined, short_loops, with_room
from asmc_pin.plant.compiled_run.one_period import advance, hold, observe, within
from asmc_pin.plant.compiled_run.run_arrays import Histories
from asmc_pin.plant.compiled_run.run_rows import (
    BEGAN_Q,
    BEGAN_V,
    EXTERNAL,
    FRICTION,
    TORQUE,
    Q,
    Setup,
    V,
)
from asmc_pin.plant.joint_reach import reached

# Rows of the table: what belongs to the run and its trials, with shapes as in `Inputs` and `Trials`, but a command and
# a gain of the law for each trial, (batch, nv), noise of one tick, (batch, 3, nv), and the log, (ticks, batch, rows,
# nv); then where a history stands in the log, −1 for one that is not written; then what belongs to one arm.
(
    NUMBERS,
    COMMAND,
    TOLD_GAIN,
    KS,
    Q_REF,
    V_REF,
    SHARES,
    LOADS,
    OWN_LOADS,
    NOISE,
    PLANT,
    STATE,
    DRIVE,
    SENSOR,
    SEEN,
    STOPPED_AT,
    REACH,
    LOG,
    PLACES,
    PARENT,
    BODY,
    GRAVITY,
    ROWS,
    SCRATCH,
    ROOM_OF_LINKS,
    ROOM_OF_SQUARES,
    SIGNS,
) = range(27)


@inlined
def _setup_of(numbers: Array) -> Setup:
    """The scalars of a plant and its log, from an array of them."""
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
        int(numbers[16]),
    )


@inlined
def _note(
    log: Array,
    places: IntArray,
    q: Array,
    v: Array,
    seen: Array,
    state: Array,
    ks: Array,
    gain: Array,
    q_ref: Array,
    v_ref: Array,
    k: int,
) -> None:
    """What happened in a period, at the places of `Histories`."""
    for i in range(q.size):
        log[0, i], log[1, i], log[2, i], log[3, i] = q[i], v[i], state[TORQUE, i], state[FRICTION, i]
        if places[4] >= 0:
            log[places[4], i], log[places[5], i] = seen[0, i], seen[1, i]
        log[places[6], i] = seen[2, i]
        if places[7] >= 0:
            log[places[7], i] = state[EXTERNAL, i]
        if places[8] >= 0:
            log[places[8], i] = surface(ks[i], seen[0, i], seen[1, i], q_ref[k, i], v_ref[k, i])
        if places[9] >= 0:
            log[places[9], i] = gain[i]


@inlined
def _one_trial(
    k: int,
    logged: bool,
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
    reach: Array,
    log: Array,
    places: IntArray,
    ks: Array,
    gain: Array,
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
        reached(reach, q, k)
        advance(
            setup, parent, body, gravity, older_share, loads, own_loads, 0,
            plant, state, drive, scratch, room, squares, signs,
        )  # fmt: skip
        if logged:
            _note(log, places, q, v, seen, state, ks, gain, q_ref, v_ref, k)
    if k + 1 < len(q_ref):
        if not within(setup, state, q_ref, k + 1):
            return k + 1
        observe(setup, k < 0, plant, state, sensor, noise, seen)
    return -1


@with_room
def run_commands(k: int, table: IntArray, told: Array) -> int:
    """Carry trials over the period of tick k under given commands, and look at the next tick.

    Args:
        k: The tick; −1 to look at tick 0 alone.
        table: `ArrayTable.rows` of all that the trials of one arm need, in the order of the rows above.
        told: Written: what is reported at the next tick, (3, batch, nv), of these trials.

    Returns:
        How many of the trials run.
    """
    setup, ticks, running = _setup_of(floats1(table, NUMBERS)), len(floats2(table, Q_REF)), 0
    command, gain, ks = floats2(table, COMMAND), floats2(table, TOLD_GAIN), floats1(table, KS)
    q_ref, v_ref, older_share = floats2(table, Q_REF), floats2(table, V_REF), floats1(table, SHARES)
    loads, own_loads, noise = floats2(table, LOADS), floats3(table, OWN_LOADS), floats3(table, NOISE)
    plant, state, drive = floats3(table, PLANT), floats3(table, STATE), floats3(table, DRIVE)
    sensor, seen, stopped_at = floats3(table, SENSOR), floats3(table, SEEN), whole1(table, STOPPED_AT)
    reach, log, places = floats3(table, REACH), floats4(table, LOG), whole1(table, PLACES)
    parent, body, gravity = whole1(table, PARENT), floats2(table, BODY), floats1(table, GRAVITY)
    scratch, room, squares = floats2(table, SCRATCH), floats2(table, ROOM_OF_LINKS), floats3(table, ROOM_OF_SQUARES)
    signs, nothing = whole2(table, SIGNS), np.zeros((3, command.shape[1]))
    at, logged = k // setup.log_every % len(log), k % setup.log_every == 0
    for trial in whole1(table, ROWS):
        if stopped_at[trial] == ticks:
            stop = _one_trial(
                k, logged, command[trial], setup, parent, body, gravity, q_ref, v_ref, older_share, loads,
                own_loads[trial] if own_loads.size else nothing[:0], noise[trial] if noise.size else nothing,
                plant[trial], state[trial], drive[trial], sensor[trial], seen[trial], reach[trial],
                log[at, trial], places, ks, gain[trial], scratch, room, squares, signs,
            )  # fmt: skip
            if stop < 0:
                running += 1
            else:
                stopped_at[trial] = stop
                state[trial] = 0.0
                seen[trial] = 0.0
        for row in range(3):
            for i in range(seen.shape[2]):
                told[row, trial, i] = seen[trial, row, i]
    return running


@short_loops
def _spread_one(log: Array, row: int, trial: int, history: Array, begin: int, end: int) -> None:
    """One history of one trial."""
    for k in range(begin, end):
        for i in range(history.shape[2]):
            history[trial, k, i] = log[k - begin, trial, row, i]


@short_loops
def spread(log: Array, places: IntArray, begin: int, end: int, stopped: IntArray, histories: Histories) -> None:
    """Write the log of logged ticks from `begin` on to the histories; of a trial that stopped, those before it."""
    for trial in range(log.shape[1]):
        last = min(end, stopped[trial])
        for number, history in enumerate(histories):
            if places[number] >= 0:
                _spread_one(log, places[number], trial, history, begin, last)
