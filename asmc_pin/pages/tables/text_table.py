"""Tables of text: figures with their ranges, which of them is the best, and the same as Markdown."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from asmc_pin._typing import Array
from asmc_pin.metrics import Best
from asmc_pin.statistics.order_statistics import spread_of
from asmc_pin.statistics.pairwise import best_of
from asmc_pin.words.media import for_cell

NOTHING = "–"

NOTABLE = 0.02
"""A figure that half the step moves by more than this part of itself says so where it stands, and in a warning."""

UNCONVERGED = (
    "(± %): half the step moves the figure by so much, so it is not converged; a column is not marked where such a "
    "figure would be the best."
)
"""For the words beside a table."""


class Table(NamedTuple):
    """A table of text.

    Attributes:
        title: What it shows, with the unit where one fits all.
        header: Column names.
        rows: Cells.
        best: Which figure of a column is the best, if any, for the first so many columns.
        ranges: By row and column of a figure over several trials, its 5 % and 95 % quantile.
        certain: Row and column of every figure that is the best with certainty; None where nothing is known but the
            figures themselves.
    """

    title: str
    header: list[str]
    rows: list[list[str]]
    best: Sequence[Best] = ()
    ranges: Mapping[tuple[int, int], tuple[str, str]] = MappingProxyType({})
    certain: frozenset[tuple[int, int]] | None = None

    def marked(self) -> set[tuple[int, int]]:
        """Row and column of every cell that is the best of its column; none where there is nothing to compare.

        Of figures over several trials it is what their paired ratios are certain of. Of single ones, those that are
        printed alike are equally good. One that is not converged is not called the best.
        """
        if self.certain is not None:
            return {(row, column) for row, column in self.certain if "±" not in self.rows[row][column]}
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

    def texts(self) -> list[list[str]]:
        """The cells, each with its range behind it in brackets."""
        return [
            [
                f"{cell} [{' … '.join(self.ranges[i, j])}]" if (i, j) in self.ranges else cell
                for j, cell in enumerate(row)
            ]
            for i, row in enumerate(self.rows)
        ]


class Told(NamedTuple):
    """One figure of every controller, as text.

    Attributes:
        texts: Medians.
        ranges: 5 % and 95 %; None where they are printed like the median, or there is one trial only.
        best: Index of the controller that is the best with certainty.
    """

    texts: list[str]
    ranges: list[tuple[str, str] | None]
    best: int | None


def _figure(cell: str) -> float | None:
    """The figure that a cell shows; None if it shows none."""
    found = re.fullmatch(r"([0-9.e+-]+)( \(±[^)]*\))?", cell)
    return None if found is None else float(found[1])


def told(values: Array, moved: Array, best: Best, *, counted: bool = False) -> Told:
    """One figure of every controller over its trials.

    Args:
        values: Shape (controllers, trials); +∞ for a failure, NaN where the figure is not defined.
        moved: By what part of itself half the step moves each median, shape (controllers,); NaN where not known.
        best: Which is the best.
        counted: Whether it is counted rather than measured.
    """
    spread = spread_of(values.T)
    shown = _count if counted else number
    texts, ranges = [], []
    for median, low, high, part in zip(spread.median, spread.low, spread.high, moved, strict=True):
        text = shown(float(median)) if math.isfinite(median) else NOTHING
        texts.append(text + (f" (±{100.0 * abs(part):.2g} %)" if abs(part) > NOTABLE else ""))
        ends = shown(float(low)), shown(float(high))
        ranges.append(None if math.isnan(median) or set(ends) == {text} or math.isinf(low) else ends)
    certain = best_of(values, best == "largest") if best is not None and values.shape[1] > 1 else None
    return Told(texts, ranges, certain)


def table_of(title: str, header: list[str], labels: list[str], columns: Sequence[Told], best: Sequence[Best]) -> Table:
    """A table of a column for each figure and a row for each controller.

    Args:
        title: Of the table.
        header: Of all columns, that of the labels first.
        labels: Of the rows.
        columns: One for each figure.
        best: Which is the best, for each column.
    """
    rows = [[label, *(column.texts[i] for column in columns)] for i, label in enumerate(labels)]
    ranges = {
        (i, j): ends
        for j, column in enumerate(columns, start=1)
        for i, ends in enumerate(column.ranges)
        if ends is not None
    }
    certain = frozenset((column.best, j) for j, column in enumerate(columns, start=1) if column.best is not None)
    return Table(title, header, rows, [None, *best], ranges, certain)


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


def _count(value: float) -> str:
    """A figure of what is counted: a whole one has no decimals."""
    return f"{value:.0f}" if abs(value) < 1e6 and value == round(value) else number(value)


def markdown_table(table: Table) -> str:
    """A Markdown table; the best figure of each column in bold."""
    rows = [[for_cell(cell) for cell in row] for row in table.rows]
    for row, column in table.marked():
        rows[row][column] = f"**{rows[row][column]}**"
    for (row, column), range_ in table.ranges.items():
        rows[row][column] += f" [{for_cell(' … '.join(range_))}]"
    header = [for_cell(cell) for cell in table.header]
    lines = [header, ["---"] + ["---:"] * (len(header) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
