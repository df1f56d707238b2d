"""Expressions of a step in C: the same operations in the same order, each rounded as numba's compiled code does."""

from __future__ import annotations

import ast
from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np

from asmc_pin.codegen.translation.c_terms import AND, ATOM, CHOICE, OR, ORDER, PRODUCT, SAME, SIGN, SUM, Kind, Term
from asmc_pin.codegen.translation.c_words import NotInC, identifier, literal
from asmc_pin.codegen.translation.restricted_python import PythonFunction
from asmc_pin.codegen.translation.surroundings import Surroundings

_ARITHMETIC: dict[type[ast.operator], tuple[str, int]] = {
    ast.Add: ("+", SUM),
    ast.Sub: ("-", SUM),
    ast.Mult: ("*", PRODUCT),
    ast.Div: ("/", PRODUCT),
}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, int]] = {
    ast.Lt: ("<", ORDER),
    ast.LtE: ("<=", ORDER),
    ast.Gt: (">", ORDER),
    ast.GtE: (">=", ORDER),
    ast.Eq: ("==", SAME),
    ast.NotEq: ("!=", SAME),
}
HELPERS: dict[Any, tuple[str, int]] = {
    abs: ("absolute", 1),
    np.abs: ("absolute", 1),
    np.sqrt: ("root", 1),
    np.copysign: ("with_sign_of", 2),
    np.minimum: ("smaller", 2),
    np.maximum: ("larger", 2),
    pow: ("power", 2),
}
"""Functions of numbers that a step may call: name of the C helper, and how many numbers it takes."""
TICK_FIELDS = {
    "q": "sample->q",
    "v": "sample->v",
    "torque": "sample->tau",
    "q_ref": "setpoint->q",
    "v_ref": "setpoint->v",
    "a_ref": "setpoint->a",
}
"""Fields of a `Tick` in the exported structures."""


