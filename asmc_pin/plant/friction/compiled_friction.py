"""Set-valued joint friction over one time step, solved exactly per trial.

Time-stepping friction (Moreau) asks for the joint velocity v⁺ at the end of a step of length h with

    M (v⁺ − v_free) + h B v⁺ + h f = 0,    fᵢ ∈ cᵢ Sgn(v⁺ᵢ),    Sgn(0) = [−1, 1],

where v_free is the velocity without friction, B the viscous coefficients and c the levels (one per direction of motion;
with a Stribeck curve those of the velocity at the start of the step). These are the optimality conditions of the
strictly convex problem

    min over v⁺ of  ½ v⁺ᵀ(M + hB)v⁺ − (M v_free)ᵀv⁺ + h Σ cᵢ|v⁺ᵢ|,

so v⁺ exists and is unique, and a joint that sticks has v⁺ = 0 exactly: no creep and no chatter at any h.

The solver walks over faces (which joints slide, and which way), as Lawson and Hanson's NNLS does: from face to face the
objective falls strictly, so the walk ends; started on the face of the present velocity it mostly ends on the first one.
It works with the correction d = v⁺ − v_free, whose round-off is relative to what friction does and not to the speed.
With A = M + hB:

    A d = −h B v_free − h f,    d_stuck = −v_free,stuck,    load that a sticking joint carries  h f = −A d − h B v_free.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.numerics.cholesky import solve_face

# A sticking joint is let go when its load exceeds the level by more than this part of the terms that the load is summed
# from. Anything less is round-off; letting go then would only make the walk revisit a face.
RELEASE_TOLERANCE = 1e-13
# Faces visited per joint before the walk is given up and the trial made NaN. It does not happen with a positive
# definite M.
FACES_PER_JOINT = 20


@njit(cache=True, nogil=True, inline="always")
def _sticks(forward: Array, backward: Array, sign: IntArray, i: int) -> bool:
    """Whether joint i sticks; one without Coulomb friction has the sign 0 too, but no kink to stick in."""
    return bool(sign[i] == 0 and (forward[i] > 0.0 or backward[i] > 0.0))


@njit(cache=True, nogil=True, inline="always")
def carried_load(i: int, matrix: Array, drag: Array, correction: Array) -> tuple[float, float]:
    """Friction impulse h·fᵢ that balances sticking joint i, and the sum of the magnitudes of its terms."""
    load = -drag[i]
    magnitude = abs(load)
    for j in range(drag.size):
        term = matrix[i, j] * correction[j]
        load -= term
        magnitude += abs(term)
    return load, magnitude


@njit(cache=True, nogil=True, inline="always")
def _set_up_face(
    matrix: Array,
    drag: Array,
    forward: Array,
    backward: Array,
    free: Array,
    sign: IntArray,
    face: IntArray,
    rhs: Array,
    correction: Array,
) -> int:
    """Write which joints move on the face `sign`, the right-hand side of their d, and d of the others.

    Returns:
        How many joints move.
    """
    count = 0
    for i in range(free.size):
        if _sticks(forward, backward, sign, i):
            correction[i] = -free[i]
        else:
            face[count] = i
            count += 1
    for k in range(count):
        i = face[k]
        total = -drag[i]
        if sign[i] != 0:
            total -= forward[i] if sign[i] > 0 else -backward[i]
        for j in range(free.size):
            if _sticks(forward, backward, sign, j):
                total += matrix[i, j] * free[j]
        rhs[i] = total
    return count


@njit(cache=True, nogil=True, inline="always")
def _go(face: IntArray, count: int, free: Array, correction: Array, sign: IntArray, present: Array) -> int:
    """Move `present` towards the face's minimiser, no further than where the first joint would turn round: it sticks.

    Returns:
        That joint; −1 if the minimiser was reached, −2 if it is not finite.
    """
    fraction = 1.0
    blocker = -1
    for k in range(count):
        i = face[k]
        target = free[i] + correction[i]
        if not np.isfinite(target):
            return -2
        if sign[i] != 0 and target * sign[i] <= 0.0:
            reach = 0.0 if present[i] == 0.0 else present[i] / (present[i] - target)
            if blocker < 0 or reach < fraction:
                fraction = reach
                blocker = i
    for k in range(count):
        i = face[k]
        present[i] += fraction * (free[i] + correction[i] - present[i])
    if blocker >= 0:
        present[blocker] = 0.0
        sign[blocker] = 0
    return blocker


@njit(cache=True, nogil=True, inline="always")
def _let_go(
    matrix: Array,
    drag: Array,
    forward: Array,
    backward: Array,
    free: Array,
    correction: Array,
    sign: IntArray,
) -> bool:
    """Let the sticking joint that is overloaded by most slide, and say whether there is one."""
    worst = 0.0
    release = -1
    toward = 0
    for i in range(free.size):
        if _sticks(forward, backward, sign, i):
            load, magnitude = carried_load(i, matrix, drag, correction)
            excess = load - forward[i] if load > 0.0 else -load - backward[i]
            if excess > worst and excess > RELEASE_TOLERANCE * magnitude:
                worst = excess
                release = i
                toward = 1 if load > 0.0 else -1
    if release >= 0:
        sign[release] = toward
    return release >= 0


@njit(cache=True, nogil=True)
def walk(
    matrix: Array,
    drag: Array,
    forward: Array,
    backward: Array,
    free: Array,
    present: Array,
    sign: IntArray,
    correction: Array,
    face: IntArray,
    rhs: Array,
    factor: Array,
) -> bool:
    """Walk to the optimal face from that of `present`; leave the solution in `sign` and `correction`.

    `face`, `rhs` and `factor`, (nv,), (nv,) and (nv, nv), are to work in.

    `drag` is the impulse of viscous friction at v_free, `forward` and `backward` are h·c of motion forwards and
    backwards. A joint without Coulomb friction has sign 0 too, but no kink to stick in.
    """
    nv = free.size
    for i in range(nv):
        sign[i] = int(np.sign(present[i])) if forward[i] > 0.0 or backward[i] > 0.0 else 0
    for _ in range(FACES_PER_JOINT * nv + 1):
        count = _set_up_face(matrix, drag, forward, backward, free, sign, face, rhs, correction)
        solve_face(matrix, rhs, face, count, factor, correction)
        blocker = _go(face, count, free, correction, sign, present)
        if blocker == -2:
            return False
        if blocker == -1 and not _let_go(matrix, drag, forward, backward, free, correction, sign):
            return True
    return False


@njit(cache=True, nogil=True)
def slide_or_stick(
    mass: Array,
    velocity: Array,
    acceleration: Array,
    forward: Array,
    backward: Array,
    viscous: Array,
    step: float,
    active: BoolArray,
    next_velocity: Array,
    impulse: Array,
    implicit: float = 1.0,
) -> None:
    """Velocity after one step under Coulomb and viscous friction, for a batch of trials.

    Args:
        mass: Joint-space inertia, armature included. Shape (batch, nv, nv), kg·m².
        velocity: Velocity at the start of the step. Shape (batch, nv), rad/s.
        acceleration: What the arm would do without friction. Shape (batch, nv), rad/s².
        forward: Coulomb level against motion forwards, breakaway included; not negative. Shape (batch, nv), N·m.
        backward: The same against motion backwards.
        viscous: Viscous coefficient, not negative. Shape (batch, nv), N·m·s/rad.
        step: Length of the step, s.
        active: Trials to step; the others are left as they are. Shape (batch,).
        next_velocity: Written: velocity after the step, exactly 0.0 where a joint sticks, NaN in a trial that has no
            solution (a mass matrix that is not positive definite, or values that are not finite). Shape (batch, nv),
            rad/s.
        impulse: Added to: impulse of friction on the joint, so negative where it slides forwards. Shape (batch, nv),
            N·m·s.
        implicit: Share of v⁺ in the velocity that viscous friction acts at, the rest is v: 1 as in the equations above,
            1/2 for the trapezoidal rule.
    """
    batch, nv = velocity.shape
    matrix = np.empty((nv, nv))
    damping = np.empty(nv)
    drag = np.empty(nv)
    ahead = np.empty(nv)
    back = np.empty(nv)
    free = np.empty(nv)
    present = np.empty(nv)
    correction = np.empty(nv)
    sign, face, rhs, factor = np.empty(nv, np.int64), np.empty(nv, np.int64), np.empty(nv), np.empty((nv, nv))
    for trial in range(batch):
        if not active[trial]:
            continue
        for i in range(nv):
            present[i] = velocity[trial, i]
            free[i] = present[i] + step * acceleration[trial, i]
            damping[i] = step * viscous[trial, i]
            drag[i] = damping[i] * (implicit * free[i] + (1.0 - implicit) * present[i])
            ahead[i] = step * forward[trial, i]
            back[i] = step * backward[trial, i]
            for j in range(nv):
                matrix[i, j] = mass[trial, i, j]
            matrix[i, i] += implicit * damping[i]
        solved = walk(matrix, drag, ahead, back, free, present, sign, correction, face, rhs, factor)
        for i in range(nv):
            speed = free[i] + correction[i]
            before = (1.0 - implicit) * velocity[trial, i]
            if not solved:
                next_velocity[trial, i] = np.nan
            elif sign[i] == 0 and (ahead[i] > 0.0 or back[i] > 0.0):
                next_velocity[trial, i] = 0.0
                impulse[trial, i] -= carried_load(i, matrix, drag, correction)[0] + damping[i] * before
            else:
                next_velocity[trial, i] = speed
                impulse[trial, i] -= damping[i] * (implicit * speed + before) + (
                    ahead[i] if sign[i] > 0 else -back[i] if sign[i] < 0 else 0.0
                )


@njit(cache=True, nogil=True)
def stribeck_level(velocity: float, coulomb: float, breakaway: float, scale: float) -> float:
    """Friction's level at a velocity: coulomb + (breakaway − coulomb)·exp(−(v/scale)²); at rest exactly breakaway."""
    x = velocity / scale
    return coulomb + (breakaway - coulomb) * float(np.exp(-x * x))


@njit(cache=True, nogil=True)
def stribeck_levels(velocity: Array, coulomb: Array, breakaway: Array, scale: Array, level: Array) -> None:
    """`stribeck_level` for a batch.

    Args:
        velocity: Shape (batch, nv), rad/s.
        coulomb: Level of fast motion, (batch, nv), N·m.
        breakaway: Level at rest, (batch, nv), N·m.
        scale: Stribeck velocity, (batch, nv), rad/s.
        level: Written, (batch, nv), N·m.
    """
    for trial in range(velocity.shape[0]):
        for i in range(velocity.shape[1]):
            level[trial, i] = stribeck_level(
                velocity[trial, i], coulomb[trial, i], breakaway[trial, i], scale[trial, i]
            )
