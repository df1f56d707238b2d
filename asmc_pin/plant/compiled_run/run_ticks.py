"""Ticks of one trial after the other, compiled: with a compiled law through many of them, or one under its commands.

All that belongs to a trial stands in its own rows, so its result depends neither on the batch, nor on how ticks are cut
into chunks, nor on the thread that computes it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.controllers.one_trial.compiled_tde import surface
from asmc_pin.controllers.one_trial.trial_step import WORK_ROWS, Tick
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.plant.compiled_run.run_rows import (
    AT_Q,
    AT_V,
    CORNER,
    COUNT,
    EXTERNAL,
    FRICTION,
    IMPULSE,
    LIMIT,
    MEAN_REMAINING,
    NEXT_Q,
    NEXT_V,
    NO_LOAD,
    PUSH,
    REMAINING,
    SCRATCH_ROWS,
    SPEED_LIMIT,
    TORQUE,
    TOTAL,
    Q,
    Setup,
    V,
)
from asmc_pin.plant.compiled_run.schemes import integrate
from asmc_pin.plant.drive.compiled_drive import joint_torque
from asmc_pin.plant.sensor.compiled_sensor import read_sensor
from asmc_pin.rigid_body.dynamics import ROOM


class Trials(NamedTuple):
    """What belongs to the trials of a run; the first axis is the trial's.

    Attributes:
        plant: Parameters, (batch, PLANT_ROWS, nv).
        state: (batch, STATE_ROWS, nv).
        drive: What the current loops carry, then commands on their way, oldest first, (batch, rows, nv).
        sensor: Memory of the sensors, (batch, rows, nv).
        seen: Angle, velocity and torque as reported at the present tick, (batch, 3, nv).
        active: Whether it runs, (batch,).
        stopped_at: Tick at which it stopped, (batch,); the number of ticks where it did not.
    """

    plant: Array
    state: Array
    drive: Array
    sensor: Array
    seen: Array
    active: BoolArray
    stopped_at: IntArray


class Inputs(NamedTuple):
    """What comes from outside.

    Attributes:
        q_ref: Reference, (T, nv), rad.
        v_ref: Its velocity.
        a_ref: Its acceleration.
        older_share: Part of each step in which the older of two commands still acts, (substeps,).
        loads: Disturbances, mean over each step, the same for all trials, (ticks·substeps, nv), N·m; empty for none.
        own_loads: Those of each trial, (batch, ticks·substeps, nv); empty for none.
        noise: Of the sensors, (batch, ticks, 3, nv); empty for none.
    """

    q_ref: Array
    v_ref: Array
    a_ref: Array
    older_share: Array
    loads: Array
    own_loads: Array
    noise: Array


class Histories(NamedTuple):
    """What is written of a run, (batch, T, nv) each; empty where it is not asked for."""

    q: Array
    v: Array
    torque: Array
    friction_torque: Array
    q_measured: Array
    v_measured: Array
    torque_measured: Array
    external_torque: Array
    s: Array
    gain: Array


@short_loops
def _within(setup: Setup, state: Array, q_ref: Array, k: int) -> bool:
    """Whether a trial is where it can go on from; written so that NaN is not."""
    for i in range(state.shape[1]):
        slow = abs(state[V, i]) <= setup.speed_bound
        if not (slow and abs(state[Q, i] - q_ref[k, i]) <= setup.error_bound):
            return False
    return True


@short_loops
def _observe(setup: Setup, first: bool, plant: Array, state: Array, sensor: Array, noise: Array, seen: Array) -> None:
    """What the drives of a trial report."""
    if setup.senses:
        read_sensor(
            first, setup.period, setup.delay_fraction, setup.exact_velocity, setup.keep,
            plant[COUNT], noise, state[Q], state[V], state[TORQUE], sensor, seen,
        )  # fmt: skip
    else:
        for row in range(3):
            for i in range(seen.shape[1]):
                seen[row, i] = state[row, i]  # Q, V and TORQUE


@short_loops
def _hold(plant: Array, scratch: Array, command: Array) -> bool:
    """The command within the drive's limits, in row `TOTAL`; False if it is not finite."""
    finite = True
    for i in range(command.size):
        finite = finite and np.isfinite(command[i])
        scratch[TOTAL, i] = min(max(command[i], -plant[LIMIT, i]), plant[LIMIT, i])
    return finite


