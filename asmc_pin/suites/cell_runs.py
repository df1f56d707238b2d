"""Running cells, each in a process of its own, and what they leave on disk: one JSON file, written whole."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import AsmcPinError, ExperimentError
from asmc_pin.statistics.order_statistics import quantile
from asmc_pin.suites.cell_experiment import cell_experiment
from asmc_pin.suites.suite_reading import Suite
from asmc_pin.sweeping.sweep_key import sweep_key
from asmc_pin.sweeping.sweep_workers import in_workers
from asmc_pin.tuning.controller_tuning import ControllerTuning
from asmc_pin.tuning.fair_score import CHATTER, trial_figure

Cell = tuple[str, str, str]
"""Arm, task, law."""


@dataclass(frozen=True, eq=False)
class CellResult:
    """What came of a law on one arm in one task.

    Attributes:
        arm: Name of the arm.
        task: Name of the task.
        law: Name of the law in the suite.
        trials: Candidates that were tried.
        setting: The gains that won.
        kept: Whether they kept the limit in every training trial, and failed in none.
        train: Their objective there; +∞ for a failure.
        held_out: Objective in each held-out trial; +∞ for a failure.
        chatter: Torque variation in each.
        over: Held-out trials beyond the limit, or failed.
    """

    arm: str
    task: str
    law: str
    trials: int
    setting: Mapping[str, Any]
    kept: bool
    train: float
    held_out: Array
    chatter: Array
    over: int

    @property
    def figure(self) -> float:
        """Median over the held-out trials; +∞ where most of them failed, or no gains kept the limit."""
        return float(quantile(self.held_out, 0.5)) if self.kept else math.inf

    @property
    def failed(self) -> int:
        """Held-out trials that failed."""
        return int(np.sum(~np.isfinite(self.held_out)))

    def to_json_dict(self) -> dict[str, Any]:
        """Valid JSON; null for what is infinite."""
        lists = {name: [_known(x) for x in getattr(self, name)] for name in ("held_out", "chatter")}
        names = ("arm", "task", "law", "trials", "kept", "over")
        return {
            **{name: getattr(self, name) for name in names},
            "setting": dict(self.setting),
            "train": _known(self.train),
            **lists,
        }


def from_json(table: Mapping[str, Any]) -> CellResult:
    """What `to_json_dict` gave."""
    return CellResult(
        arm=str(table["arm"]),
        task=str(table["task"]),
        law=str(table["law"]),
        trials=int(table["trials"]),
        setting=dict(table["setting"]),
        kept=bool(table["kept"]),
        train=_figure(table["train"]),
        held_out=np.array([_figure(x) for x in table["held_out"]]),
        chatter=np.array([_figure(x) for x in table["chatter"]]),
        over=int(table["over"]),
    )


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _figure(value: float | None) -> float:
    return math.inf if value is None else float(value)


def cell_key(suite: Suite, cell: Cell) -> str:
    """SHA-256 of all that a cell depends on: its experiment, its URDF, its law's code, the budget and the package."""
    found = [sweep_key(cell_experiment(suite, *cell)), suite.trials, suite.sha256]
    return hashlib.sha256(json.dumps(found).encode()).hexdigest()


def run_cell(suite: Suite, cell: Cell) -> CellResult:
    """Tune a law on the training draws of an arm and a task, and judge it on the others.

    Raises:
        ExperimentError: the law fits no arm, or it raised.
    """
    arm, task, law = cell
    tuning = ControllerTuning(cell_experiment(suite, *cell), law)
    winner = tuning.search(suite.trials, None, "")
    held_out = tuning.judged(winner).tuned
    objective = str(suite.tables["objective"])
    return CellResult(
        arm=arm,
        task=task,
        law=law,
        trials=len(tuning.candidates),
        setting=winner.setting,
        kept=winner.score.within,
        train=winner.score.error,
        held_out=np.array([trial_figure(x, objective) for x in held_out]),
        chatter=np.array([trial_figure(x, CHATTER) for x in held_out]),
        over=tuning.over(held_out),
    )


def cell_path(folder: Path, cell: Cell) -> Path:
    """Where a cell's result lies; a law's name may hold what no file's name may."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in cell[2])[:60]
    return folder / "cells" / f"{cell[0]}-{cell[1]}-{plain}-{hashlib.sha256(cell[2].encode()).hexdigest()[:8]}.json"


def stored_cell(folder: Path, cell: Cell, key: str) -> CellResult | None:
    """The result of a cell that is there and belongs to this key; None where it has to be run."""
    try:
        told = json.loads(cell_path(folder, cell).read_text(encoding="utf-8"))
        return from_json(told) if told["key"] == key else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def run_cells(suite: Suite, folder: Path, cells: Sequence[tuple[Cell, str]], workers: int) -> Iterator[CellResult]:
    """Run cells and store each as it is done.

    Args:
        suite: Theirs.
        folder: Of the benchmark.
        cells: What to run, with the key of each.
        workers: Processes.

    Raises:
        ExperimentError: a law fits no arm, or it raised.
    """
    keys = dict(cells)
    work = partial(_told, suite)
    todo = [cell for cell, _ in cells]
    results = map(work, todo) if workers == 1 or len(todo) < 2 else in_workers(work, todo, workers)
    for cell, told, trouble in results:
        if trouble is not None:
            raise ExperimentError("", trouble)
        assert told is not None
        text = json.dumps({"key": keys[cell], **told}, indent=1, ensure_ascii=False)
        write_whole(cell_path(folder, cell), text + "\n")
        yield from_json(told)


def _told(suite: Suite, cell: Cell) -> tuple[Cell, dict[str, Any] | None, str | None]:
    """In a worker: a cell's result, or what is wrong: our errors do not travel between processes."""
    try:
        return cell, run_cell(suite, cell).to_json_dict(), None
    except AsmcPinError as error:
        return cell, None, f"{cell[2]} on {cell[0]}, {cell[1]}: {error}"
