"""The summary as tables: for a terminal, Markdown and LaTeX."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from asmc_pin._typing import Array
from asmc_pin.metrics import METRICS, MOVED, Best, Metric
from asmc_pin.pages.tables.text_table import NOTHING, Table, Told, markdown_table, table_of, told
from asmc_pin.results.ensemble_summary import alike, ends, failed_words, failures, figures_by_trial, labels_of
from asmc_pin.statistics.order_statistics import spread_of
from asmc_pin.words.media import for_markdown

TOOL = {
    "tool_rms_position": ("RMS [mm]", 1e3),
    "tool_max_position": ("maximum [mm]", 1e3),
    "tool_rms_rotation": ("RMS [rad]", 1.0),
    "tool_max_rotation": ("maximum [rad]", 1.0),
    "tool_path_accuracy": ("path accuracy [mm]", 1e3),
    "tool_path_repeatability": ("path repeatability [mm]", 1e3),
}
"""Columns of the summary about the tool, m and rad, where the experiment names one: header, and factor to its unit."""


def short_names(joints: Sequence[str]) -> list[str]:
    """Joint names without the words that all of them begin or end with (``panda_``, ``_joint``)."""
    words = [name.split("_") for name in joints]
    while len(words) > 1 and min(map(len, words)) > 1 and len({item[-1] for item in words}) == 1:
        words = [item[:-1] for item in words]
    while len(words) > 1 and min(map(len, words)) > 1 and len({item[0] for item in words}) == 1:
        words = [item[1:] for item in words]
    short = ["_".join(item) for item in words]
    told_apart = len(set(short)) == len(short) and not any(name.isdigit() for name in short)
    return short if told_apart else list(joints)


def display_unit(metric: Metric, kind: str) -> tuple[float, str]:
    """Factor from SI, and the unit in which a person reads the metric on a joint of this kind."""
    prismatic = kind == "prismatic"
    if metric.quantity == "position":
        return (1e3, "mm") if prismatic else (180.0 / math.pi, "deg")
    if metric.quantity == "share":
        return 100.0, "%"
    revolute, other = (metric.unit.split(" or ") * 2)[:2]
    return 1.0, other if prismatic else revolute


def per_joint(summary: pd.DataFrame, name: str) -> tuple[list[str], list[str], Array]:
    """One metric for every controller, trial and joint, in the units that a person reads.

    Returns:
        Labels, the unit of each joint, and the values, shape (controllers, trials, nv); +∞ for a failure.
    """
    units = [display_unit(METRICS[name], kind) for kind in _joint_kinds(summary)]
    values = figures_by_trial(summary, name) * np.array([factor for factor, _ in units])
    return labels_of(summary), [unit for _, unit in units], values


def _joint_kinds(summary: pd.DataFrame) -> list[str]:
    return list(summary.joint_kind.iloc[: summary.joint.nunique()])


def metric_table(summary: pd.DataFrame, name: str) -> Table:
    """One metric, a row for each controller and a column for each joint: medians with their ranges."""
    columns, best, header, title = _metric_columns(summary, name)
    return _with_marks(summary, table_of(title, header, labels_of(summary), columns, best))


def _metric_columns(summary: pd.DataFrame, name: str) -> tuple[list[Told], list[Best], list[str], str]:
    _, units, values = per_joint(summary, name)
    joints = short_names(list(dict.fromkeys(summary.joint)))
    same = len(set(units)) == 1
    title = METRICS[name].title + (f" [{units[0]}]" if same and units[0] != "1" else "")
    header = joints if same else [f"{joint} [{unit}]" for joint, unit in zip(joints, units, strict=True)]
    moved, best = moves(summary, name), METRICS[name].best
    counted = METRICS[name].quantity == "count"
    columns = [told(values[:, :, j], moved[:, j], best, counted=counted) for j in range(len(units))]
    return columns, [best] * len(units), ["controller", *header], title


def _with_marks(summary: pd.DataFrame, table: Table) -> Table:
    """Of a single run the smallest figure is marked as it is: there is nothing to be more certain by."""
    return table._replace(certain=None) if alike(summary) else table


def moves(summary: pd.DataFrame, name: str) -> Array:
    """How half the step moves each median of a metric, relative to the finer one; NaN where that is not known.

    Shape (controllers, nv).
    """
    if MOVED + name not in summary:
        return np.full((summary.controller.nunique(), summary.joint.nunique()), np.nan)
    first = summary[summary.trial == summary.trial.iloc[0]]
    return np.asarray(first[MOVED + name].to_numpy(), dtype=np.float64).reshape(-1, summary.joint.nunique())


def overview(summary: pd.DataFrame) -> Table:
    """The table for a terminal: RMS error of each joint, the worst error, how much the torque chatters, any trip."""
    columns, best, header, title = _metric_columns(summary, "rms_error")
    _, units, worst = per_joint(summary, "max_error")
    _, force_units, variation = per_joint(summary, "torque_variation")
    if len(set(units)) == 1:
        header.append(f"worst error [{units[0]}]")
        best.append(METRICS["max_error"].best)
        columns.append(figure_of_all(worst, moves(summary, "max_error"), np.max, best[-1]))
    if len(set(force_units)) == 1:
        header.append(f"chatter [{force_units[0]}]")
        best.append(METRICS["torque_variation"].best)
        columns.append(figure_of_all(variation, moves(summary, "torque_variation"), np.sum, best[-1]))
    _, _, tripped = per_joint(summary, "trip_time")
    if np.isfinite(tripped).any():
        header.append("trips at [s]")
        best.append(None)
        columns.append(figure_of_all(np.where(np.isnan(tripped), np.inf, tripped), moves(summary, "trip_time"), np.min))
    table = _with_marks(summary, table_of(title, header, labels_of(summary), columns, best))
    failed = failures(summary)
    if failed.any():
        states = map(failed_words, failed, ends(summary))
        rows = [[*row, state] for row, state in zip(table.rows, states, strict=True)]
        table = table._replace(header=[*header, "status"], rows=rows)
    return table


def tool_table(summary: pd.DataFrame) -> Table | None:
    """Error of the tool frame, a row for each controller; None if the experiment names none."""
    if "tool" not in summary:
        return None
    smallest: Best = "smallest"  # all of them are errors
    unmoved = np.full(summary.controller.nunique(), np.nan)
    columns, best = [], []
    for name, (_, factor) in TOOL.items():
        # The path is judged over all trials together, so there is nothing to be certain by.
        best.append(None if name.startswith("tool_path") else smallest)
        columns.append(told(factor * figures_by_trial(summary, name)[:, :, 0], unmoved, best[-1]))
    header = ["controller", *(text for text, _ in TOOL.values())]
    title = f"Tool-centre error of {summary.tool.iloc[0]}"
    return _with_marks(summary, table_of(title, header, labels_of(summary), columns, best))


def figure_of_all(values: Array, moved: Array, whole: Callable[..., Array], best: Best = None) -> Told:
    """One figure for all joints, and by what part of itself half the step moves it.

    Args:
        values: Figures of the joints, 0 or more, shape (controllers, trials, nv).
        moved: See `moves`.
        whole: What makes one of them along an axis, such as `numpy.max`.
        best: Which is the best; None where neither is.
    """
    medians = spread_of(np.moveaxis(values, 1, 0)).median
    with np.errstate(divide="ignore", invalid="ignore"):  # a figure of 0 that half the step moves
        now, finer = whole(medians, axis=1), whole(medians / (1.0 - moved), axis=1)
        change = np.divide(finer - now, finer, out=np.full(finer.shape, np.nan), where=finer > 0.0)
    return told(whole(values, axis=2), change, best)


def metric_tables_markdown(summary: pd.DataFrame) -> str:
    """All metrics as Markdown, each with its definition."""
    parts = []
    for name, metric in METRICS.items():
        table = metric_table(summary, name)
        if all(cell == NOTHING for row in table.rows for cell in row[1:]):
            continue
        parts += [f"## {for_markdown(table.title)}", "", f"`{metric.formula}`", ""]
        parts += [markdown_table(table), ""]
    return "\n".join(parts)
