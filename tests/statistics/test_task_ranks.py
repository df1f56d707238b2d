"""Ranks over tasks: ties share theirs, failures are last, and the interval is one of the mean."""

import math

import numpy as np
import pytest
from scipy import stats

from asmc_pin.errors import ParameterError
from asmc_pin.statistics.task_ranks import mean_ranks, task_ranks


def test_the_smallest_is_first_and_failures_share_the_last_ranks():
    figures = np.array([[1.0, math.inf], [2.0, math.inf], [math.inf, 0.1]])
    assert task_ranks(figures).tolist() == [[1.0, 2.5], [2.0, 2.5], [3.0, 1.0]]


def test_mean_ranks_are_those_behind_friedmans_test():
    figures = np.random.default_rng(2).lognormal(size=(4, 12))
    ranks = [mean.rank for mean in mean_ranks(figures)]
    k, n = figures.shape
    chi = 12.0 * n / (k * (k + 1)) * (sum(r * r for r in ranks) - k * (k + 1) ** 2 / 4.0)
    assert chi == pytest.approx(stats.friedmanchisquare(*figures).statistic, rel=1e-12)
    assert sum(ranks) == pytest.approx(10.0)


def test_an_interval_holds_the_mean_and_is_a_point_where_the_rank_never_changes():
    source = np.random.default_rng(3)
    figures = np.vstack([source.lognormal(size=(2, 20)), 1e3 + source.lognormal(size=(1, 20))])
    first, second, last = mean_ranks(figures, seed=1)
    assert (last.rank, last.low, last.high) == (3.0, 3.0, 3.0)
    for mean in (first, second):
        assert 1.0 <= mean.low < mean.rank < mean.high <= 2.0
    with pytest.raises(ParameterError):
        mean_ranks(np.array([[1.0, math.nan]]))
