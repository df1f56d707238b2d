"""A sweep that is killed at any moment and started again ends with the same bytes."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from processes import command, environment, group_lives, run
from sweep_cases import contents, tiny

from asmc_pin.sweeping import sweep

# Forks a sweep again and again from a process that has everything loaded, and kills it: by the clock at any moment,
# even one that is too late, or where it has made so many of all its calls, which on every machine is in mid run.
DRIVER = """
import json, os, random, signal, sys, time
from pathlib import Path
from moments import after_calls, calls
from sweep_cases import tiny
from asmc_pin.sweeping import sweep
from asmc_pin.sweeping.row_files import key_of, shards_there

folder, kills, seed, by_clock = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4] == "clock"

def once(where):
    sweep(tiny(), 10, where, workers=1, block=2)

once(folder / "whole")
began = time.monotonic()
once(folder / "timed")
wall = time.monotonic() - began
made = calls(lambda: once(folder / "counted"))
moments, half_done = random.Random(seed), 0
for _ in range(kills):
    share = moments.uniform(0.0, 0.95)
    child = os.fork()
    if child == 0:
        try:
            if not by_clock:
                after_calls(int(share * made), lambda: os.kill(os.getpid(), signal.SIGKILL))
            once(folder / "killed")
        finally:
            os._exit(0)
    if by_clock:
        time.sleep(share * wall)
        os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    shards = shards_there(folder / "killed")
    assert all(key is not None for key in shards.values()), "a shard is not whole"
    half_done += os.WIFSIGNALED(status) and not (folder / "killed" / "provenance.json").exists()
once(folder / "killed")
print(json.dumps({"half_done": half_done}))
"""


def killed(folder: Path, kills: int, seed: int, by: str) -> dict[str, int]:
    here = str(Path(__file__).resolve().parent.parent / "support")
    paths = environment()["PYTHONPATH"]
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", DRIVER, str(folder), str(kills), str(seed), by],
        env=environment(PYTHONPATH=f"{here}:{paths}"),
        capture_output=True,
        text=True,
        timeout=500,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, int] = json.loads(done.stdout)
    return found


def test_three_kills_leave_the_same_bytes(tmp_path):
    assert killed(tmp_path, 3, seed=1, by="calls")["half_done"] >= 1
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")


@pytest.mark.long
@pytest.mark.parametrize("by", ["calls", "clock"])
@pytest.mark.parametrize("seed", range(5))
def test_a_hundred_kills_leave_the_same_bytes(tmp_path, seed, by):
    killed(tmp_path, 10, seed, by)
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")


@pytest.mark.long
def test_a_killed_sweep_of_two_workers_leaves_none_of_them_and_ends_with_the_same_bytes(tmp_path):
    """The command line, killed with nothing told to its workers, twice; then to its end."""
    (tmp_path / "tiny.toml").write_text(tiny(duration=0.5).to_toml())
    arguments = ("sweep", "tiny.toml", "--trials", "100", "--workers", "2", "--block", "4")
    rows = tmp_path / "results" / "tiny-sweep" / "rows"
    for wanted in (3, 9):
        process = subprocess.Popen(
            command(*arguments), env=environment(), cwd=tmp_path, stderr=subprocess.DEVNULL, start_new_session=True
        )
        try:
            deadline = time.monotonic() + 200
            while len(list(rows.glob("*.parquet"))) < wanted:
                assert time.monotonic() < deadline
                assert process.poll() is None, "it was over before it was killed"
                time.sleep(0.01)
            process.kill()
            process.wait()
            while group_lives(process.pid):
                assert time.monotonic() < deadline, "a worker outlives the sweep"
                time.sleep(0.1)
        finally:
            if group_lives(process.pid):
                os.killpg(process.pid, signal.SIGKILL)
    kept = {path: path.stat().st_mtime_ns for path in rows.glob("*.parquet")}
    assert 9 <= len(kept) < 50
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {path: path.stat().st_mtime_ns for path in kept} == kept, "what was there is not computed again"
    sweep(tiny(duration=0.5), 100, tmp_path / "whole", workers=1, block=4)
    assert contents(rows.parent) == contents(tmp_path / "whole")
