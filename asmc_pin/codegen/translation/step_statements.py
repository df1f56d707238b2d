"""Statements of a step in C, with every local variable declared where its life begins."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field

from asmc_pin.codegen.translation.c_terms import Kind, Term
from asmc_pin.codegen.translation.c_words import NotInC
from asmc_pin.codegen.translation.expressions import Expressions, c_local
from asmc_pin.codegen.translation.restricted_python import PythonFunction

Path = tuple[int, ...]
"""A block by the blocks around it, outermost first; () is the function's own."""

_AUGMENTED: dict[type[ast.operator], str] = {ast.Add: "+=", ast.Sub: "-=", ast.Mult: "*=", ast.Div: "/="}


@dataclass
class Local:
    """A local variable.

    Attributes:
        block: The innermost block that all its uses lie in.
        at_first: Whether its first statement, an assignment of that very block, can declare it.
        stores: How often it is assigned to.
        kind: What it is, once that is known.
    """

    block: Path
    at_first: bool
    stores: int = 1
    kind: Kind | None = None
    declared: bool = False


@dataclass
class Statements:
    """The body of one function.

    Attributes:
        source: The function.
        expressions: Its expressions.
        type_name: Of a real number in C.
        joints: The macro with the number of joints.
        returns: What it gives, once that is known.
    """

    source: PythonFunction
    expressions: Expressions
    type_name: str
    joints: str
    returns: Kind = "nothing"
    locals: dict[str, Local] = field(default_factory=dict)
    _temporaries: int = 0

    def lines(self) -> list[str]:
        """All of it."""
        body = self.source.statements()
        for path, statement, name, stored in _uses(body, ()):
            if name in self.locals:
                local = self.locals[name]
                shared = _common(local.block, path)
                local.at_first &= shared == local.block
                local.block = shared
                local.stores += stored
            elif stored and name not in self.expressions.known:
                self.locals[name] = Local(path, isinstance(statement, ast.Assign))
        return self._block(body, ())

    def _block(self, body: list[ast.stmt], path: Path) -> list[str]:
        made: list[str] = []
        for number, statement in enumerate(body):
            try:
                made += self._statement(statement, (*path, number))
            except NotInC as error:
                if self.source.file in str(error):
                    raise
                raise self._refuse(statement, str(error)) from error
        early = [
            f"{self._declaration(local.kind)} {c_local(name)} = {'0' if local.kind == 'truth' else self._zero()};"
            for name, local in self.locals.items()
            if local.block == path and not local.at_first and local.kind is not None
        ]
        return early + made

    def _statement(self, node: ast.stmt, path: Path) -> list[str]:
        if isinstance(node, ast.Assign):
            return self._assign(node)
        if isinstance(node, ast.AugAssign):
            if type(node.op) not in _AUGMENTED:
                raise self._refuse(node, "of the augmented assignments +=, -=, *= and /= have a counterpart here")
            target = self._target(node.target, None)
            return [f"{target} {_AUGMENTED[type(node.op)]} {self.expressions.real(node.value).code};"]
        if isinstance(node, ast.For):
            return self._for(node, path)
        if isinstance(node, ast.If):
            return self._if(node, path)
        if isinstance(node, ast.Return):
            return self._return(node)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            return [f"{self.expressions.term(node.value).code};"]
        if isinstance(node, ast.Pass):
            return []
        raise self._refuse(node, f"'{type(node).__name__}' has no counterpart here")

    def _assign(self, node: ast.Assign) -> list[str]:
        if len(node.targets) != 1:
            raise self._refuse(node, "assign to one target at a time")
        target = node.targets[0]
        if not isinstance(target, ast.Tuple):
            return self._store(target, node.value)
        if not isinstance(node.value, ast.Tuple) or len(node.value.elts) != len(target.elts):
            raise self._refuse(node, "a tuple is assigned one by one, from as many values")
        pairs = list(zip(target.elts, node.value.elts, strict=True))
        stored = {name for each in target.elts for name in _base_names(each)}
        if not stored & {item.id for item in ast.walk(node.value) if isinstance(item, ast.Name)}:
            return [line for each, value in pairs for line in self._store(each, value)]
        # Python reads all values before it stores the first.
        made, kept = [], []
        for _, value in pairs:
            term = self.expressions.term(value)
            term = self.expressions.real(value) if term.kind == "whole" else term
            self._temporaries += 1
            kept.append(Term(f"next_{self._temporaries}", term.kind))
            made.append(f"const {self._declaration(term.kind)} {kept[-1].code} = {term.code};")
        return made + [line for (each, _), term in zip(pairs, kept, strict=True) for line in self._put(each, term)]

    def _store(self, target: ast.expr, value: ast.expr) -> list[str]:
        term = self.expressions.term(value)
        return self._put(target, self.expressions.real(value) if term.kind == "whole" else term)

    def _put(self, target: ast.expr, term: Term) -> list[str]:
        if term.kind not in ("real", "truth"):
            raise self._refuse(target, f"a {term.kind} cannot be kept in a variable")
        return [f"{self._target(target, term.kind)} = {term.code};"]

    def _target(self, node: ast.expr, kind: Kind | None) -> str:
        if isinstance(node, ast.Name):
            return self._local(node, kind)
        place = self.expressions.term(node)
        if place.kind != "real" or kind == "truth":
            raise self._refuse(node, "only numbers are stored in rows")
        if place.writes is None:
            raise self._refuse(node, "what a step is told is not to be written to")
        self.expressions.written.add(place.writes)
        return place.code

    def _local(self, node: ast.Name, kind: Kind | None) -> str:
        local = self.locals.get(node.id)
        if local is None:
            raise self._refuse(node, f"'{node.id}' is a parameter; give the new value a name of its own")
        wanted = kind or local.kind
        if wanted is None or (local.kind is not None and local.kind != wanted):
            raise self._refuse(node, f"'{node.id}' is one kind of value first and another one later")
        local.kind = wanted
        code = c_local(node.id)
        self.expressions.known[node.id] = Term(code, wanted)
        if not local.at_first or local.declared:
            return code
        local.declared = True
        return f"{'const ' if local.stores == 1 else ''}{self._declaration(wanted)} {code}"

    def _for(self, node: ast.For, path: Path) -> list[str]:
        call, variable = node.iter, node.target
        over = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"
        if not (over and isinstance(variable, ast.Name)) or node.orelse or len(call.args) != 1:  # type: ignore[attr-defined]
            raise self._refuse(node, "loops go over the joints: 'for i in range(row.size):'")
        (size,) = call.args  # type: ignore[attr-defined]
        if not (isinstance(size, ast.Attribute) and size.attr == "size"):
            raise self._refuse(node, "loops go over the joints: 'for i in range(row.size):'")
        if self.expressions.term(size.value).kind != "row":
            raise self._refuse(node, f"'{ast.unparse(size.value)}' is no row of one number per joint")
        index = c_local(variable.id)
        self.expressions.known[variable.id] = Term(index, "index")
        body = self._block(node.body, (*path, 0))
        del self.expressions.known[variable.id]
        return [f"for (int {index} = 0; {index} < {self.joints}; ++{index}) {{", *_indented(body), "}"]

    def _if(self, node: ast.If, path: Path) -> list[str]:
        made = [f"if ({self.expressions.truth(node.test).code}) {{"]
        made += _indented(self._block(node.body, (*path, 0)))
        if node.orelse:
            made += ["} else {", *_indented(self._block(node.orelse, (*path, 1)))]
        return [*made, "}"]

    def _return(self, node: ast.Return) -> list[str]:
        if node.value is None:
            return ["return;"]
        term = self.expressions.term(node.value)
        term = self.expressions.real(node.value) if term.kind == "whole" else term
        if term.kind not in ("real", "truth") or self.returns not in ("nothing", term.kind):
            raise self._refuse(node, f"a function gives a number, or yes or no, and not a {term.kind}")
        self.returns = term.kind
        return [f"return {term.code};"]

    def _declaration(self, kind: Kind | None) -> str:
        return "int" if kind == "truth" else self.type_name

    def _zero(self) -> str:
        return f"({self.type_name})0"

    def _refuse(self, node: ast.AST, told: str) -> Exception:
        return self.source.refuse(node, told)


