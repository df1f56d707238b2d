"""The page of a benchmark, as Markdown and as HTML. Nothing in it depends on when or where it was made."""

from __future__ import annotations

from collections.abc import Sequence

from asmc_pin.pages.benches.bench_findings import BenchFindings
from asmc_pin.pages.benches.bench_tables import (
    HOW_FAILED,
    HOW_MEANT,
    HOW_PAIRED,
    HOW_RANKED,
    bench_lines,
    mean_table,
    pair_table_of,
    problem_table,
    rank_table,
)
from asmc_pin.pages.plates import Plate
from asmc_pin.pages.tables.findings_page import FindingsPage, Section


def bench_title(findings: BenchFindings) -> str:
    """What was run."""
    part = "a part of " if findings.scope else ""
    return f"{part}{findings.suite}: {len(findings.laws)} laws on {len(findings.problems)} problems"


def _sections(findings: BenchFindings) -> list[Section]:
    found = [Section("Ranks", HOW_RANKED, [rank_table(findings)])]
    found.append(Section("Means over arms and tasks", HOW_MEANT, [mean_table(findings)]))
    found.append(Section("Law by law, problem by problem", HOW_FAILED, [problem_table(findings)]))
    if findings.proposed in findings.laws and len(findings.laws) > 1:
        found.append(Section("The proposed law", HOW_PAIRED, [pair_table_of(findings, findings.proposed)]))
    return found


def page_of_bench(findings: BenchFindings, plates: Sequence[Plate]) -> FindingsPage:
    """The page of a benchmark, with its figures."""
    return FindingsPage(bench_title(findings), bench_lines(findings), _sections(findings), plates)
