"""One block of a sweep: its trials run, and their rows as the bytes of a Parquet file."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment.variation.axes import as_column
from asmc_pin.metrics import METRICS
from asmc_pin.sweeping.failure_scan import ScanEnd, scan_ends
from asmc_pin.sweeping.lockstep import TrialTables
from asmc_pin.sweeping.sweep_plan import FAILS_AT, PASSED, SCANNED, TOGETHER, TOOL, VARIED, SweepPlan
from asmc_pin.sweeping.trial_runs import TrialOutcome, TrialRuns


class BlockRows:
    """Runs blocks of one sweep, in one process.

    Args:
        plan: The sweep.
    """

    def __init__(self, plan: SweepPlan) -> None:
        self._plan = plan
        self._runs = TrialRuns(plan)

    def table(self, block: range) -> pa.Table:
        """The rows of a block's trials, in order of trial, then controller, then joint.

        Raises:
            ExperimentError: see `TrialRuns`.
        """
        parts = [self._together(block[first : first + TOGETHER]) for first in range(0, len(block), TOGETHER)]
        return pa.concat_tables(parts).combine_chunks()

    def _together(self, block: range) -> pa.Table:
        """The rows of trials that are run at once."""
        plan, variation = self._plan, self._plan.variation
        labels = list(plan.experiment.controllers)
        jobs, quantities = [], []
        for trial in block:
            try:
                drawn = variation.quantities(trial)
            except ValueError as error:
                raise ExperimentError("", f"{plan.experiment.origin}: trial {trial}: {error}") from None
            quantities.append(drawn)
            jobs.append(TrialTables(trial, variation.place_of(trial)[1], variation.tables(drawn)))
        scanned = [variation.scan_at(variation.place_of(job.trial)[0]) for job in jobs]
        ends: dict[tuple[int, str], ScanEnd] = {}
        for scan in variation.scans:
            here = [i for i, each in enumerate(scanned) if each is scan]
            found = scan_ends(self._runs, scan, [jobs[i] for i in here], labels)
            ends |= {(here[k], label): end for (k, label), end in found.items()}
        plain = [i for i, each in enumerate(scanned) if each is None]
        outcomes: dict[tuple[int, str], TrialOutcome] = {
            (plain[k], label): outcome for (k, label), outcome in self._runs([jobs[i] for i in plain]).items()
        }
        columns: dict[str, list[Any]] = {name: [] for name in plan.schema.names}
        for i, job in enumerate(jobs):
            for label in labels:
                axis, end = scanned[i], ends.get((i, label))
                drawn = quantities[i] if axis is None or end is None else {**quantities[i], axis.path: end.reached}
                _add(columns, plan, job, outcomes[i, label] if end is None else end.outcome, drawn)
                if variation.scans:
                    joints = len((outcomes[i, label] if end is None else end.outcome).joints)
                    columns[SCANNED] += [None if axis is None else axis.path] * joints
                    columns[PASSED] += [None if end is None else end.passed] * joints
                    columns[FAILS_AT] += [math.nan if end is None else end.fails_at] * joints
        return pa.table(columns, schema=plan.schema)

    def parquet(self, block: range) -> bytes:
        """The same as a file, bit for bit the same whenever and wherever it is made."""
        return as_parquet(self.table(block))


def _add(
    columns: dict[str, list[Any]], plan: SweepPlan, job: TrialTables, outcome: TrialOutcome, drawn: Mapping[str, Any]
) -> None:
    """The rows of one trial under one controller."""
    joints = len(outcome.joints)
    point, draw = plan.variation.place_of(job.trial)
    same = {
        "trial": job.trial,
        "draw": draw,
        "point": point,
        "arm": outcome.arm,
        "controller": outcome.shown,
        "law": outcome.law,
        "knows_model": outcome.knows_model,
        "status": outcome.status,
        "end_time": outcome.end_time,
    }
    for name, value in same.items():
        columns[name] += [value] * joints
    columns["joint"] += [name for name, _ in outcome.joints]
    columns["joint_kind"] += [kind for _, kind in outcome.joints]
    for axis in plan.variation.axes:
        columns[f"{VARIED}{axis.path}"] += as_column(axis, drawn[axis.path], joints)
    for name in METRICS:
        columns[name] += np.asarray(outcome.figures[name]).tolist()
    for name in TOOL if plan.experiment.metrics.tool is not None else ():
        columns[name] += [outcome.tool.get(name, math.nan)] * joints


def as_parquet(table: pa.Table) -> bytes:
    """A table as Parquet whose pages carry checksums."""
    content = io.BytesIO()
    pq.write_table(table, content, write_page_checksum=True)
    return content.getvalue()
