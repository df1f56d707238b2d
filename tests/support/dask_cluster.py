"""A real Dask scheduler with workers, each a process of its own on the loopback interface."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from processes import environment


@dataclass
class Cluster:
    """What runs: `workers` may be killed."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


def _address(told: Path) -> str | None:
    """What the scheduler's file says; None while it is not there or not written to its end."""
    try:
        return str(json.loads(told.read_text())["address"])
    except (FileNotFoundError, json.JSONDecodeError):
        return None


@contextmanager
def dask_cluster(folder: Path, workers: int, **variables: str) -> Iterator[Cluster]:
    """A cluster; whatever is left of it is killed afterwards.

    Args:
        folder: For its files.
        workers: How many, of one thread each.
        variables: Of their environment.
    """
    told = folder / "scheduler.json"
    log = (folder / "cluster.log").open("wb")
    common = {"env": environment(**variables), "cwd": folder, "stdout": log, "stderr": log}
    module = [sys.executable, "-m", "distributed.cli."]
    here = ["--host", "127.0.0.1"]

    def start(name: str, *arguments: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen([*module[:-1], module[-1] + name, *here, *arguments], **common)  # type: ignore[call-overload, no-any-return]

    started = [start("dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(told))]
    try:
        deadline = time.monotonic() + 120
        while (address := _address(told)) is None:
            assert time.monotonic() < deadline, "the scheduler does not start"
            assert started[0].poll() is None
            time.sleep(0.05)
        few = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder)]
        started += [start("dask_worker", address, *few) for _ in range(workers)]
        yield Cluster(address, started[0], started[1:])
    finally:
        for process in started:
            if process.poll() is None:
                process.kill()
            process.wait()
        log.close()
