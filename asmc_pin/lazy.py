"""Public names of a package that load on first use: importing it, or a light module in it, stays quick (PEP 562)."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module


def load_on_first_use(package: str) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """The ``__getattr__``, ``__dir__`` and ``__all__`` of a package whose names load when they are first asked for.

    Which names there are, and where each is at home, stands once: in the package's own block ``if TYPE_CHECKING:``, a
    line ``from home import name as name`` for each, which type checkers and editors read as well.

    A module of the package may not bear one of the names: importing it would put it in the name's place.

    Args:
        package: The package's own ``__name__``.
    """
    module = sys.modules[package]
    homes = homes_of(package)

    def load(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        value = getattr(import_module(homes[name]), name)
        setattr(module, name, value)
        return value

    return load, lambda: sorted({*vars(module), *homes}), sorted(homes)


def homes_of(package: str) -> dict[str, str]:
    """The module that defines each public name, as the package's block ``if TYPE_CHECKING:`` has it."""
    spec = sys.modules[package].__spec__
    source = getattr(spec and spec.loader, "get_source", lambda _: None)(package)
    if source is None:
        raise ImportError(f"the source of {package} is not there, and says where its names are at home")
    blocks = (
        node.body
        for node in ast.parse(source).body
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    )
    return {
        alias.name: str(item.module)
        for block in blocks
        for item in block
        if isinstance(item, ast.ImportFrom)
        for alias in item.names
    }
