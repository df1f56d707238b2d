"""A log at equal steps, and filters that shift nothing in time."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_smoothing_spline
from scipy.signal import butter, sosfiltfilt

from asmc_pin._typing import Array

ORDER = 4
"""Of the Butterworth filter; run both ways, so of eight in all, and without delay."""


def at_equal_steps(time: Array, values: Array, step: float) -> tuple[Array, Array]:
    """Values at multiples of a step, by straight lines between the rows.

    Args:
        time: Increasing, shape (T,), s.
        values: Shape (T, n).
        step: s.

    Returns:
        Times, shape (N,), and values, shape (N, n).
    """
    grid = np.arange(int(np.floor((time[-1] - time[0]) / step + 1e-9)) + 1) * step + time[0]
    return grid, np.column_stack([np.interp(grid, time, column) for column in values.T])


def low_passed(values: Array, step: float, cutoff: float) -> Array:
    """Values through a Butterworth filter of order 4, forwards and backwards: no delay, −6 dB at the cutoff.

    Args:
        values: At equal steps along the first axis.
        step: s.
        cutoff: Hz; at 0.45 of the sampling rate and beyond nothing is done.
    """
    if cutoff * step >= 0.45 or len(values) < 4:
        return values
    sections = butter(ORDER, cutoff, fs=1.0 / step, output="sos")
    length = min(len(values) - 1, int(3.0 / (cutoff * step)))
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=length))


def differentiated(time: Array, values: Array) -> tuple[Array, Array]:
    """First and second derivatives of smooth columns, by a cubic spline through them."""
    curve = CubicSpline(time, values)
    return np.asarray(curve(time, 1)), np.asarray(curve(time, 2))


def white_noise(time: Array, values: Array) -> Array:
    """Standard deviation of what is white in each column: of third differences, at rows about one median step apart.

    A smooth motion leaves almost nothing in third differences, white noise twenty times its variance; the rounding of a
    moving encoder is nearly white.

    Args:
        time: Shape (T,), s.
        values: Shape (T, n).

    Returns:
        Shape (n,).
    """
    gaps = np.diff(time)
    even = np.abs(gaps - np.median(gaps)) < 0.3 * np.median(gaps)
    rows = np.flatnonzero(even[:-2] & even[1:-1] & even[2:])
    if rows.size < 8:
        rows = np.arange(len(gaps) - 2)
    third = values[rows + 3] - 3.0 * values[rows + 2] + 3.0 * values[rows + 1] - values[rows]
    return np.asarray(np.sqrt(np.mean(third**2, axis=0) / 20.0))


def smoothing_curve(time: Array, values: Array, deviation: float) -> BSpline:
    """A cubic smoothing spline whose distance from the values has a given RMS: what rounding or noise left.

    Of all curves with that distance it has the least integral of its squared second derivative.

    Args:
        time: Shape (T,), s.
        values: One column, shape (T,).
        deviation: RMS of values − spline to aim at, never exceeded; 0 puts the spline through all of them.

    Returns:
        The spline.
    """
    if deviation <= 0.0:
        return make_smoothing_spline(time, values, lam=0.0)
    low, high = 1e-16, 1e2
    kept: BSpline | None = None
    while kept is None or high / low > 2.0:
        middle = float(np.sqrt(low * high))
        tried = make_smoothing_spline(time, values, lam=middle)
        if float(np.sqrt(np.mean((tried(time) - values) ** 2))) < deviation:
            low, kept = middle, tried
        else:
            high = middle
        if high < 1e-15:  # the rows are not that smooth
            return make_smoothing_spline(time, values, lam=0.0)
    return kept
