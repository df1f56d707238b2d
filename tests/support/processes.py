"""Running the command line as a process of its own, as a user does."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

from paths import REPOSITORY

ROOT = REPOSITORY
START = "from asmc_pin.cli import main; main()"


def environment(**changes: str) -> dict[str, str]:
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths)), "COLUMNS": "200", **changes}


def command(*arguments: str, before: str = "", options: tuple[str, ...] = ()) -> list[str]:
    """The command line in a fresh interpreter; `before` is run first, to put something in the way."""
    return [sys.executable, *options, "-c", f"{before}\n{START}", *arguments]


def run(*arguments: str, before: str = "", env: dict[str, str] | None = None, **options: Any) -> Any:
    """Status, standard output and error of a run, as text."""
    options = {"capture_output": True, "text": True, "encoding": "utf-8", "timeout": 300, **options}
    return subprocess.run(command(*arguments, before=before), env=environment(**(env or {})), **options)


def group_lives(group: int) -> bool:
    """Whether any process of a group is left; of a child that was started in a session of its own, its pid."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
