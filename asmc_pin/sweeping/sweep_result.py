"""What `sweep` hands back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin.pages.sweeps.sweep_findings import SweepFindings
from asmc_pin.pages.sweeps.sweep_page import sweep_title
from asmc_pin.pages.sweeps.sweep_tables import distribution_table, failure_lines, scan_lines, verdict_lines
from asmc_pin.words.shown import Cells, Shown


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Shown):
    """A complete sweep, and where it lies.

    Attributes:
        out: Its folder.
        trials: Number of trials, each with every controller.
        findings: Its figures, and how the controllers compare.
    """

    out: Path
    trials: int
    findings: SweepFindings

    def lines(self) -> list[str]:
        """What was swept, who is better, who failed, and where."""
        found = self.findings
        return [sweep_title(found), *verdict_lines(found), *failure_lines(found), *scan_lines(found)]

    def table(self) -> Cells:
        """Median and quantiles of every controller over all trials."""
        table = distribution_table(self.findings, None)
        return table.header, table.rows

    @property
    def hardest(self) -> int:
        """Number of the trial, of those at the grids, in which any controller's first metric is largest or failed."""
        metric = next(iter(self.findings.scores.values()))
        worst = np.max([np.where(np.isnan(scores), np.inf, scores) for scores in metric.values()], axis=0)
        draw, point = np.unravel_index(int(np.argmax(worst)), worst.shape)
        return int(draw) * (self.trials // self.findings.draws) + int(point)

    def remarks(self) -> list[str]:
        """Where the rest lies."""
        return [f"report: {self.out / 'report.html'}", f"one trial again: --replay TRIAL, 0 to {self.trials - 1}"]

    def to_json_dict(self) -> dict[str, Any]:
        """What ``sweep --json`` prints: valid JSON, null for a figure that is infinite."""
        overall = [item for item in self.findings.comparisons if item.point is None]
        return {
            "out": str(self.out),
            "trials": self.trials,
            "draws": self.findings.draws,
            "failed": dict(self.findings.failed),
            "comparisons": [item.paired.to_json_dict() for item in overall],
        }
