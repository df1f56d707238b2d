"""A group of options as one parameter of a command: a frozen dataclass whose fields are the options."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Collection, Mapping
from typing import Any, get_type_hints


def takes_option_groups(
    *, without: Collection[str] = (), instead: Mapping[str, Any] | None = None
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorate a command: each of its parameters whose type is a dataclass becomes the options of that class.

    Args:
        without: Fields that mean nothing to this command.
        instead: Types that fields have here in place of their own, with their option.
    """
    types = instead or {}

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        groups: dict[str, tuple[type, tuple[str, ...]]] = {}
        parameters: list[inspect.Parameter] = []
        for parameter in inspect.signature(command, eval_str=True).parameters.values():
            group = parameter.annotation
            if isinstance(group, type) and dataclasses.is_dataclass(group):
                options = _options(group, without, types)
                groups[parameter.name] = group, tuple(each.name for each in options)
                parameters += options
            else:
                parameters.append(parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY))

        @functools.wraps(command)
        def run(**given: Any) -> None:
            made = {
                name: group(**{option: given.pop(option) for option in options})
                for name, (group, options) in groups.items()
            }
            command(**made, **given)

        # What typer reads in place of the command's own.
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {each.name: each.annotation for each in parameters}
        del run.__wrapped__
        return run

    return decorate


def option_names(group: type) -> tuple[str, ...]:
    """The names of a group's options, as a command's parameters have them."""
    return tuple(each.name for each in dataclasses.fields(group))


def _options(group: Any, without: Collection[str], instead: Mapping[str, Any]) -> list[inspect.Parameter]:
    types = get_type_hints(group, include_extras=True) | dict(instead)
    return [
        inspect.Parameter(each.name, inspect.Parameter.KEYWORD_ONLY, default=each.default, annotation=types[each.name])
        for each in dataclasses.fields(group)
        if each.name not in without
    ]
