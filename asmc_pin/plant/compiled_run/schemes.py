"""The integrators for one trial, compiled; what each is and claims is said in `asmc_pin.plant.integrators`.

A step carries the rows `AT_Q`, `AT_V` of scratch to `NEXT_Q`, `NEXT_V` under the torque in row `PUSH`, and adds
friction's impulse to row `IMPULSE`.
"""

from __future__ import annotations

from asmc_pin._typing import Array, IntArray
from asmc_pin.numerics.cholesky import solve_shifted
from asmc_pin.numerics.short_loops import inlined, short_loops
from asmc_pin.plant.compiled_run.friction_step import after_step, fill_levels
from asmc_pin.plant.compiled_run.run_rows import (
    AHEAD,
    AT_Q,
    AT_V,
    BACK,
    BIAS,
    EARLY,
    FACTOR,
    FORCE,
    IMPULSE,
    MASS,
    MIDDLE,
    MIDPOINT,
    NEXT_Q,
    NEXT_V,
    OTHER_IMPULSE,
    PUSH,
    SEMI_IMPLICIT,
    SHIFT,
    STOP_DAMPING,
    STOP_LOWER,
    STOP_STIFFNESS,
    STOP_UPPER,
    SUM_Q,
    SUM_V,
    VISCOUS,
    Setup,
    X,
)
from asmc_pin.plant.world.end_stops import stop_torque
from asmc_pin.rigid_body.dynamics import fill_dynamics


@inlined
def _fill_forces(
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    plant: Array,
    scratch: Array,
    room: Array,
    squares: Array,
    q: int,
    v: int,
) -> None:
    """M at the angles in row q, and what drives the joints there at the velocities in row v, without friction."""
    fill_dynamics(parent, body, gravity, scratch[q], scratch[v], room, squares[MASS], scratch[BIAS])
    for i in range(plant.shape[1]):
        push = scratch[PUSH, i]
        if setup.stops:
            push += stop_torque(
                scratch[q, i],
                scratch[v, i],
                plant[STOP_LOWER, i],
                plant[STOP_UPPER, i],
                plant[STOP_STIFFNESS, i],
                plant[STOP_DAMPING, i],
            )
        scratch[FORCE, i] = push - scratch[BIAS, i]


@short_loops
def integrate(
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    plant: Array,
    state: Array,
    scratch: Array,
    room: Array,
    squares: Array,
    signs: IntArray,
) -> None:
    """One step of the plant's scheme."""
    nv = plant.shape[1]
    step = setup.step
    half = 0.5 * step
    if setup.scheme != SEMI_IMPLICIT and setup.scheme != MIDPOINT:
        smooth = _runge_kutta(setup, parent, body, gravity, plant, scratch, room, squares)
        if smooth:
            return
    for i in range(nv):
        scratch[MIDDLE, i] = scratch[AT_Q, i] + half * scratch[AT_V, i]
    _fill_forces(setup, parent, body, gravity, plant, scratch, room, squares, MIDDLE, AT_V)
    if setup.scheme == SEMI_IMPLICIT:
        after_step(
            setup, plant, state, scratch, squares, signs,
            AT_V, AT_V, step, 1.0, NEXT_V, IMPULSE, False,
        )  # fmt: skip
        for i in range(nv):
            scratch[NEXT_Q, i] = scratch[MIDDLE, i] + half * scratch[NEXT_V, i]
        return
    after_step(
        setup, plant, state, scratch, squares, signs, AT_V, AT_V, half, 1.0, EARLY, IMPULSE, True
    )  # fmt: skip
    _fill_forces(setup, parent, body, gravity, plant, scratch, room, squares, MIDDLE, EARLY)
    after_step(
        setup, plant, state, scratch, squares, signs, AT_V, EARLY, step, 0.5, NEXT_V, IMPULSE, False
    )  # fmt: skip
    for i in range(nv):
        scratch[NEXT_Q, i] = scratch[AT_Q, i] + half * (scratch[AT_V, i] + scratch[NEXT_V, i])


@short_loops
def _runge_kutta(
    setup: Setup,
    parent: IntArray,
    body: Array,
    gravity: Array,
    plant: Array,
    scratch: Array,
    room: Array,
    squares: Array,
) -> bool:
    """The classical scheme; False, with nothing changed, where a joint with Coulomb friction does not slide on."""
    nv = plant.shape[1]
    step = setup.step
    smooth = True
    for i in range(nv):
        scratch[NEXT_Q, i], scratch[NEXT_V, i] = scratch[AT_Q, i], scratch[AT_V, i]
        scratch[SUM_Q, i], scratch[SUM_V, i], scratch[OTHER_IMPULSE, i], scratch[SHIFT, i] = 0.0, 0.0, 0.0, 0.0
    for stage in range(4):
        weight = 2.0 if 0 < stage < 3 else 1.0
        span = 0.5 * step if stage < 2 else step if stage == 2 else 0.0
        _fill_forces(setup, parent, body, gravity, plant, scratch, room, squares, NEXT_Q, NEXT_V)
        if setup.friction:
            fill_levels(setup, plant, scratch, NEXT_V)
            for i in range(nv):
                v = scratch[NEXT_V, i]
                given = (-scratch[AHEAD, i] if v > 0.0 else scratch[BACK, i] if v < 0.0 else 0.0) - plant[
                    VISCOUS, i
                ] * v
                scratch[FORCE, i] += given
                scratch[OTHER_IMPULSE, i] += weight * step / 6.0 * given
                smooth = smooth and _slides_alike(scratch, i)
        solve_shifted(squares[MASS], scratch, SHIFT, FORCE, X, squares[FACTOR])
        for i in range(nv):
            scratch[SUM_Q, i] += weight * scratch[NEXT_V, i]
            scratch[SUM_V, i] += weight * scratch[X, i]
            scratch[NEXT_Q, i] = scratch[AT_Q, i] + span * scratch[NEXT_V, i]
            scratch[NEXT_V, i] = scratch[AT_V, i] + span * scratch[X, i]
    for i in range(nv):
        scratch[NEXT_V, i] = scratch[AT_V, i] + step / 6.0 * scratch[SUM_V, i]
        scratch[NEXT_Q, i] = scratch[AT_Q, i] + step / 6.0 * scratch[SUM_Q, i]
        smooth = smooth and (not setup.friction or _slides_alike(scratch, i))
    if smooth:
        for i in range(nv):
            scratch[IMPULSE, i] += scratch[OTHER_IMPULSE, i]
    return smooth


@short_loops
def _slides_alike(scratch: Array, i: int) -> bool:
    """Whether joint i, if it has Coulomb friction, moves the same way in the row `NEXT_V` as in `AT_V`."""
    kinked = scratch[AHEAD, i] > 0.0 or scratch[BACK, i] > 0.0
    return not kinked or scratch[NEXT_V, i] * scratch[AT_V, i] > 0.0
