"""The public names of the package by the room that they come from, for docs/python.md and for the site."""

from __future__ import annotations

import inspect
from collections.abc import Mapping

import asmc_pin
from asmc_pin.lazy import homes_of


def by_room() -> dict[str, list[str]]:
    """Every name of `asmc_pin.__all__`, functions first, under the room that defines it."""
    rooms: dict[str, list[str]] = {}
    for name, home in homes_of("asmc_pin").items():
        rooms.setdefault(home.split(".")[1], []).append(name)
    return {room: sorted(names, key=_order) for room, names in sorted(rooms.items())}


def _order(name: str) -> tuple[int, str]:
    thing = getattr(asmc_pin, name)
    return (0 if inspect.isfunction(thing) else 2 if inspect.isclass(thing) else 1), name.lower()


def first_line(name: str) -> str:
    """What a name says of itself in one line; a registry or an alias has no docstring of its own."""
    thing = getattr(asmc_pin, name)
    if isinstance(thing, Mapping):
        return f"By their names: {', '.join(thing)}."
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())
