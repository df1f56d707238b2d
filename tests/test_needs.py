"""A test that needs a program from outside is skipped without it, but never in CI."""

import ast
import os
import stat
import subprocess
import sys
from pathlib import Path

import needs
import pytest
from paths import REPOSITORY, TESTS

HERE = TESTS
ROOT = REPOSITORY


@pytest.fixture
def nothing_installed(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


def install(folder, name):
    path = folder / name
    path.write_text("#!/bin/sh\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.mark.parametrize("what", needs.PROGRAMS)
def test_without_the_program_a_test_is_skipped_with_a_reason(what, nothing_installed, monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match=needs.PROGRAMS[what].package):
        needs.program(what)


@pytest.mark.parametrize("what", needs.PROGRAMS)
def test_in_ci_it_fails(what, nothing_installed, monkeypatch):
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match=needs.PROGRAMS[what].package):
        needs.program(what)


@pytest.mark.parametrize("ci", ["", "true"])
def test_with_the_program_it_runs_anywhere(ci, nothing_installed, monkeypatch):
    monkeypatch.setenv("CI", ci)
    for what, each in needs.PROGRAMS.items():
        path = install(nothing_installed, each.commands[-1])
        assert needs.program(what) == path


def test_the_packages_that_are_absent_are_those_that_ci_installs(nothing_installed):
    def absent():
        environment = {**os.environ, "PATH": str(nothing_installed)}
        command = [sys.executable, "-S", str(HERE / "needs.py")]  # before anything is installed, pytest neither
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()

    assert absent() == sorted(each.package for each in needs.PROGRAMS.values())
    install(nothing_installed, "pdflatex")
    assert needs.PROGRAMS["latex"].package not in absent()
    assert "tests/needs.py" in (ROOT / ".ci" / "run").read_text()


def test_no_test_looks_for_a_program_or_skips_by_itself():
    skips = {"which", "skipif", "importorskip", "skip"}
    for path in HERE.rglob("*.py"):
        if path.name in ("needs.py", Path(__file__).name):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute):
                assert node.attr not in skips, f"{path.name}, line {node.lineno}: use needs.program"
