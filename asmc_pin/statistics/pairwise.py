"""Every pair of laws compared by several metrics, as one family of tests."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.statistics.paired_ratio import ratio_interval
from asmc_pin.statistics.rank_tests import holm, probability_of_improvement, signed_rank_p

FAMILY_LEVEL = 0.05
"""Chance of one order too many that is taken over all pairs and metrics of a family together."""


@dataclass(frozen=True)
class PairedComparison:
    """Two laws in the same trials, by one metric of which less is better.

    Attributes:
        metric: Name of it.
        better: Label of the law with the smaller figure.
        worse: Label of the other.
        ratio: Figure of the better over that of the worse; 0 where the worse failed in most trials.
        low: Lower end of its 95 % interval.
        high: Upper end; where it is 1 or more, the order of the two is not certain.
        p: Wilcoxon's, adjusted by Holm over all pairs and metrics of the family.
        improvement: Probability that a trial of the better has the smaller figure.
        certain: Whether the interval excludes 1.
    """

    metric: str
    better: str
    worse: str
    ratio: float
    low: float
    high: float
    p: float
    improvement: float
    certain: bool

    @property
    def certain_in_family(self) -> bool:
        """Whether the test agrees with the interval, for all pairs and metrics of the family at once."""
        return self.certain and self.p < FAMILY_LEVEL

    def to_json_dict(self) -> dict[str, Any]:
        """Valid JSON; null for an end that is infinite."""
        ends = {name: getattr(self, name) for name in ("ratio", "low", "high", "p", "improvement")}
        told = {name: value if np.isfinite(value) else None for name, value in ends.items()}
        return {"metric": self.metric, "better": self.better, "worse": self.worse, **told, "certain": self.certain}


def pairwise(figures: Mapping[str, Mapping[str, Array]], seed: int = 0) -> list[PairedComparison]:
    """Compare every pair of laws by every metric.

    Args:
        figures: By metric and label, shape (trials,), 0 or more, +∞ for a failure; trials are paired by their number.
        seed: Of the resampling.

    Returns:
        Metric by metric, the pairs in the order of the labels.
    """
    found = []
    for metric, laws in figures.items():
        for one, other in itertools.combinations(laws, 2):
            interval = ratio_interval(laws[one], laws[other], seed)
            if interval.ratio > 1.0:
                one, other = other, one
                interval = ratio_interval(laws[one], laws[other], seed)
            found.append((metric, one, other, interval))
    p = holm(np.array([signed_rank_p(figures[metric][one], figures[metric][other]) for metric, one, other, _ in found]))
    return [
        PairedComparison(
            metric,
            one,
            other,
            interval.ratio,
            interval.low,
            interval.high,
            float(adjusted),
            probability_of_improvement(figures[metric][one], figures[metric][other]),
            interval.excludes_one,
        )
        for (metric, one, other, interval), adjusted in zip(found, p, strict=True)
    ]


def best_of(figures: Array, largest: bool = False, seed: int = 0) -> int | None:
    """Which of several laws is the best with certainty: its paired ratio to every other excludes 1.

    Args:
        figures: Shape (laws, trials), 0 or more, +∞ for a failure; NaN throughout for a law without the figure.
        largest: Whether more is better.
        seed: Of the resampling.

    Returns:
        Index of the law; None where the order of the first two is not certain, or there is nothing to compare.
    """
    known = [k for k, row in enumerate(figures) if not np.isnan(row).any()]
    if len(known) < 2:
        return None
    medians = [float(np.median(figures[k])) for k in known]
    first = known[int(np.argmax(medians) if largest else np.argmin(medians))]
    for k in known:
        if k == first:
            continue
        interval = ratio_interval(figures[first], figures[k], seed)
        beaten = interval.low > 1.0 if largest else interval.high < 1.0
        if not (interval.excludes_one and beaten):
            return None
    return first
