"""``summary.md`` and ``report.html`` of a tuning. Nothing in them depends on when or where they were made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.experiment.toml_text import toml_value
from asmc_pin.pages.html_fragments import details, table_html
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.pages.tunings.tune_figures import tune_plates
from asmc_pin.pages.tunings.tune_findings import TuneFindings
from asmc_pin.pages.tunings.tune_tables import (
    HOW_COMPARED,
    HOW_GAINS,
    HOW_JUDGED,
    gains_table,
    pair_rows,
    result_lines,
    result_table,
)
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_html, for_markdown


def tune_title(findings: TuneFindings) -> str:
    """What was tuned."""
    return f"{findings.experiment.name}: {', '.join(item.shown for item in findings.controllers)}, tuned"


def _facts(findings: TuneFindings) -> Iterator[str]:
    experiment = findings.experiment
    yield (
        f"{experiment.duration:g} s on {experiment.arm.source}, control period {1e3 * experiment.period:g} ms, "
        f"seed {experiment.seed}"
    )
    for axis, given in experiment.sweep.items():
        yield f"varies: {toml_value(axis)} = {toml_value(given)}"
    yield from result_lines(findings)


def _sections(findings: TuneFindings) -> list[tuple[str, str, Table]]:
    found = [("Held out", HOW_JUDGED, result_table(findings))]
    if findings.comparisons:
        found.append(("Who is better", HOW_COMPARED, pair_rows(findings)))
    return [*found, ("Gains", HOW_GAINS, gains_table(findings))]


def tune_markdown(findings: TuneFindings, plates: Sequence[Plate], figures: str) -> str:
    """The page as Markdown.

    Args:
        findings: The tuning's.
        plates: Its figures.
        figures: What stands before the name of a figure's PNG file, from the page's own folder.
    """
    lines = [f"# {for_markdown(tune_title(findings))}", ""]
    lines += [f"- {for_markdown(line)}" for line in _facts(findings)]
    for title, how, table in _sections(findings):
        lines += ["", f"## {title}", "", for_markdown(how), "", markdown_table(table)]
    for plate in plates:
        caption = for_markdown(plate.caption)
        lines += ["", f"![{caption}](<{figures}{plate.name}.png>)", "", f"*{caption}*"]
    return "\n".join(lines) + "\n"


def tune_html(findings: TuneFindings, plates: Sequence[Plate]) -> str:
    """The page as one HTML file that opens offline."""
    colours = controller_colors([item.shown for item in findings.controllers])
    title = tune_title(findings)
    body = [f"<h1>{for_html(title)}</h1>", "<ul>", *(f"<li>{for_html(x)}</li>" for x in _facts(findings)), "</ul>"]
    for heading, how, table in _sections(findings):
        body += [f"<h2>{heading}</h2>", f'<p class="soft">{for_html(how)}</p>']
        body.append(f'<div class="scroll" tabindex="0">{table_html(table, colours)}</div>')
    body += ["<h2>Figures</h2>", *(plate.html() for plate in plates)]
    body.append(details("The experiment as tuned", f"<pre>{for_html(findings.experiment.to_toml().strip())}</pre>"))
    return framed(title, body, player=False)


def write_tune_page(findings: TuneFindings, path: str | Path) -> None:
    """Write the page elsewhere than into the tuning's folder.

    Args:
        findings: The tuning's.
        path: Ends in ``.html`` (one file) or in ``.md`` (figures as PNG files beside it).

    Raises:
        ParameterError: another suffix.
        ResultError: the file cannot be written.
    """
    path = Path(path)
    plates = list(tune_plates(findings))
    if is_html(path):
        write_whole(path, tune_html(findings, plates))
        return
    write_beside(path, plates)
    write_whole(path, tune_markdown(findings, plates, f"{path.stem}_"))
