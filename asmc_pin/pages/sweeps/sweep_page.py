"""``summary.md`` and ``report.html`` of a sweep. Nothing in them depends on when or where they were made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from asmc_pin.pages.plates import Plate
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
from asmc_pin.pages.tables.findings_page import FindingsPage, Section, experiment_details, experiment_lines
from asmc_pin.viewer.colours import controller_colors


def sweep_title(findings: SweepFindings) -> str:
    """What was swept, and how much."""
    points = len(findings.points)
    grid = f" at {points} points" if points > 1 else ""
    return f"{findings.experiment.name}: {', '.join(findings.labels)} in {findings.draws} draws{grid}"


def _facts(findings: SweepFindings) -> Iterator[str]:
    yield from experiment_lines(findings.experiment)
    yield from verdict_lines(findings)
    yield from failure_lines(findings)


def _sections(findings: SweepFindings) -> list[Section]:
    points = (None, *shown_points(findings))
    found = [Section("Distributions", HOW_SCORED, [distribution_table(findings, at) for at in points], named=True)]
    if findings.fails_at:
        scans = [scan_table(findings, path) for path in findings.fails_at]
        found.append(Section("Where it fails", HOW_SCANNED, scans, named=True))
    if findings.comparisons:
        pairs = [comparison_table(findings, at) for at in points]
        found.append(Section("Who is better", HOW_COMPARED, pairs, named=True))
    return found


def page_of_sweep(findings: SweepFindings, plates: Sequence[Plate]) -> FindingsPage:
    """The page of a sweep, with its figures."""
    return FindingsPage(
        title=sweep_title(findings),
        facts=list(_facts(findings)),
        sections=_sections(findings),
        plates=plates,
        colours=controller_colors(findings.labels),
        appendix=experiment_details("The experiment as run", findings.experiment.to_toml()),
    )
