"""Pieces of HTML that the report is put together from; whatever comes from a file is escaped here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from asmc_pin.metrics import Metric
from asmc_pin.pages.tables.text_table import Table
from asmc_pin.viewer import controller_colors
from asmc_pin.words.media import for_html


def table_html(table: Table, colours: Mapping[str, str]) -> str:
    """A table whose rows are named by their first cell; the best figure of each column is marked.

    Args:
        table: What it shows.
        colours: Colour of each controller, shown beside its name.
    """
    marked = table.marked()
    head = "".join(f'<th scope="col">{for_html(cell).replace("_", "_<wbr>")}</th>' for cell in table.header)
    rows = []
    for i, line in enumerate(table.rows):
        colour = colours.get(line[0]) or colours.get(line[0].partition(", trial ")[0])
        chip = f'<span class="chip" style="--colour:{colour}"></span>' if colour else ""
        cells = "".join(
            _cell(cell, (i, j) in marked, table.ranges.get((i, j))) for j, cell in enumerate(line[1:], start=1)
        )
        whose = f' data-controller="{for_html(line[0].partition(", trial ")[0])}"' if colour else ""
        rows.append(f'<tr{whose}><th scope="row">{chip}{for_html(line[0])}</th>{cells}</tr>')
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _cell(text: str, best: bool, ends: tuple[str, str] | None) -> str:
    kind = ' class="best"' if best else ' class="over"' if "diverged" in text else ""
    span = f"<small>{for_html(' … '.join(ends))}</small>" if ends else ""
    return f"<td{kind}>{for_html(text)}{span}</td>"


def definitions(metrics: Iterable[Metric]) -> str:
    """A table of metrics: name, unit, formula, source."""
    rows = "".join(
        f'<tr><th scope="row">{for_html(metric.title)}</th><td>{for_html(metric.unit)}</td>'
        f"<td><code>{for_html(metric.formula)}</code></td><td>{for_html(metric.source)}</td></tr>"
        for metric in metrics
    )
    head = "".join(
        f'<th scope="col" class="text">{cell}</th>' for cell in ("Metric", "SI unit", "Definition", "Source")
    )
    return f'<table class="definitions"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'


def definition_list(facts: Sequence[tuple[str, str]]) -> str:
    """Terms and what they are."""
    return "<dl>" + "".join(f"<dt>{for_html(term)}</dt><dd>{for_html(value)}</dd>" for term, value in facts) + "</dl>"


def details(summary: str, content: str) -> str:
    """Something to unfold. The summary is plain text, the content HTML."""
    return f"<details><summary>{for_html(summary)}</summary>{content}</details>"


def scroll(name: str, content: str) -> str:
    """What may be wider than the page, and then scrolls by itself; its name is for who cannot see it.

    Where there is more to the right, ``report.js`` shows the line that says so.
    """
    return (
        f'<div class="scroll-box"><div class="scroll" role="region" aria-label="{for_html(name)}" tabindex="0">'
        f'{content}</div><p class="more" aria-hidden="true">more to the right →</p></div>'
    )


def legend(labels: Sequence[str]) -> str:
    """A button for each controller, which hides it everywhere on the page; see ``report.js``."""
    colours = controller_colors(labels)
    buttons = "".join(
        f'<button type="button" aria-pressed="true" data-label="{for_html(label)}">'
        f'<span class="chip" style="--colour:{colours[label]}"></span>{for_html(label)}</button>'
        for label in labels
    )
    return f'<div class="legend" role="group" aria-label="Controllers shown">{buttons}</div>'
