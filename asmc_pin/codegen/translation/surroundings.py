"""What the expressions of a function ask of the translation that they are part of."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from asmc_pin.codegen.translation.c_terms import Kind, Term
from asmc_pin.codegen.translation.restricted_python import PythonFunction
from asmc_pin.words.choices import RealType


@dataclass(frozen=True)
class CFunction:
    """A translated function.

    Attributes:
        c_name: Its name in C.
        kinds: What its parameters are.
        writes: Which of them it writes to.
        returns: What it gives.
        text: Its definition.
    """

    c_name: str
    kinds: tuple[Kind, ...]
    writes: tuple[bool, ...]
    returns: Kind
    text: str


class Surroundings(Protocol):
    """The rest of a translation: tables, helpers and other functions."""

    real_type: RealType
    period_row: int | None

    def helper(self, name: str) -> str:
        """The C name of a helper, which is needed from now on."""
        ...

    def row(self, table: Term, row: tuple[int, str]) -> str:
        """A row of a table in C."""
        ...

    def function(
        self, caller: PythonFunction, node: ast.AST, function: Callable[..., Any], given: Sequence[Term]
    ) -> CFunction:
        """The function that is called there, for what it is given."""
        ...
