"""Running blocks: in this process, or in workers of joblib's loky, each on one thread.

A worker is handed the plan and a block, and hands back the bytes of the block's rows; it writes nothing. So what a
killed sweep leaves behind is what this process had written, and a worker on another machine needs no disk of ours.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import joblib

from asmc_pin.errors import ExperimentError
from asmc_pin.sweeping.block_rows import BlockRows
from asmc_pin.sweeping.sweep_plan import SweepPlan
from asmc_pin.sweeping.worker_block import run_block

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
    """
    if workers == 1 or len(blocks) < 2:
        rows = BlockRows(plan)
        for block in blocks:
            yield block, rows.parquet(block)
        return
    run = joblib.delayed(_run_block)
    with joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        pool = joblib.Parallel(
            min(workers, len(blocks)), return_as="generator_unordered", batch_size=1, max_nbytes=None
        )
        with _interrupts_held_back(), _quiet_tracker():
            done = pool(run(plan, block, os.getpid()) for block in blocks)
        for block, content, trouble in done:
            if trouble is not None:
                raise ExperimentError("", trouble)
            yield block, content


def _run_block(plan: SweepPlan, block: range, parent: int) -> tuple[range, bytes, str | None]:
    """In a worker of this machine: see `run_block`."""
    _end_with(parent)
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

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
