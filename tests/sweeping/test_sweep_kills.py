"""A sweep that is killed at any moment and started again ends with the same bytes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from processes import environment
from sweep_cases import contents

# Forks a sweep again and again from a process that has everything loaded, and kills it; the last one may end.
DRIVER = """
import json, os, random, signal, sys, time
from pathlib import Path
from sweep_cases import tiny
from asmc_pin.sweeping import sweep
from asmc_pin.sweeping.row_files import key_of, shards_there

folder, kills, seed, workers = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])

def once(where):
    sweep(tiny(), 10, where, workers=workers, block=2)

once(folder / "whole")
began = time.monotonic()
once(folder / "timed") if workers == 1 else None
wall = max(time.monotonic() - began, 3.0 * (workers > 1))
moments, half_done = random.Random(seed), 0
for _ in range(kills):
    child = os.fork()
    if child == 0:
        try:
            once(folder / "killed")
        finally:
            os._exit(0)
    time.sleep(moments.uniform(0.0, wall))
    os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    shards = shards_there(folder / "killed")
    assert all(key is not None for key in shards.values()), "a shard is not whole"
    half_done += os.WIFSIGNALED(status) and not (folder / "killed" / "provenance.json").exists()
once(folder / "killed")
print(json.dumps({"half_done": half_done}))
"""


def killed(folder: Path, kills: int, seed: int, workers: int = 1) -> dict[str, int]:
    here = str(Path(__file__).resolve().parent.parent / "support")
    paths = environment()["PYTHONPATH"]
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", DRIVER, str(folder), str(kills), str(seed), str(workers)],
        env=environment(PYTHONPATH=f"{here}:{paths}"),
        capture_output=True,
        text=True,
        timeout=500,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, int] = json.loads(done.stdout)
    return found


def test_three_kills_leave_the_same_bytes(tmp_path):
    assert killed(tmp_path, 3, seed=1)["half_done"] >= 1
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_fifty_kills_leave_the_same_bytes(tmp_path, seed):
    killed(tmp_path, 10, seed)
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")
