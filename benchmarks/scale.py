"""What a sweep of 10⁹ trials on 1,000 workers costs and needs: measured rates of this machine, and a simulation.

    python benchmarks/scale.py [--trials 1e9] [--workers 1000] [--docs docs/scale.md]

Measured, each by itself: what a trial costs and how many bytes its rows are; what a block costs a real Dask scheduler
and the process that writes, by blocks that compute nothing; what a waiting worker costs the scheduler; how fast shards
become one file; how much memory the page's figures take. A trial is 2 s of the UR5 at 1 kHz under one law, with a load
and friction of its own, as in `sweep.py`. Times are processor time, which other programs disturb less than the clock.

Simulated, because it can't be run here: the workers, the scheduler and the writing process as a queue of blocks, with
these figures, for several sizes of a block. Scheduler and writer serve one block after the other. A worker dies now and
then, what it had is run again, and another one takes its place.
"""

from __future__ import annotations

import argparse
import heapq
import os
import random
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

from sweep import children, experiment

from asmc_pin.sweeping import dask_workers
from asmc_pin.sweeping.block_rows import BlockRows
from asmc_pin.sweeping.row_files import write_rows, write_shard
from asmc_pin.sweeping.sweep_plan import SweepPlan, sweep_plan
from asmc_pin.sweeping.trial_scores import TrialScores

SIZES = (32, 256, 2048, 16_384)
"""Trials of a block that are simulated."""

LIFE = 24.0
"""Hours after which a worker dies, on average: assumed, as on machines that may be taken away."""

WAITING = 20
"""Workers that are started to see what a waiting one costs."""

MANY_WORKERS = """
import asyncio, sys
import asmc_pin.sweeping.dask_workers  # before there are threads that would all import it at once
from distributed import Worker
async def main():
    workers = await asyncio.gather(*[Worker(sys.argv[1], nthreads=1, dashboard=False) for _ in range(int(sys.argv[2]))])
    await asyncio.gather(*[worker.finished() for worker in workers])
asyncio.run(main())
"""


@dataclass
class Rates:
    """What was measured: seconds of one processor, and bytes.

    Attributes:
        trial: Of a trial, s.
        bytes_per_trial: Rows of a trial in a shard, bytes.
        start: From nothing to a first block, s.
        scheduler_block, scheduler_mb: What a block and a MB of rows cost the scheduler, s.
        writer_block, writer_mb: The same of the process that writes them, s.
        heartbeat: What a waiting worker costs the scheduler, s per s.
        gathering: Shards to one file, MB per s.
        figure_bytes: Memory of the process that writes, bytes per trial.
    """

    trial: float = 0.0
    bytes_per_trial: float = 0.0
    start: float = 0.0
    scheduler_block: float = 0.0
    scheduler_mb: float = 0.0
    writer_block: float = 0.0
    writer_mb: float = 0.0
    heartbeat: float = 0.0
    gathering: float = 0.0
    figure_bytes: float = 0.0


def plan_of(draws: int, block: int) -> SweepPlan:
    """The sweep, with a key that says it is none to keep."""
    return sweep_plan(experiment(), draws, block, "0" * 64)


def cpu_of(pid: int) -> float:
    """Processor time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure_trials(rates: Rates, trials: int = 128) -> None:
    """What a trial costs, and its rows; shards to one file."""
    rows = BlockRows(plan_of(trials, trials))
    rows.parquet(range(4))  # compile, or load from the cache
    rates.trial, content = min((timed(lambda: rows.parquet(range(trials))) for _ in range(2)), key=lambda x: x[0])
    rates.trial /= trials
    rates.bytes_per_trial = len(content) / trials
    plan = plan_of(20 * trials, trials)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "rows").mkdir()
        for block in plan.blocks:
            write_shard(Path(folder), block, content)
        seconds, _ = timed(lambda: sum(len(table) for table in write_rows(plan, Path(folder))))
    rates.gathering = 1e-6 * len(content) * len(plan.blocks) / seconds


def timed(run: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of a call, s, and what it gave."""
    start = process_time()
    given = run()
    return process_time() - start, given


def measure_figures(rates: Rates, draws: int = 100_000) -> None:
    """Memory of one figure for each trial and metric."""
    plan = plan_of(draws, 32)
    tracemalloc.start()
    kept = TrialScores(plan)
    rates.figure_bytes = tracemalloc.get_traced_memory()[0] / draws
    tracemalloc.stop()
    assert kept.labels


