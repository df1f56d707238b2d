"""A tuning that is killed at any moment and started again ends with the same bytes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from processes import environment
from tune_cases import repeatable

# Forks a tuning again and again from a process that has everything loaded, and kills it.
DRIVER = """
import json, os, random, signal, sys, time
from pathlib import Path
from tune_cases import small
from asmc_pin.tuning import tune

folder, kills, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])

def once(where):
    tune(small(), 36, where)

began = time.monotonic()
once(folder / "whole")
wall = time.monotonic() - began
moments, half_done = random.Random(seed), 0
for _ in range(kills):
    child = os.fork()
    if child == 0:
        try:
            once(folder / "killed")
        finally:
            os._exit(0)
    time.sleep(moments.uniform(0.05, 0.7) * wall)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    half_done += not (folder / "killed" / "provenance.json").exists()
once(folder / "killed")
print(json.dumps({"half_done": half_done}))
"""


@pytest.mark.long
def test_three_kills_leave_the_same_bytes(tmp_path):
    here = str(Path(__file__).resolve().parent.parent / "support")
    paths = environment()["PYTHONPATH"]
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", DRIVER, str(tmp_path), "3", "1"],
        env=environment(PYTHONPATH=f"{here}:{paths}"),
        capture_output=True,
        text=True,
        timeout=500,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["half_done"] >= 1
    assert repeatable(tmp_path / "killed") == repeatable(tmp_path / "whole")
