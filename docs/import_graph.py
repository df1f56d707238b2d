"""Who imports whom in the package, read from the source; drawn in docs/rooms.md, and what tests of the layers ask.

Every import counts: at the top of a file, in a function, for type checkers only, and ``import_module("a.b")``. A
package whose public names load on first use lists them in a block for type checkers, so those count as well.
The one thing not seen is the folder of commands, whose files `cli/dispatch.py` imports by listing it.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "asmc_pin"
OPEN = {"_typing", "errors", "words", "disk", "lazy", "clock", "registering"}
"""What is open to all, and says nothing of how rooms depend on each other."""


@cache
def sources() -> dict[str, Path]:
    """Every module of the package and its file."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        names = [PACKAGE.name, *path.relative_to(PACKAGE).with_suffix("").parts]
        found[".".join(names[:-1] if names[-1] == "__init__" else names)] = path
    return found


def imports(source: str, module: str, is_package: bool) -> set[str]:
    """Every module that the source names in an import, absolute; wherever the import stands, `TYPE_CHECKING` included.

    ``from a import b`` counts as a.b, be b a module or not. ``import_module("a")`` counts as well.
    """
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                package = module.split(".")[: None if is_package else -1]
                package = package[: len(package) - node.level + 1]
                base = ".".join([*package, *([base] if base else [])])
            found |= {f"{base}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in ("import_module", "__import__"):
                found.add(str(node.args[0].value))
    return found


@cache
def imports_of(module: str) -> frozenset[str]:
    """What a module of the package imports, by `imports`."""
    path = sources()[module]
    return frozenset(imports(path.read_text(encoding="utf-8"), module, path.name == "__init__.py"))


def file_graph() -> dict[str, set[str]]:
    """Module -> modules of the package that it imports; of a name that is no module, the module that has it."""
    known = sources()
    graph = {}
    for module in known:
        targets = {target if target in known else target.rpartition(".")[0] for target in imports_of(module)}
        graph[module] = (targets & set(known)) - {module}
    return graph


def circles(graph: Mapping[str, Collection[str]]) -> list[list[str]]:
    """Groups of nodes that reach each other: the strongly connected parts of more than one node, by Tarjan."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph[node]:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            start = stack.index(node)
            if len(stack) - start > 1:
                found.append(sorted(stack[start:]))
            del stack[start:]

    for node in graph:
        if node not in index:
            visit(node)
    return found


def room_of(module: str, inside: str = "") -> str | None:
    """The room that a module is in: a folder or a file at the top, or directly inside of a room; None if elsewhere."""
    names = module.split(".")[1:]
    if inside:
        if names[:1] != [inside] or len(names) < 2:
            return None
        names = names[1:]
    return names[0] if names else None


def room_graph(inside: str = "") -> dict[str, set[str]]:
    """Room -> rooms that it imports; what is open to all is left out, and so are files beside rooms inside of one."""
    graph: dict[str, set[str]] = {}
    for module, targets in file_graph().items():
        room = room_of(module, inside)
        if room is None or room in OPEN or (inside and not (PACKAGE / inside / room).is_dir()):
            continue
        others = {room_of(target, inside) for target in targets} - {None, room} - OPEN
        graph.setdefault(room, set()).update(other for other in others if other)
    return {room: others & set(graph) for room, others in graph.items()}


def reduced(graph: Mapping[str, Collection[str]]) -> dict[str, set[str]]:
    """The graph, which has no circle, without the arrows that a longer way makes plain."""

    @cache
    def reach(node: str) -> frozenset[str]:
        return frozenset().union(*({other} | reach(other) for other in graph[node]))

    return {
        node: {other for other in others if not any(other in reach(via) for via in others)}
        for node, others in graph.items()
    }


def layers(graph: Mapping[str, Collection[str]]) -> list[list[str]]:
    """Nodes in rows: each stands one row below the lowest of what it imports."""

    @cache
    def depth(node: str) -> int:
        return 1 + max((depth(other) for other in graph[node]), default=-1)

    rows: dict[int, list[str]] = {}
    for node in sorted(graph):
        rows.setdefault(depth(node), []).append(node)
    return [rows[key] for key in sorted(rows)]


def folders() -> Iterator[tuple[str, int]]:
    """Every folder of the package by its path, and how many files it holds, `__init__` aside."""
    for folder in sorted({path.parent for path in sources().values()}):
        files = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
        yield folder.relative_to(PACKAGE.parent).as_posix(), len(files)


def docstring(module: str) -> list[str]:
    """The paragraphs of a module's docstring, each in one line."""
    text = ast.get_docstring(ast.parse(sources()[module].read_text(encoding="utf-8"))) or ""
    return [" ".join(paragraph.split()) for paragraph in text.split("\n\n")]