def measure_start(rates: Rates) -> None:
    """A worker's start: the interpreter, the imports, compiled code from its cache, the arm, one trial."""
    code = "import scale; scale.BlockRows(scale.plan_of(32, 1)).parquet(range(1))"
    here = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])}
    before = os.times()
    subprocess.run([sys.executable, "-c", code], env=here, check=True)
    after = os.times()
    rates.start = after.children_user + after.children_system - before.children_user - before.children_system


def measure_scheduler(rates: Rates, blocks: int = 200) -> None:
    """What blocks that compute nothing cost the scheduler and this process, at two sizes of what comes back."""
    from distributed import Client

    with tempfile.TemporaryDirectory() as folder:
        told = Path(folder) / "scheduler.json"
        arguments = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(told)]
        log = (Path(folder) / "log").open("w")
        quiet: dict[str, Any] = {"stdout": log, "stderr": log, "cwd": folder}
        command = [sys.executable, "-m", "distributed.cli.dask_scheduler", *arguments]
        scheduler = subprocess.Popen(command, **quiet)
        workers = None
        try:
            while not told.exists():
                time.sleep(0.1)
            with Client(scheduler_file=str(told), set_as_default=False) as client:
                address = client.scheduler.address
                idle = rate_of_cpu(scheduler.pid)
                workers = subprocess.Popen([sys.executable, "-c", MANY_WORKERS, address, str(WAITING)], **quiet)
                client.wait_for_workers(WAITING, timeout=300)
                time.sleep(5.0)
                rates.heartbeat = max(0.0, rate_of_cpu(scheduler.pid) - idle) / WAITING
                found = {size: blocks_cost(client, address, scheduler.pid, blocks, size) for size in (1000, 1_000_000)}
        finally:
            for process in filter(None, (workers, scheduler)):
                for child in children(process.pid):
                    os.kill(child, 9)
                process.kill()
                process.wait()
    small, large = found[1000], found[1_000_000]
    rates.scheduler_mb, rates.writer_mb = (max(0.0, (b - a) / 0.999) for a, b in zip(small, large, strict=True))
    rates.scheduler_block, rates.writer_block = small


def rate_of_cpu(pid: int, seconds: float = 10.0) -> float:
    """Processor time that a process takes, s per s."""
    before, began = cpu_of(pid), time.monotonic()
    time.sleep(seconds)
    return (cpu_of(pid) - before) / (time.monotonic() - began)


def blocks_cost(client: Any, address: str, scheduler: int, blocks: int, size: int) -> tuple[float, float]:
    """Processor time of the scheduler and of this process, s per block, shards written."""
    import distributed

    def stand_in(_plan: SweepPlan, _block: range) -> tuple[str, bytes, None]:
        return "", bytes(size), None

    plan, real = plan_of(blocks, 1), dask_workers._run_block
    dask_workers._run_block = stand_in
    try:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "rows").mkdir()
            before, mine = cpu_of(scheduler), process_time()
            for block, content in dask_workers._results(distributed, client, plan, plan.blocks, address):
                write_shard(Path(folder), block, content)
            return (cpu_of(scheduler) - before) / blocks, (process_time() - mine) / blocks
    finally:
        dask_workers._run_block = real


@dataclass
class Outlook:
    """How a simulated sweep went; times in s."""

    wall: float
    scheduler_busy: float
    writer_busy: float
    lost: float


def simulate(rates: Rates, size: int, blocks: int, workers: int, seed: int = 0) -> Outlook:
    """Blocks through workers, scheduler and writer, event by event.

    A worker has `AHEAD` blocks with it; it is given another when the writer has taken one. Block times vary by 10 %.
    The scheduler is slower by what the heartbeats take of it.
    """
    draw = random.Random(seed)
    share = max(1e-3, 1.0 - workers * rates.heartbeat)
    mb = 1e-6 * size * rates.bytes_per_trial
    scheduling = (rates.scheduler_block + rates.scheduler_mb * mb) / share
    writing = rates.writer_block + rates.writer_mb * mb
    left, lost, scheduler_at, writer_at = blocks, 0.0, 0.0, 0.0
    free = [rates.start] * workers
    done: list[tuple[float, int]] = []  # when a worker is done with a block, and which

    def run(worker: int, ready: float) -> None:
        """The worker has another block from a time on."""
        nonlocal lost, left
        left -= 1
        seconds = size * rates.trial * max(0.1, draw.gauss(1.0, 0.1))
        if draw.random() < seconds / (3600.0 * LIFE):  # it died in the middle, and another one begins
            again = 0.5 * seconds + rates.start
            lost += again
            seconds += again
        free[worker] = max(free[worker], ready) + seconds
        heapq.heappush(done, (free[worker], worker))

    for k in range(min(blocks, workers * dask_workers.AHEAD)):
        scheduler_at += 0.5 * scheduling  # half of its work is handing a block out, half taking it back
        run(k % workers, scheduler_at)
    end = 0.0
    while done:
        now, worker = heapq.heappop(done)
        scheduler_at = max(scheduler_at, now) + 0.5 * scheduling
        end = writer_at = max(writer_at, scheduler_at) + writing
        if left:
            scheduler_at += 0.5 * scheduling
            run(worker, max(scheduler_at, writer_at))
    return Outlook(end, blocks * scheduling / end, blocks * writing / end, lost / (blocks * size * rates.trial))