@short_loops
def _advance(
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    older_share: Array,
    loads: Array,
    own_loads: Array,
    since: int,
    plant: Array,
    state: Array,
    drive: Array,
    scratch: Array,
    room: Array,
    mass: Array,
    factor: Array,
    matrix: Array,
    sign: IntArray,
) -> None:
    """Carry a trial over one period under the command in row `TOTAL`."""
    nv = plant.shape[1]
    newest = drive.shape[0] - 1
    for i in range(nv):
        scratch[AT_Q, i], scratch[AT_V, i] = state[Q, i], state[V, i]
        scratch[PUSH, i] = scratch[TOTAL, i]
        scratch[IMPULSE, i], state[EXTERNAL, i] = 0.0, 0.0
        if setup.shaped:
            for row in range(1, newest):
                drive[row, i] = drive[row + 1, i]
            drive[newest, i] = scratch[TOTAL, i]
            scratch[TOTAL, i] = 0.0
    for index in range(setup.substeps):
        for i in range(nv):
            load = 0.0
            if loads.size:
                load += loads[since + index, i]
            if own_loads.size:
                load += own_loads[since + index, i]
            state[EXTERNAL, i] += load / setup.substeps
            push = scratch[TOTAL, i]
            if setup.shaped:
                push, drive[0, i] = joint_torque(
                    drive[2, i], drive[1, i], older_share[index], drive[0, i],
                    plant[REMAINING, i], plant[MEAN_REMAINING, i], plant[LIMIT, i], scratch[AT_V, i],
                    plant[CORNER, i], plant[NO_LOAD, i], plant[SPEED_LIMIT, i], setup.foldback,
                )  # fmt: skip
                scratch[TOTAL, i] += push
            scratch[PUSH, i] = push + load
        integrate(setup, parent, body, gravity, plant, state, scratch, room, mass, factor, matrix, sign)
        for i in range(nv):
            scratch[AT_Q, i], scratch[AT_V, i] = scratch[NEXT_Q, i], scratch[NEXT_V, i]
    for i in range(nv):
        state[Q, i], state[V, i] = scratch[AT_Q, i], scratch[AT_V, i]
        state[TORQUE, i] = scratch[TOTAL, i] / setup.substeps if setup.shaped else scratch[TOTAL, i]
        state[FRICTION, i] = scratch[IMPULSE, i] / setup.period


@short_loops
def _write(histories: tuple[Array, ...], trial: int, k: int, q: Array, v: Array, seen: Array, state: Array) -> None:
    """What happened in a period: where it began, what was reported then, and what acted."""
    q_log, v_log, torque, friction, q_measured, v_measured, torque_measured, external = histories
    for i in range(q.size):
        q_log[trial, k, i], v_log[trial, k, i] = q[i], v[i]
        torque[trial, k, i], friction[trial, k, i] = state[TORQUE, i], state[FRICTION, i]
        if q_measured.size:
            q_measured[trial, k, i], v_measured[trial, k, i] = seen[0, i], seen[1, i]
            torque_measured[trial, k, i] = seen[2, i]
        if external.size:
            external[trial, k, i] = state[EXTERNAL, i]


@short_loops
def _fill_nan(history: Array, trial: int, k: int) -> None:
    """Make a history of a trial NaN from tick k on, if it is written at all."""
    if history.size:
        history[trial, k:] = np.nan


@short_loops
def _stop(histories: Histories, trials: Trials, trial: int, k: int) -> None:
    """End a trial at tick k, and park it."""
    trials.active[trial] = False
    trials.stopped_at[trial] = k
    trials.state[trial] = 0.0
    trials.seen[trial] = 0.0
    for history in histories:
        _fill_nan(history, trial, k)


