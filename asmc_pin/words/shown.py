"""How objects show themselves: lines that a person reads, a table, and in a notebook the same as HTML.

Whatever comes from a file is plain text until here: `visible` and `for_html` are applied once, to the whole.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterable, Sequence

from asmc_pin.words.media import for_html
from asmc_pin.words.text import visible

UNDEFINED = "–"
"""What stands in a table where a figure is not defined."""

Cells = tuple[list[str], list[list[str]]]
"""Header and rows of a table of text; a row's first cell names it."""


class Shown:
    """An object that shows itself; the command line prints the same lines."""

    def lines(self) -> list[str]:
        """What it says, a line per finding; the first, or `headline`, is the one to read."""
        raise NotImplementedError

    def headline(self) -> str:
        """The line of `lines` that says most."""
        return self.lines()[0]

    def table(self) -> Cells | None:
        """Figures that belong in a table, under the lines; None for none."""
        return None

    def tables(self) -> list[Cells]:
        """All tables, one under the other."""
        table = self.table()
        return [] if table is None else [table]

    def remarks(self) -> list[str]:
        """What else has to be known, under the tables."""
        return []

    def picture(self) -> str:
        """HTML for a notebook, under the tables; names in it are escaped already."""
        return ""

    def __str__(self) -> str:
        rows = [row for k, table in enumerate(self.tables()) for row in [""] * (k > 0) + aligned(table)]
        return "\n".join(map(visible, [*self.lines(), *rows, *self.remarks()]))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {visible(self.headline())}>"

    def _repr_html_(self) -> str:
        first = self.headline()
        said = [f"<strong>{for_html(line)}</strong>" if line == first else for_html(line) for line in self.lines()]
        parts = [paragraph(said), *map(table_html, self.tables()), self.picture()]
        return "<div>" + "".join([*parts, paragraph(map(for_html, self.remarks()))]) + "</div>"


def figure(value: float, form: str = ".4g") -> str:
    """A number in a table; what is not defined is said by a dash."""
    return UNDEFINED if math.isnan(value) else f"{value:{form}}"


def aligned(table: Cells) -> list[str]:
    """A table as lines of text: names to the left, figures to the right."""
    header, rows = table
    cells = [[visible(cell) for cell in row] for row in (header, *rows)]
    widths = [max(map(_width, column)) for column in zip(*cells, strict=True)]
    lines = []
    for row in cells:
        gaps = [" " * (width - _width(cell)) for width, cell in zip(widths, row, strict=True)]
        rest = (gap + cell for gap, cell in zip(gaps[1:], row[1:], strict=True))
        lines.append("  ".join([row[0] + gaps[0], *rest]).rstrip())
    return lines


def paragraph(lines: Iterable[str]) -> str:
    """Lines of HTML, one under the other; nothing for none."""
    text = "<br>".join(lines)
    return f"<p>{text}</p>" if text else ""


def table_html(table: Cells) -> str:
    """A table of text as HTML."""
    header, rows = table
    head = "".join(f'<th scope="col">{for_html(cell)}</th>' for cell in header)
    body = (
        f'<tr><th scope="row">{for_html(first)}</th>' + "".join(f"<td>{for_html(cell)}</td>" for cell in rest) + "</tr>"
        for first, *rest in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table>"


def sparkline(values: Sequence[float], title: str, *, points: int = 200) -> str:
    """A small curve as inline SVG, from its lowest to its highest value; it breaks where a value is not defined.

    Args:
        values: Equally spaced in time.
        title: What it shows, plain text.
        points: How many of the values are drawn at most.
    """
    kept = list(values[:: max(1, math.ceil(len(values) / points))])
    defined = [value for value in kept if math.isfinite(value)]
    low, high = (min(defined), max(defined)) if defined else (0.0, 0.0)
    path, pen = [], "M"
    for i, value in enumerate(kept):
        if math.isfinite(value):
            height = 0.5 if high == low else (value - low) / (high - low)
            path.append(f"{pen}{160 * i / max(len(kept) - 1, 1):.1f} {30 - 28 * height:.1f}")
        pen = "L" if math.isfinite(value) else "M"
    return (
        f'<svg width="162" height="32" role="img"><title>{for_html(title)}</title>'
        f'<path d="{"".join(path)}" fill="none" stroke="currentColor"/></svg>'
    )


def _width(text: str) -> int:
    """Columns that a line takes in a terminal: marks stand on the letter before them, some letters take two."""
    wide = {"W": 2, "F": 2}
    return sum(0 if unicodedata.combining(c) else wide.get(unicodedata.east_asian_width(c), 1) for c in text)
