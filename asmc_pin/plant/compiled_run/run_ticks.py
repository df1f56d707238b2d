"""Ticks of one trial after the other, compiled: each runs through many of them under a compiled law.

All that belongs to a trial stands in its own rows, so its result depends neither on the batch, nor on how ticks are cut
into chunks, nor on the thread that computes it.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.controllers.one_trial.compiled_tde import surface
from asmc_pin.controllers.one_trial.trial_step import WORK_ROWS, Tick, run_at
from asmc_pin.numerics.short_loops import inlined, short_loops, with_room
from asmc_pin.plant.compiled_run.one_period import advance, hold, observe, within
from asmc_pin.plant.compiled_run.run_arrays import Histories, Inputs, Trials
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
from asmc_pin.plant.joint_reach import reached
from asmc_pin.rigid_body.dynamics import ROOM


@inlined
def _write(
    histories: Histories,
    trial: int,
    k: int,
    q: Array,
    v: Array,
    state: Array,
    told: Array,
    ks: Array,
    gain: int,
    memory: Array,
) -> None:
    """What happened in a period, as logged tick k: where it began, what the law was told then, and what acted."""
    for i in range(q.size):
        histories.q[trial, k, i], histories.v[trial, k, i] = q[i], v[i]
        histories.torque[trial, k, i] = state[TORQUE, i]
        histories.friction_torque[trial, k, i] = state[FRICTION, i]
        if histories.q_measured.size:
            histories.q_measured[trial, k, i] = told[0, i]
            histories.v_measured[trial, k, i] = told[1, i]
        histories.torque_measured[trial, k, i] = told[2, i]
        if histories.external_torque.size:
            histories.external_torque[trial, k, i] = state[EXTERNAL, i]
        if histories.s.size:
            histories.s[trial, k, i] = surface(ks[i], told[0, i], told[1, i], told[3, i], told[4, i])
        if gain >= 0:
            histories.gain[trial, k, i] = memory[gain, i]


@short_loops
def _fill_nan(history: Array, trial: int, k: int) -> None:
    """Make a history of a trial NaN from logged tick k on, if it is written at all."""
    if history.size:
        history[trial, k:] = np.nan


@short_loops
def _stop(histories: Histories, trials: Trials, trial: int, k: int, logged: int) -> None:
    """End a trial at tick k, of which some have been logged before, and park it."""
    trials.active[trial] = False
    trials.stopped_at[trial] = k
    trials.state[trial] = 0.0
    trials.seen[trial] = 0.0
    for history in histories:
        _fill_nan(history, trial, logged)


@short_loops
def _follow_law(
    step: int,
    begin: int,
    end: int,
    law: Array,
    memory: Array,
    gain: int,
    ks: Array,
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    inputs: Inputs,
    own_loads: Array,
    trials: Trials,
    histories: Histories,
    trial: int,
    scratch: Array,
    room: Array,
    squares: Array,
    signs: IntArray,
    work: Array,
    told: Array,
    nothing: Array,
    command: Array,
) -> None:
    """One trial of `run_law`."""
    nv = command.size
    plant, state, drive, sensor = trials.plant[trial], trials.state[trial], trials.drive[trial], trials.sensor[trial]
    seen, q, v, reach = told[:3], scratch[BEGAN_Q], scratch[BEGAN_V], trials.reach[trial]
    every = setup.log_every
    logged = -(-begin // every)  # of the ticks before
    for k in range(begin, end):
        if k == 0:
            for row in range(3):
                for i in range(nv):
                    seen[row, i] = trials.seen[trial, row, i]
        else:
            if not within(setup, state, inputs.q_ref, k):
                _stop(histories, trials, trial, k, logged)
                return
            observe(
                setup, False, plant, state, sensor,
                inputs.noise[trial, k - begin] if inputs.noise.size else nothing, seen,
            )  # fmt: skip
        for i in range(nv):
            told[3, i], told[4, i], told[5, i] = inputs.q_ref[k, i], inputs.v_ref[k, i], inputs.a_ref[k, i]
            q[i], v[i] = state[Q, i], state[V, i]
        tick = Tick(k, told[0], told[1], told[2], told[3], told[4], told[5])
        run_at(step, tick, law, memory, work, command)
        if not hold(plant, scratch, command):
            _stop(histories, trials, trial, k, logged)
            return
        reached(reach, q, k)
        advance(
            setup, parent, body, gravity, inputs.older_share, inputs.loads, own_loads, (k - begin) * setup.substeps,
            plant, state, drive, scratch, room, squares, signs,
        )  # fmt: skip
        if k == logged * every:
            _write(histories, trial, logged, q, v, state, told, ks, gain, memory)
            logged += 1


@with_room
def run_law(
    step: int,
    begin: int,
    end: int,
    law: Array,
    memory: Array,
    gain: int,
    ks: Array,
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    inputs: Inputs,
    trials: Trials,
    histories: Histories,
    rows: IntArray,
) -> None:
    """Run trials under a compiled law from one tick to another.

    Args:
        step: Address of the law's `TrialStep`.
        begin: First tick.
        end: Tick before which to stop.
        law: Its parameters, (1 or batch, rows, nv).
        memory: What it remembers, (batch, rows, nv); written.
        gain: Row of that which is logged as the gain; −1 for none.
        ks: K_s with which s is logged, (nv,), 1/s.
        setup: Scalars of the plant.
        parent: Of the `Bodies` of these trials' arm.
        body: Of the same.
        gravity: Of the same.
        inputs: What comes from outside, in these ticks.
        trials: The trials; written.
        histories: Written.
        rows: Which trials.
    """
    nv = ks.size
    scratch, room, work = np.empty((SCRATCH_ROWS, nv)), np.empty((nv, ROOM)), np.empty((WORK_ROWS, nv))
    squares, signs = np.zeros((SQUARES, nv, nv)), np.empty((2, nv), np.int64)
    told, nothing, command = np.empty((6, nv)), np.zeros((3, nv)), np.empty(nv)
    for trial in rows:
        if trials.active[trial]:
            _follow_law(
                step, begin, end, law[trial if len(law) > 1 else 0], memory[trial], gain, ks,
                setup, parent, body, gravity, inputs,
                inputs.own_loads[trial] if inputs.own_loads.size else nothing[:0], trials, histories, trial,
                scratch, room, squares, signs, work, told, nothing, command,
            )  # fmt: skip
