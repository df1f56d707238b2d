"""Ratios of two laws' figures in the same trials, with a bootstrap interval.

Trials are paired: with common random numbers both laws meet the same start, noise and scatter in trial i, so what the
draw alone does to both cancels in the ratio (Law, Simulation Modeling and Analysis, 5th ed., sec. 11.2). Ratios are
taken as logarithms, so that halving an error and doubling it weigh the same, and no unit is needed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError

RESAMPLES = 2999
LEVEL = 0.95
LARGEST_JACKKNIFE = 5000
"""Size of a sample above which an interval is the bootstrap's percentiles: BCa's jackknife costs n², and what it
corrects shrinks with 1/√n."""

_AT_ONCE = 2**22
"""Numbers that are resampled at once where a sample is large; a hundred thousand trials would take gigabytes."""

FEWEST = 6
"""Trials from which on a paired test can reach 5 % at all: 2 · 2⁻⁶ is below it, 2 · 2⁻⁵ is not."""


@dataclass(frozen=True)
class RatioInterval:
    """How many times the second law's figure the first law's is, with an interval.

    Attributes:
        ratio: Geometric mean over the trials; the median where a failure makes a ratio infinite.
        low: Lower end of the interval.
        high: Upper end; infinite where failures of the first law reach.
        trials: Number of pairs.
    """

    ratio: float
    low: float
    high: float
    trials: int

    @property
    def excludes_one(self) -> bool:
        """Whether the interval of the logarithm excludes 0, on trials enough to say so."""
        return self.trials >= FEWEST and (self.high < 1.0 or self.low > 1.0)


def log_ratios(first: Array, second: Array) -> Array:
    """Logarithm of first over second, trial by trial.

    Args:
        first: Figures, 0 or more, +∞ for a failure; any shape.
        second: The same of the other law, in the same trials.

    Returns:
        ±∞ where just one failed (or just one is 0), 0 where both did: a tie.

    Raises:
        ParameterError: a figure is NaN or negative, or the trials are not as many.
    """
    first, second = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if first.shape != second.shape:
        raise ParameterError("second", f"has shape {second.shape}, the first {first.shape}; trials come in pairs")
    for name, figures in (("first", first), ("second", second)):
        if not (figures >= 0.0).all():
            raise ParameterError(name, "has a figure that is negative or no number; a failure is +∞")
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(first == second, 0.0, np.log(first) - np.log(second)))


def ratio_interval(first: Array, second: Array, seed: int = 0) -> RatioInterval:
    """The ratio of two laws' figures over paired trials, with its 95 % interval.

    The mean of the log ratios with BCa's bootstrap interval. Where a failure makes a log ratio infinite a mean says
    nothing: then the median takes its place, with the bootstrap's percentiles, since BCa's acceleration is not defined
    there. Both are exact about failures: one that matters makes an end infinite, or 0.

    Args:
        first: Figures, shape (trials,), 0 or more; +∞ for a failure.
        second: The same of the other law.
        seed: Of the resampling.
    """
    logs = log_ratios(first, second)
    if np.isfinite(logs).all():
        middle = float(np.mean(logs))
        low, high = bca_interval(logs, np.mean, seed)
    else:
        middle, low, high = _median_interval(logs, seed)
    with np.errstate(over="ignore"):
        ratio, low, high = (float(np.exp(x)) for x in (middle, low, high))
    return RatioInterval(ratio, low, high, len(logs))


def bca_interval(
    sample: Array, statistic: Callable[..., Any], seed: int = 0, level: float = LEVEL, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """Bias-corrected and accelerated bootstrap interval of a statistic, by `scipy.stats.bootstrap`.

    Efron (1987), Better Bootstrap Confidence Intervals, JASA 82(397). A sample of equal values has no spread: its
    interval is the statistic itself. One of more than `LARGEST_JACKKNIFE` values has the percentiles.

    Args:
        sample: Shape (n,), finite.
        statistic: Takes ``axis``.
        seed: Of the resampling.
        level: Of confidence.
        resamples: Their number.
    """
    if len(sample) < 2 or np.ptp(sample) <= 1e-14 * np.max(np.abs(sample)):
        value = float(statistic(sample, axis=-1))
        return value, value
    large = len(sample) > LARGEST_JACKKNIFE
    ends = _bootstrapped(sample, statistic, seed, level, resamples, "percentile" if large else "BCa")
    if not np.isfinite(ends).all():  # the jackknife has no skewness to correct by
        ends = _bootstrapped(sample, statistic, seed, level, resamples, "percentile")
    return ends


def _bootstrapped(
    sample: Array, statistic: Callable[..., Any], seed: int, level: float, resamples: int, method: Any
) -> tuple[float, float]:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # degenerate data, which the caller sees as NaN
        found = stats.bootstrap(
            (sample,),
            statistic,
            axis=-1,
            confidence_level=level,
            n_resamples=resamples,
            batch=None if len(sample) <= LARGEST_JACKKNIFE else max(1, _AT_ONCE // len(sample)),
            method=method,
            rng=np.random.default_rng(seed),
        ).confidence_interval
    return float(found.low), float(found.high)


def _median_interval(logs: Array, seed: int) -> tuple[float, float, float]:
    """Median of values that may be infinite, and the percentiles of its resamples; order statistics only."""
    source, middles = np.random.default_rng(seed), [(len(logs) - 1) // 2, len(logs) // 2]
    found = np.empty((0, 2))
    while len(found) < RESAMPLES:
        some = min(max(1, _AT_ONCE // len(logs)), RESAMPLES - len(found))
        draws = source.integers(0, len(logs), (some, len(logs)))
        # Lower and upper median are taken apart: their mean is undefined between −∞ and +∞.
        found = np.vstack([found, np.partition(logs[draws], middles, axis=1)[:, middles]])
    lower, upper = np.sort(found, axis=0).T
    tail = 0.5 * (1.0 - LEVEL)
    own = np.sort(logs)
    ends = own[(len(logs) - 1) // 2], own[len(logs) // 2]
    middle = ends[0] if ends[0] == ends[1] else 0.0 if np.isinf(ends).all() else 0.5 * (ends[0] + ends[1])
    return float(middle), float(lower[int(tail * RESAMPLES)]), float(upper[-1 - int(tail * RESAMPLES)])
