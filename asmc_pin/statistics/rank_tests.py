"""Tests and probabilities that know only which figure is smaller, so that a failure has its place among them."""

from __future__ import annotations

import numpy as np
from scipy import stats

from asmc_pin._typing import Array
from asmc_pin.statistics.paired_ratio import log_ratios


def signed_rank_p(first: Array, second: Array) -> float:
    """Two-sided p of Wilcoxon's signed-rank test on paired trials, by `scipy.stats.wilcoxon`.

    Wilcoxon (1945), Biometrics Bulletin 1(6). Of the log ratios, whose largest are those with a failure. Ties, two
    failures among them, keep their ranks and count for neither side (Pratt 1959, JASA 54(287)): dropping them would
    make few differences look like a rule.

    Args:
        first: Figures, shape (trials,), 0 or more; +∞ for a failure.
        second: The same of the other law, in the same trials.
    """
    return signed_rank_p_of(log_ratios(first, second))


def signed_rank_p_of(differences: Array) -> float:
    """The same of differences, shape (n,), which may be infinite; 1 where all are 0."""
    if not np.any(differences):
        return 1.0
    # The test sees ranks and signs only, and infinite differences have ranks too.
    ranks = np.sign(differences) * stats.rankdata(np.abs(differences))
    return float(stats.wilcoxon(ranks, zero_method="pratt").pvalue)


def holm(p: Array) -> Array:
    """Holm's adjusted p of a family of tests: reject those below α, and at most α is the chance of one too many.

    Holm (1979), A Simple Sequentially Rejective Multiple Test Procedure, Scand. J. Statistics 6(2).

    Args:
        p: Of every test of the family, shape (m,).
    """
    p = np.asarray(p, dtype=np.float64)
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate((len(p) - np.arange(len(p))) * p[order])
    adjusted = np.empty_like(p)
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def probability_of_improvement(first: Array, second: Array) -> float:
    """Probability that a trial of the first law has a smaller figure than one of the second; a tie counts half.

    Agarwal, Schwarzer, Castro, Courville, Bellemare (2021), Deep Reinforcement Learning at the Edge of the Statistical
    Precipice, NeurIPS, sec. 4.3: the mean over tasks of U/(nm) of Mann and Whitney (1947).

    Args:
        first: Figures, shape (trials,) or (tasks, trials); +∞ for a failure.
        second: The same of the other law; the trials may be others.
    """
    shares = []
    for one, other in zip(np.atleast_2d(first), np.atleast_2d(second), strict=True):
        ordered = np.sort(other)  # by ranks: a hundred thousand trials have too many pairs to look at each
        upto, below = (np.searchsorted(ordered, one, side) for side in ("right", "left"))
        won = np.sum(ordered.size - upto) + 0.5 * np.sum(upto - below)
        shares.append(float(won) / (one.size * ordered.size))
    return float(np.mean(shares))
