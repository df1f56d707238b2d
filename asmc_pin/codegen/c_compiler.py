"""A C compiler of this machine, where there is one: running the recorded vectors, and loading an exported law."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from asmc_pin.errors import AsmcPinError

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion")
"""Flags under which exported code has no warning, as C; as C++ without the first."""
EXACT = ("-O2", "-ffp-contract=off")
"""Flags under which it computes what Python computes."""
_SECONDS = 120.0


class CompilerError(AsmcPinError):
    """A C compiler that is there could not do its work."""


def find_compiler() -> str | None:
    """The command of the C compiler: ``CC`` where it is set, else the first of gcc, clang and cc that is there."""
    named = os.environ.get("CC")
    wanted = shlex.split(named)[:1] if named else ["gcc", "clang", "cc"]
    return next((path for path in map(shutil.which, wanted) if path is not None), None)


def compile_c(compiler: str, sources: list[Path], out: Path, *flags: str) -> None:
    """Compile C sources.

    Raises:
        CompilerError: the compiler fails, in its own words.
    """
    command = [compiler, *STRICT, *EXACT, *flags, *map(str, sources), "-o", str(out), "-lm"]
    done = _run(command, "compiling")
    if done.returncode:
        raise CompilerError(f"{compiler} cannot compile {sources[0].name}: {_first_line(done.stderr)}")


@dataclass(frozen=True)
class VectorRun:
    """What running the recorded vectors came to.

    Attributes:
        ticks: How many there are.
        wrong: How many of them are not what Python computed.
        first_wrong_line: Line of the first of these in the CSV; 0 for none.
        largest_difference: Largest difference of a torque, N·m.
    """

    ticks: int
    wrong: int
    first_wrong_line: int
    largest_difference: float


def run_vectors(runner: Path, vectors: Path) -> VectorRun:
    """Run a compiled runner.

    Raises:
        CompilerError: it ends otherwise than a runner does.
    """
    done = _run([str(runner), str(vectors)], "running the recorded vectors")
    pattern = r"ticks (\d+) wrong (\d+) first_wrong_line (\d+) largest_difference (\S+)\s*"
    told = re.fullmatch(pattern, done.stdout)
    if told is None:
        raise CompilerError(f"the runner ended with status {done.returncode}: {_first_line(done.stderr)}")
    return VectorRun(int(told[1]), int(told[2]), int(told[3]), float(told[4]))


def _run(command: list[str], doing: str) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=_SECONDS)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CompilerError(f"{doing} failed: {error}") from error


def _first_line(text: str) -> str:
    lines = [line for line in text.split("\n") if "error:" in line and "ld returned" not in line]
    lines = lines or text.strip().split("\n")
    return lines[0].strip() or "it said nothing"
