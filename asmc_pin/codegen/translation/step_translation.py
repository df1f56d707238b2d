"""A law's step and every function that it calls, as static C functions, with the rows of the tables that they use."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from asmc_pin.codegen.translation.c_terms import Kind, Term
from asmc_pin.codegen.translation.c_words import NotInC, comment, identifier, slug
from asmc_pin.codegen.translation.expressions import Expressions, c_local
from asmc_pin.codegen.translation.restricted_python import PythonFunction, read_function
from asmc_pin.codegen.translation.step_statements import Statements
from asmc_pin.codegen.translation.surroundings import CFunction
from asmc_pin.words.choices import RealType

TABLES: tuple[Kind, ...] = ("tick", "law", "memory", "work")
_PASSED: tuple[Kind, ...] = ("real", "truth", "row", *TABLES)


@dataclass
class StepTranslation:
    """What becomes of a step.

    Attributes:
        prefix: With which every name in C begins.
        real_type: What is computed in.
        period_row: Row of the law's parameters that is the period; a step reads the time since the last tick instead.
        rows: By table: number of each row that is used, and its name in C.
        helpers: Helpers that are called, such as ``root``.
        functions: In an order in which each comes after those that it calls.
    """

    prefix: str
    real_type: RealType
    period_row: int | None
    rows: dict[Kind, dict[int, str]] = field(default_factory=lambda: {"law": {}, "memory": {}, "work": {}})
    helpers: set[str] = field(default_factory=set)
    functions: list[CFunction] = field(default_factory=list)
    _made: dict[tuple[Any, tuple[Kind, ...]], CFunction] = field(default_factory=dict)
    _open: list[Any] = field(default_factory=list)

    @property
    def type_name(self) -> str:
        """Of a real number in C."""
        return f"{self.prefix}_real"

    def helper(self, name: str) -> str:
        """The C name of a helper, which is needed from now on."""
        self.helpers.add(name)
        return f"{self.prefix}_{name}"

    def row(self, table: Term, row: tuple[int, str]) -> str:
        """A row of a table in C."""
        number, called = row
        names = self.rows[table.kind]
        if number not in names:
            name = identifier(slug(called))
            taken = [other for other, used in names.items() if used == name]
            names[number] = f"{name}_{number}" if taken else name
        place = f"{table.code}->parameters" if table.kind == "law" else table.code
        return f"{place}->{names[number]}"

    def name_memory(self, names: Sequence[str]) -> None:
        """Give the rows of memory the names of a state's fields, all of them whether they are used or not."""
        for number, name in enumerate(names):
            own = identifier(slug(name))
            self.rows["memory"][number] = f"{own}_{number}" if own in self.rows["memory"].values() else own

    def entry(self, function: Callable[..., Any]) -> CFunction:
        """Translate a step ``(tick, law, memory, work, command)``.

        Raises:
            NotInC: it does what has no counterpart here; the message says where.
        """
        source = read_function(function)
        kinds: tuple[Kind, ...] = ("tick", "law", "memory", "work", "row")
        if len(source.parameters()) != len(kinds):
            raise source.refuse(source.tree, "a step takes tick, law, memory, work and command")
        return self._translated(source, kinds)

    def function(
        self, caller: PythonFunction, node: ast.AST, function: Callable[..., Any], given: Sequence[Term]
    ) -> CFunction:
        """The function that is called there, for what it is given."""
        kinds = tuple("real" if term.kind == "whole" else term.kind for term in given)
        if any(kind not in _PASSED for kind in kinds):
            raise caller.refuse(node, "a function is handed numbers, rows and tables")
        source = read_function(function)
        if len(source.parameters()) != len(kinds):
            raise caller.refuse(node, f"{source.name} takes {len(source.parameters())} arguments")
        return self._translated(source, kinds)

    def _translated(self, source: PythonFunction, kinds: tuple[Kind, ...]) -> CFunction:
        key = (source.function, kinds)
        if key in self._made:
            return self._made[key]
        if source.function in self._open:
            raise source.refuse(source.tree, "a function that calls itself has no counterpart here")
        self._open.append(source.function)
        parameters = source.parameters()
        known = {
            name: Term(c_local(name), kind, writes=name if kind in ("row", "memory", "work") else None)
            for name, kind in zip(parameters, kinds, strict=True)
        }
        expressions = Expressions(source, self, known)
        statements = Statements(source, expressions, self.type_name, f"{self.prefix.upper()}_NV")
        body = statements.lines()
        self._open.pop()
        writes = tuple(name in expressions.written for name in parameters)
        name = f"{self.prefix}_law_{slug(source.name)}"
        taken = sum(each.c_name == name or each.c_name.startswith(f"{name}__") for each in self.functions)
        name = f"{name}__{taken + 1}" if taken else name
        declared = [
            self._parameter(each, kind, written) for each, kind, written in zip(parameters, kinds, writes, strict=True)
        ]
        unused = [each for each in parameters if not any(item.id == each for item in _names(source))]
        gives = {"nothing": "void", "truth": "int"}.get(statements.returns, self.type_name)
        text = "\n".join(
            [
                *_remark(source),
                f"static {gives} {name}({', '.join(declared)})",
                "{",
                *(f"    (void){c_local(each)};" for each in unused),
                *(f"    {line}" for line in body),
                "}",
            ]
        )
        made = CFunction(name, kinds, writes, statements.returns, text)
        self.functions.append(made)
        self._made[key] = made
        return made

    def _parameter(self, name: str, kind: Kind, written: bool) -> str:
        const = "" if written else "const "
        if kind in TABLES:
            return f"{const}{self.prefix}_{kind} *{c_local(name)}"
        if kind == "row":
            return f"{const}{self.type_name} *{c_local(name)}"
        return f"{'int' if kind == 'truth' else self.type_name} {c_local(name)}"


def _names(source: PythonFunction) -> list[ast.Name]:
    return [item for statement in source.statements() for item in ast.walk(statement) if isinstance(item, ast.Name)]


def _remark(source: PythonFunction) -> list[str]:
    text = ast.get_docstring(source.tree)
    lines = comment(text or f"{source.name}").strip().split("\n")
    lines[-1] += f" ({comment(source.file)})" if len(lines) == 1 else ""
    return [
        "/* "
        + "\n * ".join(lines).replace(" * \n", " *\n")
        + (" */" if len(lines) == 1 else f"\n * ({source.file}) */")
    ]


__all__ = ["CFunction", "NotInC", "StepTranslation"]
