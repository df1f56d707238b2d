"""Intervals, tests and probabilities against published and scipy values, and what a failure does to each."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from asmc_pin.errors import ParameterError
from asmc_pin.statistics.order_statistics import quantile, spread_of, with_failures
from asmc_pin.statistics.paired_ratio import FEWEST, bca_interval, log_ratios, ratio_interval
from asmc_pin.statistics.pairwise import best_of, pairwise
from asmc_pin.statistics.rank_tests import holm, probability_of_improvement, signed_rank_p, signed_rank_p_of

INF = math.inf
BASE = np.exp(np.random.default_rng(5).normal(size=16))
"""Draws that both laws of a pair share."""


@pytest.fixture
def rng():
    """A generator of each test's own: no other test's draws shift its numbers."""
    return np.random.default_rng(6)


# Quantiles -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.0, 0.05, 0.3, 0.5, 0.95, 1.0])
def test_without_failures_a_quantile_is_numpys(share, rng):
    figures = rng.normal(size=(16, 3))
    assert quantile(figures, share) == pytest.approx(np.quantile(figures, share, axis=0), rel=1e-13)


def test_a_failure_is_worse_than_any_figure_and_reaches_what_it_is_part_of():
    figures = np.array([3.0, 1.0, 2.0, INF, 5.0])
    spread = spread_of(figures)
    assert (spread.median, spread.low, spread.high) == (3.0, pytest.approx(1.2), INF)
    # Of 21 trials the 95 % quantile is the second largest itself: one failure does not reach it.
    assert spread_of(np.append(np.arange(20.0), INF)).high == 19.0


def test_half_of_the_trials_failing_makes_the_median_infinite():
    assert spread_of(np.array([1.0, INF])).median == INF
    assert spread_of(np.array([1.0, 2.0, INF])).median == 2.0


def test_failures_are_never_dropped_and_what_is_undefined_in_all_stays_undefined():
    figures = np.array([[1.0, np.nan, np.nan], [np.nan, np.nan, np.nan], [2.0, np.nan, 0.3]])
    filled = with_failures(figures, np.array([False, True, False]))
    assert filled[:, 0].tolist() == [1.0, INF, 2.0]
    assert np.isnan(filled[:, 1]).all()
    assert filled[:, 2].tolist() == [INF, INF, 0.3]  # not settled is later than settled
    assert (with_failures(np.full((2, 1), np.nan), np.array([True, True])) == INF).all()


def test_a_trial_that_never_tripped_counts_as_later_than_any_also_where_only_a_failure_has_a_time():
    figures = np.array([[0.4], [np.nan], [np.nan]])
    assert with_failures(figures, np.array([True, False, False])).ravel().tolist() == [0.4, INF, INF]
    assert spread_of(with_failures(figures, np.array([True, False, False]))).median.tolist() == [INF]


# Bootstrap -----------------------------------------------------------------------------------------------------------

# Efron, Tibshirani (1993), An Introduction to the Bootstrap, table 14.1, test A; table 14.2 has the interval.
SPATIAL_A = [48, 36, 20, 29, 42, 42, 20, 42, 22, 41, 45, 14, 6, 0, 33, 28, 34, 4, 32, 24, 47, 41, 24, 26, 30, 41]


def test_bca_gives_the_published_interval_of_the_variance_of_the_spatial_test():
    sample = np.array(SPATIAL_A, dtype=float)
    assert np.var(sample) == pytest.approx(171.5, abs=0.05)
    low, high = bca_interval(sample, np.var, level=0.90, resamples=20_000)
    assert (low, high) == (pytest.approx(115.8, abs=3.0), pytest.approx(259.6, abs=5.0))


def test_the_interval_of_a_ratio_is_scipys_of_the_mean_log_ratio(rng):
    first, second = BASE * np.exp(0.2 * rng.normal(size=16)), BASE
    found = ratio_interval(first, second, seed=3)
    logs = np.log(first / second)
    exact = stats.bootstrap((logs,), np.mean, n_resamples=2999, method="BCa", rng=np.random.default_rng(3))
    assert np.log([found.low, found.high]) == pytest.approx(list(exact.confidence_interval), rel=1e-12)
    assert found.ratio == pytest.approx(stats.gmean(first / second))


def test_common_draws_cancel_in_the_ratio_so_that_a_small_difference_shows(rng):
    small = 0.97 * BASE * np.exp(0.01 * rng.normal(size=16))
    paired = ratio_interval(small, BASE)
    assert paired.excludes_one
    assert paired.high < 1.0
    # The same figures out of step: what the draws do to both covers the difference.
    assert not ratio_interval(small, np.roll(BASE, 5)).excludes_one


def test_equal_figures_have_a_ratio_of_one_and_nothing_is_certain_of_them():
    found = ratio_interval(BASE, BASE)
    assert (found.ratio, found.low, found.high, found.excludes_one) == (1.0, 1.0, 1.0, False)


def test_so_few_trials_that_no_test_could_tell_tell_nothing():
    first = np.linspace(0.1, 0.2, FEWEST - 1)
    assert ratio_interval(first, 2.0 * first).high < 1.0
    assert not ratio_interval(first, 2.0 * first).excludes_one
    assert ratio_interval(np.linspace(0.1, 0.2, FEWEST), np.ones(FEWEST)).excludes_one


@pytest.mark.long
@settings(deadline=None, max_examples=30)
@given(st.lists(st.floats(0.1, 10.0), min_size=6, max_size=20), st.integers(0, 3), st.integers(0, 3))
def test_exchanging_the_laws_inverts_a_ratio_and_keeps_its_p(figures, first_fails, second_fails):
    first = np.array(figures)
    second = first[::-1].copy()
    first[:first_fails], second[:second_fails] = INF, INF
    forth, back = ratio_interval(first, second), ratio_interval(second, first)
    with np.errstate(divide="ignore"):
        assert forth.ratio == pytest.approx(np.divide(1.0, back.ratio), rel=1e-9)
    assert forth.low <= forth.ratio * (1 + 1e-9)
    assert forth.ratio <= forth.high * (1 + 1e-9)
    assert signed_rank_p(first, second) == pytest.approx(signed_rank_p(second, first))
    assert probability_of_improvement(first, second) == pytest.approx(1.0 - probability_of_improvement(second, first))


def test_two_failures_are_a_tie_and_one_is_infinitely_worse():
    assert log_ratios(np.array([INF, INF, 1.0]), np.array([INF, 1.0, INF])).tolist() == [0.0, INF, -INF]
    with pytest.raises(ParameterError, match="a failure is"):
        log_ratios(np.array([np.nan]), np.array([1.0]))
    with pytest.raises(ParameterError, match="trials come in pairs"):
        log_ratios(np.ones(3), np.ones(4))


def test_a_few_failures_open_the_interval_upwards_and_many_take_the_certainty_of_being_better():
    better = 0.8 * BASE
    once = np.where(np.arange(16) < 1, INF, better)
    assert ratio_interval(once, BASE).excludes_one  # 15 of 16 trials are better
    often = np.where(np.arange(16) < 7, INF, better)
    assert not ratio_interval(often, BASE).excludes_one
    assert ratio_interval(often, BASE).high == INF
    always = ratio_interval(np.full(16, INF), BASE)
    assert (always.ratio, always.low) == (INF, INF)
    assert always.excludes_one


# Ranks ---------------------------------------------------------------------------------------------------------------

# Darwin's maize, Cramér von Mises and Fisher's example; scipy's page of `wilcoxon` prints W = 24, p = 0.04126.
MAIZE = np.array([6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75], dtype=float)


def test_wilcoxon_gives_the_published_p_of_darwins_maize():
    assert signed_rank_p_of(MAIZE) == pytest.approx(0.04126, abs=5e-6)


def test_an_infinite_difference_has_the_rank_of_the_largest_and_is_not_dropped():
    assert signed_rank_p_of(np.where(MAIZE == 75, INF, MAIZE)) == signed_rank_p_of(MAIZE)
    assert signed_rank_p_of(np.where(MAIZE == -67, -INF, MAIZE)) > signed_rank_p_of(MAIZE)


def test_ties_alone_are_no_evidence():
    assert signed_rank_p(np.full(16, INF), np.full(16, INF)) == 1.0
    # Two differences among fourteen ties: with the ties dropped p could not be larger than with them kept.
    assert signed_rank_p_of(np.array([1.0, 2.0] + [0.0] * 14)) > 0.1


def test_holm_gives_the_printed_adjusted_values():
    # The examples in the manuals of Pingouin (`holm`) and of Julia's MultipleTesting (`Holm`).
    assert holm(np.array([0.50, 0.003, 0.32, 0.054, 0.0003])) == pytest.approx([0.64, 0.012, 0.64, 0.162, 0.0015])
    assert holm(np.array([0.001, 0.01, 0.03, 0.5])) == pytest.approx([0.004, 0.03, 0.06, 0.5])
    # By hand, out of order: each p times the number not yet rejected, never falling.
    assert holm(np.array([0.01, 0.04, 0.03, 0.005])) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm(np.array([0.5, 0.9])).tolist() == [1.0, 1.0]


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12))
def test_holm_lies_between_the_raw_values_and_bonferronis(p):
    adjusted = holm(np.array(p))
    assert (adjusted >= np.array(p) * (1 - 1e-12)).all()
    assert (adjusted <= np.minimum(len(p) * np.array(p), 1.0) + 1e-12).all()


def test_the_probability_of_improvement_is_that_of_mann_and_whitney(rng):
    first, second = rng.normal(size=13), rng.normal(size=9) + 0.4
    exact = stats.mannwhitneyu(second, first).statistic / (13 * 9)  # pairs in which the second is larger
    assert probability_of_improvement(first, second) == pytest.approx(exact)
    assert probability_of_improvement(np.array([INF, 1.0]), np.array([INF, 2.0])) == pytest.approx((0.5 + 1 + 1) / 4)
    both = np.stack([first[:9], second]), np.stack([second, first[:9]])
    assert probability_of_improvement(*both) == pytest.approx(0.5)


# Families ------------------------------------------------------------------------------------------------------------


def test_a_family_holds_every_pair_by_every_metric_and_is_adjusted_as_one(rng):
    figures = {
        "error": {"A": 0.5 * BASE, "B": BASE, "C": BASE * np.exp(0.3 * rng.normal(size=16))},
        "chatter": {"A": BASE, "B": 0.9 * BASE, "C": np.full(16, INF)},
    }
    found = pairwise(figures)
    assert [(item.metric, {item.better, item.worse}) for item in found] == [
        (metric, pair) for metric in figures for pair in ({"A", "B"}, {"A", "C"}, {"B", "C"})
    ]
    ab, bc = found[0], found[2]
    assert (ab.better, ab.worse, ab.certain) == ("A", "B", True)
    assert ab.ratio == pytest.approx(0.5)
    assert not bc.certain
    assert bc.low < 1.0 < bc.high
    raw = [signed_rank_p(figures[item.metric][item.better], figures[item.metric][item.worse]) for item in found]
    assert [item.p for item in found] == pytest.approx(holm(np.array(raw)).tolist())
    failing = found[-1].to_json_dict()
    assert (failing["better"], failing["worse"], failing["ratio"]) == ("B", "C", 0.0)


def test_an_order_that_is_certain_by_itself_may_not_be_in_a_family_of_several():
    """Six trials of one sign have p = 2 · 2⁻⁶ = 0.031: below 5 % alone, 0.0625 as one of two."""
    laws = {"A": np.linspace(0.5, 0.6, 6) * BASE[:6], "B": BASE[:6]}
    (alone,) = pairwise({"error": laws})
    assert (alone.certain, alone.p, alone.certain_in_family) == (True, pytest.approx(2.0**-5), True)
    for item in pairwise({"error": laws, "effort": laws}):
        assert (item.certain, item.p, item.certain_in_family) == (True, pytest.approx(2.0**-4), False)


def test_the_best_is_named_only_where_it_is_certain():
    near = BASE * np.exp(0.05 * np.tile([1.0, -1.0], 8))  # 5 % above and below by turns: as good as BASE
    assert best_of(np.stack([2.0 * BASE, BASE, 3.0 * BASE])) == 1
    assert best_of(np.stack([2.0 * BASE, BASE, near])) is None
    assert best_of(np.stack([2.0 * BASE, BASE, 3.0 * BASE]), largest=True) == 2
    assert best_of(np.stack([BASE, np.full(16, np.nan)])) is None
    assert best_of(np.stack([BASE, np.full(16, INF)])) == 0
    assert best_of(np.full((2, 16), INF)) is None


# Many trials ----------------------------------------------------------------------------------------------------------


def test_the_probability_of_improvement_is_that_of_looking_at_every_pair(rng):
    one, other = rng.integers(0, 6, (3, 40)).astype(float), rng.integers(0, 6, (3, 30)).astype(float)
    one[0, :5] = other[0, :3] = INF
    pairs = (one[:, :, None] < other[:, None, :]) + 0.5 * (one[:, :, None] == other[:, None, :])
    assert probability_of_improvement(one, other) == pytest.approx(pairs.mean(), rel=1e-14)


def test_many_trials_take_no_memory_that_grows_with_their_square():
    source = np.random.default_rng(1)
    figures = np.exp(source.normal(size=(2, 6000)))
    figures[1] *= 1.1
    failing = figures.copy()
    failing[0, :40] = INF
    tracemalloc.start()
    try:
        (found,) = pairwise({"m": dict(zip("AB", figures, strict=True))})
        interval = ratio_interval(*failing)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2e8  # every pair of trials, or all resamples at once, take 3e8
    logs = np.log(figures[0]) - np.log(figures[1])
    width = 1.96 * logs.std() / np.sqrt(len(logs))
    assert (math.log(found.low), math.log(found.high)) == pytest.approx(
        (logs.mean() - width, logs.mean() + width), abs=0.003
    )
    assert interval.low < interval.ratio < interval.high < INF
