"""What a benchmark found, in the form that its page, tables and figures are made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.statistics.over_tasks import shifted_geometric_mean
from asmc_pin.statistics.pairwise import PairedComparison, pairwise
from asmc_pin.statistics.task_ranks import MeanRank, mean_ranks

SHIFT = 1e-5
"""Of the shifted geometric mean over the problems, in the figures' SI unit: two counts of the encoders of all tasks of
`asmc-bench-1` but `coarse`. Below it matters little which law has the smaller error."""


@dataclass(frozen=True, eq=False)
class BenchFindings:
    """The figures of a complete benchmark: one for each law and problem, that is an arm with a task.

    Attributes:
        suite: Its name.
        sha256: Of its conditions.
        scope: What of the suite was run, in words; empty for all of it.
        conditions: How gains were searched and judged, in words.
        seed: Of the suite.
        laws: Names, as the suite has them.
        kinds: Name -> law.
        problems: Arm and task of each problem.
        unit: SI unit of the figures.
        figures: Median over the held-out trials, (laws, problems), SI; +∞ for a failure.
        unkept: Whether no gains kept the limit in training, (laws, problems).
        failed: Held-out trials that failed, (laws, problems).
        over: Held-out trials beyond the limit, or failed, (laws, problems).
        trials: Candidates that were tried, (laws, problems).
        held_out: Held-out trials of each.
        proposed: Law whose place is said plainly.
    """

    suite: str
    sha256: str
    scope: str
    conditions: str
    seed: int
    laws: Sequence[str]
    kinds: Mapping[str, str]
    problems: Sequence[tuple[str, str]]
    unit: str
    figures: Array
    unkept: Array
    failed: Array
    over: Array
    trials: Array
    held_out: int
    proposed: str = "baek2016"

    @cached_property
    def ranks(self) -> list[MeanRank]:
        """Mean rank of each law over the problems."""
        return mean_ranks(self.figures, self.seed)

    @property
    def tasks(self) -> list[str]:
        """In the order of the problems."""
        return list(dict.fromkeys(task for _, task in self.problems))

    def means(self, task: str | None = None) -> Array:
        """Shifted geometric mean of each law, (laws,), SI; +∞ for a law that failed in a problem of them.

        Args:
            task: Over its arms; over all problems when omitted.
        """
        here = [task in (None, each) for _, each in self.problems]
        return shifted_geometric_mean(self.figures[:, here], SHIFT)

    @cached_property
    def order(self) -> list[int]:
        """Laws by their mean rank, the best first; equal ones as the suite has them."""
        return sorted(range(len(self.laws)), key=lambda k: (self.ranks[k].rank, k))

    @cached_property
    def pairs(self) -> list[PairedComparison]:
        """Every pair of laws over the problems, as one family."""
        return pairwise({"figure": dict(zip(self.laws, self.figures, strict=True))}, self.seed)

    @property
    def lost(self) -> Array:
        """Problems that each law failed, (laws,)."""
        return np.asarray(np.sum(~np.isfinite(self.figures), axis=1))

    def verdicts_on(self, law: str) -> list[tuple[str, PairedComparison]]:
        """Each other law, and the comparison with it."""
        return [(p.worse if p.better == law else p.better, p) for p in self.pairs if law in (p.better, p.worse)]
