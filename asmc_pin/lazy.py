"""Public names of a package that load on first use: importing it, or a light module in it, stays quick (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def load_on_first_use(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """The ``__getattr__`` and the ``__dir__`` of a package whose public names load when they are first asked for.

    A module of the package may not bear one of the names: importing it would put it in the name's place.

    Args:
        package: The package's own ``__name__``.
        homes: The module that defines each name, as seen from the package.
    """
    module = sys.modules[package]

    def load(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        value = getattr(import_module(f"{package}.{homes[name]}"), name)
        setattr(module, name, value)
        return value

    return load, lambda: sorted({*vars(module), *homes})
