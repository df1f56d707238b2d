"""Whatever a file holds, no command crashes, hangs, lies or says more than one message: see the folder `fuzz`.

Each kind of input runs in a process of its own, which forks for every input. `make fuzz` runs ten thousand of each.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
SOME = {"urdf": 200, "toml": 60, "certificate": 150, "result": 100}
MANY = 1000


def campaign(kind, *options):
    """What a run of the fuzzer printed; it must have found nothing."""
    command = [sys.executable, "-m", "fuzz", "--kind", kind, *map(str, options)]
    path = os.pathsep.join([str(TESTS), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(command, cwd=TESTS, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("kind", SOME)
def test_some_hostile_files_of_every_kind(kind):
    said = campaign(kind, "--count", SOME[kind], "--workers", 1)
    assert f"{SOME[kind]} inputs" in said


@pytest.mark.long
@pytest.mark.parametrize("kind", SOME)
def test_a_thousand_hostile_files_of_every_kind(kind):
    said = campaign(kind, "--count", MANY, "--seed", 1, "--workers", 1)
    assert f"{MANY} inputs" in said
