"""Compiled local maximisation of a figure of the condition over a box of angles and armatures.

A dense BFGS with projection on the box: some 50 evaluations of a few microseconds each. The general optimiser that was
here before spent more than 90 % of its time outside the figure.
"""

from __future__ import annotations

import numba
import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm.compiled_norms import figure_gradient
from asmc_pin.rigid_body.recursion import Links

_ITERATIONS = 200
_LONGEST_STEP = 0.5  # of one coordinate, rad: a basin is about that wide


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _look(kind: int, links: Links, mbar: Array, z: Array, start: Array, width: Array, gradient: Array) -> float:
    """The figure at z = (q, share of the armature's range), with its gradient by z."""
    n = mbar.size
    armature = np.empty(n)
    for i in range(n):
        armature[i] = start[i] + width[i] * z[n + i]
    value = figure_gradient(kind, links, armature, z[:n], mbar, gradient[:n], gradient[n:])
    for i in range(n):
        gradient[n + i] *= width[i]
    return value


@numba.njit(cache=True, nogil=True, error_model="numpy")
def climb(
    kind: int,
    links: Links,
    mbar: Array,
    z: Array,
    lower: Array,
    upper: Array,
    start: Array,
    width: Array,
    values: Array,
) -> int:
    """Climb from each row of z to a local maximum, in place.

    Args:
        kind: The figure; see `compiled_norms`.
        links: The arm.
        mbar: Diagonal of M̄, shape (n,).
        z: Starts, then maxima: angles and shares (0 to 1) of the armature's range, shape (count, 2n).
        lower: Lower bounds of z, shape (2n,); −∞ for a periodic joint. Equal bounds hold a coordinate.
        upper: The same, above.
        start: Least armature, shape (n,).
        width: Range of the armature, shape (n,).
        values: Receives the figure at each maximum, shape (count,).

    Returns:
        Number of evaluations.
    """
    count, size = z.shape
    evaluations = 0
    inverse = np.empty((size, size))
    gradient, trial_gradient, trial = np.empty(size), np.empty(size), np.empty(size)
    direction, step, change, product = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    held, was_held = np.zeros(size, dtype=np.bool_), np.zeros(size, dtype=np.bool_)
    for row in range(count):
        x = z[row]
        value = _look(kind, links, mbar, x, start, width, gradient)
        evaluations += 1
        fresh = True
        was_held[:] = False
        for _ in range(_ITERATIONS):
            changed = False
            for i in range(size):
                held[i] = (x[i] <= lower[i] and gradient[i] <= 0.0) or (x[i] >= upper[i] and gradient[i] >= 0.0)
                changed = changed or held[i] != was_held[i]
                was_held[i] = held[i]
            if changed or fresh:
                # A different face of the box: what was learnt of the curvature mixes with coordinates now held.
                inverse[:, :] = 0.0
                for i in range(size):
                    inverse[i, i] = 1.0
                fresh = True
            slope, longest, steepest = 0.0, 0.0, 0.0
            for i in range(size):
                total = 0.0
                if not held[i]:
                    for j in range(size):
                        if not held[j]:
                            total += inverse[i, j] * gradient[j]
                    slope += total * gradient[i]
                    steepest = max(steepest, abs(gradient[i]))
                direction[i] = total
                longest = max(longest, abs(total))
            if steepest <= 1e-14 * abs(value) or longest == 0.0:
                break
            reach = 0.1 / longest if fresh else min(1.0, _LONGEST_STEP / longest)
            gained = False
            for _ in range(40):
                moved = 0.0
                for i in range(size):
                    trial[i] = min(max(x[i] + reach * direction[i], lower[i]), upper[i])
                    moved = max(moved, abs(trial[i] - x[i]))
                if moved == 0.0:
                    break
                trial_value = _look(kind, links, mbar, trial, start, width, trial_gradient)
                evaluations += 1
                expected = 0.0
                for i in range(size):
                    expected += gradient[i] * (trial[i] - x[i])
                if trial_value > value and trial_value >= value + 1e-4 * expected:
                    gained = True
                    break
                reach *= 0.4
            if not gained:
                if fresh:
                    break
                fresh = True
                continue
            curvature, size_y, size_s = 0.0, 0.0, 0.0
            for i in range(size):
                step[i] = trial[i] - x[i]
                # Minimising −f: the change of its gradient.
                change[i] = gradient[i] - trial_gradient[i]
                curvature += step[i] * change[i]
                size_y += change[i] * change[i]
                size_s += step[i] * step[i]
                x[i] = trial[i]
                gradient[i] = trial_gradient[i]
            gain = trial_value - value
            value = trial_value
            if gain <= 1e-15 * abs(value):
                break
            if curvature > 1e-12 * np.sqrt(size_y) * np.sqrt(size_s):
                if fresh:
                    for i in range(size):
                        inverse[i, i] = curvature / size_y
                fresh = False
                total = 0.0
                for i in range(size):
                    product[i] = 0.0
                    for j in range(size):
                        product[i] += inverse[i, j] * change[j]
                    total += product[i] * change[i]
                weight = (1.0 + total / curvature) / curvature
                for i in range(size):
                    for j in range(size):
                        inverse[i, j] += (
                            weight * step[i] * step[j] - (product[i] * step[j] + step[i] * product[j]) / curvature
                        )
            else:
                fresh = True
        values[row] = value
    return evaluations
