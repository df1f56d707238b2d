"""Which controller of a sweep is better, and how sure that is: every pair, by every metric, as one family of tests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyarrow as pa

from asmc_pin._typing import Array
from asmc_pin.pages.sweeps.sweep_findings import FAILURE, Compared
from asmc_pin.statistics.pairwise import pairwise
from asmc_pin.sweeping.sweep_plan import SweepPlan
from asmc_pin.sweeping.trial_scores import TrialScores


def compared(plan: SweepPlan, scores: TrialScores) -> list[Compared]:
    """All comparisons: over all points together and by where scans fail, and at each point of several.

    Draws are the sample: what a draw gives at several points is not independent, so over all points a draw counts once.
    Where the draws are all alike there is no sample, and nothing is compared. Each point is a family of tests.
    """
    if scores.alike or len(scores.labels) < 2:
        return []
    points = plan.variation.grid_points
    overall = {name: {label: _over_points(x) for label, x in by.items()} for name, by in scores.scores.items()}
    for axis in plan.variation.scans:
        assert axis.scan is not None
        if len(scores.fails_at[axis.path]) < 2:
            continue
        ways = {label: np.abs(x - axis.scan[0]) for label, x in scores.fails_at[axis.path].items()}
        with np.errstate(divide="ignore"):
            overall[f"{FAILURE}{axis.path}"] = {label: 1.0 / way for label, way in ways.items()}
    families: dict[int | None, dict[str, dict[str, Array]]] = {None: overall}
    for point in range(points) if points > 1 else ():
        families[point] = {name: {label: x[:, point] for label, x in by.items()} for name, by in scores.scores.items()}
    seed = plan.experiment.seed
    return [Compared(point, item) for point, family in families.items() for item in pairwise(family, seed)]


def _over_points(figures: Array) -> Array:
    """Geometric mean over the points of each draw, (draws,); +∞ where one is."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(np.mean(np.log(figures), axis=1)))


def comparisons_table(comparisons: Sequence[Compared]) -> pa.Table:
    """``comparisons.parquet``: a row for each."""
    schema = pa.schema(
        [("point", pa.int64())]
        + [(name, pa.string()) for name in ("metric", "better", "worse")]
        + [(name, pa.float64()) for name in ("ratio", "low", "high", "p", "improvement")]
        + [("certain", pa.bool_())]
    )
    rows = [{"point": item.point, **vars(item.paired)} for item in comparisons]
    return pa.Table.from_pylist(rows, schema=schema)
