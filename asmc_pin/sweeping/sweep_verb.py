"""Running a sweep, from where it stands to its end."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from asmc_pin.disk.files import write_whole
from asmc_pin.disk.reading import user_path
from asmc_pin.disk.sole_writer import sole_writer
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.results import result_folder
from asmc_pin.sweeping.dask_workers import cluster_results
from asmc_pin.sweeping.row_files import missing_blocks, shards_there, write_shard
from asmc_pin.sweeping.sweep_files import write_findings
from asmc_pin.sweeping.sweep_key import sweep_key
from asmc_pin.sweeping.sweep_plan import SweepPlan, sweep_plan
from asmc_pin.sweeping.sweep_result import Sweep
from asmc_pin.sweeping.sweep_workers import block_results, cores
from asmc_pin.words.given import check_experiment
from asmc_pin.words.interface import flag_words, option_words

Progress = Callable[[str, float], None]
"""Told what is being done, and which share of all is done, 0 to 1."""

_WARM = 2.0
"""Time from the first block on, s, after which the rate is taken of what came after it."""


def sweep(
    experiment: Experiment,
    trials: int,
    out: str | Path | None = None,
    *,
    workers: int | None = None,
    dask: str | None = None,
    block: int | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Sweep:
    """Run every controller of an experiment in many trials that vary as its ``[sweep]`` says.

    In a trial every controller meets the same plant, start, noise and motion. The rows are the same to the last bit
    whatever the workers and the blocks; a sweep that was killed goes on from the blocks that it had written.

    Args:
        experiment: See `asmc_pin.load_experiment`.
        trials: Draws at each point of the grids and for each scan.
        out: Folder of the result; ``results/NAME-sweep`` when omitted.
        workers: Processes; as many as there are processors when omitted.
        dask: Address of a Dask scheduler, such as ``tcp://10.0.0.1:8786``, whose workers run the blocks instead.
        block: Trials that are run and written together; some dozens when omitted.
        force: Whether rows of another experiment, version or number of trials that lie there may be replaced.
        progress: Called now and then.

    Raises:
        ResultError: something is there that may not be replaced, or cannot be written.
        ExperimentError: a value that was drawn fits no experiment, or a law of one's own raised an exception.
        ParameterError: an argument is out of range, or no cluster answers.
        MissingDependencyError: Dask is asked for and not installed.
    """
    check_experiment(experiment)
    if workers is not None and dask is not None:
        raise ParameterError("workers", "processes of this machine and a Dask cluster given; expected one of them")
    if workers is not None and (isinstance(workers, bool) or int(workers) != workers or workers < 1):
        raise ParameterError("workers", f"{workers!r} given; expected a whole number of processes, at least 1")
    folder = user_path(out) if out is not None else Path("results") / f"{experiment.name}-sweep"
    tell = progress or (lambda _what, _share: None)
    tell("loading", 0.0)
    plan = sweep_plan(experiment, trials, block, sweep_key(experiment))
    _check_folder(plan, folder, force)
    with sole_writer(folder):
        _check_folder(plan, folder, force)  # another run may have been quicker
        return _run(plan, folder, workers, dask, tell)


def _run(plan: SweepPlan, folder: Path, workers: int | None, dask: str | None, tell: Progress) -> Sweep:
    """Run what is not there yet, and write what it comes to."""
    write_whole(folder / result_folder.EXPERIMENT, plan.experiment.to_toml())
    todo = missing_blocks(plan, folder)
    left = sum(map(len, todo))
    started, began, done = datetime.now(UTC), time.monotonic(), 0
    tell(how_far(plan, left, 0, 0, 0.0), 1.0 - left / plan.trials)
    first: tuple[int, float] | None = None
    results = block_results(plan, todo, workers or cores()) if dask is None else cluster_results(plan, todo, dask)
    for finished, content in results:
        write_shard(folder, finished, content)
        done += len(finished)
        now = time.monotonic()
        first = first or (done, now)
        warm = now - first[1] > _WARM  # before, what starting and compiling took is in the rate
        counted, since = (done - first[0], first[1]) if warm else (done, began)
        tell(how_far(plan, left, done, counted, now - since), 1.0 - (left - done) / plan.trials)
    tell("writing", 1.0)
    findings = write_findings(plan, folder, started, time.monotonic() - began)
    return Sweep(folder, plan.trials, findings)


def how_far(plan: SweepPlan, left: int, done: int, counted: int, seconds: float) -> str:
    """Trials done, how fast, and how long the rest takes.

    Args:
        plan: The sweep.
        left: Trials that were to be run when it was started.
        done: Of these, how many are.
        counted: Of these, how many the rate is taken of.
        seconds: That they took.
    """
    said = f"{plan.trials - left + done:,} of {plan.trials:,} trials"
    if not counted or seconds <= 0.0:
        return said
    rate = counted / seconds
    rest = (left - done) / rate
    unit, size = next(((unit, size) for unit, size in (("h", 3600.0), ("min", 60.0)) if rest >= 2.0 * size), ("s", 1.0))
    return f"{said}, {rate:.3g} per s, {rest / size:.0f} {unit} left"


def _check_folder(plan: SweepPlan, folder: Path, force: bool) -> None:
    """Refuse a folder whose files are no sweep's, or those of another one."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise ResultError(folder, f"{folder} is not a folder; give another one with {option_words('out')}")
    try:
        (folder / "rows").mkdir(parents=True, exist_ok=True) if not folder.exists() else None
        names = {path.name for path in folder.iterdir()}
        if names and not {"rows", result_folder.EXPERIMENT} & names:
            raise ResultError(
                folder,
                f"{folder} holds files that are no sweep, and is left alone; "
                f"give another folder with {option_words('out')}",
            )
        if result_folder.TRAJECTORIES in names:
            raise ResultError(
                folder, f"{folder} holds the result of a comparison; give another folder with {option_words('out')}"
            )
        (folder / "rows").mkdir(exist_ok=True)
    except OSError as error:
        raise ResultError(folder, f"{folder} cannot be written: {error.strerror or error}") from error
    there = shards_there(folder)
    stale = sum(key not in (plan.key, None) for key in there.values())
    if stale and not force:
        raise ResultError(
            folder,
            f"{folder} holds rows of another experiment, URDF or version ({stale} files), which are not reused; "
            f"{flag_words('force')} replaces them, {option_words('out')} writes elsewhere",
        )
    beyond = [path for path in there if int(path.stem.split("-")[1]) >= plan.trials]
    if beyond and not stale and not force:
        raise ResultError(
            folder,
            f"{folder} holds rows of more trials than the {plan.trials} asked for; {flag_words('force')} removes them, "
            f"{option_words('out')} writes elsewhere",
        )
