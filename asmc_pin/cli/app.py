"""The application object, and running it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated

import typer

from asmc_pin.cli.console import note, say
from asmc_pin.cli.interrupt import INTERRUPTED

app = typer.Typer(
    name="asmc-pin",
    help="Is this M̄ allowed, which controller is better, what does it look like: TDE control of an arm from its URDF.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(value: bool) -> None:
    if value:
        say(f"asmc-pin {version('asmc-pin')}")
        raise typer.Exit()


@app.callback()
def _root(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def run(argv: Sequence[str] | None) -> int:
    """Run a command.

    Args:
        argv: Arguments without the program's name; the process's own when None.

    Returns:
        Its exit status; errors are raised.
    """
    # Commands register themselves on import.
    from asmc_pin.cli import condition, design, proof, study, tables  # noqa: F401

    warnings.showwarning = lambda message, *_args, **_kwargs: note(f"warning: {message}")
    status = app(args=None if argv is None else list(argv), standalone_mode=False)
    if status == INTERRUPTED:  # typer makes of KeyboardInterrupt a status
        raise KeyboardInterrupt
    return status if isinstance(status, int) else 0
