"""What `asmc_pin` offers: every verb, every type that their signatures need, and none of it loaded before its use."""

from __future__ import annotations

import ast
import collections.abc
import dataclasses
import importlib
import inspect
import re
import subprocess
import sys
import types
import typing
from collections.abc import Iterator
from pathlib import Path

import pytest
from short_experiment import SHORT

import asmc_pin
from asmc_pin import _typing
from asmc_pin.lazy import homes_of

VERBS = [
    *("load_arm", "lemma1_norm", "weighted_norm", "verify", "certify", "check", "design", "bounds", "stability"),
    *("certify_loop", "export", "load_exported", "identify", "read_log", "mbar_on_log", "law_on_log"),
    *("suggest_gains", "agree", "load_experiment", "compare", "reproduce", "rollout", "sweep", "tune", "bench", "view"),
    "inspect",
]

# Data of a report that only our own code reads: what it is made of may change without notice.
OURS = {
    "Arm.tree",
    "Arm.made_of",
    "BoundsReport.cases",
    "BoundsReport.proofs",
    "CertificateResult.cases",
    "CertificateResult.proofs",
    "LoopProof.cases",
    "LoopProof.pieces",
    "LoopProof.proofs",
}


@pytest.mark.parametrize("name", VERBS)
def test_every_verb_is_a_documented_function_of_that_name(name):
    verb = getattr(asmc_pin, name)
    assert inspect.isfunction(verb)
    assert verb.__name__ == name
    assert verb.__doc__


HOMES = homes_of("asmc_pin")


