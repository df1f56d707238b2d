"""Programs that some tests need: without one a test is skipped, but fails in CI, so that it cannot be lost unseen.

``python tests/needs.py`` prints the Debian packages of those that are absent, for `.ci/run`.
"""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Program:
    """A program from outside of Python.

    Attributes:
        commands: Names that it goes by; the first that is found is taken.
        package: Debian's package of it.
    """

    commands: tuple[str, ...]
    package: str


PROGRAMS = {
    "c": Program(("gcc",), "gcc"),
    "c++": Program(("g++",), "g++"),
    "clang": Program(("clang",), "clang"),
    "browser": Program(("chromium", "chromium-browser", "google-chrome"), "chromium"),
    "latex": Program(("pdflatex",), "texlive-latex-recommended"),
}
"""All that tests want. A test that needs another program adds a line, and CI installs it."""


def found(what: str) -> str | None:
    """Path of a program of `PROGRAMS`; None where it is not installed."""
    return next((path for path in map(shutil.which, PROGRAMS[what].commands) if path is not None), None)


def program(what: str) -> str:
    """Path of a program of `PROGRAMS`; where it is not installed the test ends here, in CI as a failure."""
    import pytest

    path = found(what)
    if path is None:
        wanted = f"needs {PROGRAMS[what].commands[0]} (Debian: {PROGRAMS[what].package})"
        if os.environ.get("CI"):
            pytest.fail(f"{wanted}, and CI must run this test")
        pytest.skip(wanted)
    return path


def real_log(name: str) -> Path:
    """A log of a real arm, which lies beside the repository and is no part of it; without it the test is skipped."""
    import pytest

    path = Path(__file__).parents[2] / "shared" / "logs" / name
    if not path.is_file():
        pytest.skip(f"needs {name}, the log of a real arm, in shared/logs beside the repository")
    return path


if __name__ == "__main__":
    print(*sorted({each.package for what, each in PROGRAMS.items() if found(what) is None}))
