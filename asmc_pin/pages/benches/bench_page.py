"""The page of a benchmark, as Markdown and as HTML. Nothing in it depends on when or where it was made."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.pages.benches.bench_figures import bench_plates
from asmc_pin.pages.benches.bench_findings import BenchFindings
from asmc_pin.pages.benches.bench_tables import (
    HOW_FAILED,
    HOW_PAIRED,
    HOW_RANKED,
    bench_lines,
    pair_table_of,
    problem_table,
    rank_table,
)
from asmc_pin.pages.html_fragments import table_html
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.words.media import for_html, for_markdown


def bench_title(findings: BenchFindings) -> str:
    """What was run."""
    part = "a part of " if findings.scope else ""
    return f"{part}{findings.suite}: {len(findings.laws)} laws on {len(findings.problems)} problems"


def _sections(findings: BenchFindings) -> list[tuple[str, str, Table]]:
    found = [("Ranks", HOW_RANKED, rank_table(findings))]
    found.append(("Law by law, problem by problem", HOW_FAILED, problem_table(findings)))
    if findings.proposed in findings.laws and len(findings.laws) > 1:
        found.append(("The proposed law", HOW_PAIRED, pair_table_of(findings, findings.proposed)))
    return found


def bench_markdown(findings: BenchFindings, plates: Sequence[Plate], figures: str) -> str:
    """The page as Markdown.

    Args:
        findings: The benchmark's.
        plates: Its figures.
        figures: What stands before the name of a figure's PNG file, from the page's own folder.
    """
    lines = [f"# {for_markdown(bench_title(findings))}", ""]
    lines += [f"- {for_markdown(line)}" for line in bench_lines(findings)]
    for title, how, table in _sections(findings):
        lines += ["", f"## {title}", "", for_markdown(how), "", markdown_table(table)]
    for plate in plates:
        caption = for_markdown(plate.caption)
        lines += ["", f"![{caption}](<{figures}{plate.name}.png>)", "", f"*{caption}*"]
    return "\n".join(lines) + "\n"


def bench_html(findings: BenchFindings, plates: Sequence[Plate]) -> str:
    """The page as one HTML file that opens offline."""
    title = bench_title(findings)
    body = [f"<h1>{for_html(title)}</h1>", "<ul>", *(f"<li>{for_html(x)}</li>" for x in bench_lines(findings)), "</ul>"]
    for heading, how, table in _sections(findings):
        body += [f"<h2>{heading}</h2>", f'<p class="soft">{for_html(how)}</p>']
        body.append(f'<div class="scroll" tabindex="0">{table_html(table, {})}</div>')
    return framed(title, [*body, "<h2>Figures</h2>", *(plate.html() for plate in plates)], player=False)


def write_bench_page(findings: BenchFindings, path: str | Path) -> None:
    """Write the page elsewhere than into the benchmark's folder.

    Args:
        findings: The benchmark's.
        path: Ends in ``.html`` (one file) or in ``.md`` (figures as PNG files beside it).

    Raises:
        ParameterError: another suffix.
        ResultError: the file cannot be written.
    """
    path = Path(path)
    plates = list(bench_plates(findings))
    if is_html(path):
        write_whole(path, bench_html(findings, plates))
        return
    write_beside(path, plates)
    write_whole(path, bench_markdown(findings, plates, f"{path.stem}_"))
