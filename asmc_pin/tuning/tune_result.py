"""What `tune` hands back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.experiment import Experiment
from asmc_pin.pages.tunings.tune_findings import TunedController, TuneFindings
from asmc_pin.pages.tunings.tune_page import tune_title
from asmc_pin.pages.tunings.tune_tables import result_lines, result_table
from asmc_pin.statistics.order_statistics import spread_of
from asmc_pin.words.shown import Cells, Shown


@dataclass(frozen=True, eq=False, repr=False)
class Tuned(Shown):
    """A complete tuning, and where it lies.

    Attributes:
        out: Its folder; None where nothing was written.
        path: The experiment with the best gains, which `asmc-pin compare` runs.
        experiment: The same, checked.
        findings: What was tried, and how the best did.
    """

    out: Path
    path: Path
    experiment: Experiment
    findings: TuneFindings

    def lines(self) -> list[str]:
        """What was tuned, and what has to be said of each controller."""
        return [tune_title(self.findings), *result_lines(self.findings)]

    def table(self) -> Cells:
        """How every controller did, in training and held out."""
        table = result_table(self.findings)
        return table.header, table.rows

    def remarks(self) -> list[str]:
        """Where the rest lies."""
        return [f"tuned experiment: {self.path}", f"report: {self.out / 'report.html'}"]

    def to_json_dict(self) -> dict[str, Any]:
        """What ``tune --json`` prints: valid JSON, null for a figure that is infinite."""
        return {"out": str(self.out), "experiment": str(self.path), **findings_json(self.findings)}


def findings_json(findings: TuneFindings) -> dict[str, Any]:
    """The findings as valid JSON; null for a figure that is infinite."""
    return {
        "objective": findings.objective,
        "budget": findings.budget,
        "seed": findings.experiment.seed,
        "controllers": {item.label: _controller(item) for item in findings.controllers},
        "comparisons": [item.to_json_dict() for item in findings.comparisons],
    }


def _controller(item: TunedController) -> dict[str, Any]:
    return {
        "law": item.law,
        "parameters": dict(item.setting),
        "trials": item.trials,
        "train": _known(item.errors[item.winner]),
        "held_out": _middle(item.held_out),
        "file": {
            "train": _known(item.errors[0]),
            "held_out": _middle(item.held_out_start),
            "within_limits": bool(item.within[0]),
            "over": item.over_start,
        },
        "within_limits": item.keeps_limits,
        "failed": item.failed,
        "over": item.over,
        "refused": item.refused,
        "change": {name: _known(getattr(item.change, name)) for name in ("ratio", "low", "high")},
    }


def _middle(figures: Array) -> float | None:
    return _known(np.asarray(spread_of(figures).median))


def _known(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None
