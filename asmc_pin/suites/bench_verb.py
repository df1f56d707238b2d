"""Running a suite, from where it stands to its end."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from asmc_pin.disk.files import write_whole
from asmc_pin.disk.reading import user_path
from asmc_pin.disk.sole_writer import sole_writer
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.pages.benches.bench_figures import bench_plates
from asmc_pin.pages.benches.bench_findings import BenchFindings
from asmc_pin.pages.benches.bench_page import page_of_bench
from asmc_pin.pages.sweeps.sweep_tables import unit_on
from asmc_pin.results.provenance import PACKAGES, package_version
from asmc_pin.suites.bench_result import Benchmark, bench_json
from asmc_pin.suites.cell_experiment import cell_experiment
from asmc_pin.suites.cell_runs import CellResult, cell_key, run_cells, stored_cell
from asmc_pin.suites.suite_reading import DEFAULT, Suite, load_suite
from asmc_pin.sweeping.sweep_workers import cores
from asmc_pin.tuning.fair_score import Judge
from asmc_pin.words.interface import option_words

Progress = Callable[[str, float], None]
"""Told what is being done, and which share of all is done, 0 to 1."""


def bench(
    suite: str | Path = DEFAULT,
    out: str | Path | None = None,
    *,
    quick: bool = False,
    arms: Iterable[str] | None = None,
    tasks: Iterable[str] | None = None,
    laws: Iterable[str] | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Benchmark:
    """Tune every law of a suite on each arm in each task with the same budget, and rank them by held-out draws.

    A law of one's own joins by one line of a file that extends the suite (docs/bench.md). A benchmark that was
    killed goes on from the cells that it had written and ends with the same result.

    Args:
        suite: Name of a shipped suite, or a file that extends one.
        out: Folder of the result; ``results/NAME``, or ``results/NAME-part`` for a part, when omitted.
        quick: Whether to run the small part that the suite names for a first look; no result of the suite.
        arms: Some of its arms; all when omitted.
        tasks: Some of its tasks.
        laws: Some of its laws.
        workers: Processes; as many as there are processors when omitted.
        progress: Called now and then.

    Returns:
        Ranks and figures. A law that fails is no error: its figure is +∞.

    Raises:
        ExperimentError: there is no such suite, or a law fits no arm or raised.
        ParameterError: the suite has no such arm, task or law, or an argument is out of range.
        ResultError: the folder cannot be written, or holds something else.
    """
    if workers is not None and (isinstance(workers, bool) or int(workers) != workers or workers < 1):
        raise ParameterError("workers", f"{workers!r} given; expected a whole number of processes, at least 1")
    chosen = load_suite(suite).part(quick=quick, arms=arms, tasks=tasks, laws=laws)
    name = chosen.name if chosen.whole else f"{chosen.name}-part"
    folder = user_path(out) if out is not None else Path("results") / name
    tell = progress or (lambda _what, _share: None)
    tell("loading", 0.0)
    for arm in chosen.arms:  # what does not fit is said before anything is run
        for law in chosen.laws:
            cell_experiment(chosen, arm, next(iter(chosen.tasks)), law).build_controllers()
    _prepare(folder)
    with sole_writer(folder):
        return _run(chosen, folder, workers, tell)


def _run(chosen: Suite, folder: Path, workers: int | None, tell: Progress) -> Benchmark:
    """Run the cells that are not there yet, and write what all come to."""
    started, began = datetime.now(UTC), time.monotonic()
    keys = {cell: cell_key(chosen, cell) for cell in chosen.cells}
    stored = {cell: stored_cell(folder, cell, key) for cell, key in keys.items()}
    found = {cell: result for cell, result in stored.items() if result is not None}
    todo = [(cell, key) for cell, key in keys.items() if cell not in found]
    tell(f"{len(found)} of {len(keys)} cells", len(found) / len(keys))
    for result in run_cells(chosen, folder, todo, workers or cores()):
        found[result.arm, result.task, result.law] = result
        tell(f"{len(found)} of {len(keys)} cells", len(found) / len(keys))
    tell("writing", 1.0)
    cells = [found[cell] for cell in chosen.cells]
    findings = findings_of(chosen, cells)
    _write(folder, findings, cells, started, time.monotonic() - began)
    return Benchmark(folder, findings, cells)


def findings_of(suite: Suite, cells: Sequence[CellResult]) -> BenchFindings:
    """What the cells of a suite come to."""
    laws, problems = list(suite.laws), [(arm, task) for arm in suite.arms for task in suite.tasks]
    by = {(cell.law, cell.arm, cell.task): cell for cell in cells}
    grid = [[by[law, arm, task] for arm, task in problems] for law in laws]
    shape = len(laws), len(problems)
    judge = Judge(cell_experiment(suite, *problems[0], laws[0]))
    tables = suite.tables
    conditions = (
        f"{suite.trials} candidates of each law on each arm and task, {tables['train']} training draws, "
        f"{suite.held_out} held out; {judge.words().split(';')[0]}; torque noise at most "
        f"{100.0 * tables['torque_noise']:g} % of the largest torque; {1e3 * tables['period']:g} ms"
    )
    return BenchFindings(
        suite=suite.name,
        sha256=suite.sha256,
        scope=suite.scope(),
        conditions=conditions,
        seed=int(tables["seed"]),
        laws=laws,
        kinds={law: str(table["law"]) for law, table in suite.laws.items()},
        problems=problems,
        unit=unit_on(judge.kinds, judge.objective),
        figures=np.array([[cell.figure for cell in row] for row in grid]).reshape(shape),
        unkept=np.array([[not cell.kept for cell in row] for row in grid]).reshape(shape),
        failed=np.array([[cell.failed for cell in row] for row in grid]).reshape(shape),
        over=np.array([[cell.over for cell in row] for row in grid]).reshape(shape),
        trials=np.array([[cell.trials for cell in row] for row in grid]).reshape(shape),
        held_out=suite.held_out,
    )


def _prepare(folder: Path) -> None:
    """Make the folder; refuse one whose files are no benchmark's."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise ResultError(folder, f"{folder} is not a folder; give another one with {option_words('out')}")
    try:
        names = {path.name for path in folder.iterdir()} if folder.exists() else set()
        if names and "cells" not in names:
            raise ResultError(
                folder,
                f"{folder} holds files that are no benchmark, and is left alone; "
                f"give another folder with {option_words('out')}",
            )
        (folder / "cells").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultError(folder, f"{folder} cannot be written: {error.strerror or error}") from error


def _write(
    folder: Path, findings: BenchFindings, cells: Sequence[CellResult], started: datetime, seconds: float
) -> None:
    """Every file but the cells, each whole."""
    write_whole(folder / "bench.json", json.dumps(bench_json(findings, cells), indent=2, ensure_ascii=False) + "\n")
    page_of_bench(findings, list(bench_plates(findings))).write_into(folder)
    told = {
        "suite": {"name": findings.suite, "sha256": findings.sha256, "part": findings.scope},
        "started": started.isoformat(timespec="seconds"),
        "seconds": round(seconds, 3),
        "packages": {name: package_version(name) for name in PACKAGES},
    }
    write_whole(folder / "provenance.json", json.dumps(told, indent=2, ensure_ascii=False) + "\n")
