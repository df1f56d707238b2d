"""Whatever a file holds, no command crashes, hangs, lies or says more than one message: see the folder `fuzz`.

Each kind of input runs in a process of its own, which forks for every input. `make fuzz` runs ten thousand of each.
"""

import contextlib
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from fuzz import generate_toml, generate_urdf
from fuzz.hostile import INJECTED
from fuzz.judge import faults
from fuzz.run import MEMORY, Outcome, command
from paths import TESTS

from asmc_pin import load_arm
from asmc_pin.errors import ArmError
from asmc_pin.experiment import Experiment

SOME = {"urdf": 60, "toml": 20, "certificate": 50, "result": 40}
MANY = 500


def campaign(kind, *options):
    """What a run of the fuzzer printed; it must have found nothing."""
    command = [sys.executable, "-m", "fuzz", "--kind", kind, *map(str, options)]
    path = os.pathsep.join([str(TESTS), str(TESTS / "support"), *filter(None, [os.environ.get("PYTHONPATH")])])
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
def test_five_hundred_hostile_files_of_every_kind(kind):
    said = campaign(kind, "--count", MANY, "--seed", 1, "--workers", 1)
    assert f"{MANY} inputs" in said


def said(status=0, out="", err="", trace="", signal=0, claims=()):
    return Outcome(status, signal, out.encode(), err.encode(), trace, 0.1, list(claims))


TRACE = 'Traceback (most recent call last):\n  File "/x/asmc_pin/arms/loading.py", line 9, in load_arm\nKeyError: 1\n'
WRONG = {
    "an exception came out of main": said(1, trace=TRACE),
    "status 5": said(5),
    "status 4": said(4, err="asmc-pin: a fault of ours, see ours.txt\n"),
    "killed by signal 11": said(None, signal=11),
    "hangs": said(None, signal=24),
    "traceback on standard error": said(2, err=f"asmc-pin: no\n{TRACE}"),
    "a stranger's words on standard error": said(0, "{}", err="Error: mass\n"),
    "status 2 with standard output": said(2, "{}", "asmc-pin: no\n"),
    "status 2 with other than one message": said(2, err="asmc-pin: warning: this\n"),
    "an empty message": said(2, err="asmc-pin: \n"),
    "out of memory": said(2, err="asmc-pin: out of memory\n"),
    "a message without end": said(2, err=f"asmc-pin: {'n' * 5000}\n"),
    "a library's warning": said(0, "{}", "asmc-pin: warning: invalid value encountered in sqrt\n"),
    "a control character on standard output": said(0, '{"a": "\x1b[31m"}'),
    "a control character on standard error": said(0, "{}", "asmc-pin: \u202e\n"),
    "a control character in JSON": said(0, '{"a\\u001b": 1}'),
    "not one valid JSON object": said(0, '{"a": NaN}'),
    "false claim": said(0, "{}", claims=["untrue: the norm is 2"]),
    "left behind": said(0, "{}"),
    "markup in a page": said(0, "{}"),
    "a stranger's code was imported": said(0, "{}"),
}
LEFT = {
    "left behind": ("made.new", ""),
    "markup in a page": ("page.html", INJECTED),
    "a stranger's code was imported": ("imported", ""),
}


@pytest.mark.parametrize("what", WRONG)
def test_each_fault_is_found(what, tmp_path):
    for folder in ("work", "tmp"):
        (tmp_path / folder).mkdir()
    if what in LEFT:
        name, content = LEFT[what]
        (tmp_path / "work" / name).write_text(content)
    assert what in {fault.what for fault in faults(["verify", "--json"], WRONG[what], tmp_path)}


@pytest.mark.parametrize(
    "right",
    [
        said(0, '{"a": null}\n', "asmc-pin: warning: prismatic: j\n"),
        said(1, "{}"),
        said(3, "{}", "asmc-pin: nothing is proven\n"),
        said(2, err="asmc-pin: warning: this\nasmc-pin: x.toml: 2 mistakes\n  a: is\n  b: too\n"),
        said(130, err="asmc-pin: interrupted\n"),
    ],
)
def test_what_is_as_it_should_be_is_no_fault(right, tmp_path):
    for folder in ("work", "tmp"):
        (tmp_path / folder).mkdir()
    assert list(faults(["verify", "--json"], right, tmp_path)) == []


def test_a_traceback_in_a_file_that_the_message_names_gives_the_place(tmp_path):
    (tmp_path / "work").mkdir()
    (tmp_path / "tmp").mkdir()
    (tmp_path / "tmp" / "ours.txt").write_text(TRACE)
    (fault,) = faults(["verify"], said(4, err="asmc-pin: a fault of ours, see ours.txt\n"), tmp_path)
    assert fault.where == "KeyError at asmc_pin/arms/loading.py:load_arm"


def hang():
    while True:
        pass


def swell():
    bytearray(4 * MEMORY)


def crash():
    os.kill(os.getpid(), signal.SIGSEGV)


@pytest.mark.parametrize(("does", "what"), [(hang, "hangs"), (swell, "MemoryError"), (crash, "killed by signal 11")])
def test_what_hangs_swells_or_crashes_ends_alone_and_is_told(does, what, tmp_path, monkeypatch):
    monkeypatch.setattr("fuzz.run.SECONDS", 1)
    (tmp_path / "work").mkdir()
    outcome = command(["arms"], tmp_path, before=does)
    assert any(what in f"{fault.what} {fault.where}" for fault in faults(["arms"], outcome, tmp_path))


def test_a_command_runs_as_from_a_shell(tmp_path):
    (tmp_path / "work").mkdir()
    outcome = command(["verify", "nowhere", "--mbar", "1"], tmp_path)
    assert (outcome.status, outcome.out, outcome.trace) == (2, b"", "")
    assert outcome.err.startswith(b"asmc-pin: 'nowhere'")
    assert list(faults(["verify"], outcome, tmp_path)) == []


@pytest.mark.parametrize("make", [generate_urdf.make, generate_toml.make])
def test_the_same_seed_gives_the_same_files(make, tmp_path):
    sound = [b"<robot/>"] if make is generate_urdf.make else [b"name = 'x'\n"]

    def made(folder, seed):
        folder.mkdir()
        words = make(np.random.default_rng(seed), folder, sound)
        return words, {path.name: path.read_bytes() for path in folder.iterdir()}

    assert made(tmp_path / "a", 3) == made(tmp_path / "b", 3)
    assert made(tmp_path / "c", 4) != made(tmp_path / "d", 5)


def test_what_is_generated_is_sound_before_it_is_disturbed(tmp_path):
    rng = np.random.default_rng(0)
    path = tmp_path / "arm.urdf"
    for _ in range(20):
        path.write_text(generate_urdf.text(rng, generate_urdf.sound(rng, 3)), encoding="utf-8")
        with contextlib.suppress(ArmError) if "mimic" in path.read_text() else contextlib.nullcontext():
            load_arm(path)
    for _ in range(10):
        experiment = generate_toml.small(rng)
        if experiment["reference"]["kind"] != "csv":
            Experiment.from_dict({**experiment, "controllers": {"A": {"law": "ppc"}}})
