"""A tuning that is killed at any moment and started again ends with the same bytes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from processes import environment
from tune_cases import repeatable

# Forks a tuning again and again from a process that has everything loaded, and kills it where it has made so many of
# all its calls, which on every machine is in mid run.
DRIVER = """
import json, os, random, signal, sys
from pathlib import Path
from moments import after_calls, calls
from tune_cases import small
from asmc_pin.tuning import tune

folder, kills, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])

def once(where):
    tune(small(), 36, where)

once(folder / "whole")
made = calls(lambda: once(folder / "counted"))
moments, half_done = random.Random(seed), 0
for _ in range(kills):
    moment = int(moments.uniform(0.05, 0.7) * made)
    child = os.fork()
    if child == 0:
        try:
            after_calls(moment, lambda: os.kill(os.getpid(), signal.SIGKILL))
            once(folder / "killed")
        finally:
            os._exit(0)
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
