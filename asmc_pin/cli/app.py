"""The application object, on which every command registers itself."""

from __future__ import annotations

from importlib.metadata import version
from typing import Annotated

import typer

from asmc_pin.cli.console import say

MBAR, STUDIES, ROBOT, PICTURES, LISTS = PANELS = (
    "May I use this M̄, and with which gains?",
    "Which controller is better?",
    "How does it come to the robot?",
    "What does it look like?",
    "What is there, and can it be believed?",
)
"""Under which question help lists a command, in this order."""

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
