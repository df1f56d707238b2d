"""Files and folders are written whole or not at all, by real processes that are killed or run out of room."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import moments
import pytest
from processes import ROOT, command, environment, run
from short_experiment import SHORT

from asmc_pin.arms import load_arm
from asmc_pin.cli.entry import main
from asmc_pin.disk.file_access import check_writable
from asmc_pin.disk.files import whole_folder, write_whole
from asmc_pin.disk.unfinished import remove_leftovers
from asmc_pin.errors import ResultError
from asmc_pin.results.result_writing import check_target


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_written_as_any_other_and_a_former_one_is_replaced(tmp_path):
    page, plain = tmp_path / "page.html", tmp_path / "plain"
    write_whole(page, "M̄\n")
    plain.write_text("")
    assert page.read_bytes() == "M̄\n".encode()
    assert stat.S_IMODE(page.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)
    page.chmod(0o640)
    write_whole(page, b"\x00new")
    assert page.read_bytes() == b"\x00new"
    assert stat.S_IMODE(page.stat().st_mode) == 0o640
    assert names(tmp_path) == ["page.html", "plain"]


def test_a_link_stays_a_link_and_a_device_a_device(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "page").write_text("old")
    (tmp_path / "page").symlink_to("far/page")
    write_whole(tmp_path / "page", "new")
    assert (tmp_path / "page").is_symlink()
    assert (tmp_path / "far" / "page").read_text() == "new"
    write_whole("/dev/null", "nobody")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_a_pipe_that_nobody_reads_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ResultError, match="cannot be written"):
        write_whole(tmp_path / "pipe", "nobody")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_whole(tmp_path / "pipe", "somebody")
    assert os.read(reader, 100) == b"somebody"
    os.close(reader)


def test_a_name_of_any_length_and_a_text_of_any_origin_can_be_written(tmp_path):
    page = tmp_path / ("ü" * 127)
    write_whole(page, "a name \udcff from the command line")
    assert page.read_text(encoding="utf-8") == "a name \\udcff from the command line"
    assert names(tmp_path) == [page.name]


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_former_file_survives_a_full_disk(tmp_path, monkeypatch, step):
    page = tmp_path / "page.html"
    page.write_text("old")

    def full(*_arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, step, full)
    with pytest.raises(ResultError, match=r"page\.html cannot be written: No space left on device"):
        write_whole(page, "new")
    assert page.read_text() == "old"
    assert names(tmp_path) == ["page.html"]


def test_what_cannot_be_written_is_told_before_any_work(tmp_path):
    check_writable(tmp_path / "page.html")
    for path, why in ((tmp_path, "Is a directory"), (tmp_path / "gone" / "page.html", "No such file or directory")):
        with pytest.raises(ResultError, match=why):
            check_writable(path)
        with pytest.raises(ResultError, match=why):
            write_whole(path, "")


# A limit on the size of files stands for a full disk: the command line itself, its own pages, results and certificates.


def limited(*arguments: str, cwd: Path, kilobytes: int) -> subprocess.CompletedProcess[str]:
    shell = f'ulimit -f {kilobytes}; exec "$0" "$@"'
    arguments = ("bash", "-c", shell, *command(*arguments))
    env = environment(NUMBA_DISABLE_CACHING="")
    return subprocess.run(arguments, cwd=cwd, env=env, capture_output=True, text=True, timeout=300)


@pytest.mark.parametrize("page", ["page.html", "page.md"])
def test_a_page_that_has_no_room_leaves_the_former_one(tmp_path, page):
    (tmp_path / page).write_text("old")
    arguments = ("verify", "two_link", "--mbar", "0.01", "--samples", "64", "--report", page)
    done = limited(*arguments, cwd=tmp_path, kilobytes=8)
    assert done.returncode == 2
    assert "unrefuted" in done.stdout, "what was found is told before"
    assert "cannot be written: File too large" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert (tmp_path / page).read_text() == "old"
    assert not [name for name in names(tmp_path) if name.startswith(".")]


@pytest.mark.parametrize("kilobytes", [2, 64])  # the trajectories have no room, then a figure or the report
def test_a_result_that_has_no_room_leaves_the_former_one(tmp_path, kilobytes):
    (tmp_path / "short.toml").write_text(SHORT)
    former = tmp_path / "results" / "short"
    former.mkdir(parents=True)
    for name in ("experiment.toml", "provenance.json"):
        (former / name).write_text("former")
    done = limited("compare", "short.toml", "--force", cwd=tmp_path, kilobytes=kilobytes)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert "cannot be written" in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert names(tmp_path / "results") == ["short"]
    assert (former / "provenance.json").read_text() == "former"


# Killed ---------------------------------------------------------------------------------------------------------------

FOLDER = """
import time
from pathlib import Path
from asmc_pin.disk.files import whole_folder
with whole_folder(Path("result")) as made:
    (made / "x").write_text("half")
    print("written", flush=True)
    time.sleep(120)
