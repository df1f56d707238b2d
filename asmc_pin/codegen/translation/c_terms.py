"""Pieces of C expressions with their kind and how tightly they bind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["real", "truth", "whole", "count", "index", "row", "tick", "law", "memory", "work", "nothing"]
"""real: a number. truth: yes or no. whole: an integer constant. count: ticks taken. index: of a joint. row: one number
per joint. tick, law, memory, work: the tables that a step is handed. nothing: what a function without return gives."""

CHOICE, OR, AND, SAME, ORDER, SUM, PRODUCT, SIGN, ATOM = range(9)
"""How tightly an operator binds, the loosest first."""


@dataclass(frozen=True)
class Term:
    """A piece of C.

    Attributes:
        code: The text.
        kind: What it is.
        level: How tightly its outermost operator binds.
        value: Of a constant: what it is.
        writes: Of a row or table: the name of the parameter or table that writing to it writes to.
    """

    code: str
    kind: Kind
    level: int = ATOM
    value: float | int | None = None
    writes: str | None = None

    def within(self, level: int) -> str:
        """The text as an operand of an operator of this level, in parentheses where it binds less tightly."""
        return self.code if self.level >= level else f"({self.code})"
