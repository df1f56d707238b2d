"""Curves with more points than a figure can show."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array

POINTS = 1500
"""How many lows and highs the width of a figure can show."""


def thinned(time: Array, values: Array, points: int = POINTS) -> tuple[Array, Array]:
    """The same curve to the eye, chatter included: of every few samples the lowest and the highest, in their order.

    Args:
        time: Shape (T,).
        values: Shape (T,); NaN leaves a gap.
        points: Number of groups; a curve of up to twice as many samples is returned as it is.

    Returns:
        Times and values.
    """
    if values.size <= 2 * points:
        return time, values
    size = -(-values.size // points)
    padded = np.full(-(-values.size // size) * size, np.nan)
    padded[: values.size] = values
    groups = padded.reshape(-1, size)
    low = np.argmin(np.where(np.isnan(groups), np.inf, groups), axis=1)
    high = np.argmax(np.where(np.isnan(groups), -np.inf, groups), axis=1)
    picked = np.sort(np.stack([low, high], axis=1), axis=1) + size * np.arange(len(groups))[:, None]
    picked = np.minimum(picked.ravel(), values.size - 1)
    return time[picked], values[picked]


def running_max(time: Array, values: Array, windows: int = 150) -> tuple[Array, Array]:
    """Largest value in each of some windows: how a size that keeps crossing zero goes on a logarithmic axis.

    Args:
        time: Shape (T,).
        values: Shape (T,), not negative; NaN counts as nothing.
        windows: Their number.

    Returns:
        Middle of each window, and the largest value in it; NaN where there is none.
    """
    edges = np.unique(np.linspace(0, values.size, windows + 1).astype(int))
    middle = 0.5 * (time[edges[:-1]] + time[edges[1:] - 1])
    return middle, np.asarray(np.fmax.reduceat(values, edges[:-1]))


def envelope(time: Array, low: Array, high: Array, windows: int = 600) -> tuple[Array, Array, Array]:
    """The lowest of the lower and the highest of the upper ends of a band in each of some windows.

    Args:
        time: Shape (T,).
        low: Lower end, shape (T,); NaN where there is none.
        high: Upper end.
        windows: Their number; a band of fewer points is returned as it is.

    Returns:
        Middle of each window, and both ends; NaN where there is none in all of it.
    """
    if time.size <= windows:
        return time, low, high
    edges = np.unique(np.linspace(0, time.size, windows + 1).astype(int))
    middle = 0.5 * (time[edges[:-1]] + time[edges[1:] - 1])
    return middle, np.fmin.reduceat(low, edges[:-1]), np.fmax.reduceat(high, edges[:-1])


def spread(error: Array) -> float:
    """How many times the RMS of one controller's error is that of another, on the joint where they differ most.

    Args:
        error: Shape (controller, T, joint); a controller with NaN does not count.
    """
    size = np.sqrt(np.mean(error**2, axis=1))
    size = size[np.isfinite(size).all(axis=1)]
    if len(size) < 2:
        return 1.0
    return float(np.max(size.max(axis=0) / np.maximum(size.min(axis=0), 1e-12)))
