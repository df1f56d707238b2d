"""What a tuning leaves on disk: the tuned experiment, every candidate, held-out rows, page, figures, JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from asmc_pin.disk.files import write_whole
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.finding import TUNED
from asmc_pin.metrics import METRICS
from asmc_pin.pages.tunings.tune_figures import tune_plates
from asmc_pin.pages.tunings.tune_findings import TuneFindings
from asmc_pin.pages.tunings.tune_page import page_of_tuning
from asmc_pin.results import result_folder
from asmc_pin.results.provenance import provenance
from asmc_pin.sweeping.block_rows import as_parquet
from asmc_pin.sweeping.trial_runs import TrialOutcome
from asmc_pin.tuning.controller_tuning import ControllerTuning, HeldOut
from asmc_pin.tuning.tune_result import findings_json

STUDIES, CANDIDATES, HELD_OUT = "studies", "candidates.parquet", "held_out.parquet"
JSON = "tune.json"

Judged = Mapping[str, tuple[ControllerTuning, HeldOut]]
"""By label: a controller's tuning, and its outcomes on the held-out draws."""


def tuned_experiment(experiment: Experiment, settings: Mapping[str, Mapping[str, Any]]) -> Experiment:
    """The experiment with other gains, by label, under the name NAME-tuned."""
    tables = {label: {**table, **settings.get(label, {})} for label, table in experiment.controllers.items()}
    return experiment.replace(name=f"{experiment.name[:94]}-tuned", controllers=tables)


def write_tuning(
    folder: Path, findings: TuneFindings, tuned: Experiment, judged: Judged, key: str, started: datetime, seconds: float
) -> Path:
    """Write every file but the journals, each whole; the tuned experiment's path.

    Args:
        folder: Of the tuning.
        findings: What was found.
        tuned: The experiment with the best gains.
        judged: Tunings with their outcomes.
        key: Of all that the result depends on.
        started: When this run of it began.
        seconds: Wall time of this run.
    """
    path = folder / TUNED
    head = f"# {findings.experiment.name} with the gains that `asmc-pin tune` found: {findings.budget} candidates of "
    write_whole(path, f"{head}each controller.\n# Objective: {findings.objective}.\n{tuned.to_toml()}")
    write_whole(folder / CANDIDATES, as_parquet(_candidates(judged)))
    write_whole(folder / HELD_OUT, as_parquet(_held_out(judged)))
    write_whole(folder / JSON, json.dumps(findings_json(findings), indent=2, ensure_ascii=False) + "\n")
    page_of_tuning(findings, list(tune_plates(findings))).write_into(folder)
    experiment = findings.experiment
    told = provenance(experiment, experiment.build_arm(), started, {"tune": seconds}, folder)
    told["tune"] = {"key": key, "budget": findings.budget}
    told["files"] = {
        name: digest
        for name, digest in told["files"].items()
        # Journals carry times, and so differ between two runs of the same tuning.
        if name != result_folder.PROVENANCE and not name.startswith(f"{STUDIES}/")
    }
    write_whole(folder / result_folder.PROVENANCE, json.dumps(told, indent=2, ensure_ascii=False) + "\n")
    return path


def _candidates(judged: Judged) -> pa.Table:
    """A row for each candidate."""
    rows = [
        {
            "controller": label,
            "candidate": item.number,
            "setting": json.dumps(dict(item.setting)),
            "error": item.score.error,
            "excess": item.score.excess,
            "chatter": item.score.chatter,
            "failed": item.score.failed,
            "within": item.score.within,
        }
        for label, (tuning, _) in judged.items()
        for item in tuning.candidates
    ]
    text, number, count = pa.string(), pa.float64(), pa.int64()
    columns = [("controller", text), ("candidate", count), ("setting", text), ("error", number), ("excess", number)]
    return pa.Table.from_pylist(
        rows, schema=pa.schema([*columns, ("chatter", number), ("failed", count), ("within", pa.bool_())])
    )


def _held_out(judged: Judged) -> pa.Table:
    """A row for each held-out trial, controller, side and joint."""
    text, number, count = pa.string(), pa.float64(), pa.int64()
    named = [("draw", count), ("point", count), ("controller", text), ("law", text), ("gains", text)]
    named += [("joint", text), ("joint_kind", text), ("status", text), ("end_time", number)]
    columns: dict[str, list[Any]] = {name: [] for name, _ in named} | {name: [] for name in METRICS}
    for label, (tuning, held_out) in judged.items():
        points = len(held_out.tuned) // len(tuning.held_out)
        for gains, outcomes in (("tuned", held_out.tuned), ("file", held_out.start)):
            for i, outcome in enumerate(outcomes):
                place = {"draw": tuning.held_out[i // points], "point": i % points}
                _add(columns, outcome, {**place, "controller": label, "gains": gains})
    return pa.table(columns, schema=pa.schema([*named, *((name, number) for name in METRICS)]))


def _add(columns: dict[str, list[Any]], outcome: TrialOutcome, same: Mapping[str, Any]) -> None:
    joints: Sequence[tuple[str, str]] = outcome.joints
    every = {**same, "law": outcome.law, "status": outcome.status, "end_time": outcome.end_time}
    for name, value in every.items():
        columns[name] += [value] * len(joints)
    columns["joint"] += [name for name, _ in joints]
    columns["joint_kind"] += [kind for _, kind in joints]
    for name in METRICS:
        columns[name] += np.asarray(outcome.figures[name]).tolist()
