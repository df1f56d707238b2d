"""Ctrl-C: status 130 at any moment, one line, nothing half-written; never swallowed."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest
from processes import command, environment, run
from short_experiment import SHORT

MESSAGE = "asmc-pin: interrupted; nothing half-written was left behind"
VERIFY = ("verify", "two_link", "--mbar", "0.01", "--samples", "64", "--json")
HERE = "import os, signal\ndef press(): os.kill(os.getpid(), signal.SIGINT)\n"


def interrupted_at_import(number: int) -> subprocess.CompletedProcess[str]:
    """Ctrl-C when so many modules are loaded after the handler: the same moment on a slow machine and on a fast one."""
    arguments = command(*VERIFY, options=("-X", "importtime"))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(arguments, env=environment(), **pipes) as process:
        lines, count = [], None
        for line in process.stderr:
            lines.append(line)
            if line.endswith("asmc_pin.cli.console\n"):
                count = 0
            count = None if count is None else count + 1
            if count == number:
                process.send_signal(signal.SIGINT)
        out = process.stdout.read()
    return subprocess.CompletedProcess(arguments, process.returncode, out, "".join(lines[-3:]))


def moments(count: int, seed: int) -> list[int]:
    return [1, *sorted(random.Random(seed).sample(range(2, 1100), count - 1))]


@pytest.mark.parametrize("number", moments(6, seed=1))
def test_ctrl_c_while_python_imports_is_130(number):
    done = interrupted_at_import(number)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.splitlines()[-1] == MESSAGE


@pytest.mark.long
@pytest.mark.parametrize("number", moments(40, seed=2))
def test_ctrl_c_at_many_moments_of_the_imports_is_130(number):
    test_ctrl_c_while_python_imports_is_130(number)


@pytest.mark.long
@pytest.mark.parametrize("share", [0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05])
def test_ctrl_c_at_any_time_is_130_or_too_late(share):
    began = time.monotonic()
    whole = run(*VERIFY)
    wall = time.monotonic() - began
    assert whole.returncode == 0
    with subprocess.Popen(
        command(*VERIFY), env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        time.sleep(share * wall)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode in (130, 0)
    assert b"Traceback" not in err
    if process.returncode == 0:
        assert json.loads(out)["verdict"] == "unrefuted"


GUARD = """
import asmc_pin.cli.commands.listing_commands as tables
def guarded():
    while True:
        try:
            press()
            time.sleep(60)
        except BaseException:
            pass
tables.arm_rows = guarded
"""


def test_no_guard_in_anybodys_code_swallows_it():
    done = run("arms", before=f"{HERE}import time{GUARD}", timeout=60)
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


def interrupted_while_writing(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    (folder / "short.toml").write_text(SHORT)
    arguments = command("compare", "short.toml", *options)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(arguments, env=environment(), cwd=folder, **pipes) as process:
        deadline = time.monotonic() + 120
        while not list(folder.glob("results/.short.*.new/*")) and process.poll() is None:
            assert time.monotonic() < deadline
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    return subprocess.CompletedProcess(arguments, process.returncode, out, err)


def test_a_result_that_was_being_written_leaves_nothing_and_a_former_one_stays(tmp_path):
    done = interrupted_while_writing(tmp_path)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.splitlines()[-1] == MESSAGE
    assert list((tmp_path / "results").iterdir()) == []
    former = tmp_path / "results" / "short"
    former.mkdir()
    for name in ("experiment.toml", "provenance.json"):
        (former / name).write_text("former")
    done = interrupted_while_writing(tmp_path, "--force")
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
    done = run(*CERTIFY, "--certificate", "proof.npz", before=before, cwd=tmp_path, timeout=240)
    assert done.returncode == 130, done.stderr
    found = json.loads(done.stdout)
    assert 0.3 < found["scale_proven"] <= found["scale_refuted"]
    assert done.stderr.splitlines()[-1] == "asmc-pin: interrupted; what is printed is what was known by then"
    checked = run("check", "proof.npz", "--json", cwd=tmp_path)
    assert json.loads(checked.stdout)["valid"]


STUBBORN = """
import time
import asmc_pin.condition.certificate as certificate
def stubborn(*arguments, progress, **options):
    state = type("State", (), {"proven": 0.0, "refuted": 1.0, "trying": "", "seconds": 0.0})
    progress(state)
    try:
        press()
    except KeyboardInterrupt:
        press()
    time.sleep(60)
certificate.certify = stubborn
"""


def test_a_second_ctrl_c_waits_for_nothing():
    done = run(*CERTIFY, before=HERE + STUBBORN, timeout=55)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.splitlines()[-1] == MESSAGE
