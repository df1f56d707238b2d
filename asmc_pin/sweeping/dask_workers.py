"""Running blocks on a Dask cluster: the same blocks and the same bytes as with workers of this machine.

The scheduler is handed some blocks for each thread of its workers and more as they are done, so that neither it nor
this process holds much, however long the sweep is. It runs again what a lost worker had; what was handed over is on
this process's disk.
"""

from __future__ import annotations

import logging
import time
import uuid
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from asmc_pin.errors import ExperimentError, MissingDependencyError, ParameterError
from asmc_pin.sweeping.sweep_plan import SweepPlan
from asmc_pin.sweeping.worker_block import run_block

AHEAD = 3
"""Blocks that are with the scheduler for each thread: one being run, and some so that no worker waits."""

PATIENCE = 30.0
"""How long a scheduler may take to answer, and to have a first worker, s."""

LOSSES = 4
"""How often a block is handed over anew after the scheduler has given it up: it does so when several workers died."""


def cluster_results(plan: SweepPlan, blocks: Sequence[range], address: str) -> Iterator[tuple[range, bytes]]:
    """Rows of each block, in whatever order they come to be done.

    Args:
        plan: The sweep.
        blocks: What to run.
        address: Of the scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises:
        MissingDependencyError: Dask is not installed.
        ParameterError: no scheduler or no worker is there, or they are lost for good.
        ExperimentError: a block cannot be run.
    """
    try:
        import distributed
    except ImportError:
        raise MissingDependencyError("distributed", "dask", "for sweeps on a Dask cluster") from None
    with _quiet():
        client = _connected(distributed, address)
        try:
            yield from _results(distributed, client, plan, blocks, address)
        finally:
            with suppress(Exception):  # a scheduler that is gone has nothing left to be told
                client.close(timeout=5)


@contextmanager
def _quiet() -> Iterator[None]:
    """In the block, Dask logs nothing of a lost worker or scheduler: it is dealt with here, or told in one message."""
    log = logging.getLogger("distributed.client")
    former = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(former)


def _connected(distributed: Any, address: str) -> Any:
    """A client of the scheduler, once a worker is there."""
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ParameterError(
            "dask", f"no Dask scheduler answers at {address!r} ({_first_line(error)}); start one with: dask scheduler"
        ) from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        client.close(timeout=5)
        raise ParameterError(
            "dask", f"the scheduler at {address} has no worker; start some with: dask worker {address} --nthreads 1"
        ) from None
    return client


def _results(
    distributed: Any, client: Any, plan: SweepPlan, blocks: Sequence[range], address: str
) -> Iterator[tuple[range, bytes]]:
    waiting = iter(blocks)
    under_way: dict[str, tuple[range, int]] = {}
    room, looked = AHEAD * _threads(client, address), time.monotonic()
    done = distributed.as_completed(loop=client.loop)
    name = uuid.uuid4().hex  # another sweep, or this one started again, may be with the same scheduler

    def hand_over(block: range, losses: int) -> None:
        future = client.submit(_run_block, plan, block, pure=False, key=f"block-{block[0]}-{losses}-{name}")
        under_way[future.key] = block, losses
        done.add(future)

    while True:
        if time.monotonic() - looked > 5.0:  # workers come and go
            looked = time.monotonic()
            room = AHEAD * max(1, _threads(client, address))
        while len(under_way) < room and (block := next(waiting, None)) is not None:
            hand_over(block, 0)
        if not under_way:
            return
        future = next(done)
        block, losses = under_way.pop(future.key)
        try:
            # A worker that dies with rows that were not fetched yet is no loss: this waits until they are made again.
            worker, content, trouble = future.result()
        except distributed.KilledWorker as error:
            if losses >= LOSSES:
                raise _no_end(block, error, address) from None
            hand_over(block, losses + 1)
            continue
        except Exception as error:
            raise _no_end(block, error if future.status == "error" else None, address) from None
        future.release()
        if trouble is not None:
            raise ExperimentError("", f"worker {worker}: {trouble}")
        yield block, content


def _threads(client: Any, address: str) -> int:
    """Threads of all workers, one each: what several of one process load and compile at once may wait for ever."""
    try:
        threads: dict[str, int] = client.nthreads()
    except (OSError, ValueError) as error:
        raise ParameterError("dask", _why(error, address)) from None
    for worker, count in threads.items():
        if count > 1:
            raise ParameterError(
                "dask",
                f"worker {worker} has {count} threads; start workers of one thread, and as many as there are "
                f"processors: dask worker {address} --nthreads 1 --nworkers {count}",
            )
    return len(threads)


def _no_end(block: range, error: Exception | None, address: str) -> ParameterError:
    return ParameterError("dask", f"trials {block[0]} to {block[-1]} came to no end: {_why(error, address)}")


def _why(error: Exception | None, address: str) -> str:
    """What an error of a worker says; without one the connection to the scheduler is lost."""
    said = f"the scheduler at {address} is gone" if error is None else _first_line(error)
    return f"{said}; what was done is kept, and the same command goes on from there"


def _first_line(error: BaseException) -> str:
    return (str(error).strip() or type(error).__name__).splitlines()[0][:300]


def _run_block(plan: SweepPlan, block: range) -> tuple[str, bytes, str | None]:
    """In a worker of the cluster: see `run_block`."""
    from distributed import get_worker

    return str(get_worker().address), *run_block(plan, block, elsewhere=True)
