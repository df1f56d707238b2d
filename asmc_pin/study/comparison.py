"""What `compare` hands back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from asmc_pin.arms import Arm
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.condition.premises import premises_along
from asmc_pin.engine import Rollout
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS, Trip, evaluate
from asmc_pin.pages.summary_tables import overview
from asmc_pin.pages.tables.text_table import Table
from asmc_pin.pages.theorem_tables import theorem_lines
from asmc_pin.plant import moving_arms
from asmc_pin.references import SolvedPath, reference_words
from asmc_pin.results.ensemble_summary import failures, figures_by_trial, paired
from asmc_pin.statistics.order_statistics import spread_of
from asmc_pin.study.notes.comparison_notes import log_lines, phase_lines
from asmc_pin.study.notes.reference_norms import Lemma1Range, lemma1_lines
from asmc_pin.study.notes.sensitivity_notes import limit_lines, sensitivity_lines
from asmc_pin.study.refinement import Refinement
from asmc_pin.study.run_monitors import Theorems
from asmc_pin.study.tool_rows import tool_figures
from asmc_pin.tool_error import ToolError
from asmc_pin.words.shown import Cells, Shown


@dataclass(frozen=True, repr=False)
class Comparison(Shown):
    """Controllers compared on one motion of one arm, and where the result lies.

    Attributes:
        experiment: As run.
        arm: The arm.
        out: Folder of the result.
        rows: One row for each controller, trial and joint; metrics in SI units, NaN where not defined.
        dataset: Trajectories of the first trial, and the bands of all; dimensions controller, trial, time, joint;
            units as attributes.
        warnings: What a user ought to be told, in plain words.
        lemma1: ‖I − M⁻¹M̄‖₂ along the reference, in every phase, for each label whose law has an M̄.
        theorems: The paper's claims, held against the first trial.
        refinement: How far the metrics move with half the step, if that was asked for.
        tool: Error of the tool frame in the first trial by label, if the experiment names one.
        trips: By label, the first limit of the named robot that any trial was beyond; without those that never were.
    """

    experiment: Experiment
    arm: Arm
    out: Path
    rows: pd.DataFrame
    dataset: xr.Dataset
    warnings: tuple[str, ...]
    lemma1: Mapping[str, Lemma1Range]
    theorems: Theorems
    refinement: Refinement | None = None
    tool: Mapping[str, ToolError] = field(default_factory=dict)
    trips: Mapping[str, Trip] = field(default_factory=dict)

    @property
    def notes(self) -> list[str]:
        """What is worth knowing and is no warning."""
        reference = self.experiment.build_reference()
        solved = [str(reference)] if isinstance(reference, SolvedPath) else []
        solved += [f"reference: {line}" for line in reference_words(reference)]
        refined = [] if self.refinement is None else self.refinement.notes()
        moving = moving_arms(self.experiment.build_plant(), self.experiment.period, self.experiment.duration)
        told = phase_lines(moving) + lemma1_lines(self.lemma1)
        told += sensitivity_lines(self.experiment, self.rows) + limit_lines(self.experiment, self.rows)
        told += theorem_lines(self.theorems.claims) + solved + refined
        return told + log_lines(self.experiment.log_every)

    @property
    def about(self) -> Premises:
        """The arm that verdicts are about, with all that is supposed, along the reference."""
        return premises_along(self.arm, self.dataset.q_ref.to_numpy())

    def headline(self) -> str:
        """What was compared, on what."""
        return f"{self.experiment.name}: {len(self.experiment.controllers)} controllers on {self.arm.name}"

    def lines(self) -> list[str]:
        """What was compared, what to be careful about, and what the table shows."""
        return [self.headline(), *(f"warning: {line}" for line in self.warnings), self.overview().title]

    def table(self) -> Cells:
        """The overview."""
        shown = self.overview()
        return shown.header, shown.texts()

    def remarks(self) -> list[str]:
        """What to know about the figures, and where the rest lies."""
        page = self.out / "report.html"
        pages = [f"report: {page}"] if page.is_file() else []
        return [*(f"note: {line}" for line in self.notes), *pages, f"replay: asmc-pin view {self.out}"]

    def overview(self) -> Table:
        """The table that a person reads first."""
        return overview(self.rows)

    def to_json_dict(self) -> dict[str, Any]:
        """What ``compare --json`` prints: valid JSON, null where a figure is not defined.

        Errors are in the `error_units` of their joint, the rest in SI; lists have one value for each joint: the median
        over the trials, and under ``…_low`` and ``…_high`` their 5 % and 95 % quantiles.
        """
        prismatic = [kind == "prismatic" for kind in self.arm.joint_kinds]
        degrees = np.where(prismatic, 1e3, 180.0 / math.pi)
        controllers = {}
        # In the file's order, and under the file's labels: a label as shown may carry a mark.
        for label, (_, rows) in zip(
            self.experiment.controllers, self.rows.groupby("controller", sort=False), strict=True
        ):
            failed = int(failures(rows).sum())
            figures: dict[str, Any] = {
                "law": rows.law.iloc[0],
                "knows_model": bool(rows.knows_model.iloc[0]),
                "status": "diverged" if failed else "ok",
                "failed": failed,
                "end_time": float(rows.end_time.min()),
            }
            for name, metric in METRICS.items():
                spread = spread_of(figures_by_trial(rows, name)[0])
                factor = degrees if metric.quantity == "position" else 1.0
                for end, values in (("", spread.median), ("_low", spread.low), ("_high", spread.high)):
                    figures[name + end] = [float(x) if math.isfinite(x) else None for x in factor * values]
            if label in self.lemma1:
                item = self.lemma1[label]
                figures["lemma1_along_reference"] = [item.lower, item.upper]
                figures["lemma1_verdict"] = item.verdict
                figures["lemma1_hypotheses"] = item.hypotheses.to_json_dict()
                figures["lemma1_parts"] = [part.to_json_dict() for part in item.parts]
            figures["theorems"] = self.theorems.of_first_trial(str(rows.controller.iloc[0]))
            if self.experiment.plant.limits is not None:
                figures["trip"] = self._trip(label)
            if label in self.tool:
                figures["tool"] = tool_figures(rows)
            if self.refinement is not None:
                figures["refinement"] = self.refinement.of_controller(str(rows.controller.iloc[0]))
            controllers[label] = figures
        return {
            "arm": self.arm.name,
            "limits": self.experiment.plant.limits,
            "out": str(self.out),
            "experiment": self.experiment.name,
            "joints": list(self.arm.joint_names),
            "error_units": ["mm" if item else "deg" for item in prismatic],
            "trials": int(self.rows.trial.nunique()),
            "q0_deviation": self.experiment.ensemble.q0_deviation,
            "controllers": controllers,
            "comparisons": [item.to_json_dict() for item in paired(self.rows)],
            "warnings": list(self.warnings),
        }

    def _trip(self, label: str) -> dict[str, Any] | None:
        """What would first have stopped the robot in any trial; null where nothing would."""
        trip = self.trips.get(label)
        return None if trip is None else {**asdict(trip), "joint": self.arm.joint_names[trip.joint]}


def summary_rows(
    experiment: Experiment, arm: Arm, rollouts: Mapping[str, Rollout], shown: Mapping[str, str] | None = None
) -> pd.DataFrame:
    """Tidy rows: one for each controller, trial and joint, with every metric in SI units.

    Args:
        experiment: As run.
        arm: The arm.
        rollouts: By label.
        shown: Label as results show it, by label, where it differs: that of a law that knows the model.
    """
    settings = experiment.metric_settings()
    names = {label: label for label in rollouts} | dict(shown or {})
    parts = []
    for label, run in rollouts.items():
        batch = len(run.status)
        frame = pd.DataFrame(
            {
                "experiment": experiment.name,
                "arm": arm.name,
                "controller": names[label],
                "law": experiment.controllers[label]["law"],
                "knows_model": names[label] != label,
                "trial": np.repeat(np.arange(batch), arm.nv),
                "joint": list(arm.joint_names) * batch,
                "joint_kind": list(arm.joint_kinds) * batch,
                "status": np.repeat(np.array(run.status, dtype=object), arm.nv),
                "end_time": np.repeat(run.end_time, arm.nv),
            }
        )
        for name, values in evaluate(run, settings).items():
            frame[name] = values.ravel()
        parts.append(frame)
    return pd.concat(parts, ignore_index=True)
