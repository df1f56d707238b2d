"""What happens to one trial at a tick and in the period after it, compiled: drives, loads, integration, sensors."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.numerics.short_loops import inlined, short_loops
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


@inlined
def within(setup: Setup, state: Array, q_ref: Array, k: int) -> bool:
    """Whether a trial is where it can go on from; written so that NaN is not."""
    for i in range(state.shape[1]):
        slow = abs(state[V, i]) <= setup.speed_bound
        if not (slow and abs(state[Q, i] - q_ref[k, i]) <= setup.error_bound):
            return False
    return True


@inlined
def observe(setup: Setup, first: bool, plant: Array, state: Array, sensor: Array, noise: Array, seen: Array) -> None:
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


@inlined
def hold(plant: Array, scratch: Array, command: Array) -> bool:
    """The command within the drive's limits, in row `TOTAL`; False if it is not finite."""
    finite = True
    for i in range(command.size):
        finite = finite and np.isfinite(command[i])
        scratch[TOTAL, i] = min(max(command[i], -plant[LIMIT, i]), plant[LIMIT, i])
    return finite


@short_loops
def _add_loads(loads: Array, own_loads: Array, at: int, substeps: int, state: Array, scratch: Array) -> None:
    """Add the disturbances of an integration step to row `PUSH`, and to their mean over the period."""
    for i in range(state.shape[1]):
        load = 0.0
        if loads.size:
            load += loads[at, i]
        if own_loads.size:
            load += own_loads[at, i]
        scratch[PUSH, i] += load
        state[EXTERNAL, i] += load / substeps


@inlined
def advance(
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
    squares: Array,
    signs: IntArray,
) -> None:
    """Carry a trial over one period under the command in row `TOTAL`."""
    nv = plant.shape[1]
    newest = drive.shape[0] - 1
    for i in range(nv):
        scratch[AT_Q, i], scratch[AT_V, i] = state[Q, i], state[V, i]
        scratch[IMPULSE, i], state[EXTERNAL, i] = 0.0, 0.0
        if setup.shaped:
            for row in range(1, newest):
                drive[row, i] = drive[row + 1, i]
            drive[newest, i] = scratch[TOTAL, i]
            scratch[TOTAL, i] = 0.0
    for index in range(setup.substeps):
        for i in range(nv):
            push = scratch[TOTAL, i]
            if setup.shaped:
                push, drive[0, i] = joint_torque(
                    drive[2, i], drive[1, i], older_share[index], drive[0, i],
                    plant[REMAINING, i], plant[MEAN_REMAINING, i], plant[LIMIT, i], scratch[AT_V, i],
                    plant[CORNER, i], plant[NO_LOAD, i], plant[SPEED_LIMIT, i], setup.foldback,
                )  # fmt: skip
                scratch[TOTAL, i] += push
            scratch[PUSH, i] = push
        if loads.size or own_loads.size:
            _add_loads(loads, own_loads, since + index, setup.substeps, state, scratch)
        integrate(setup, parent, body, gravity, plant, state, scratch, room, squares, signs)
        for i in range(nv):
            scratch[AT_Q, i], scratch[AT_V, i] = scratch[NEXT_Q, i], scratch[NEXT_V, i]
    for i in range(nv):
        state[Q, i], state[V, i] = scratch[AT_Q, i], scratch[AT_V, i]
        state[TORQUE, i] = scratch[TOTAL, i] / setup.substeps if setup.shaped else scratch[TOTAL, i]
        state[FRICTION, i] = scratch[IMPULSE, i] / setup.period
