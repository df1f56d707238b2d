"""``summary.md`` and ``report.html`` of a sweep. Nothing in them depends on when or where they were made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.experiment.toml_text import toml_value
from asmc_pin.pages.html_fragments import details, table_html
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.sweeps.sweep_figures import sweep_plates
from asmc_pin.pages.sweeps.sweep_findings import SweepFindings
from asmc_pin.pages.sweeps.sweep_tables import (
    HOW_COMPARED,
    HOW_SCANNED,
    HOW_SCORED,
    comparison_table,
    distribution_table,
    failure_lines,
    scan_table,
    shown_points,
    verdict_lines,
)
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_html, for_markdown

_Section = tuple[str, str, list[Table]]


def sweep_title(findings: SweepFindings) -> str:
    """What was swept, and how much."""
    points = len(findings.points)
    grid = f" at {points} points" if points > 1 else ""
    return f"{findings.experiment.name}: {', '.join(findings.labels)} in {findings.draws} draws{grid}"


def _facts(findings: SweepFindings) -> Iterator[str]:
    experiment = findings.experiment
    yield (
        f"{experiment.duration:g} s on {experiment.arm.source}, control period {1e3 * experiment.period:g} ms, "
        f"seed {experiment.seed}"
    )
    for axis, given in experiment.sweep.items():
        yield f"varies: {toml_value(axis)} = {toml_value(given)}"
    yield from verdict_lines(findings)
    yield from failure_lines(findings)


def _sections(findings: SweepFindings) -> list[_Section]:
    points = list(shown_points(findings))
    found = [("Distributions", HOW_SCORED, [distribution_table(findings, point) for point in (None, *points)])]
    if findings.fails_at:
        found.append(("Where it fails", HOW_SCANNED, [scan_table(findings, path) for path in findings.fails_at]))
    if findings.comparisons:
        found.append(("Who is better", HOW_COMPARED, [comparison_table(findings, point) for point in (None, *points)]))
    return found


def sweep_markdown(findings: SweepFindings, plates: Sequence[Plate], figures: str) -> str:
    """The page as Markdown.

    Args:
        findings: The sweep's.
        plates: Its figures.
        figures: What stands before the name of a figure's PNG file, from the page's own folder.
    """
    lines = [f"# {for_markdown(sweep_title(findings))}", ""]
    lines += [f"- {for_markdown(line)}" for line in _facts(findings)]
    for title, how, tables in _sections(findings):
        lines += ["", f"## {title}", "", for_markdown(how)]
        for table in tables:
            lines += ["", f"{for_markdown(table.title or 'one point')}:", "", markdown_table(table)]
    for plate in plates:
        caption = for_markdown(plate.caption)
        lines += ["", f"![{caption}](<{figures}{plate.name}.png>)", "", f"*{caption}*"]
    return "\n".join(lines) + "\n"


def write_sweep_page(findings: SweepFindings, path: str | Path) -> None:
    """Write the page elsewhere than into the sweep's folder.

    Args:
        findings: The sweep's.
        path: Ends in ``.html`` (one file) or in ``.md`` (figures as PNG files beside it).

    Raises:
        ParameterError: another suffix.
        ResultError: the file cannot be written.
    """
    path = Path(path)
    plates = list(sweep_plates(findings))
    if is_html(path):
        write_whole(path, sweep_html(findings, plates))
        return
    write_beside(path, plates)
    write_whole(path, sweep_markdown(findings, plates, f"{path.stem}_"))


def sweep_html(findings: SweepFindings, plates: Sequence[Plate]) -> str:
    """The page as one HTML file that opens offline."""
    colours = controller_colors(findings.labels)
    title = sweep_title(findings)
    body = [f"<h1>{for_html(title)}</h1>", "<ul>", *(f"<li>{for_html(x)}</li>" for x in _facts(findings)), "</ul>"]
    for heading, how, tables in _sections(findings):
        body += [f"<h2>{heading}</h2>", f'<p class="soft">{for_html(how)}</p>']
        for table in tables:
            name = for_html(table.title or "one point")
            body += [f"<h3>{name}</h3>", f'<div class="scroll" tabindex="0">{table_html(table, colours)}</div>']
    body += ["<h2>Figures</h2>", *(plate.html() for plate in plates)]
    body.append(details("The experiment as run", f"<pre>{for_html(findings.experiment.to_toml().strip())}</pre>"))
    return framed(title, body, player=False)
