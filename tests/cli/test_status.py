"""Every end has its status: faults, closed readers, encodings, typing errors; whatever is in the way."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest
from processes import command, environment, run

from asmc_pin.clock import Clock, tell_of_compiling
from asmc_pin.words.media import ascii_signs

VIOLATED = ("verify", "two_link", "--mbar", "10", "--samples", "64")
HOLDS = ("verify", "two_link", "--mbar", "0.01", "--samples", "64")


# Faults ---------------------------------------------------------------------------------------------------------------

IN_THE_WAY = """
import atexit, os, sys, threading
import asmc_pin.cli.commands.listing_commands as tables
def rows():
    {}
    return ["a"], [["b"]]
tables.arm_rows = rows
"""


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("raise ValueError('a\\nb \\x1b[31m')", "ValueError: a\\x0ab \\x1b[31m"),
        ("raise type('Panic', (BaseException,), {})('deep')", "Panic: deep"),
        ("raise OSError('a library has its own words')", "OSError: a library has its own words"),
        ("open(os.path.join(os.path.dirname(tables.__file__), 'gone.txt'))", "FileNotFoundError"),
        ("import numpy; numpy.linalg.inv([[0.0]])", "LinAlgError: Singular matrix"),
        ("sys.exit(1)", "SystemExit: 1"),
        ("t = threading.Thread(target=lambda: 1 / 0); t.start(); t.join()", "ZeroDivisionError"),
        ("atexit.register(lambda: 1 / 0)", "ZeroDivisionError"),
        ("type('D', (), {'__del__': lambda self: 1 / 0})()", "ZeroDivisionError"),
        ("(f := lambda: f())()", "RecursionError"),
    ],
)
def test_what_nobody_foresaw_is_status_4_one_line_and_a_file_with_the_traceback(what, says, tmp_path):
    done = run("arms", before=IN_THE_WAY.format(what), env={"TMPDIR": str(tmp_path)})
    assert done.returncode == 4
    assert done.stderr.startswith("asmc-pin: a fault of asmc-pin itself, ")
    assert says in done.stderr
    assert done.stderr.count("\n") == 1
    name = re.search(r"traceback in (\S+)", done.stderr)[1]
    text = Path(name).read_text(encoding="utf-8")
    assert Path(name).parent == tmp_path
    assert "Traceback (most recent call last)" in text
    assert "['arms']" in text


def test_a_fault_says_so_where_its_traceback_can_be_written_nowhere(tmp_path):
    before = IN_THE_WAY.format("raise ValueError('x')") + "import tempfile\ntempfile.tempdir = '/nowhere'\n"
    before += "os.makedirs('gone'); os.chdir('gone'); os.rmdir('../gone')"
    done = run("arms", before=before, cwd=tmp_path)
    assert done.returncode == 4
    assert "could not be written" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("raise OSError(28, 'No space left on device', 'page.html')", "No space left on device: page.html"),
        ("open('/nowhere/at/all')", "No such file or directory: /nowhere/at/all"),
        ("raise MemoryError", "out of memory"),
    ],
)
def test_what_the_users_disk_and_memory_answer_is_status_2(what, says):
    done = run("arms", before=IN_THE_WAY.format(what))
    assert (done.returncode, done.stdout) == (2, "")
    assert says in done.stderr
    assert done.stderr.count("\n") == 1


# Readers that leave ---------------------------------------------------------------------------------------------------


def without_reader(arguments: tuple[str, ...], which: str) -> subprocess.CompletedProcess[bytes]:
    reading, writing = os.pipe()
    os.close(reading)
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, which: writing}
    done = subprocess.run(command(*arguments), env=environment(), timeout=300, **streams)
    os.close(writing)
    return done


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (VIOLATED, 1),
        ((*VIOLATED, "--json"), 1),
        (("verify", "nosuch", "--mbar", "1"), 2),
        (("controllers",), 0),
        (("verify", "--help"), 0),
    ],
)
@pytest.mark.parametrize("which", ["stdout", "stderr"])
def test_a_reader_that_leaves_keeps_the_status(arguments, status, which):
    done = without_reader(arguments, which)
    assert done.returncode == status
    assert b"roken" not in (done.stderr or b"")
    assert b"rror" not in (done.stderr or b"")


def test_streams_that_are_closed_keep_the_status_and_nothing_is_written_elsewhere(tmp_path):
    shell = 'exec "$0" "$@" >&- 2>&- <&-'
    page = tmp_path / "page.md"
    arguments = command(*VIOLATED, "--report", str(page))
    assert subprocess.run(["sh", "-c", shell, *arguments], env=environment(), timeout=300).returncode == 1
    assert page.read_text(encoding="utf-8").startswith("# Lemma 1 on two_link: violated")
    shell = 'exec "$0" "$@" 2>&-'
    done = subprocess.run(["sh", "-c", shell, *command("view", "nosuch")], env=environment(), capture_output=True)
    assert (done.returncode, done.stdout) == (2, b"")  # a message that has no place is no result


@pytest.mark.parametrize("arguments", [VIOLATED, ("--version",)])
def test_a_disk_too_full_for_the_result_is_one_message_and_status_2(arguments):
    with open("/dev/full", "w") as full:
        done = run(*arguments, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == "asmc-pin: standard output cannot be written: No space left on device"
    assert "Traceback" not in done.stderr


# Encodings ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252", "utf-16", "utf-8:strict"])
@pytest.mark.parametrize(("arguments", "status"), [(("design", "--help"), 0), (("verify", "ü", "--mbar", "1"), 2)])
def test_an_encoding_without_our_signs_changes_the_signs_and_not_the_status(encoding, arguments, status):
    done = run(*arguments, env={"PYTHONIOENCODING": encoding}, encoding=encoding.partition(":")[0])
    assert done.returncode == status
    assert "Traceback" not in done.stderr


def test_a_verdict_can_be_read_in_ascii():
    done = run(*VIOLATED, env={"PYTHONIOENCODING": "ascii"}, encoding="ascii")
    assert done.returncode == 1
    assert "||I - M^-1Mbar||2 < 1" in done.stdout


def test_the_plain_c_locale_is_enough(tmp_path):
    with open(tmp_path / "out", "wb") as out:
        locale = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
        assert run(*HOLDS, env=locale, capture_output=False, stdout=out).returncode == 0
    assert b"unrefuted" in (tmp_path / "out").read_bytes()


def test_json_is_the_same_object_in_every_encoding():
    texts = [run("controllers", "--json", env={"PYTHONIOENCODING": name}).stdout for name in ("ascii", "utf-8")]
    assert texts[0].isascii()
    assert not texts[1].isascii()
    assert json.loads(texts[0]) == json.loads(texts[1])


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("‖I − M⁻¹M̄‖₂ ≤ 1…", "||I - M^-1Mbar||2 <= 1..."),
        ("q̈ = ω·τ², ∞ Γ", "qddot = omega*tau^2, inf Gamma"),
        ("Gelenk_ü → 手", "Gelenk_u -> \\u624b"),
    ],
)
def test_signs_have_letters_that_a_person_can_read(text, plain):
    assert ascii_signs(text) == plain


# Typing errors --------------------------------------------------------------------------------------------------------

HEAVY = ["numpy", "pinocchio", "numba", "matplotlib", "pandas", "xarray", "cvxpy", "scipy"]
HEAVY += ["h5py", "trimesh", "meshcat", "mujoco", "optuna"]
LOADED = f"""
import os, sys
def tell(status, end=os._exit):
    os.write(2, " ".join(["loaded:", *sorted(set({HEAVY}) & set(sys.modules))]).encode())
    end(status)