def _uses(body: list[ast.stmt], path: Path) -> Iterator[tuple[Path, ast.stmt, str, bool]]:
    """Every name in the order of the text: its block, its statement, and whether it is stored there."""
    for number, statement in enumerate(body):
        inner: list[list[ast.stmt]] = []
        if isinstance(statement, ast.For):
            own: list[ast.AST] = [statement.iter]
            inner = [statement.body]
        elif isinstance(statement, ast.If):
            own, inner = [statement.test], [statement.body, statement.orelse]
        elif isinstance(statement, ast.Assign):
            own = [statement.value, *statement.targets]  # read before it is stored
        else:
            own = [statement]
        for part in own:
            for item in ast.walk(part):
                if isinstance(item, ast.Name):
                    yield path, statement, item.id, isinstance(item.ctx, ast.Store)
        for branch, block in enumerate(inner):
            yield from _uses(block, (*path, number, branch))


def _base_names(target: ast.expr) -> set[str]:
    return {item.id for item in ast.walk(target) if isinstance(item, ast.Name) and _is_base(target, item)}


def _is_base(target: ast.expr, name: ast.Name) -> bool:
    return name is target or (isinstance(target, ast.Subscript) and name is target.value)


def _common(a: Path, b: Path) -> Path:
    shared = []
    for one, other in zip(a, b, strict=False):
        if one != other:
            break
        shared.append(one)
    # Blocks are pairs of statement and branch.
    return tuple(shared[: len(shared) // 2 * 2])


def _indented(lines: list[str]) -> list[str]:
    return [f"    {line}" for line in lines]
