"""Packages whose public names load on first use: importing one, or a light module in it, stays quick."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType


class _Package(ModuleType):
    """A package; where a module and a public name of it are alike, the name stays what is public."""

    _homes: Mapping[str, str]

    def __getattr__(self, name: str) -> object:
        if name not in self._homes:
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}'")
        value = getattr(import_module(f"{self.__name__}.{self._homes[name]}"), name)
        setattr(self, name, value)
        return value

    def __setattr__(self, name: str, value: object) -> None:
        # Whoever imports the module of a public name would put it in that name's place.
        shadows = isinstance(value, ModuleType) and self._homes.get(name) == name
        super().__setattr__(name, getattr(value, name) if shadows else value)

    def __dir__(self) -> list[str]:
        return sorted({*vars(self), *self._homes})


def load_on_first_use(package: str, homes: Mapping[str, str]) -> None:
    """Make the public names of a package load when they are first asked for.

    Args:
        package: The package's own ``__name__``.
        homes: The module that defines each name, as seen from the package.
    """
    module = sys.modules[package]
    module.__dict__["_homes"] = dict(homes)
    module.__class__ = _Package
