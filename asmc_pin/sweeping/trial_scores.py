"""One figure for each trial and controller, gathered while the rows go by, which never are all in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa

from asmc_pin._typing import Array
from asmc_pin.baselines import shown_label
from asmc_pin.experiment.law_lookup import load_law
from asmc_pin.experiment.variation.draws import is_finite
from asmc_pin.metrics import METRICS
from asmc_pin.statistics.joint_mean import joint_logs
from asmc_pin.sweeping.sweep_plan import FAILS_AT, VARIED, SweepPlan

SCORED = tuple(name for name, metric in METRICS.items() if metric.main and metric.best == "smallest")
"""Metrics by which controllers are compared."""


class TrialScores:
    """Figures of a sweep; `add` is given the rows block by block.

    The figure of a trial is the `joint_mean`. A run that failed has +∞.

    Attributes:
        labels: Controllers as the rows show them.
        scores: Metric -> label -> (draws, points of the grids).
        fails_at: Scanned key -> label -> (draws,); of a key of one controller that one's alone.
        kinds: Of the joints that there are, ``"revolute"`` and ``"prismatic"``.
        drawn: Random key that is one number -> (draws,).
    """

    def __init__(self, plan: SweepPlan) -> None:
        self._plan = plan
        experiment, variation = plan.experiment, plan.variation
        laws = {label: load_law(str(t["law"]), plan.folder) for label, t in experiment.controllers.items()}
        self.labels = [shown_label(label, law) for label, law in laws.items()]
        shape = plan.draws, variation.grid_points
        self.scores = {name: {label: np.full(shape, np.nan) for label in self.labels} for name in SCORED}
        shown = dict(zip(laws, self.labels, strict=True))
        self.fails_at = {
            axis.path: {shown[label]: np.full(plan.draws, np.nan) for label in laws if axis.concerns(label)}
            for axis in variation.scans
        }
        self.drawn: dict[str, Array] = {
            axis.path: np.full(plan.draws, np.nan) for axis in variation.axes if axis.draw is not None
        }
        self.kinds: set[str] = set()
        self._listed: set[str] = set()

    def add(self, rows: pa.Table) -> None:
        """Take in the rows of some trials, all joints of each."""
        self.kinds |= {
            "prismatic" if kind == "prismatic" else "revolute" for kind in rows["joint_kind"].unique().to_pylist()
        }
        names = ["trial", "draw", "point", "controller", "status", *SCORED]
        column: dict[str, Any] = {name: rows[name].to_numpy(zero_copy_only=False) for name in names}
        changes = (np.diff(column["trial"]) != 0) | (column["controller"][1:] != column["controller"][:-1])
        starts = np.concatenate([[0], np.flatnonzero(changes) + 1])
        counts = np.diff(np.append(starts, rows.num_rows))
        draw, point, label, status = (column[name][starts] for name in ("draw", "point", "controller", "status"))
        grid = point < self._plan.variation.grid_points
        for name in SCORED:
            mean = np.exp(np.add.reduceat(joint_logs(column[name], METRICS[name].least), starts) / counts)
            mean[(status != "ok") | np.isnan(mean)] = np.inf
            for one in self.labels:
                here = grid & (label == one)
                self.scores[name][one][draw[here], point[here]] = mean[here]
        for k, axis in enumerate(self._plan.variation.scans):
            failing = rows[FAILS_AT].to_numpy(zero_copy_only=False)[starts]
            for one in self.fails_at[axis.path]:
                here = (point == self._plan.variation.grid_points + k) & (label == one)
                self.fails_at[axis.path][one][draw[here]] = failing[here]
        for path, values in self.drawn.items():
            told = rows[f"{VARIED}{path}"].to_numpy(zero_copy_only=False)
            values[draw] = told[starts]
            if np.any(told != np.repeat(told[starts], counts)):
                self._listed.add(path)  # one for each joint is not one number

    @property
    def alike(self) -> bool:
        """Whether no draw differs from the first."""
        every = [x for by in (self.scores | self.fails_at).values() for x in by.values()]
        return all(np.array_equal(x, np.broadcast_to(x[:1], x.shape), equal_nan=True) for x in every)

    @property
    def single(self) -> dict[str, Array]:
        """Of `drawn`, what was one number in every trial."""
        return {path: x for path, x in self.drawn.items() if path not in self._listed and np.isfinite(x).all()}

    def points(self) -> list[str]:
        """What the grids stand at, in words, point by point."""
        variation = self._plan.variation
        grids = [axis for axis in variation.axes if axis.values]
        told = []
        for point in range(variation.grid_points):
            at = variation.quantities(point)
            told.append(", ".join(f"{'×' if a.factor else ''}{_word(at[a.path])} {a.path}" for a in grids))
        return told


def _word(value: Any) -> str:
    return f"{value:g}" if is_finite(value) else value if isinstance(value, str) else f"{str(value)[:40]}"
