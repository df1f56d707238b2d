"""Running a command of the application."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules

import typer

from asmc_pin.cli import commands
from asmc_pin.cli.app import PANELS, app
from asmc_pin.cli.console import note
from asmc_pin.cli.examples import shown_examples
from asmc_pin.cli.interrupt import INTERRUPTED
from asmc_pin.errors import ParameterError
from asmc_pin.words.interface import speaking

# Commands register themselves on import; help lists them panel by panel, one without a panel first.
for _file in sorted(iter_modules(commands.__path__), key=lambda found: found.name):
    import_module(f"{commands.__name__}.{_file.name}")
for _each in app.registered_commands:
    assert _each.callback is not None
    _each.epilog = shown_examples(_each.name or _each.callback.__name__)
app.registered_commands.sort(
    key=lambda each: PANELS.index(each.rich_help_panel) if each.rich_help_panel in PANELS else -1
)

_OTHER_NAMES = {"scaling": "scale", "tube_width": "tube"}
"""Options by the names of the parameters that they become, where these are others."""


def run(argv: Sequence[str] | None) -> int:
    """Run a command.

    Args:
        argv: Arguments without the program's name; the process's own when None.

    Returns:
        Its exit status; errors are raised.
    """
    warnings.showwarning = lambda message, *_args, **_kwargs: note(f"warning: {message}")
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        with speaking("command line"):
            status = app(args=words, standalone_mode=False)
    except ParameterError as error:
        raise _as_typed(error, words) from error
    if status == INTERRUPTED:  # typer makes of KeyboardInterrupt a status
        raise KeyboardInterrupt
    return status if isinstance(status, int) else 0


def _as_typed(error: ParameterError, words: Sequence[str]) -> ParameterError:
    """The same error with its parameter's name as it was typed, where the command has an option of that name."""
    name = next((word for word in words if not word.startswith("-")), "")
    group = typer.main.get_command(app)
    command = getattr(group, "commands", {}).get(name)
    parameter = error.parameter.partition(".")[0]  # payload.link is said with --payload
    parameter = _OTHER_NAMES.get(parameter, parameter)
    for option in [] if command is None else command.params:
        if option.param_type_name == "option" and option.name == parameter:
            return ParameterError(option.opts[0], error.said)
    return error
