"""Reading a function's source as a tree, and finding what the names in it stand for."""

from __future__ import annotations

import ast
import builtins
import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asmc_pin.codegen.translation.c_words import NotInC


@dataclass(frozen=True)
class PythonFunction:
    """A function as it is written.

    Attributes:
        name: Its name.
        function: The function itself, without what a compiler put around it.
        tree: Its definition.
        names: What its free names stand for.
        file: Where it is written.
        first_line: Line of the file on which `tree` begins.
    """

    name: str
    function: Callable[..., Any]
    tree: ast.FunctionDef
    names: Mapping[str, Any]
    file: str
    first_line: int

    def refuse(self, node: ast.AST, told: str) -> NotInC:
        """The error on a place of this function."""
        line = self.first_line + getattr(node, "lineno", 1) - 1
        return NotInC(f"{self.file}, line {line}, in {self.name}: {told}")

    def parameters(self) -> list[str]:
        """Names of its parameters.

        Raises:
            NotInC: it has others than plain ones.
        """
        found = self.tree.args
        if found.vararg or found.kwarg or found.kwonlyargs or found.defaults or found.posonlyargs:
            raise self.refuse(self.tree, "only plain parameters without defaults have a counterpart in C")
        return [each.arg for each in found.args]

    def statements(self) -> list[ast.stmt]:
        """Its body without the docstring."""
        return self.tree.body[1:] if ast.get_docstring(self.tree) is not None else self.tree.body


class _WithoutAnnotations(ast.NodeTransformer):
    """An annotated assignment is an assignment."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        if node.value is None:
            return ast.copy_location(ast.Pass(), node)
        return ast.copy_location(ast.Assign([node.target], node.value), node)


def read_function(function: Callable[..., Any]) -> PythonFunction:
    """A function's source; one that numba compiled is taken as it is written.

    Raises:
        NotInC: it is no function with source in a file.
    """
    written = getattr(function, "py_func", function)
    name = getattr(written, "__name__", repr(written))
    try:
        lines, first = inspect.getsourcelines(written)
        (tree,) = ast.parse(textwrap.dedent("".join(lines))).body
    except (OSError, TypeError, SyntaxError, ValueError) as error:
        raise NotInC(f"the source of {name} cannot be read: {error}") from error
    if not isinstance(tree, ast.FunctionDef):
        raise NotInC(f"{name} is not a plain function; write its step as def")
    tree = _WithoutAnnotations().visit(tree)
    closed = inspect.getclosurevars(written).nonlocals
    names = {**vars(builtins), **written.__globals__, **closed}
    return PythonFunction(name, written, tree, names, Path(inspect.getfile(written)).name, first)
