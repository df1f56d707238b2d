"""What to do next: the command that follows from a verdict, about the same arm and with the same options."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

import typer

from asmc_pin.cli.console import say
from asmc_pin.cli.option_groups.grouping import option_names
from asmc_pin.cli.option_groups.loading_options import LoadingOptions

_SAME = ("box", "condition", *option_names(LoadingOptions))
"""Options that say what a statement is about."""


def again(context: typer.Context, verb: str, *more: str, also: Sequence[str] = (), without: Sequence[str] = ()) -> str:
    """A command about the arm of the one that runs, with its options where they say what the statement is about.

    Args:
        context: Of the command that runs.
        verb: The command to give.
        more: Its other words.
        also: Names of further options of this command that are to be kept.
        without: Names of options of the arm that are not.
    """
    words = ["asmc-pin", verb, str(context.params["arm"]), *more]
    for option in context.command.params:
        value = context.params.get(option.name or "")
        kept = option.name in (*_SAME, *also) and option.name not in without
        if option.param_type_name != "option" or not kept or not value:
            continue
        if value == option.get_default(context):
            continue
        if option.nargs > 1:
            words += [option.opts[0], *map(str, value)]
            continue
        for each in value if isinstance(value, list | tuple) else [value]:
            words += [option.opts[0]] if each is True else [option.opts[0], str(each)]
    return shlex.join(words)


def say_next(what: str, command: str) -> None:
    """Print it: the last line of a text, never part of JSON."""
    say(f"next: {what}: {command}")
