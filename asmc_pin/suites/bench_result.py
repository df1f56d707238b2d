"""What `bench` hands back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asmc_pin.pages.benches.bench_findings import BenchFindings
from asmc_pin.pages.benches.bench_page import bench_title
from asmc_pin.pages.benches.bench_tables import bench_lines, rank_table
from asmc_pin.suites.cell_runs import CellResult
from asmc_pin.words.shown import Cells, Shown


@dataclass(frozen=True, eq=False, repr=False)
class Benchmark(Shown):
    """A complete benchmark, and where it lies.

    Attributes:
        out: Its folder.
        findings: Ranks, profiles and comparisons.
        cells: What came of each law on each arm in each task.
    """

    out: Path
    findings: BenchFindings
    cells: Sequence[CellResult]

    def lines(self) -> list[str]:
        """What was run, who is ahead, where the proposed law stands, and who fails where."""
        return [bench_title(self.findings), *bench_lines(self.findings)]

    def table(self) -> Cells:
        """Every law by its mean rank."""
        table = rank_table(self.findings)
        return table.header, table.rows

    def remarks(self) -> list[str]:
        """Where the rest lies."""
        return [f"report: {self.out / 'report.html'}"]

    def to_json_dict(self) -> dict[str, Any]:
        """What ``bench --json`` prints: valid JSON, null for what is infinite."""
        return {"out": str(self.out), **bench_json(self.findings, self.cells)}


def bench_json(findings: BenchFindings, cells: Sequence[CellResult]) -> dict[str, Any]:
    """The findings as valid JSON; null for what is infinite."""
    laws = {}
    for k in findings.order:
        mean = findings.ranks[k]
        laws[findings.laws[k]] = {
            "law": findings.kinds[findings.laws[k]],
            "rank": {"mean": mean.rank, "low": mean.low, "high": mean.high},
            "shifted_mean": _known(findings.means()[k]),
            "shifted_mean_of_task": {task: _known(findings.means(task)[k]) for task in findings.tasks},
            "problems_failed": int(findings.lost[k]),
            "trials_failed": int(findings.failed[k].sum()),
            "trials_over": int(findings.over[k].sum()),
            "figures": {
                f"{arm} {task}": _known(x)
                for (arm, task), x in zip(findings.problems, findings.figures[k], strict=True)
            },
        }
    pairs = [{k: v for k, v in item.to_json_dict().items() if k != "metric"} for item in findings.pairs]
    return {
        "suite": findings.suite,
        "sha256": findings.sha256,
        "part": findings.scope,
        "laws": laws,
        "comparisons": pairs,
        "cells": [cell.to_json_dict() for cell in cells],
    }


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