class Expressions:
    """The expressions of one function.

    Args:
        source: The function.
        step: What is being translated, which knows the tables and the other functions.
        known: Names of parameters and local variables, and what they are; grows as statements are read.
    """

    def __init__(self, source: PythonFunction, step: Surroundings, known: dict[str, Term]) -> None:
        self.source, self.step, self.known = source, step, known
        self.written: set[str] = set()

    def term(self, node: ast.expr) -> Term:
        """Any expression."""
        make: Callable[[Any], Term] | None = getattr(self, f"_{type(node).__name__.lower()}", None)
        if make is None:
            raise self.refuse(node, f"{_shown(node)} has no counterpart here")
        try:
            return make(node)
        except NotInC as error:
            if self.source.file in str(error):
                raise
            raise self.refuse(node, str(error)) from error

    def real(self, node: ast.expr) -> Term:
        """An expression that has to be a number; an integer constant becomes one."""
        return self._as(node, self.term(node), "real")

    def truth(self, node: ast.expr) -> Term:
        """An expression that has to be yes or no."""
        return self._as(node, self.term(node), "truth")

    def refuse(self, node: ast.AST, told: str) -> NotInC:
        """The error on a place of this function."""
        return self.source.refuse(node, told)

    def _as(self, node: ast.expr, term: Term, kind: Kind) -> Term:
        if term.kind == "whole" and kind == "real" and term.value is not None:
            return Term(literal(float(term.value), self.step.real_type), "real", term.level, float(term.value))
        if term.kind != kind:
            raise self.refuse(node, f"{_shown(node)} is a {term.kind}, and a {kind} is needed here")
        return term

    def _constant(self, node: ast.Constant) -> Term:
        return self._value(node, node.value)

    def _value(self, node: ast.expr, value: object) -> Term:
        """A constant of Python as one of C."""
        if isinstance(value, bool):
            return Term("1" if value else "0", "truth", value=value)
        if isinstance(value, int):
            return Term(str(value), "whole", ATOM if value >= 0 else SIGN, value)
        if isinstance(value, float):
            code = literal(value, self.step.real_type)
            return Term(code, "real", SIGN if code.startswith("-") else ATOM, value)
        raise self.refuse(node, f"{_shown(node)} is no number")

    def _name(self, node: ast.Name) -> Term:
        if node.id in self.known:
            return self.known[node.id]
        if node.id in self.source.names:
            return self._value(node, self.source.names[node.id])
        raise self.refuse(node, f"'{node.id}' has no value here; a loop's variable means nothing after the loop")

    def _attribute(self, node: ast.Attribute) -> Term:
        owner = node.value
        if isinstance(owner, ast.Name) and owner.id in self.known:
            base = self.known[owner.id]
            if base.kind == "tick" and node.attr == "ticks":
                return Term(f"{base.code}->ticks", "count")
            if base.kind == "tick" and node.attr in TICK_FIELDS:
                return Term(f"{base.code}->{TICK_FIELDS[node.attr]}", "row")
        elif isinstance(owner, ast.Name) and self.source.names.get(owner.id) is np and node.attr == "pi":
            return self._value(node, float(np.pi))
        raise self.refuse(node, f"{_shown(node)} has no counterpart here")

    def _subscript(self, node: ast.Subscript) -> Term:
        base = self.term(node.value)
        if base.kind == "row":
            return Term(f"{base.code}[{self._column(node.slice)}]", "real", writes=base.writes)
        if base.kind not in ("law", "memory", "work"):
            raise self.refuse(node, f"{_shown(node.value)} is a {base.kind}, which has no entries")
        if not isinstance(node.slice, ast.Tuple):
            row = self.step.row(base, self._row_number(node.slice))
            return Term(row, "row", writes=base.writes)
        if len(node.slice.elts) != 2:
            raise self.refuse(node, "a table has a row and a joint")
        number, column = self._row_number(node.slice.elts[0]), self._column(node.slice.elts[1])
        if base.kind == "law" and number[0] == self.step.period_row:
            return Term(f"{base.code}->dt", "real")
        return Term(f"{self.step.row(base, number)}[{column}]", "real", writes=base.writes)

    def _row_number(self, node: ast.expr) -> tuple[int, str]:
        """A row by its number, which has to be known before the step runs, and what it is called."""
        term = self.term(node)
        if term.kind != "whole" or term.value is None or term.value < 0:
            raise self.refuse(node, f"the row {_shown(node)} has to be a constant, 0 or more")
        return int(term.value), node.id.lower() if isinstance(node, ast.Name) else f"row_{term.value}"

    def _column(self, node: ast.expr) -> str:
        term = self.term(node)
        if term.kind == "index" or (term.kind == "whole" and term.value == 0):
            return term.code
        raise self.refuse(node, f"a joint is the variable of a loop, or 0, and not {_shown(node)}")

    def _unaryop(self, node: ast.UnaryOp) -> Term:
        if isinstance(node.op, ast.Not):
            return Term(f"!{self.truth(node.operand).within(SIGN)}", "truth", SIGN)
        inner = self.term(node.operand)
        if not isinstance(node.op, ast.USub) or inner.kind not in ("real", "whole"):
            raise self.refuse(node, f"{_shown(node)} has no counterpart here")
        if inner.kind == "whole" and inner.value is not None:
            return Term(str(-inner.value), "whole", SIGN, -inner.value)
        code = inner.within(SIGN)
        return Term(f"-({code})" if code.startswith("-") else f"-{code}", "real", SIGN)

    def _binop(self, node: ast.BinOp) -> Term:
        if isinstance(node.op, ast.Pow):
            return self._power(node)
        if type(node.op) not in _ARITHMETIC:
            raise self.refuse(node, f"the operator of {_shown(node)} has no counterpart here")
        sign, level = _ARITHMETIC[type(node.op)]
        left, right = self.real(node.left), self.real(node.right)
        return Term(f"{left.within(level)} {sign} {right.within(level + 1)}", "real", level)

    def _power(self, node: ast.BinOp) -> Term:
        base, exponent = self.real(node.left), self.term(node.right)
        if exponent.value is not None:
            raise self.refuse(node, f"write {_shown(node)} as a product: a constant power is rounded in several ways")
        return Term(f"{self.step.helper('power')}({base.code}, {self.real(node.right).code})", "real")

    def _compare(self, node: ast.Compare) -> Term:
        if len(node.ops) != 1 or type(node.ops[0]) not in _COMPARISONS:
            raise self.refuse(node, f"{_shown(node)} has no counterpart here; compare two numbers at a time")
        sign, level = _COMPARISONS[type(node.ops[0])]
        left, right = self.term(node.left), self.term(node.comparators[0])
        if left.kind == "count" and right.kind == "whole" and isinstance(right.value, int) and right.value >= 0:
            return Term(f"{left.code} {sign} {right.code}U", "truth", level)
        pair = (self._as(node.left, left, "real"), self._as(node.comparators[0], right, "real"))
        return Term(f"{pair[0].within(SUM)} {sign} {pair[1].within(SUM)}", "truth", level)

    def _boolop(self, node: ast.BoolOp) -> Term:
        sign, level = ("&&", AND) if isinstance(node.op, ast.And) else ("||", OR)
        # In parentheses where the other of the two stands inside: compilers ask for them.
        parts = [self.truth(value) for value in node.values]
        return Term(
            f" {sign} ".join(part.within(level if part.level == level else SAME) for part in parts), "truth", level
        )

    def _ifexp(self, node: ast.IfExp) -> Term:
        asked, yes, no = self.truth(node.test), self.term(node.body), self.term(node.orelse)
        if "real" in (yes.kind, no.kind):
            yes, no = self._as(node.body, yes, "real"), self._as(node.orelse, no, "real")
        if yes.kind != no.kind or yes.kind not in ("real", "truth"):
            raise self.refuse(node, f"{_shown(node)} is a {yes.kind} or a {no.kind}; both have to be numbers")
        return Term(f"{asked.within(OR)} ? {yes.within(OR)} : {no.within(OR)}", yes.kind, CHOICE)

    def _call(self, node: ast.Call) -> Term:
        if node.keywords or any(isinstance(each, ast.Starred) for each in node.args):
            raise self.refuse(node, "give arguments one by one, without their names")
        called = self._called(node.func)
        if called is float:
            return self.real(node.args[0])
        if _is_helper(called):
            name, takes = HELPERS[called]
            if len(node.args) != takes:
                raise self.refuse(node, f"{_shown(node.func)} takes {takes} numbers here")
            given = ", ".join(self.real(each).code for each in node.args)
            return Term(f"{self.step.helper(name)}({given})", "real")
        if not isinstance(getattr(called, "py_func", called), FunctionType):
            raise self.refuse(node, f"{_shown(node.func)} has no counterpart here; known are {_known_helpers()}")
        given_terms = [self.term(each) for each in node.args]
        made = self.step.function(self.source, node, called, given_terms)
        for term, writes in zip(given_terms, made.writes, strict=True):
            if writes and term.writes is None:
                raise self.refuse(node, f"{made.c_name} writes to what a step is told, which is not to be written to")
            if writes and term.writes is not None:
                self.written.add(term.writes)
        passed = [
            self._as(each, term, "real").code if kind == "real" else term.code
            for each, term, kind in zip(node.args, given_terms, made.kinds, strict=True)
        ]
        return Term(f"{made.c_name}({', '.join(passed)})", made.returns)

    def _called(self, node: ast.expr) -> Any:
        """What is called: a function, found by its name or as one of numpy's."""
        if isinstance(node, ast.Name) and node.id not in self.known:
            return self.source.names.get(node.id)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = self.source.names.get(node.value.id)
            return getattr(module, node.attr, None) if module is np else None
        return None


def c_local(name: str) -> str:
    """A local variable's name in C."""
    return identifier(name)


def _is_helper(called: Any) -> bool:
    return any(called is each for each in HELPERS)


def _known_helpers() -> str:
    return "abs, float, np.copysign, np.maximum, np.minimum, np.sqrt, and functions under short_loops"


def _shown(node: ast.AST) -> str:
    return f"'{ast.unparse(node)}'"
