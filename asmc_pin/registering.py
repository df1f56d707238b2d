"""Registries that a class enters by a decorator, so that what is registered and its name stand in one place."""

from __future__ import annotations

from collections.abc import Callable, MutableMapping
from typing import TypeVar

Thing = TypeVar("Thing")


def registering(registry: MutableMapping[str, Thing]) -> Callable[[str], Callable[[Thing], Thing]]:
    """A decorator for a registry: ``@kind("ramps")`` puts what it stands above there under that name.

    Raises:
        ValueError: on use, if the name is taken by another; two of one name would hide each other.
    """

    def named(name: str) -> Callable[[Thing], Thing]:
        def register(thing: Thing) -> Thing:
            if name in registry:
                raise ValueError(f"{name!r} is registered already: {registry[name]!r}")
            registry[name] = thing
            return thing

        return register

    return named
