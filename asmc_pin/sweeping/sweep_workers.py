"""Running blocks: in this process, or in workers of joblib's loky, each on one thread.

A worker is handed the plan and a block, and hands back the bytes of the block's rows; it writes nothing. So what a
killed sweep leaves behind is what this process had written, and a worker on another machine needs no disk of ours.
"""

from __future__ import annotations

import functools
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

import joblib
from joblib.externals.loky.backend.resource_tracker import ensure_running
from joblib.externals.loky.process_executor import TerminatedWorkerError

from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.sweeping.block_rows import BlockRows
from asmc_pin.sweeping.sweep_plan import SweepPlan
from asmc_pin.sweeping.worker_block import run_block

Item = TypeVar("Item")
Result = TypeVar("Result")

_watching = False


@contextmanager
def _quiet_tracker() -> Iterator[None]:
    """Let loky's tracker of resources, a process that begins here, not warn of what an interrupted sweep leaves to it.

    It removes these semaphores and folders; that it has to is no news to the user.
    """
    name = "PYTHONWARNINGS"
    former = os.environ.get(name)
    os.environ[name] = ",".join(filter(None, [former, "ignore:resource_tracker"]))
    try:
        yield
    finally:
        if former is None:
            del os.environ[name]
        else:
            os.environ[name] = former


def cores() -> int:
    """Processors that this process may use."""
    return int(joblib.cpu_count())


def block_results(plan: SweepPlan, blocks: Sequence[range], workers: int) -> Iterator[tuple[range, bytes]]:
    """Rows of each block, in whatever order they come to be done.

    Args:
        plan: The sweep.
        blocks: What to run.
        workers: Processes; 1 for this one alone.

    Raises:
        ExperimentError: a block cannot be run.
        ParameterError: a worker was killed.
    """
    if workers == 1 or len(blocks) < 2:
        rows = BlockRows(plan)
        for block in blocks:
            yield block, rows.parquet(block)
        return
    for block, content, trouble in in_workers(functools.partial(_run_block, plan), blocks, workers):
        if trouble is not None:
            raise ExperimentError("", trouble)
        yield block, content


def in_workers(work: Callable[[Item], Result], items: Sequence[Item], workers: int) -> Iterator[Result]:
    """What becomes of each item in a process of its own, in whatever order they come to be done.

    Args:
        work: A function of a module; it hands our errors back in words, for they do not travel between processes.
        items: What it is given, one by one.
        workers: Processes at once.

    Raises:
        ParameterError: one of them was killed.
    """
    run = joblib.delayed(_watched)
    with joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        pool = joblib.Parallel(min(workers, len(items)), return_as="generator_unordered", batch_size=1, max_nbytes=None)
        with _quiet_tracker():
            ensure_running()  # unblocks SIGINT where it begins a tracker, so it has to be there before
        with _interrupts_held_back(), _quiet_tracker():
            done = pool(run(work, item, os.getpid()) for item in items)
        try:
            for result in done:  # noqa: UP028  # `yield from` would end it itself, before the warning is dealt with
                yield result
        except TerminatedWorkerError:
            raise ParameterError(
                "workers",
                "the system or somebody ended one of the processes, maybe for want of memory; what they had handed "
                "over is kept, and the same command goes on from there, with --workers 1 in this process alone",
            ) from None
        finally:
            with warnings.catch_warnings():
                # Whoever takes no more results has a reason, and tells it; what is under way is let go.
                warnings.filterwarnings("ignore", ".*tasks which were still being processed", UserWarning)
                done.close()


def _watched(work: Callable[[Item], Result], item: Item, parent: int) -> Result:
    """In a worker of this machine, which ends with the process that began it."""
    _end_with(parent)
    return work(item)


def _run_block(plan: SweepPlan, block: range) -> tuple[range, bytes, str | None]:
    """In a worker: see `run_block`."""
    return block, *run_block(plan, block)


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """In the block, Ctrl-C waits; processes that are started in it never see one, for they inherit what is blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with(parent: int) -> None:
    """Have this process end soon after the one that runs the sweep, however that ended."""
    global _watching
    if _watching:
        return
    _watching = True
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the sweep's own process hears it, and ends this one

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
