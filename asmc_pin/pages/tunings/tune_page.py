"""``summary.md`` and ``report.html`` of a tuning. Nothing in them depends on when or where they were made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from asmc_pin.pages.plates import Plate
from asmc_pin.pages.tables.findings_page import FindingsPage, Section, experiment_details, experiment_lines
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


def tune_title(findings: TuneFindings) -> str:
    """What was tuned."""
    return f"{findings.experiment.name}: {', '.join(item.shown for item in findings.controllers)}, tuned"


def _facts(findings: TuneFindings) -> Iterator[str]:
    yield from experiment_lines(findings.experiment)
    yield from result_lines(findings)


def _sections(findings: TuneFindings) -> list[Section]:
    found = [Section("Held out", HOW_JUDGED, [result_table(findings)])]
    if findings.comparisons:
        found.append(Section("Who is better", HOW_COMPARED, [pair_rows(findings)]))
    return [*found, Section("Gains", HOW_GAINS, [gains_table(findings)])]


def page_of_tuning(findings: TuneFindings, plates: Sequence[Plate]) -> FindingsPage:
    """The page of a tuning, with its figures."""
    return FindingsPage(
        title=tune_title(findings),
        facts=list(_facts(findings)),
        sections=_sections(findings),
        plates=plates,
        colours=controller_colors([item.shown for item in findings.controllers]),
        appendix=experiment_details("The experiment as tuned", findings.experiment.to_toml()),
    )
