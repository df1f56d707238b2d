"""What a complete sweep leaves beside its rows: comparisons, summary, figures, report, and where it comes from."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.pages.sweeps.sweep_figures import sweep_plates
from asmc_pin.pages.sweeps.sweep_findings import SweepFindings
from asmc_pin.pages.sweeps.sweep_page import page_of_sweep
from asmc_pin.results import result_folder
from asmc_pin.results.provenance import provenance
from asmc_pin.sweeping.block_rows import as_parquet
from asmc_pin.sweeping.controllers_compared import compared, comparisons_table
from asmc_pin.sweeping.row_files import write_rows
from asmc_pin.sweeping.sweep_plan import SweepPlan
from asmc_pin.sweeping.trial_scores import TrialScores

COMPARISONS = "comparisons.parquet"


def write_findings(plan: SweepPlan, folder: Path, started: datetime, seconds: float) -> SweepFindings:
    """Write every file that is made of the rows, each whole, and say what they hold.

    Args:
        plan: A sweep all of whose shards are there.
        folder: Of the sweep.
        started: When this run of it began.
        seconds: Wall time of this run.
    """
    scores = TrialScores(plan)
    failed = dict.fromkeys(scores.labels, 0)
    for table in write_rows(plan, folder):
        scores.add(table)
    first = next(iter(scores.scores.values()))
    for label in failed:
        failed[label] = int((~(first[label] < float("inf"))).sum())
    findings = SweepFindings(
        experiment=plan.experiment,
        draws=plan.draws,
        labels=scores.labels,
        points=scores.points(),
        scores=scores.scores,
        fails_at=scores.fails_at,
        drawn=scores.single,
        failed=failed,
        kinds=frozenset(scores.kinds),
        alike=scores.alike,
        comparisons=compared(plan, scores),
    )
    write_whole(folder / COMPARISONS, as_parquet(comparisons_table(findings.comparisons)))
    page_of_sweep(findings, list(sweep_plates(findings))).write_into(folder)
    told = provenance(plan.experiment, plan.experiment.build_arm(), started, {"sweep": seconds}, folder)
    told["sweep"] = {"key": plan.key, "trials": plan.trials, "draws": plan.draws}
    told["files"].pop(result_folder.PROVENANCE, None)
    write_whole(folder / result_folder.PROVENANCE, json.dumps(told, indent=2, ensure_ascii=False) + "\n")
    return findings
