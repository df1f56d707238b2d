"""Inputs as a stranger or a damaged disk may hand them over, and the command line asked about them in this process."""

from __future__ import annotations

import atexit
import contextlib
import io
import shutil
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from short_experiment import SHORT

from asmc_pin.cli import main

BODY = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="1"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


class Said(NamedTuple):
    """What a command gave back."""

    status: object
    out: str
    err: str


def asked(*argv: str | Path) -> Said:
    """Run the command line; an exception that it lets through goes through here too."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main([str(part) for part in argv])
    except SystemExit as ended:
        return Said(ended.code, out.getvalue(), err.getvalue())
    return Said(None, out.getvalue(), err.getvalue())


def refusal(*argv: str | Path) -> str:
    """The one message of a command that has to be refused as bad input."""
    said = asked(*argv)
    assert said.status == 2, said
    assert not said.out
    lines = [line for line in said.err.splitlines() if not line.startswith("asmc-pin: warning:")]
    assert sum(line.startswith("asmc-pin: ") for line in lines) == 1, said.err
    assert "Traceback" not in said.err
    assert all(character.isprintable() or character == "\n" for character in said.err), repr(said.err)
    return said.err


def chain(joints: int, *, name: str = "j", kind: str = "revolute", extra: str = "", body: str = BODY) -> str:
    """A URDF of so many joints in a row."""
    parts = ['<robot name="r"><link name="l0"/>']
    for k in range(joints):
        axis = "0 1 0" if k % 2 else "1 0 0"
        parts.append(
            f'<link name="l{k + 1}">{body}</link><joint name="{name}{k}" type="{kind if k else "revolute"}">'
            f'<parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0 0 0.1"/><axis xyz="{axis}"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    return "\n".join([*parts, extra, "</robot>"])


def verify(path: Path) -> Sequence[str]:
    """The quickest question about an arm."""
    return ["verify", str(path), "--mbar", "0.01", "--samples", "4"]


@cache
def _made() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="asmc-hostile-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / "short.toml").write_text(SHORT.replace("duration = 0.2", "duration = 0.05"))
    said = asked("compare", folder / "short.toml", "--out", folder / "made")
    assert said.status == 0, said
    return folder / "made"


def small_result(folder: Path) -> Path:
    """A copy of a small result, for a test to do with as it likes."""
    return Path(shutil.copytree(_made(), folder / "result"))
