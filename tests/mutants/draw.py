"""Which mutants are tried: all that the operators can make, in an order that a seed fixes.

The order comes from a digest of each mutant alone, not from a generator run over the list: an edit of one line changes
the lot of the mutants of that line and of no other, so that the list of equivalents stays true.
"""

from __future__ import annotations

import difflib
import hashlib
import types
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

from mutants.operators import operators


@dataclass(frozen=True)
class Mutant:
    """One fault.

    Attributes:
        module: Path of the file below the project's root.
        function: Qualified name of the outermost function that changed; None if the module's or a class's own code did.
        line: Number of the first line that changed.
        was: That line (or lines), stripped.
        becomes: What stands there instead.
        operator: Name of the operator.
        source: The whole changed text.
    """

    module: str
    function: str | None
    line: int
    was: str
    becomes: str
    operator: str
    source: str

    @property
    def name(self) -> tuple[str, str, str]:
        """What tells it from others, and stays as it is when lines move."""
        return self.module, self.was, self.becomes


def _same(old: types.CodeType, new: types.CodeType) -> bool:
    """Whether two codes do the same, wherever their lines stand."""
    if (old.co_code, old.co_names, old.co_varnames, old.co_freevars) != (
        new.co_code,
        new.co_names,
        new.co_varnames,
        new.co_freevars,
    ):
        return False
    if len(old.co_consts) != len(new.co_consts):
        return False
    for a, b in zip(old.co_consts, new.co_consts, strict=True):
        if isinstance(a, types.CodeType) and isinstance(b, types.CodeType):
            if not _same(a, b):
                return False
        elif repr(a) != repr(b):
            return False
    return True


def functions(code: types.CodeType) -> Iterator[types.CodeType]:
    """The outermost functions below a module's code: its own and those of its classes."""
    for const in code.co_consts:
        if isinstance(const, types.CodeType):
            if const.co_flags & 0x2:  # CO_NEWLOCALS: a function, not the body of a class
                yield const
            else:
                yield from functions(const)


def changed_function(old: types.CodeType, new: types.CodeType) -> tuple[types.CodeType, types.CodeType] | None:
    """The function in which two codes of a module differ, before and after; None if they differ elsewhere."""
    befores, afters = list(functions(old)), list(functions(new))
    if [f.co_qualname for f in befores] != [f.co_qualname for f in afters]:
        return None
    differing = [(a, b) for a, b in zip(befores, afters, strict=True) if not _same(a, b)]
    return differing[0] if len(differing) == 1 else None


def _made(root: Path, module: str, operator: str, occurrence: int) -> Mutant | None:
    """A mutant in full; None if it does not parse or does what the original does."""
    path = root / module
    text = path.read_text(encoding="utf-8")
    source = mutate_code(text, operators()[operator], occurrence)
    return None if source is None else _compared(path, module, operator, text, source)


def _compared(path: Path, module: str, operator: str, text: str, source: str) -> Mutant | None:
    try:
        old, new = compile(text, str(path), "exec"), compile(source, str(path), "exec")
    except SyntaxError:
        return None
    if _same(old, new):
        return None
    before, after = text.splitlines(), source.splitlines()
    edits = [e for e in difflib.SequenceMatcher(None, before, after, False).get_opcodes() if e[0] != "equal"]
    was = " ".join(line.strip() for e in edits for line in before[e[1] : e[2]])
    becomes = " ".join(" ".join(line.split()) for e in edits for line in after[e[3] : e[4]])
    pair = changed_function(old, new)
    return Mutant(module, pair and pair[0].co_qualname, edits[0][1] + 1, was, becomes, operator, source)


def positions(root: Path, module: str) -> Iterator[tuple[str, int, str]]:
    """Operator, occurrence and a name of each fault that a module can have."""
    text = (root / module).read_text(encoding="utf-8")
    lines, known, seen, occurrences = text.splitlines(), operators(), Counter[str](), Counter[str]()
    for node in ast_nodes(get_ast(text)):
        for operator, made in known.items():
            for at, _ in made.mutation_positions(node):
                name = f"{module}:{operator}:{lines[at[0] - 1].strip()}:{at[1]}"
                seen[name] += 1
                yield operator, occurrences[operator], f"{name}:{seen[name]}"
                occurrences[operator] += 1


def draw(root: Path, modules: list[str], count: int, seed: int) -> tuple[list[Mutant], int]:
    """The first mutants in the seed's order, and how many faults there are to draw from."""
    lots = []
    for module in modules:
        for operator, occurrence, name in positions(root, module):
            lots.append((hashlib.sha256(f"{seed}:{name}".encode()).hexdigest(), module, operator, occurrence))
    drawn: dict[tuple[str, str, str], Mutant] = {}
    for _, module, operator, occurrence in sorted(lots):
        if len(drawn) == count:
            break
        mutant = _made(root, module, operator, occurrence)
        if mutant is not None:
            drawn.setdefault(mutant.name, mutant)
    return sorted(drawn.values(), key=lambda m: (m.module, m.line, m.becomes)), len(lots)


def by_hand(root: Path, faults: list[dict[str, str]]) -> list[Mutant]:
    """The mutants of `by_hand.toml`.

    Raises:
        ValueError: The line that one changes is not there, or more than once.
    """
    made = []
    for fault in faults:
        path = root / fault["module"]
        text = path.read_text(encoding="utf-8")
        at = [k for k, line in enumerate(text.split("\n")) if line.strip() == fault["was"]]
        if len(at) != 1:
            raise ValueError(f"by_hand.toml, '{fault['what']}': its line stands {len(at)} times in {fault['module']}")
        lines = text.split("\n")
        lines[at[0]] = lines[at[0]].replace(fault["was"], fault["becomes"])
        mutant = _compared(path, fault["module"], "by hand", text, "\n".join(lines))
        assert mutant is not None
        made.append(mutant)
    return made