"""
FILE = """
import os, time
from asmc_pin.disk.files import write_whole
def wait(descriptor):
    print("written", flush=True)
    time.sleep(120)
os.fsync = wait
write_whole("result", "half")
"""
SWAP = """
import os, signal
from pathlib import Path
from asmc_pin.disk.files import whole_folder
replace = os.replace
def killed(source, target):
    replace(source, target)
    os.kill(os.getpid(), signal.SIGKILL)
os.replace = killed
with whole_folder(Path("result")) as made:
    (made / "x").write_text("new")
"""

KILLED_AT_FIVE_FILES = f"""
import os, signal, sys
sys.path.append({str(Path(moments.__file__).parent)!r})
from moments import when_opened
when_opened(".new/", 5, lambda: os.kill(os.getpid(), signal.SIGKILL))
"""


def started(code: str, folder: Path) -> subprocess.Popen[str]:
    arguments = [sys.executable, "-c", code]
    process = subprocess.Popen(arguments, cwd=folder, env=environment(), stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    return process


@pytest.mark.parametrize("code", [FOLDER, FILE], ids=["folder", "file"])
def test_what_a_killed_run_left_goes_with_the_next_and_what_a_living_one_writes_stays(tmp_path, code):
    process = started(code, tmp_path)
    (half,) = names(tmp_path)
    assert half.startswith(".result.")
    remove_leftovers(tmp_path / "result")
    assert names(tmp_path) == [half]  # it lives
    process.kill()
    process.wait()
    (tmp_path / ".result.notes").write_text("the user's own")
    remove_leftovers(tmp_path / "other")
    assert half in names(tmp_path)
    remove_leftovers(tmp_path / "result")
    assert names(tmp_path) == [".result.notes"]


@pytest.mark.parametrize("then", ["a file", "a folder"])
def test_the_next_run_that_writes_there_tidies_up(tmp_path, then):
    process = started(FOLDER, tmp_path)
    process.kill()
    process.wait()
    if then == "a file":
        write_whole(tmp_path / "result", "whole")
    else:
        with whole_folder(tmp_path / "result") as made:
            (made / "x").write_text("whole")
    assert names(tmp_path) == ["result"]


def killed_between(folder: Path) -> None:
    (folder / "result").mkdir()
    for name in ("experiment.toml", "provenance.json"):
        (folder / "result" / name).write_text("former")
    process = started(SWAP, folder)
    assert process.wait() == -signal.SIGKILL
    assert not (folder / "result").exists()


def test_a_former_result_that_had_made_room_is_put_back(tmp_path):
    killed_between(tmp_path)
    with pytest.raises(ResultError, match=r"there is a result in .* already"):
        check_target(tmp_path / "result", force=False)
    assert names(tmp_path) == ["result"]
    assert (tmp_path / "result" / "provenance.json").read_text() == "former"


def test_a_former_result_is_not_put_back_over_a_later_one(tmp_path):
    killed_between(tmp_path)
    (tmp_path / "result").mkdir()
    (tmp_path / "result" / "x").write_text("later")
    remove_leftovers(tmp_path / "result")
    assert names(tmp_path) == ["result"]
    assert names(tmp_path / "result") == ["x"]


@pytest.mark.long
def test_a_comparison_that_is_killed_leaves_nothing_after_the_next(tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    killed = run("compare", "short.toml", "--json", before=KILLED_AT_FIVE_FILES, cwd=tmp_path)
    assert killed.returncode == -signal.SIGKILL
    (half,) = names(tmp_path / "results")
    assert "trajectories.nc" in names(tmp_path / "results" / half)
    assert run("compare", "short.toml", "--json", cwd=tmp_path).returncode == 0
    assert names(tmp_path / "results") == ["short"]


# No other way to write ------------------------------------------------------------------------------------------------


def test_nothing_else_in_the_package_writes_to_a_place_of_the_users():
    # Into a folder that takes its place as a whole, the writer of its files need not be careful.
    within_a_whole_folder = {
        "study/comparison_files.py",
        "results/result_writing.py",
        "pages/figure_style.py",
        "disk/files.py",
        "cli/fault.py",
        "codegen/exporting.py",
        "viewer/film/replay_pictures.py",
    }
    for path in (ROOT / "asmc_pin").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        writes = [word for word in (".write_text(", ".write_bytes(", "copyfile(", ".savefig(Path") if word in text]
        assert not writes or path.relative_to(ROOT / "asmc_pin").as_posix() in within_a_whole_folder, (path, writes)


@pytest.mark.parametrize(
    "words",
    [
        ("inspect", "arm.urdf", "--html", "arm.urdf"),
        ("verify", "arm.urdf", "--mbar", "0.05", "--certify", "--certificate", "arm.urdf"),
        ("bounds", "arm.urdf", "--certificate", "arm.urdf"),
    ],
)
def test_an_output_never_takes_the_place_of_an_input(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    text = load_arm("two_link").urdf_text
    (tmp_path / "arm.urdf").write_text(text)
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert "give another name" in capsys.readouterr().err
    assert (tmp_path / "arm.urdf").read_text() == text
