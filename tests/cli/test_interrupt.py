"""Ctrl-C: status 130 at any moment, one line, nothing half-written; never swallowed."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import moments
import pytest
from processes import command, environment, run
from short_experiment import SHORT

MESSAGE = "asmc-pin: interrupted; nothing half-written was left behind"
VERIFY = ("verify", "two_link", "--mbar", "0.01", "--samples", "64", "--json")
HERE = f"""
import os, signal, sys, time
sys.path.append({str(Path(moments.__file__).parent)!r})
from moments import after_calls, when_opened
def press(): os.kill(os.getpid(), signal.SIGINT)
"""
# Something is done as soon as the handler of Ctrl-C is there; before that Ctrl-C is Python's own affair.
ONCE_HEARD = """
set_handler = signal.signal
def heard(*arguments):
    signal.signal = set_handler
    former = set_handler(*arguments)
    {}
    return former
signal.signal = heard
"""


def moments_of_the_imports(count: int, seed: int) -> list[int]:
    """Calls after the handler is there: a command makes some 1.8 million before all is imported."""
    return [1, *sorted(random.Random(seed).sample(range(2, 1_900_000), count - 1))]


@pytest.mark.parametrize("number", moments_of_the_imports(6, seed=1))
def test_ctrl_c_while_python_imports_is_130(number):
    done = run(*VERIFY, before=HERE + ONCE_HEARD.format(f"after_calls({number}, press)"))
    assert (done.returncode, done.stdout) == (130, "")
    *earlier, last = done.stderr.splitlines()
    assert last == MESSAGE
    assert all(line.startswith("asmc-pin: warning:") for line in earlier), earlier  # where all was imported already


@pytest.mark.long
@pytest.mark.parametrize("number", moments_of_the_imports(40, seed=2))
def test_ctrl_c_at_many_moments_of_the_imports_is_130(number):
    test_ctrl_c_while_python_imports_is_130(number)


@contextmanager
def heard() -> Iterator[subprocess.Popen[str]]:
    """A command from the moment on at which it hears Ctrl-C."""
    arguments = command(*VERIFY, before=HERE + ONCE_HEARD.format("os.write(2, b'heard\\n')"))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(arguments, env=environment(), **pipes) as process:
        assert process.stderr.readline() == "heard\n"
        yield process


@pytest.mark.long
@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05])
def test_ctrl_c_at_any_time_is_130_or_too_late(share):
    with heard() as process:
        began = time.monotonic()
        process.communicate(timeout=300)
        wall = time.monotonic() - began
    assert process.returncode == 0
    with heard() as process:
        time.sleep(share * wall)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=300)
    assert process.returncode in (130, 0)
    assert "Traceback" not in err
    if process.returncode == 0:
        assert json.loads(out)["verdict"] == "unrefuted"


GUARD = """
import asmc_pin.cli.commands.listing_commands as tables
def guarded():
    while True:
        try:
            press()
            time.sleep(3600)
        except BaseException:
            pass
