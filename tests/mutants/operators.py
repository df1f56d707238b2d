"""The faults: cosmic-ray's operators, less those that arithmetic cannot survive, and four of our own.

Cosmic-ray replaces a `*` by `<<`, which any run notices, but deletes no term of a sum, no factor, no statement and no
`abs`. Those are the faults that an earlier search by hand found unnoticed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import parso
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Example, Operator
from cosmic_ray.operators.provider import OperatorProvider

_BINARY = ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Pow_Mul", "FloorDiv_Mul", "Mod_Mul")
_BITS = ("BitOr_BitAnd", "BitAnd_BitOr")
_COMPARISON = (
    *("Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is"),
    *("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_Gt", "Gt_Lt", "LtE_GtE", "GtE_LtE"),
)
_UNARY = ("Delete_USub", "Delete_Invert", "Delete_Not")
_OTHERS = (
    *("AddNot", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd"),
    *("ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "NumberReplacer", "ZeroIterationForLoop"),
)

Span = tuple[tuple[int, int], tuple[int, int]]
"""Where a fault begins and ends, (line, column) each."""


class _Ours(Operator):
    """An operator that builds the new text of a node itself."""

    def _texts(self, node: Any) -> Iterator[str]:
        """The texts that may stand in place of a node."""
        raise NotImplementedError

    def mutation_positions(self, node: Any) -> Iterator[Span]:
        for _ in self._texts(node):
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        first = node.get_first_leaf()
        return parso.parse(first.prefix + list(self._texts(node))[index])


def _code(nodes: list[Any]) -> str:
    return "".join(node.get_code() for node in nodes).strip()


class DropTerm(_Ours):
    """a + b − c without one of its terms."""

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("x = a - b + c", "x = (a + c)", 1),)

    def _texts(self, node: Any) -> Iterator[str]:
        if node.type == "arith_expr":
            for at in range(0, len(node.children), 2):
                rest = node.children[1:] if at == 0 else node.children[: at - 1] + node.children[at + 1 :]
                yield f"({_code(rest)})"


class DropFactor(_Ours):
    """a * b / c without one of its factors."""

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("x = a / b * c", "x = (a / b)", 1),)

    def _texts(self, node: Any) -> Iterator[str]:
        if node.type == "term":
            signs = [child.value for child in node.children[1::2]]
            for at in range(0, len(node.children), 2):
                if at == 0 and signs[0] == "*":
                    yield f"({_code(node.children[2:])})"
                elif at > 0 and signs[at // 2 - 1] in "*/":
                    yield f"({_code(node.children[: at - 1] + node.children[at + 1 :])})"


class DropStatement(_Ours):
    """A write to a place, or a call for its effect, left out; other names would be missed by whoever reads them."""

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("y = 2\nx[0] = 1\n", "y = 2\npass\n", 0),)

    def _texts(self, node: Any) -> Iterator[str]:
        if node.type == "expr_stmt":
            target, sign = node.children[0], node.children[1]
            if sign.type == "operator" and sign.value == "=":
                writes = target.type == "atom_expr"
            else:
                writes = sign.type in ("operator", "augassign") or sign.get_code().strip() != "="
                writes = writes and sign.type != "annassign"
            if writes:
                yield "pass"
        elif node.type == "atom_expr" and node.parent is not None and node.parent.type == "simple_stmt":
            yield "pass"


_SWAPS = {
    "min": "max",
    "max": "min",
    "minimum": "maximum",
    "maximum": "minimum",
    "any": "all",
    "all": "any",
    "sin": "cos",
    "cos": "sin",
    "floor": "ceil",
    "ceil": "floor",
    "argmin": "argmax",
    "argmax": "argmin",
    "abs": "",
    "sqrt": "",
    "sign": "",
}


class SwapCall(_Ours):
    """A call of the opposite function, or of none."""

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("x = abs(a) + np.min(b)", "x = abs(a) + np.max(b)", 1),)

    def _texts(self, node: Any) -> Iterator[str]:
        if node.type != "atom_expr":
            return
        for k, child in enumerate(node.children[:-1]):
            name = child if child.type == "name" else child.children[-1] if child.type == "trailer" else None
            called = node.children[k + 1]
            if name is None or name.type != "name" or called.type != "trailer" or called.children[0].value != "(":
                continue
            if name.value in _SWAPS and k + 2 >= len(node.children) - 1:
                other, before = _SWAPS[name.value], node.children[:k]
                tail = _code(node.children[k + 1 :])
                if other:
                    dot = "." if child.type == "trailer" else ""
                    yield f"{_code(before)}{dot}{other}{tail}"
                elif k < 2 and len(called.children) == 3:
                    yield tail


OURS: tuple[type[Operator], ...] = (DropTerm, DropFactor, DropStatement, SwapCall)


def operators() -> dict[str, Operator]:
    """All operators by name."""
    provider = OperatorProvider()
    names = [f"ReplaceBinaryOperator_{each}" for each in (*_BINARY, *_BITS)]
    names += [f"ReplaceComparisonOperator_{each}" for each in _COMPARISON]
    names += [f"ReplaceUnaryOperator_{each}" for each in _UNARY]
    found = {name: provider[name]() for name in (*names, *_OTHERS)}
    return found | {each.__name__: each() for each in OURS}


def check_examples() -> None:
    """See that our operators make of their examples what they say."""
    for each in OURS:
        for example in each.examples():
            made = mutate_code(example.pre_mutation_code, each(), example.occurrence)
            assert made == example.post_mutation_code, (each.__name__, made)