@short_loops
def run_law(
    step: Any,
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
        step: The law's `TrialStep`, compiled.
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
    q_ref, v_ref, a_ref, noise, loads = inputs.q_ref, inputs.v_ref, inputs.a_ref, inputs.noise, inputs.loads
    nv = q_ref.shape[1]
    older_share, own_loads = inputs.older_share, inputs.own_loads
    scratch, room, work = np.empty((SCRATCH_ROWS, nv)), np.empty((nv, ROOM)), np.empty((WORK_ROWS, nv))
    mass, factor, matrix = np.zeros((nv, nv)), np.empty((nv, nv)), np.empty((nv, nv))
    sign, nothing, no_loads = np.empty(nv, np.int64), np.zeros((3, nv)), np.zeros((0, nv))
    told, command = np.empty((6, nv)), np.empty(nv)
    seen = told[:3]
    q, v, torque, wished_q, wished_v, wished_a = told[0], told[1], told[2], told[3], told[4], told[5]
    began_q, began_v = np.empty(nv), np.empty(nv)
    logged = (
        histories.q, histories.v, histories.torque, histories.friction_torque,
        histories.q_measured, histories.v_measured, histories.torque_measured, histories.external_torque,
    )  # fmt: skip
    log_s, log_gain = histories.s, histories.gain
    for trial in rows:
        plant, state, drive = trials.plant[trial], trials.state[trial], trials.drive[trial]
        sensor, remembered = trials.sensor[trial], memory[trial]
        own_law = law[trial if len(law) > 1 else 0]
        own_load = own_loads[trial] if own_loads.size else no_loads
        for k in range(begin, end):
            if not trials.active[trial]:
                break
            if k == 0:
                seen[:] = trials.seen[trial]
            else:
                if not _within(setup, state, q_ref, k):
                    _stop(histories, trials, trial, k)
                    break
                now = noise[trial, k - begin] if noise.size else nothing
                _observe(setup, False, plant, state, sensor, now, seen)
            for i in range(nv):
                wished_q[i], wished_v[i], wished_a[i] = q_ref[k, i], v_ref[k, i], a_ref[k, i]
                began_q[i], began_v[i] = state[Q, i], state[V, i]
            step(Tick(k, q, v, torque, wished_q, wished_v, wished_a), own_law, remembered, work, command)
            if not _hold(plant, scratch, command):
                _stop(histories, trials, trial, k)
                break
            _advance(
                setup, parent, body, gravity, older_share, loads, own_load, (k - begin) * setup.substeps,
                plant, state, drive, scratch, room, mass, factor, matrix, sign,
            )  # fmt: skip
            _write(logged, trial, k, began_q, began_v, seen, state)
            for i in range(nv):
                if log_s.size:
                    log_s[trial, k, i] = surface(ks[i], q[i], v[i], wished_q[i], wished_v[i])
                if gain >= 0:
                    log_gain[trial, k, i] = remembered[gain, i]


@short_loops
def run_commands(
    k: int,
    command: Array,
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    inputs: Inputs,
    trials: Trials,
    histories: Histories,
    rows: IntArray,
) -> None:
    """Carry trials over the period of tick k under given commands, (batch, nv), and look at the next tick.

    For k = −1 only tick 0 is looked at. The other arguments are those of `run_law`; the noise is that of the next tick.
    """
    q_ref, noise, loads = inputs.q_ref, inputs.noise, inputs.loads
    nv = q_ref.shape[1]
    older_share, own_loads = inputs.older_share, inputs.own_loads
    scratch, room = np.empty((SCRATCH_ROWS, nv)), np.empty((nv, ROOM))
    mass, factor, matrix = np.zeros((nv, nv)), np.empty((nv, nv)), np.empty((nv, nv))
    sign, nothing, no_loads = np.empty(nv, np.int64), np.zeros((3, nv)), np.zeros((0, nv))
    began_q, began_v = np.empty(nv), np.empty(nv)
    logged = (
        histories.q, histories.v, histories.torque, histories.friction_torque,
        histories.q_measured, histories.v_measured, histories.torque_measured, histories.external_torque,
    )  # fmt: skip
    for trial in rows:
        if not trials.active[trial]:
            continue
        plant, state, seen = trials.plant[trial], trials.state[trial], trials.seen[trial]
        if k >= 0:
            if not _hold(plant, scratch, command[trial]):
                _stop(histories, trials, trial, k)
                continue
            for i in range(nv):
                began_q[i], began_v[i] = state[Q, i], state[V, i]
            _advance(
                setup, parent, body, gravity, older_share, loads, own_loads[trial] if own_loads.size else no_loads, 0,
                plant, state, trials.drive[trial], scratch, room, mass, factor, matrix, sign,
            )  # fmt: skip
            _write(logged, trial, k, began_q, began_v, seen, state)
        if k + 1 < len(q_ref):
            if not _within(setup, state, q_ref, k + 1):
                _stop(histories, trials, trial, k + 1)
                continue
            now = noise[trial, 0] if noise.size else nothing
            _observe(setup, k < 0, plant, state, trials.sensor[trial], now, seen)
