"""What a sweep found, in the form that its page, tables and figures are made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asmc_pin._typing import Array
from asmc_pin.experiment import Experiment
from asmc_pin.statistics.pairwise import PairedComparison

FAILURE = "failure of "
"""How the name of a comparison begins that is by where a scan failed."""


@dataclass(frozen=True)
class Compared:
    """A comparison of two controllers, and where it is from.

    Attributes:
        point: Number of the grid point; None for all together, each draw by its geometric mean over the points.
        paired: The comparison. By a scan (`FAILURE`) it is of 1/(way from the start to the failure).
    """

    point: int | None
    paired: PairedComparison


@dataclass(frozen=True, eq=False)
class SweepFindings:
    """The figures of a complete sweep, one for each trial and controller.

    Attributes:
        experiment: As run.
        draws: Trials at each point.
        labels: Controllers as results show them.
        points: What the grids stand at, in words, by the number of the point; one empty text without a grid.
        scores: Metric -> label -> (draws, points), the geometric mean over the joints, SI; +∞ where the run failed.
        fails_at: Scanned key -> label -> (draws,), the smallest value seen to fail; infinite where none was.
        drawn: Random key -> (draws,), where what is drawn is one number.
        failed: Label -> runs at the grids that diverged.
        kinds: Of the joints that there are, ``"revolute"`` and ``"prismatic"``.
        alike: Whether the draws do not differ at all, so that there is nothing to be sure of.
        comparisons: Pairs of controllers, by every metric.
    """

    experiment: Experiment
    draws: int
    labels: Sequence[str]
    points: Sequence[str]
    scores: Mapping[str, Mapping[str, Array]]
    fails_at: Mapping[str, Mapping[str, Array]]
    drawn: Mapping[str, Array]
    failed: Mapping[str, int]
    kinds: frozenset[str]
    alike: bool
    comparisons: Sequence[Compared]

    @property
    def runs(self) -> int:
        """Runs of each controller at the grids."""
        return self.draws * len(self.points)
