"""Running a command of the application."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from asmc_pin.cli.app import app
from asmc_pin.cli.commands import (  # noqa: F401 - commands register themselves on import
    condition_commands,
    design_commands,
    listing_commands,
    proof_commands,
    study_commands,
)
from asmc_pin.cli.console import note
from asmc_pin.cli.interrupt import INTERRUPTED


def run(argv: Sequence[str] | None) -> int:
    """Run a command.

    Args:
        argv: Arguments without the program's name; the process's own when None.

    Returns:
        Its exit status; errors are raised.
    """
    warnings.showwarning = lambda message, *_args, **_kwargs: note(f"warning: {message}")
    status = app(args=None if argv is None else list(argv), standalone_mode=False)
    if status == INTERRUPTED:  # typer makes of KeyboardInterrupt a status
        raise KeyboardInterrupt
    return status if isinstance(status, int) else 0