def table(rates: Rates, trials: float, workers: int) -> list[str]:
    """Sizes of a block against what comes of them."""
    ideal = trials * rates.trial / workers
    lines = [
        "| trials a block | a block takes, s | blocks | blocks per s | scheduler busy | writer busy | rows, MB/s "
        "| run again | hours | of ideal |",
        "| ---: " * 10 + "|",
    ]
    for size in SIZES:
        blocks = -(-int(trials) // size)
        shown = min(blocks, 60 * workers)  # long enough for what it settles at; the rest goes on at that pace
        seen = simulate(rates, size, shown, workers)
        wall = seen.wall * blocks / shown
        lines.append(
            f"| {size:,} | {size * rates.trial:.3g} | {blocks:,} | {blocks / wall:.3g} | {seen.scheduler_busy:.0%} "
            f"| {seen.writer_busy:.0%} | {1e-6 * trials * rates.bytes_per_trial / wall:.3g} | {seen.lost:.2%} "
            f"| {wall / 3600.0:.3g} | {wall / ideal:.2f} |"
        )
    return lines


def told(rates: Rates, trials: float, workers: int) -> list[str]:
    """Everything that was measured and follows, as Markdown."""
    volume = 1e-9 * trials * rates.bytes_per_trial
    rows = [
        ("a trial, one controller", f"{1e3 * rates.trial:.3g} ms", f"{trials * rates.trial / 3600.0:,.0f} core hours"),
        ("its rows in a shard", f"{rates.bytes_per_trial:.0f} bytes", f"{volume:,.0f} GB"),
        ("start of a worker", f"{rates.start:.3g} s", f"{workers * rates.start / 3600.0:.2g} core hours"),
        ("a block, scheduler", f"{1e3 * rates.scheduler_block:.3g} ms and {1e3 * rates.scheduler_mb:.3g} ms a MB", ""),
        ("a block, writer", f"{1e3 * rates.writer_block:.3g} ms and {1e3 * rates.writer_mb:.3g} ms a MB", ""),
        (
            "a waiting worker, scheduler",
            f"{1e3 * rates.heartbeat:.2g} ms a second",
            f"{workers * rates.heartbeat:.0%} of a core",
        ),
        (
            "shards to `rows.parquet`",
            f"{rates.gathering:.3g} MB/s",
            f"{1e3 * volume / rates.gathering / 3600.0:.2g} h at the end, in one process",
        ),
        (
            "figures for the page",
            f"{rates.figure_bytes:.0f} bytes a trial",
            f"{1e-9 * trials * rates.figure_bytes:,.0f} GB of memory in one process",
        ),
    ]
    head = [f"| measured | figure | for {trials:.0e} trials on {workers:,} workers |", "| --- | ---: | ---: |"]
    return [*head, *(f"| {a} | {b} | {c} |" for a, b, c in rows), "", *table(rates, trials, workers)]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=float, default=1e9)
    parser.add_argument("--workers", type=int, default=1000)
    parser.add_argument("--docs", type=Path, help="replace the tables of this file")
    options = parser.parse_args()
    rates = Rates()
    for measure in (measure_trials, measure_figures, measure_start, measure_scheduler):
        measure(rates)
        print(f"{measure.__name__}: {rates}", flush=True)
    lines = told(rates, options.trials, options.workers)
    print("\n".join(lines))
    if options.docs is not None:
        text = options.docs.read_text(encoding="utf-8")
        begin, end = "<!-- from here: scale -->", "<!-- to here: scale -->"
        head, rest = text.split(begin)
        new = f"{head}{begin}\n" + "\n".join(lines) + f"\n{end}{rest.split(end)[1]}"
        options.docs.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
