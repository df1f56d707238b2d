"""Velocity of one trial after an integration step under friction, compiled: the quick way where every joint slides on.

The laws are those of `plant.friction`, whose solvers it calls where a joint rests, stops, starts or turns. Where each
keeps sliding the way it does, the equations are linear, and one factorisation solves dynamics and friction together:
(M + ε h B)(v⁺ − v) = h F − h B v − h c sgn(v), with F what drives the joints and ε the share of v⁺ in viscous friction.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.numerics.cholesky import solve_shifted
from asmc_pin.numerics.short_loops import inlined, short_loops
from asmc_pin.plant.compiled_run.run_rows import (
    AHEAD,
    BACK,
    BACKWARD,
    BEND,
    BREAK_BACKWARD,
    BREAK_FORWARD,
    BRISTLE,
    BRISTLE_DAMPING,
    CORRECTION,
    DRAG,
    FACTOR,
    FORCE,
    FORWARD,
    HIGH,
    LOCAL,
    LOW,
    MASS,
    MATRIX,
    PRESENT,
    RATE,
    RHS,
    SCALE,
    SHIFT,
    VISCOUS,
    Setup,
    X,
)
from asmc_pin.plant.friction.compiled_friction import carried_load, stribeck_level, walk
from asmc_pin.plant.friction.presliding import walk_pieces


@inlined
def fill_levels(setup: Setup, plant: Array, scratch: Array, at: int) -> None:
    """Friction's levels at the velocity in row `at`, N·m, to the rows `AHEAD` and `BACK`."""
    for i in range(plant.shape[1]):
        ahead, back = plant[FORWARD, i], plant[BACKWARD, i]
        if not setup.constant:
            v, scale = scratch[at, i], plant[SCALE, i]
            ahead = stribeck_level(v, ahead, plant[BREAK_FORWARD, i], scale)
            back = stribeck_level(v, back, plant[BREAK_BACKWARD, i], scale)
        scratch[AHEAD, i], scratch[BACK, i] = ahead, back


@inlined
def after_step(
    setup: Setup,
    plant: Array,
    state: Array,
    scratch: Array,
    squares: Array,
    signs: IntArray,
    v: int,
    at: int,
    step: float,
    implicit: float,
    out: int,
    impulse: int,
    trial_run: bool,
) -> None:
    """Velocity after a step under the forces in row `FORCE` and friction.

    Args:
        setup: Scalars of the plant.
        plant: Its parameters.
        state: Has how far presliding joints have given way; written.
        scratch: Rows of scratch; `v`, `at`, `out` and `impulse` say which.
        squares: M in its row `MASS`, and scratch, (SQUARES, nv, nv).
        signs: Scratch, (2, nv).
        v: Row of the velocity before.
        at: Row of the velocity at which friction's levels are taken.
        step: Length of the step, s.
        implicit: Share of v⁺ in the velocity at which viscous friction acts.
        out: Row of the velocity after; written, exactly 0.0 where a joint sticks.
        impulse: Row that friction's impulse is added to, N·m·s.
        trial_run: Leave presliding as it is, and the impulse too.
    """
    nv = plant.shape[1]
    if not setup.friction:
        for i in range(nv):
            scratch[SHIFT, i] = 0.0
            scratch[RHS, i] = step * scratch[FORCE, i]
        solve_shifted(squares[MASS], scratch, SHIFT, RHS, X, squares[FACTOR])
        for i in range(nv):
            scratch[out, i] = scratch[v, i] + scratch[X, i]
        return
    fill_levels(setup, plant, scratch, at)
    if setup.yields:
        _bend(plant, state, scratch, squares, signs, v, step, out, impulse, trial_run)
    elif not _slide_on(plant, scratch, squares, v, step, implicit, out, impulse, trial_run):
        _slide_or_stick(plant, scratch, squares, signs, v, step, implicit, out, impulse, trial_run)


@inlined
def _slide_on(
    plant: Array,
    scratch: Array,
    squares: Array,
    v: int,
    step: float,
    implicit: float,
    out: int,
    impulse: int,
    trial_run: bool,
) -> bool:
    """The step if every joint slides on, and whether it does."""
    nv = plant.shape[1]
    for i in range(nv):
        speed, damping = scratch[v, i], step * plant[VISCOUS, i]
        level = 0.0
        if scratch[AHEAD, i] > 0.0 or scratch[BACK, i] > 0.0:
            if speed == 0.0:
                return False
            level = scratch[AHEAD, i] if speed > 0.0 else -scratch[BACK, i]
        scratch[SHIFT, i] = implicit * damping
        scratch[RHS, i] = step * (scratch[FORCE, i] - level) - damping * speed
    solve_shifted(squares[MASS], scratch, SHIFT, RHS, X, squares[FACTOR])
    for i in range(nv):
        scratch[out, i] = scratch[v, i] + scratch[X, i]
        kinked = scratch[AHEAD, i] > 0.0 or scratch[BACK, i] > 0.0
        if kinked and not scratch[out, i] * scratch[v, i] > 0.0:
            return False
    if not trial_run:
        for i in range(nv):
            speed = scratch[v, i]
            level = scratch[AHEAD, i] if speed > 0.0 else -scratch[BACK, i]
            acts_at = implicit * scratch[out, i] + (1.0 - implicit) * speed
            scratch[impulse, i] -= step * (plant[VISCOUS, i] * acts_at + level)
    return True


