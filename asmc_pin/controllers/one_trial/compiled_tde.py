"""The shared control (7) of one trial, compiled: time-delay estimation and pole placement.

The letters and equations are those of `asmc_pin.controllers.tde`, which has the parameters and the state.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numba
import numpy as np
from numba import types

from asmc_pin._typing import Array, Number
from asmc_pin.controllers.one_trial.trial_step import WORK_ROWS, Tick, trial_step
from asmc_pin.numerics.short_loops import ALLOCATING, short_loops

MBAR, KS, BETA, PERIOD, FILTER_WEIGHT, BY_POSITION, AVERAGES_TORQUE = range(7)
"""Rows of a TDE law's parameters that all of them share; the last two are 1 for yes and 0 for no."""
OWN = 7
"""First row of the parameters that are a law's own."""

POSITION, VELOCITY, ACCELERATION, TORQUE = range(4)
"""Rows of memory: the arrays of a `TdeState`."""
OWN_MEMORY = 4
"""First row of memory that is a law's own, if its state begins with a `TdeState`."""

S, WANTED, PAST_TORQUE, PAST_ACCELERATION = range(4)
"""Rows of work that `tde_terms` fills: s (4); q̈_d + K_s ė + β s; τ(t−L); the estimate of q̈(t−L)."""
FREE = 4
"""First row of work that a law may use for itself."""


@short_loops
def surface(ks: Number, q: Number, v: Number, q_ref: Number, v_ref: Number) -> Number:
    """The sliding variable (4) of one joint, ė + K_s e, rad/s."""
    return (v_ref - v) + ks * (q_ref - q)


@short_loops
def with_sign(size: Number, s: Number) -> Number:
    """Size·sgn(s) for size ≥ 0, with sgn(0) = +1 (10)."""
    signed: Number = np.copysign(size, s + 0.0)  # the sum makes +0.0 of −0.0
    return signed


@short_loops
def tde_terms(tick: Tick, law: Array, memory: Array, work: Array) -> None:
    """What (7) is made of, written to the rows `S` to `PAST_ACCELERATION` of work; memory is brought up to date.

    At the first tick nothing is known and the estimate is 0: before t = 0 the arm is taken to have moved on at v_0
    unaccelerated, and the drives to have held what they hold at t = 0. By position that also defines the second tick,
    q_{−1} = q_0 − L v_0: its estimate is ((q_1 − q_0)/L − v_0)/L. A filter starts from the 0 of the first tick.
    """
    first = tick.ticks == 0
    period, weight, beta = law[PERIOD, 0], law[FILTER_WEIGHT, 0], law[BETA, 0]
    by_position, averages = law[BY_POSITION, 0] != 0.0, law[AVERAGES_TORQUE, 0] != 0.0
    for i in range(tick.q.size):
        q, v, torque = tick.q[i], tick.v[i], tick.torque[i]
        work[PAST_TORQUE, i] = 0.5 * (torque + memory[TORQUE, i]) if averages else torque
        velocity = (q - memory[POSITION, i]) / period if by_position and not first else v
        estimate = (velocity - memory[VELOCITY, i]) / period
        if weight != 1.0:
            estimate = memory[ACCELERATION, i] + weight * (estimate - memory[ACCELERATION, i])
        estimate = 0.0 if first else estimate
        memory[POSITION, i], memory[VELOCITY, i], memory[ACCELERATION, i], memory[TORQUE, i] = (
            q,
            velocity,
            estimate,
            torque,
        )
        s = surface(law[KS, i], q, v, tick.q_ref[i], tick.v_ref[i])
        work[S, i] = s
        work[WANTED, i] = tick.a_ref[i] + law[KS, i] * (tick.v_ref[i] - v) + beta * s
        work[PAST_ACCELERATION, i] = estimate


@short_loops
def pole_placement(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    """The shared control (7) as the command; what it is made of stays in work, see `tde_terms`."""
    tde_terms(tick, law, memory, work)
    for i in range(command.size):
        command[i] = work[PAST_TORQUE, i] + law[MBAR, i] * (work[WANTED, i] - work[PAST_ACCELERATION, i])


@trial_step
def plain_step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    """Pole placement with time-delay estimation and nothing else."""
    pole_placement(tick, law, memory, work, command)


def _over_trials(
    ticks: int,
    law: Array,
    q: Array,
    v: Array,
    torque: Array,
    q_ref: Array,
    v_ref: Array,
    a_ref: Array,
    position: Array,
    velocity: Array,
    acceleration: Array,
    past: Array,
    out: Array,
) -> bool:
    """See `shared_control`."""
    batch, nv = q.shape
    told, memory, work = np.empty((6, nv)), np.empty((OWN_MEMORY, nv)), np.empty((WORK_ROWS, nv))
    for given in (v, torque, q_ref, v_ref, a_ref, position, velocity, acceleration, past):
        if given.shape != q.shape:
            return False
    for trial in range(batch):
        for i in range(nv):
            told[0, i], told[1, i], told[2, i] = q[trial, i], v[trial, i], torque[trial, i]
            told[3, i], told[4, i], told[5, i] = q_ref[trial, i], v_ref[trial, i], a_ref[trial, i]
            memory[POSITION, i], memory[VELOCITY, i] = position[trial, i], velocity[trial, i]
            memory[ACCELERATION, i], memory[TORQUE, i] = acceleration[trial, i], past[trial, i]
        tick = Tick(ticks, told[0], told[1], told[2], told[3], told[4], told[5])
        pole_placement(tick, law[trial if len(law) > 1 else 0], memory, work, out[0, trial])
        for i in range(nv):
            out[1, trial, i] = work[S, i]
            for row in range(OWN_MEMORY):
                out[2 + row, trial, i] = memory[row, i]
    return True


@cache
def shared_control() -> Callable[..., bool]:
    """The shared control (7) of a batch in one call, for laws that have their step in numpy; compiled when asked for.

    The function takes the ticks taken; the law's parameters, (1 or batch, rows, nv); the fields of a sample, a set
    point and a `TdeState`, (batch, nv) each, in whatever layout; and writes the torque, s and the arrays of the next
    state, (6, batch, nv). It returns whether all shapes were the same, and has written nothing otherwise.
    """
    kinds: Any = types
    given = kinds.Array(kinds.float64, 2, "A", readonly=True)
    rows = kinds.Array(kinds.float64, 3, "C")
    signature = kinds.boolean(kinds.int64, rows, *10 * [given], rows)
    compiled: Callable[..., bool] = numba.njit(signature, **ALLOCATING)(_over_trials)
    return compiled
