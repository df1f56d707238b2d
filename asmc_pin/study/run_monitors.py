"""The paper's theorems on every run of a comparison: what is kept of their monitors, and where it goes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from asmc_pin.controllers import Controller
from asmc_pin.engine import Rollout
from asmc_pin.monitors import CAUSES, claim_rows, monitor, monitor_dataset
from asmc_pin.pages.theorem_figures import draw_theorems
from asmc_pin.plant import Plant
from asmc_pin.results import result_folder, result_writing
from asmc_pin.results.kept_ticks import kept_ticks


@dataclass(frozen=True)
class Theorems:
    """What the monitors found about the paper's theorems.

    Attributes:
        claims: See `asmc_pin.monitors.claim_rows`.
        dataset: See `asmc_pin.monitors.monitor_dataset`.
    """

    claims: pd.DataFrame
    dataset: xr.Dataset

    def write(self, folder: Path, log_every: int = 1) -> None:
        """Rows, and of the arrays one tick in so many, into a result's folder."""
        result_writing.write_summary(self.claims, folder / result_folder.CLAIMS)
        result_writing.write_trajectories(kept_ticks(self.dataset, log_every), folder / result_folder.MONITORS)

    def draw(self, folder: Path) -> None:
        """The figure, into a folder of figures."""
        draw_theorems(self.dataset, folder)

    def of_first_trial(self, controller: str) -> dict[str, Any]:
        """The verdicts on one controller, for JSON; figures that are not defined are None."""
        rows = self.claims[(self.claims.controller == controller) & (self.claims.trial == self.claims.trial.iloc[0])]
        return {
            str(row["claim"]): {
                "status": row["status"],
                "checked": int(row["checked"]),
                "broken": int(row["broken"]),
                **{name: _number(row[name]) for name in ("first_time", "worst_time", "amount", "until")},
                "unit": row["unit"],
                "causes": {cause: int(row[cause]) for cause in CAUSES if row[cause]},
                "reason": row["reason"],
            }
            for row in rows.to_dict("records")
        }


def judge_theorems(
    plant: Plant, runs: Mapping[str, Rollout], laws: Mapping[str, Controller], shown: Mapping[str, str]
) -> Theorems:
    """Hold every run against the theorems.

    Args:
        plant: What the runs ran on.
        runs: By label.
        laws: By label.
        shown: Label as results show it, by label.
    """
    found = {shown[label]: monitor(run, plant, laws[label]) for label, run in runs.items()}
    return Theorems(claim_rows(found), monitor_dataset(found))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
