"""Ranks of solvers over many tasks, with intervals over which tasks they might have been."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.statistics.paired_ratio import bca_interval


@dataclass(frozen=True)
class MeanRank:
    """The mean rank of one solver over tasks; 1 is the best.

    Attributes:
        rank: The mean.
        low: Lower end of its 95 % interval.
        high: Upper end.
    """

    rank: float
    low: float
    high: float


def task_ranks(figures: Array) -> Array:
    """Rank of each solver on each task, 1 for the smallest figure; equal figures share theirs, failures among them.

    Friedman (1937), The Use of Ranks to Avoid the Assumption of Normality, JASA 32(200).

    Args:
        figures: Shape (solvers, tasks); +∞ for a failure.

    Raises:
        ParameterError: a figure is NaN.
    """
    figures = np.asarray(figures, dtype=np.float64)
    if np.isnan(figures).any():
        raise ParameterError("figures", "have one that is no number; a failure is +∞")
    return np.asarray(stats.rankdata(figures, axis=0))


def mean_ranks(figures: Array, seed: int = 0) -> list[MeanRank]:
    """Mean rank of each solver over the tasks, with BCa's bootstrap interval over them.

    The interval says how far the mean would move with other tasks of the kind. Ranks of several solvers depend on each
    other, and on which others there are.

    Args:
        figures: Shape (solvers, tasks); +∞ for a failure.
        seed: Of the resampling, the same for every solver.
    """
    ranks = task_ranks(figures)
    return [MeanRank(float(np.mean(row)), *bca_interval(row, np.mean, seed)) for row in ranks]