def test_every_public_name_is_found_listed_and_known_to_type_checkers():
    source = ast.parse(Path(asmc_pin.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in source.body if isinstance(node, ast.If))
    # Only a name that is imported as itself is public to a type checker.
    told = [(alias.name, alias.asname) for item in block.body for alias in item.names]
    assert told == [(name, name) for name in HOMES]
    assert sorted(asmc_pin.__all__) == sorted(HOMES)
    for name in asmc_pin.__all__:
        assert getattr(asmc_pin, name) is getattr(importlib.import_module(HOMES[name]), name)
        assert name in dir(asmc_pin)


def test_what_is_not_public_is_not_there():
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        asmc_pin.nonsense  # noqa: B018


def test_importing_the_package_loads_nothing_heavy():
    code = "import sys, asmc_pin; dir(asmc_pin); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "asmc_pin.lazy" in loaded
    assert not {"numpy", "pinocchio", "pandas", "numba", "asmc_pin.arms", "asmc_pin.condition"} & set(loaded)


@pytest.mark.parametrize("name", VERBS)
def test_a_verb_stays_itself_after_the_modules_behind_it_were_imported(name):
    code = f"import {HOMES[name]}, asmc_pin; assert callable(asmc_pin.{name}), asmc_pin.{name}"
    subprocess.run([sys.executable, "-c", code], check=True)


# Signatures ----------------------------------------------------------------------------------------------------------


def deferred(module: types.ModuleType) -> dict[str, object]:
    """What a module imports for type checkers only."""
    found: dict[str, object] = {}
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            exec(compile(ast.Module(node.body, []), module.__name__, "exec"), found)
    return found


def hints(thing: object) -> dict[str, object]:
    modules = [sys.modules[base.__module__] for base in reversed(getattr(thing, "__mro__", (thing,)))]
    # An alias of another module may hold a name that only stands there.
    known = vars(collections.abc) | vars(_typing) | {"Any": typing.Any}
    known |= {name: getattr(asmc_pin, name) for name in asmc_pin.__all__}
    for module in modules:
        known |= vars(module)
        if module.__name__.startswith("asmc_pin"):
            known |= deferred(module)
    return typing.get_type_hints(thing, known)


def flat(annotation: object) -> Iterator[object]:
    """The classes within an annotation."""
    inner = typing.get_args(annotation)
    if typing.get_origin(annotation) is typing.Literal:
        return
    if isinstance(annotation, list | tuple):  # the parameters of a Callable
        inner = tuple(annotation)
    elif not inner:
        yield annotation
    for part in inner:
        yield from flat(part)


def signatures() -> Iterator[tuple[str, object]]:
    """Every annotation that a user of the public names meets, by where it stands."""
    things = {name: getattr(asmc_pin, name) for name in asmc_pin.__all__}
    ours = {module for module in sys.modules if module.partition(".")[0] == "asmc_pin"}
    for name, thing in things.items():
        if inspect.isfunction(thing):
            yield from ((f"{name}({key})", value) for key, value in hints(thing).items())
        if not inspect.isclass(thing):
            continue
        if dataclasses.is_dataclass(thing):
            shown = hints(thing)
            fields = (field.name for field in dataclasses.fields(thing) if not field.name.startswith("_"))
            yield from ((f"{name}.{key}", shown[key]) for key in fields)
        inherited = (vars(base) for base in reversed(thing.__mro__) if base.__module__ in ours)
        for key, member in {key: member for each in inherited for key, member in each.items()}.items():
            function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
            written = inspect.isfunction(function) and function.__code__.co_filename != "<string>"
            if written and (key == "__init__" or not key.startswith("_")) and function.__module__ in ours:
                yield from ((f"{name}.{key}({k})", value) for k, value in hints(function).items())


def strange(annotations: Iterator[tuple[str, object]]) -> list[str]:
    """Types of this package that a signature names and that are not public."""
    public = {id(getattr(asmc_pin, name)) for name in asmc_pin.__all__}
    return [
        f"{where}: {part.__module__}.{part.__qualname__}"
        for where, annotation in annotations
        if where.partition("(")[0] not in OURS
        for part in flat(annotation)
        if isinstance(part, type) and part.__module__.startswith("asmc_pin") and id(part) not in public
    ]


def test_every_type_that_a_public_signature_needs_is_public():
    found = list(signatures())
    assert len(found) > 300
    assert not strange(iter(found))


def test_a_type_that_is_not_public_is_noticed():
    class Hidden:
        pass

    Hidden.__module__ = "asmc_pin.somewhere"
    assert strange(iter([("verb(x)", typing.Callable[[dict[str, Hidden | None]], int])]))
    assert not strange(iter([("verb(x)", dict[str, asmc_pin.Arm])]))


def test_exceptions_to_that_are_still_needed():
    assert {where.partition("(")[0] for where, _ in signatures()} >= OURS


# Looking at a result -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    (folder / "short.toml").write_text(SHORT, encoding="utf-8")
    return asmc_pin.compare(asmc_pin.load_experiment(folder / "short.toml"), folder / "out")


def test_a_comparison_its_folder_and_its_result_make_the_same_page(compared, tmp_path):
    pages = []
    for i, thing in enumerate((compared, compared.out, str(compared.out), asmc_pin.load_result(compared.out))):
        page = asmc_pin.view(thing, html=tmp_path / f"{i}.html")
        assert page == tmp_path / f"{i}.html"
        pages.append(page.read_text(encoding="utf-8"))
    assert "Wild" in pages[0]
    assert len(set(pages)) == 1


def test_without_a_page_the_result_is_served(compared, monkeypatch):
    served = []
    monkeypatch.setattr("asmc_pin.viewer.serve", lambda *args, **options: served.append((args, options)))
    assert asmc_pin.view(compared, port=8123, open_browser=True) is None
    assert served == [((compared.out, 8123), {"open_browser": True})]


def test_what_is_no_result_and_where_no_page_can_be_are_said(compared, tmp_path):
    with pytest.raises(asmc_pin.ResultError, match="there is no result"):
        asmc_pin.view(tmp_path / "absent")
    with pytest.raises(asmc_pin.AsmcPinError, match=re.escape(str(tmp_path))):
        asmc_pin.view(compared, html=tmp_path)
