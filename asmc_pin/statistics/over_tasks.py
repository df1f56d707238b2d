"""Figures of solvers over many tasks: performance profiles, and means that no single task rules."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError


def performance_ratios(figures: Array) -> Array:
    """How many times the best solver's figure each one's is, task by task.

    Dolan, Moré (2002), Benchmarking Optimization Software with Performance Profiles, Math. Program. 91, eq. (1).

    Args:
        figures: Shape (solvers, tasks), positive; +∞ for a failure.

    Returns:
        Shape (solvers, tasks), 1 or more; +∞ for a failure, also where all fail.

    Raises:
        ParameterError: a figure is NaN, 0 or negative.
    """
    figures = np.asarray(figures, dtype=np.float64)
    if not (figures > 0.0).all():
        raise ParameterError("figures", "have one that is not positive; a failure is +∞")
    best = np.min(figures, axis=0)
    return np.asarray(np.divide(figures, best, out=np.full(figures.shape, np.inf), where=np.isfinite(figures)))


def performance_profile(figures: Array, factors: Array) -> Array:
    """Share of the tasks that each solver does within a factor of the best one: ρ_s(τ) of Dolan and Moré (2002).

    Args:
        figures: Shape (solvers, tasks), positive; +∞ for a failure, which no factor reaches.
        factors: τ, shape (m,), 1 or more.

    Returns:
        Shape (solvers, m), 0 to 1.
    """
    ratios = performance_ratios(figures)
    # Rounding of a quotient of equal figures must not cost a task at τ = 1.
    within = ratios[:, :, None] <= np.asarray(factors, dtype=np.float64) * (1.0 + 1e-12)
    return np.asarray(np.mean(within, axis=1))


def shifted_geometric_mean(figures: Array, shift: float) -> Array:
    """(Π (x + s))^(1/n) − s over the last axis: the ratio counts where figures are large, the difference where small.

    Achterberg (2007), Constraint Integer Programming, TU Berlin, appendix A.3. The shift has the figures' unit, and is
    about where a difference stops to matter; 0 gives the geometric mean.

    Args:
        figures: Shape (…, n), 0 or more; +∞ for a failure, and the mean is +∞ then.
        shift: s, 0 or more.

    Raises:
        ParameterError: a figure is NaN or negative, or the shift is.
    """
    figures = np.asarray(figures, dtype=np.float64)
    if not (figures >= 0.0).all():
        raise ParameterError("figures", "have one that is negative or no number; a failure is +∞")
    if not (np.isfinite(shift) and shift >= 0.0):
        raise ParameterError("shift", f"{shift} given; expected 0 or more, in the figures' unit")
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(np.mean(np.log(figures + shift), axis=-1)) - shift)