@short_loops
def _slide_or_stick(
    plant: Array,
    scratch: Array,
    squares: Array,
    signs: IntArray,
    v: int,
    step: float,
    implicit: float,
    out: int,
    impulse: int,
    trial_run: bool,
) -> None:
    """The step by the walk over faces; see `plant.friction.compiled_friction`."""
    nv = plant.shape[1]
    mass, matrix = squares[MASS], squares[MATRIX]
    for i in range(nv):
        scratch[SHIFT, i] = 0.0
    solve_shifted(squares[MASS], scratch, SHIFT, FORCE, X, squares[FACTOR])
    for i in range(nv):
        speed, damping = scratch[v, i], step * plant[VISCOUS, i]
        scratch[PRESENT, i] = speed
        scratch[RATE, i] = speed + step * scratch[X, i]
        scratch[DRAG, i] = damping * (implicit * scratch[RATE, i] + (1.0 - implicit) * speed)
        scratch[AHEAD, i] *= step
        scratch[BACK, i] *= step
        for j in range(nv):
            matrix[i, j] = mass[i, j]
        matrix[i, i] += implicit * damping
    drag, ahead, back, free = scratch[DRAG], scratch[AHEAD], scratch[BACK], scratch[RATE]
    correction, sign = scratch[CORRECTION], signs[0]
    solved = walk(
        matrix, drag, ahead, back, free, scratch[PRESENT], sign, correction, signs[1], scratch[RHS], squares[FACTOR]
    )
    for i in range(nv):
        before = (1.0 - implicit) * scratch[v, i]
        damping = step * plant[VISCOUS, i]
        given = 0.0
        if not solved:
            scratch[out, i] = np.nan
        elif sign[i] == 0 and (ahead[i] > 0.0 or back[i] > 0.0):
            scratch[out, i] = 0.0
            given = carried_load(i, matrix, drag, correction)[0] + damping * before
        else:
            scratch[out, i] = free[i] + correction[i]
            level = ahead[i] if sign[i] > 0 else -back[i] if sign[i] < 0 else 0.0
            given = damping * (implicit * scratch[out, i] + before) + level
        if not trial_run:
            scratch[impulse, i] -= given


@short_loops
def _bend(
    plant: Array,
    state: Array,
    scratch: Array,
    squares: Array,
    signs: IntArray,
    v: int,
    step: float,
    out: int,
    impulse: int,
    trial_run: bool,
) -> None:
    """The step with presliding; see `plant.friction.presliding`."""
    nv = plant.shape[1]
    mass, matrix = squares[MASS], squares[MATRIX]
    for i in range(nv):
        scratch[out, i] = scratch[v, i]
        total = step * scratch[FORCE, i]
        for j in range(nv):
            matrix[i, j] = mass[i, j]
            total += mass[i, j] * scratch[v, j]
        matrix[i, i] += step * plant[VISCOUS, i]
        scratch[RHS, i] = total
        bristle = plant[BRISTLE, i]
        scratch[X, i] = step * bristle * state[BEND, i]
        scratch[RATE, i] = step * (step * bristle + plant[BRISTLE_DAMPING, i]) if bristle > 0.0 else 0.0
        scratch[AHEAD, i] *= step
        scratch[BACK, i] *= step
    offset, slope, ahead, back, speed = scratch[X], scratch[RATE], scratch[AHEAD], scratch[BACK], scratch[out]
    solved = walk_pieces(
        matrix, scratch[RHS], offset, slope, ahead, back, speed, signs[0], signs[1],
        scratch[PRESENT], scratch[CORRECTION], scratch[LOW], scratch[HIGH], squares[LOCAL], squares[FACTOR],
    )  # fmt: skip
    for i in range(nv):
        force = 0.0
        if slope[i] > 0.0:
            force = min(max(offset[i] + slope[i] * speed[i], -back[i]), ahead[i]) / step
            if not trial_run:
                state[BEND, i] = (force - plant[BRISTLE_DAMPING, i] * speed[i]) / plant[BRISTLE, i]
        if not trial_run:
            scratch[impulse, i] -= step * (force + plant[VISCOUS, i] * speed[i])
        if not solved:
            speed[i] = np.nan
