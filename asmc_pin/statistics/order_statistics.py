"""Medians and quantiles in which a failure counts as worse than any figure, and is never dropped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, BoolArray

LOW, HIGH = 0.05, 0.95
"""The quantiles between which nine of ten trials lie."""


@dataclass(frozen=True, eq=False)
class Quantiles:
    """Median and quantiles of figures over trials; infinite where failures reach, NaN where the figure is undefined.

    Attributes:
        median: The middle figure.
        low: The 5 % quantile.
        high: The 95 % quantile.
    """

    median: Array
    low: Array
    high: Array


def with_failures(figures: Array, failed: BoolArray) -> Array:
    """Figures in which failures are +∞, and what has no meaning in any trial stays NaN.

    Dropping failures would flatter the law that fails most. A figure that is not a number in a trial that did not fail
    is one that was not reached in it, such as a settling time, as long as another trial has one: +∞ too. A figure that
    a failure has all the same, such as the time at which a robot would have stopped, stays.

    Args:
        figures: Shape (trials, …); NaN where undefined.
        failed: Whether a trial failed, shape (trials,).
    """
    defined = np.ones(figures.shape[1:], dtype=bool) if failed.all() else np.isfinite(figures).any(axis=0)
    return np.where(np.isnan(figures), np.where(defined, np.inf, np.nan), figures)


def quantile(figures: Array, share: float) -> Array:
    """Quantile over the first axis, between neighbours in proportion; +∞ as soon as a share of a failure is in it.

    Definition 7 of Hyndman and Fan (1996), The American Statistician 50(4), as `numpy.quantile` has it, which gives NaN
    next to an infinite value.

    Args:
        figures: Shape (trials, …), without NaN or NaN throughout; +∞ for a failure.
        share: 0 to 1.
    """
    ordered = np.sort(figures, axis=0)
    place = share * (len(ordered) - 1)
    below = int(np.floor(place + 1e-12))
    part = max(place - below, 0.0)
    if part < 1e-12:
        return np.asarray(ordered[below])
    low, high = ordered[below], ordered[below + 1]
    with np.errstate(invalid="ignore"):
        between = low + part * (high - low)
    return np.asarray(np.where(low == high, low, between))


def spread_of(figures: Array) -> Quantiles:
    """Median, 5 % and 95 % over the first axis; see `quantile`."""
    return Quantiles(quantile(figures, 0.5), quantile(figures, LOW), quantile(figures, HIGH))
