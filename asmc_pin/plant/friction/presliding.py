"""Friction that gives way before it breaks loose, over one time step.

Each joint has a spring of stiffness σ and damping d in series with its Coulomb (Stribeck) element: the asperities of
the surfaces bend by z before they slip. Implicit in the velocity at the end of a step of length h,

    M (v⁺ − v_free) + h B v⁺ + h f = 0,    fᵢ = clip(σᵢ zᵢ + κᵢ v⁺ᵢ, −c_backward, c_forward),    κ = σ h + d,

and z follows what was transmitted, σ z⁺ + d v⁺ = f. A joint under a constant load comes to rest at z = load/σ and
stays: nothing creeps (single Maxwell-slip element, or the elasto-plastic model with z_ba = z_ss; P. Dupont et al.,
"Single state elastoplastic friction models", IEEE Trans. Automatic Control 47(5), 2002; Dahl's and LuGre's models drift
there).

These are the optimality conditions of a strictly convex, continuously differentiable, piecewise quadratic problem. The
solver walks from piece to piece as `compiled_friction` does: towards the minimiser of the present piece, and no further
than where the first joint leaves it.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.numerics.cholesky import solve_face
from asmc_pin.plant.friction.compiled_friction import FACES_PER_JOINT


@njit(cache=True, nogil=True, inline="always")
def _piece(speed: float, low: float, high: float) -> int:
    return 1 if speed > high else -1 if speed < low else 0


@njit(cache=True, nogil=True)
def walk_pieces(
    matrix: Array,
    rhs: Array,
    bend: Array,
    slope: Array,
    forward: Array,
    backward: Array,
    speed: Array,
    piece: IntArray,
    face: IntArray,
    target: Array,
    right: Array,
    low: Array,
    high: Array,
    local: Array,
    factor: Array,
) -> bool:
    """Solve matrix·v + clip(bend + slope·v, −backward, forward) = rhs; start from and leave the solution in `speed`.

    A slope of 0 stands for a joint without friction. What comes after `piece` is to work in: arrays of shape (n,), and
    two of shape (n, n).
    """
    n = speed.size
    for i in range(n):
        face[i], low[i], high[i] = i, -np.inf, np.inf
        if slope[i] > 0.0:
            low[i], high[i] = (-backward[i] - bend[i]) / slope[i], (forward[i] - bend[i]) / slope[i]
        piece[i] = _piece(speed[i], low[i], high[i])
    for _ in range(FACES_PER_JOINT * n + 1):
        for i in range(n):
            right[i] = rhs[i]
            for j in range(n):
                local[i, j] = matrix[i, j]
            if piece[i] == 0:
                local[i, i] += slope[i]
                right[i] -= bend[i]
            else:
                right[i] -= forward[i] if piece[i] > 0 else -backward[i]
        solve_face(local, right, face, n, factor, target)
        leaving, fraction = -1, 1.0
        for i in range(n):
            if not np.isfinite(target[i]):
                return False
            if _piece(target[i], low[i], high[i]) != piece[i]:
                upwards = target[i] > speed[i]
                edge = (high[i] if piece[i] == 0 else low[i]) if upwards else (low[i] if piece[i] == 0 else high[i])
                way = target[i] - speed[i]
                reach = min(max((edge - speed[i]) / way, 0.0), 1.0) if way != 0.0 else 0.0
                if leaving < 0 or reach < fraction:
                    leaving, fraction = i, reach
        if leaving < 0:
            for i in range(n):
                speed[i] = target[i]
            return True
        upwards = target[leaving] > speed[leaving]
        for i in range(n):
            speed[i] += fraction * (target[i] - speed[i])
        piece[leaving] += 1 if upwards else -1
    return False


@njit(cache=True, nogil=True)
def slide_or_bend(
    mass: Array,
    velocity: Array,
    acceleration: Array,
    forward: Array,
    backward: Array,
    viscous: Array,
    stiffness: Array,
    damping: Array,
    bend: Array,
    step: float,
    active: BoolArray,
    next_velocity: Array,
    impulse: Array,
    next_bend: Array,
) -> None:
    """Velocity after one step under friction with presliding, for a batch; arguments as of `slide_or_stick`.

    Args:
        mass: Shape (batch, nv, nv), kg·m².
        velocity: Shape (batch, nv), rad/s.
        acceleration: Without friction, (batch, nv), rad/s².
        forward: Level against motion forwards, (batch, nv), N·m.
        backward: Level against motion backwards.
        viscous: Shape (batch, nv), N·m·s/rad.
        stiffness: σ, (batch, nv), N·m/rad; 0 in a joint without Coulomb friction.
        damping: d, (batch, nv), N·m·s/rad.
        bend: z at the start of the step, (batch, nv), rad.
        step: s.
        active: Trials to step, (batch,).
        next_velocity: Written, (batch, nv), rad/s; NaN where there is no solution.
        impulse: Added to, (batch, nv), N·m·s.
        next_bend: Written: z after the step, (batch, nv), rad.
    """
    batch, nv = velocity.shape
    matrix = np.empty((nv, nv))
    rhs, offset, slope = np.empty(nv), np.empty(nv), np.empty(nv)
    ahead, back, speed = np.empty(nv), np.empty(nv), np.empty(nv)
    piece, face = np.empty(nv, np.int64), np.empty(nv, np.int64)
    target, right, low, high = np.empty(nv), np.empty(nv), np.empty(nv), np.empty(nv)
    local, factor = np.empty((nv, nv)), np.empty((nv, nv))
    for trial in range(batch):
        if not active[trial]:
            continue
        for i in range(nv):
            speed[i] = velocity[trial, i]
            rhs[i] = 0.0
            for j in range(nv):
                matrix[i, j] = mass[trial, i, j]
                rhs[i] += mass[trial, i, j] * (velocity[trial, j] + step * acceleration[trial, j])
            matrix[i, i] += step * viscous[trial, i]
            offset[i] = step * stiffness[trial, i] * bend[trial, i]
            slope[i] = step * (step * stiffness[trial, i] + damping[trial, i]) if stiffness[trial, i] > 0.0 else 0.0
            ahead[i], back[i] = step * forward[trial, i], step * backward[trial, i]
        solved = walk_pieces(
            matrix, rhs, offset, slope, ahead, back, speed, piece, face, target, right, low, high, local, factor
        )
        for i in range(nv):
            next_velocity[trial, i] = speed[i] if solved else np.nan
            if slope[i] > 0.0:
                force = min(max(offset[i] + slope[i] * speed[i], -back[i]), ahead[i]) / step
                next_bend[trial, i] = (force - damping[trial, i] * speed[i]) / stiffness[trial, i]
            else:
                force = 0.0
            impulse[trial, i] -= step * (force + viscous[trial, i] * speed[i])
