"""Figures of the joints side by side, as the page of the reproduction prints them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from asmc_pin.pages.tables.text_table import Table, number
from asmc_pin.words.media import for_cell


def text_table(table: Table) -> str:
    """A Markdown table whose cells are prose, not numbers."""
    rows = [[for_cell(cell) for cell in row] for row in (table.header, *table.rows)]
    lines = [rows[0], ["---"] * len(table.header), *rows[1:]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def pair(values: Sequence[float | None], factor: float = 1.0) -> str:
    """Figures of both joints, each times a factor."""
    return " / ".join(number_or_nothing(None if x is None else factor * x) for x in values)


def plain_pair(values: Sequence[float] | None) -> str:
    """What the paper prints of both joints; a dash where it prints nothing."""
    return "–" if values is None else pair(values)


def medians(run: Mapping[str, Any], name: str, factor: float | Sequence[float] = 1.0) -> str:
    """Medians of the joints, each with its 5 % and 95 % where they are printed differently; ∞ where failures reach.

    Args:
        run: What `measure` gave.
        name: Of the figure.
        factor: What it is multiplied by, a number or one for each joint.
    """
    cells = []
    factors = [factor] * len(run[name]) if isinstance(factor, float) else factor
    for middle, low, high, scale in zip(run[name], run[f"{name}_low"], run[f"{name}_high"], factors, strict=True):
        text, below = (number_or_nothing(None if x is None else scale * x) for x in (middle, low))
        above = "∞" if high is None else number(scale * high)
        cells.append(text if middle is None or text == below == above else f"{text} [{below} … {above}]")
    return " / ".join(cells)


def number_or_nothing(value: float | None) -> str:
    """A figure; a dash where there is none."""
    return number(math.nan if value is None else value)
