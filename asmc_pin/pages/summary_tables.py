"""The summary as tables: for a terminal, Markdown and LaTeX."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from asmc_pin._typing import Array
from asmc_pin.metrics import METRICS, MOVED, Best, Metric
from asmc_pin.words.media import for_cell, for_markdown

NOTHING = "–"

NOTABLE = 0.02
"""A figure that half the step moves by more than this part of itself says so where it stands, and in a warning."""

UNCONVERGED = (
    "(± %): half the step moves the figure by so much, so it is not converged; a column is not marked where such a "
    "figure would be the best."
)
"""For the words beside a table."""

TOOL = {
    "tool_rms_position": ("RMS [mm]", 1e3),
    "tool_max_position": ("maximum [mm]", 1e3),
    "tool_rms_rotation": ("RMS [rad]", 1.0),
    "tool_max_rotation": ("maximum [rad]", 1.0),
}
"""Columns of the summary about the tool, m and rad, where the experiment names one: header, and factor to its unit."""


class Table(NamedTuple):
    """A table of text.

    Attributes:
        title: What it shows, with the unit where one fits all.
        header: Column names.
        rows: Cells.
        best: Which figure of a column is the best, if any, for the first so many columns.
    """

    title: str
    header: list[str]
    rows: list[list[str]]
    best: Sequence[Best] = ()

    def marked(self) -> set[tuple[int, int]]:
        """Row and column of every cell that is the best of its column; none where there is nothing to compare.

        Figures that are printed alike are equally good. One that is not converged is not called the best.
        """
        found = set()
        for column, best in enumerate(self.best):
            values = [_figure(row[column]) for row in self.rows]
            known = [value for value in values if value is not None]
            if best is None or not known:
                continue
            target = min(known) if best == "smallest" else max(known)
            sure = all("±" not in row[column] for row, value in zip(self.rows, values, strict=True) if value == target)
            if sure and values.count(target) < len(values):
                found |= {(row, column) for row, value in enumerate(values) if value == target}
        return found


def _figure(cell: str) -> float | None:
    """The figure that a cell shows; None if it shows none."""
    found = re.fullmatch(r"([0-9.e+-]+)( \(±[^)]*\))?", cell)
    return None if found is None else float(found[1])


def _told(value: float, moved: float) -> str:
    """A figure, and by what part of itself half the step moves it, if that is notable."""
    return number(value) + (f" (±{100.0 * abs(moved):.2g} %)" if abs(moved) > NOTABLE else "")


def number(value: float, digits: int = 3) -> str:
    """A figure with `digits` significant digits, without an exponent where none is needed; a dash for NaN."""
    if math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    size = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -5 < size < 6:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(0, digits - 1 - size)}f}"


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
    """One metric, or how half the step moves it, as controllers × joints, in the units that a person reads.

    Returns:
        Row labels, the unit of each joint, and the values, shape (rows, nv).
    """
    metric = METRICS[name.removeprefix(MOVED)]
    first = summary[(summary.controller == summary.controller.iloc[0]) & (summary.trial == summary.trial.iloc[0])]
    units = [display_unit(metric, kind) if name in METRICS else (1.0, "") for kind in first.joint_kind]
    several = summary.trial.nunique() > 1
    labels, values = [], []
    for (label, trial), rows in summary.groupby(["controller", "trial"], sort=False):
        labels.append(f"{label}, trial {trial}" if several else str(label))
        values.append(rows[name].to_numpy() * [factor for factor, _ in units])
    return labels, [unit for _, unit in units], np.array(values)


def metric_table(summary: pd.DataFrame, name: str) -> Table:
    """One metric, a row for each controller and a column for each joint."""
    labels, units, values = per_joint(summary, name)
    joints = short_names(list(dict.fromkeys(summary.joint)))
    same = len(set(units)) == 1
    title = METRICS[name].title + (f" [{units[0]}]" if same and units[0] != "1" else "")
    header = joints if same else [f"{joint} [{unit}]" for joint, unit in zip(joints, units, strict=True)]
    moved = moves(summary, name, values)
    rows = [
        [label, *map(_told, line, moves)] for label, line, moves in zip(labels, values.tolist(), moved, strict=True)
    ]
    return Table(title, ["controller", *header], rows, [None, *[METRICS[name].best] * len(header)])


def moves(summary: pd.DataFrame, name: str, values: Array) -> Array:
    """How half the step moves each figure of `per_joint`, relative to the finer one; NaN where that is not known."""
    return per_joint(summary, MOVED + name)[2] if MOVED + name in summary else np.full(values.shape, np.nan)


def overview(summary: pd.DataFrame) -> Table:
    """The table for a terminal: RMS error of each joint, the worst error, and how much the torque chatters."""
    base = metric_table(summary, "rms_error")
    _, units, worst = per_joint(summary, "max_error")
    _, force_units, variation = per_joint(summary, "torque_variation")
    header = ["controller", *base.header[1:]]
    rows, best = [list(row) for row in base.rows], list(base.best)
    if len(set(units)) == 1:
        header.append(f"worst error [{units[0]}]")
        best.append(METRICS["max_error"].best)
        _extend(rows, figures_of_all(worst, moves(summary, "max_error", worst), np.max))
    if len(set(force_units)) == 1:
        header.append(f"chatter [{force_units[0]}]")
        best.append(METRICS["torque_variation"].best)
        _extend(rows, figures_of_all(variation, moves(summary, "torque_variation", variation), np.sum))
    states = summary.groupby(["controller", "trial"], sort=False)[["status", "end_time"]].first()
    if (states.status != "ok").any():
        header.append("status")
        for row, (status, end) in zip(rows, states.to_numpy(), strict=True):
            row.append(status if status == "ok" else f"{status} at {end:.3g} s")
    return Table(base.title, header, rows, best)


def tool_table(summary: pd.DataFrame) -> Table | None:
    """Error of the tool frame, a row for each controller; None if the experiment names none."""
    if "tool" not in summary:
        return None
    several = summary.trial.nunique() > 1
    lines = []
    for (label, trial), rows in summary.groupby(["controller", "trial"], sort=False):
        figures = [number(factor * float(rows[name].iloc[0])) for name, (_, factor) in TOOL.items()]
        lines.append([f"{label}, trial {trial}" if several else str(label), *figures])
    header = ["controller", *(text for text, _ in TOOL.values())]
    smallest: Best = "smallest"  # all of them are errors
    best = [None, *[smallest] * len(TOOL)]
    return Table(f"Tool-centre error of {summary.tool.iloc[0]}", header, lines, best)


def figures_of_all(values: Array, moved: Array, whole: Callable[..., Array]) -> list[str]:
    """One figure for all joints, and by what part of itself half the step moves it.

    Args:
        values: Figures of the joints, 0 or more, shape (rows, nv).
        moved: See `moves`.
        whole: What makes one of them along an axis, such as `numpy.max`.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # a figure of 0 that half the step moves
        now, finer = whole(values, axis=1), whole(values / (1.0 - moved), axis=1)
    change = np.divide(finer - now, finer, out=np.full(finer.shape, np.nan), where=finer > 0.0)
    return [_told(value, part) for value, part in zip(now.tolist(), change.tolist(), strict=True)]


def _extend(rows: list[list[str]], cells: list[str]) -> None:
    for row, cell in zip(rows, cells, strict=True):
        row.append(cell)


def markdown_table(table: Table) -> str:
    """A Markdown table; the best figure of each column in bold."""
    rows = [[for_cell(cell) for cell in row] for row in table.rows]
    for row, column in table.marked():
        rows[row][column] = f"**{rows[row][column]}**"
    header = [for_cell(cell) for cell in table.header]
    lines = [header, ["---"] + ["---:"] * (len(header) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


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
