"""How far the figures of a comparison move when the step of the integration is halved."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from asmc_pin.metrics import METRICS, MOVED
from asmc_pin.pages.summary_tables import TOOL
from asmc_pin.pages.tables.text_table import NOTABLE, Table
from asmc_pin.results.ensemble_summary import failures, figures_by_trial
from asmc_pin.statistics.order_statistics import spread_of

_JUDGED = [name for name, metric in METRICS.items() if metric.main and metric.best]


@dataclass(frozen=True)
class Refinement:
    """The same run with steps of half the length.

    Attributes:
        substeps: Steps in a control period, as run.
        moved: One row for each controller and joint, columns as of the summary; each metric is how far its median over
            the trials moved, refined less as run, in its unit.
        relative: The same as a part of the refined figure's magnitude; NaN where that is not defined or 0.
        finer: The refined medians.
    """

    substeps: int
    moved: pd.DataFrame
    relative: pd.DataFrame
    finer: pd.DataFrame

    def worst(self, controller: str, metric: str) -> float:
        """Largest relative move of a metric of a controller over its joints; NaN if none is defined."""
        values = np.abs(self.relative.loc[self.relative.controller == controller, metric].to_numpy())
        values = values[np.isfinite(values)]
        return float(values.max()) if values.size else math.nan

    def notes(self) -> list[str]:
        """How far the metrics that laws are judged by move, a line for each controller."""
        lines = []
        for controller in self.relative.controller.unique():
            moves = ((METRICS[name].title, self.worst(controller, name)) for name in _JUDGED)
            told = [f"{title} by {100 * x:.2g} %" for title, x in moves if math.isfinite(x)]
            if told:
                lines.append(f"half the step moves, at most of all joints ({controller}): {', '.join(told)}")
        return lines

    def warnings(self) -> list[str]:
        """Figures that are artefacts of the step, and rankings that turn round with it."""
        lines = []
        for controller in self.relative.controller.unique():
            moving = {name: self.worst(controller, name) for name in _JUDGED}
            told = [f"{METRICS[name].title} by {100 * x:.2g} %" for name, x in moving.items() if x > NOTABLE]
            if told:
                lines.append(
                    f"{controller}: half the step moves {', '.join(told)}; take more than {self.substeps} substeps"
                )
        changed = self.moved.controller[self.moved.failed != self.finer.failed].unique()
        lines += [f"{name}: half the step changes whether it diverges; take more substeps" for name in changed]
        return lines + self._turned()

    def _turned(self) -> list[str]:
        coarse = self.finer[["controller", "joint"]].assign(x=self.finer.rms_error - self.moved.rms_error)
        fine = coarse.assign(x=self.finer.rms_error)
        joints = [
            str(joint)
            for joint in self.finer.joint.unique()
            if _ranking(coarse[coarse.joint == joint]) != _ranking(fine[fine.joint == joint])
        ]
        text = f"half the step changes the ranking by RMS tracking error at {', '.join(joints)}; take more substeps"
        return [text] if joints else []

    def columns(self, rows: pd.DataFrame) -> pd.DataFrame:
        """The relative moves as columns for the summary's rows, so that a figure that is not converged says so."""
        moves = self.relative.set_index(["controller", "joint"])[list(METRICS)].add_prefix(MOVED)
        return moves.loc[list(zip(rows.controller, rows.joint, strict=True))].reset_index(drop=True)

    def table(self) -> Table:
        """Largest relative move of every metric, one row for each controller."""
        titles = {name: metric.title for name, metric in METRICS.items()}
        titles |= {name: f"Tool, {text.split(' [')[0]} {name.split('_')[-1]}" for name, (text, _) in TOOL.items()}
        names = [name for name in titles if name in self.relative]
        rows = []
        for controller in self.relative.controller.unique():
            figures = [self.worst(controller, name) for name in names]
            rows.append([str(controller), *("–" if math.isnan(x) else f"{100 * x:.2g} %" for x in figures)])
        title = f"How far the metrics move from {self.substeps} to {2 * self.substeps} substeps"
        return Table(title, ["controller", *(titles[name] for name in names)], rows)

    def of_controller(self, controller: str) -> dict[str, list[float | None]]:
        """Relative moves of a controller by metric, one for each joint; null where not defined."""
        rows = self.relative[self.relative.controller == controller]
        return {name: [float(x) if math.isfinite(x) else None for x in rows[name]] for name in METRICS}


def refinement(rows: pd.DataFrame, finer: pd.DataFrame, substeps: int) -> Refinement:
    """Compare the summary of a run with that of the same run at half the step.

    Args:
        rows: As run.
        finer: With twice the substeps; the same controllers, trials and joints in the same order.
        substeps: Steps in a control period, as run.
    """
    rows, finer = _medians(rows), _medians(finer)
    moved, relative = rows.copy(), rows.copy()
    for name in (*METRICS, *(name for name in TOOL if name in rows)):
        difference = finer[name].to_numpy() - rows[name].to_numpy()
        size = np.abs(finer[name].to_numpy())
        moved[name] = difference
        relative[name] = np.divide(difference, size, out=np.full(size.shape, np.nan), where=size > 0.0)
        relative.loc[(difference == 0.0) & (size == 0.0), name] = 0.0
    return Refinement(substeps, moved, relative, finer)


def _medians(rows: pd.DataFrame) -> pd.DataFrame:
    """The median over the trials in the place of each figure, one row for each controller and joint; NaN if infinite.

    A single trial may sit beside what it would be with another last digit of its start; the median does so far less.
    """
    first = rows[rows.trial == rows.trial.iloc[0]].reset_index(drop=True)
    failed = failures(rows).sum(axis=1)
    names = [*METRICS, *(name for name in TOOL if name in rows)]
    medians = {name: spread_of(np.moveaxis(figures_by_trial(rows, name), 1, 0)).median.ravel() for name in names}
    told = {name: np.where(np.isfinite(values), values, np.nan) for name, values in medians.items()}
    found: pd.DataFrame = first.assign(**told, failed=np.repeat(failed, rows.joint.nunique()))
    return found


def _ranking(rows: pd.DataFrame) -> list[str]:
    mean = rows.groupby("controller", sort=False).x.mean()
    return [str(name) for name in mean.sort_values(kind="stable").index]