os._exit = tell
"""


@pytest.mark.parametrize(
    "arguments",
    [
        "",
        "frobnicate",
        "compare nosuch",
        "compare BROKEN",
        "verify nosuch --mbar 1",
        "verify ur5",
        "verify ur5 --mbar abc",
        "verify ur5 --mbar 1 --frobnicate",
        "verify ur5 --mbar 1 --condition lemma2",
        "verify ur5 --mbar 1 --along nosuch",
        "verify ur5 --mbar 1 --along nosuch.csv",
        "verify ur5 --mbar 1 --box elbow_joint",
        "verify ur5 --mbar 1 --payload heavy",
        "verify ur5 --mbar 1 --armature x",
        "verify ur5 --mbar 1 --lock elbow_joint=x",
        "verify ur5 --mbar 1 --gravity down",
        "verify ur5 --mbar 1 --report page.txt",
        "verify ur5 --mbar 1 --report nosuch/page.html",
        "verify ur5 --mbar 1 --certificate file.npz",
        "design nosuch",
        "design ur5 --objective speed",
        "design ur5 --form round",
        "design ur5 --gains --period x",
        "design ur5 --bounds elbow_joint",
        "stability ur5 --mbar 1 --ks 1 --beta 1 --period x",
        "stability ur5 --mbar 1 --ks x --beta 1 --period 0.001",
        "stability ur5 --mbar 1 --ks 1 --beta 1 --period 0.001 --acceleration guess",
        "agree nosuch",
        "check nosuch",
        "check .",
        "report nosuch",
        "view nosuch",
        "view nosuch --port x",
        "reproduce nosuch",
    ],
)
def test_a_typing_error_is_answered_before_anything_heavy_is_loaded(arguments, tmp_path):
    (tmp_path / "BROKEN").write_text("name = ")
    done = run(*arguments.split(), before=LOADED, cwd=tmp_path)
    message, loaded = done.stderr.splitlines()
    assert (done.returncode, done.stdout) == (2, "")
    assert message.startswith("asmc-pin: ")
    assert loaded == "loaded:"


def test_what_is_heavy_is_told_from_what_is_not():
    assert "numpy" in run(*HOLDS, before=LOADED).stderr.splitlines()[-1]


# The compiler ---------------------------------------------------------------------------------------------------------


def test_no_clock_counts_what_the_compiler_takes_and_it_is_told_once():
    told = []
    tell_of_compiling(lambda: told.append(1))
    clock, began = Clock(), time.perf_counter()
    for addend in (1.0, 2.0):
        numba.njit(lambda x, addend=addend: sum([x + addend for _ in range(3)]))(1.0)
    wall = time.perf_counter() - began
    tell_of_compiling(None)
    assert told == [1]
    assert 0.0 < clock.compiling() <= wall
    assert clock.seconds() + clock.compiling() >= wall


@pytest.mark.long
def test_the_first_run_says_that_it_compiles_and_the_second_has_no_need_to(tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path)}
    began = time.monotonic()
    first = run(*HOLDS, "--json", env=cache)
    wall = time.monotonic() - began
    second = run(*HOLDS, "--json", env=cache)
    assert first.stderr.count("compiling") == 1
    assert "compiling" not in second.stderr
    assert json.loads(first.stdout)["seconds"] < 0.5 * wall  # most of it went into compiling


def test_the_real_entry_point_is_this_one():
    from importlib.metadata import entry_points

    (script,) = entry_points(group="console_scripts", name="asmc-pin")
    assert script.value == "asmc_pin.cli:main"
    assert sys.version_info >= (3, 11)
