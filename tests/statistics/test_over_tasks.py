"""Performance profiles and shifted geometric means against their definitions, by hand and by scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from asmc_pin.errors import ParameterError
from asmc_pin.statistics.over_tasks import performance_profile, performance_ratios, shifted_geometric_mean

INF = math.inf
FIGURES = np.array([[1.0, 6.0, 2.0, INF, 5.0], [2.0, 3.0, 8.0, 4.0, INF]])
"""Two solvers on five tasks; each fails one."""


def test_a_profile_is_the_one_that_is_counted_by_hand():
    # Ratios: first 1, 2, 1, ∞, 1; second 2, 1, 4, 1, ∞.
    profile = performance_profile(FIGURES, np.array([1.0, 2.0, 3.9, 4.0, 1e9]))
    assert profile.tolist() == [[0.6, 0.8, 0.8, 0.8, 0.8], [0.4, 0.6, 0.6, 0.8, 0.8]]


def test_a_profile_is_scipys_empirical_distribution_of_the_ratios_to_the_best():
    figures = np.random.default_rng(4).lognormal(size=(3, 40))
    factors = np.geomspace(1.0, 20.0, 50)
    for solver, profile in enumerate(performance_profile(figures, factors)):
        ratios = figures[solver] / figures.min(axis=0)
        assert profile == pytest.approx(stats.ecdf(ratios).cdf.evaluate(factors), abs=1e-12)


def test_at_a_factor_of_one_a_profile_says_how_often_a_solver_wins_and_at_large_ones_how_often_it_works():
    assert performance_profile(FIGURES, np.array([1.0]))[:, 0].sum() == pytest.approx(1.0)
    assert performance_profile(FIGURES, np.array([1e300])).tolist() == [[0.8], [0.8]]
    assert performance_profile(np.full((2, 1), INF), np.array([1.0, 1e12])).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_ratios_have_no_unit_and_only_positive_figures_have_them():
    assert np.array_equal(performance_ratios(FIGURES), performance_ratios(1024.0 * FIGURES))
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(ParameterError, match="positive"):
            performance_ratios(np.array([[wrong], [1.0]]))


def test_a_shifted_mean_is_scipys_geometric_mean_of_the_shifted_figures():
    figures = np.array([0.1, 5.0, 40.0, 1000.0])
    assert shifted_geometric_mean(figures, 10.0) == pytest.approx(stats.gmean(figures + 10.0) - 10.0, rel=1e-12)
    assert shifted_geometric_mean(figures, 0.0) == pytest.approx(stats.gmean(figures), rel=1e-12)


@given(st.lists(st.floats(0.0, 1e3), min_size=1, max_size=9), st.floats(0.01, 1e3))
def test_a_shifted_mean_lies_between_the_geometric_and_the_arithmetic_one(figures, shift):
    found = float(shifted_geometric_mean(np.array(figures), shift))
    assert float(shifted_geometric_mean(np.array(figures), 0.0)) <= found + 1e-6
    assert found <= np.mean(figures) + 1e-6


def test_a_failure_in_any_task_is_in_the_mean():
    assert shifted_geometric_mean(np.array([[1.0, INF], [1.0, 1.0]]), 1.0).tolist() == [INF, pytest.approx(1.0)]
    with pytest.raises(ParameterError, match="a failure is"):
        shifted_geometric_mean(np.array([1.0, np.nan]), 1.0)
    with pytest.raises(ParameterError, match="shift"):
        shifted_geometric_mean(np.ones(2), -1.0)