tables.arm_rows = guarded
"""


def test_no_guard_in_anybodys_code_swallows_it():
    done = run("arms", before=HERE + GUARD)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", MESSAGE + "\n")


def test_where_it_is_ignored_it_stays_ignored():
    before = (
        f"{HERE}signal.signal(signal.SIGINT, signal.SIG_IGN)\nimport asmc_pin.cli.commands.listing_commands as tables\n"
    )
    before += "tables.arm_rows = lambda: (press(), (['a'], [['b']]))[1]"
    assert run("arms", before=before).returncode == 0


def test_the_caller_of_main_gets_its_own_handler_back():
    from asmc_pin.cli import main

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit):
        main(["--version"])
    assert signal.getsignal(signal.SIGINT) is before


# Results --------------------------------------------------------------------------------------------------------------


def interrupted_while_writing(folder: Path, *options: str, files: int) -> subprocess.CompletedProcess[str]:
    """Ctrl-C as so many files of the new result have been opened; the last line but one tells how many are there."""
    (folder / "short.toml").write_text(SHORT)
    tell = "os.write(2, b'%d there\\n' % sum(len(f) for _, _, f in os.walk('results')))"
    before = f"{HERE}when_opened('.new/', {files}, lambda: ({tell}, press()))"
    return run("compare", "short.toml", *options, before=before, cwd=folder)


@pytest.mark.parametrize("files", [2, 15, 40])
def test_a_result_that_was_being_written_leaves_nothing_and_a_former_one_stays(tmp_path, files):
    done = interrupted_while_writing(tmp_path, files=files)
    assert (done.returncode, done.stdout) == (130, "")
    *_, there, last = done.stderr.splitlines()
    assert int(there.split()[0]) >= 1
    assert last == MESSAGE
    assert list((tmp_path / "results").iterdir()) == []
    former = tmp_path / "results" / "short"
    former.mkdir()
    for name in ("experiment.toml", "provenance.json"):
        (former / name).write_text("former")
    done = interrupted_while_writing(tmp_path, "--force", files=files)
    assert done.returncode == 130
    assert [path.name for path in (tmp_path / "results").iterdir()] == ["short"]
    assert (former / "provenance.json").read_text() == "former"


SWAP = """
import os
replace = os.replace
def pressed(source, target):
    replace(source, target)
    press()
os.replace = pressed
from pathlib import Path
import asmc_pin.cli.commands.listing_commands as tables
from asmc_pin.disk.files import whole_folder
def rows():
    with whole_folder(Path("result")) as made:
        (made / "x").write_text("new")
tables.arm_rows = rows
"""


def test_a_former_result_comes_back_when_its_place_is_being_taken(tmp_path):
    (tmp_path / "result").mkdir()
    (tmp_path / "result" / "x").write_text("former")
    # Ctrl-C where the former folder has made room and the new one has not come.
    done = run("arms", before=HERE + SWAP, cwd=tmp_path)
    assert done.returncode == 130
    assert [path.name for path in tmp_path.iterdir()] == ["result"]
    assert (tmp_path / "result" / "x").read_text() == "former"


# A proof says what it has ---------------------------------------------------------------------------------------------

PROOF = """
import asmc_pin.condition.certificate as certificate
certify = certificate.certify
def pressed(*arguments, progress, **options):
    def tell(state):
        progress(state)
        if state.proven > 0.3:
            press()
    return certify(*arguments, progress=tell, **options)
certificate.certify = pressed
"""
UR5 = "0.14832641,0.16745535,0.15042782,0.08106527,0.09334419,0.01713695"
CERTIFY = ("verify", "ur5", "--mbar", UR5, "--certify", "--gap", "1e-6", "--budget", "600", "--json")


def test_ctrl_c_during_a_proof_prints_what_is_proven_and_is_130(tmp_path):
    before = HERE + PROOF
    done = run(*CERTIFY, "--certificate", "proof.npz", before=before, cwd=tmp_path, timeout=600)
    assert done.returncode == 130, done.stderr
    found = json.loads(done.stdout)
    assert 0.3 < found["scale_proven"] <= found["scale_refuted"]
    assert done.stderr.splitlines()[-1] == "asmc-pin: interrupted; what is printed is what was known by then"
    checked = run("check", "proof.npz", "--json", cwd=tmp_path)
    assert json.loads(checked.stdout)["valid"]


STUBBORN = """
import asmc_pin.condition.certificate as certificate
def stubborn(*arguments, progress, **options):
    state = type("State", (), {"proven": 0.0, "refuted": 1.0, "trying": "", "seconds": 0.0})
    progress(state)
    try:
        press()
    except KeyboardInterrupt:
        press()
    time.sleep(3600)
certificate.certify = stubborn
"""


def test_a_second_ctrl_c_waits_for_nothing():
    done = run(*CERTIFY, before=HERE + STUBBORN)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.splitlines()[-1] == MESSAGE
