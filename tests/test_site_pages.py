"""The site has every page, name and command, and the wheel has every page that the program cites."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import generate
import pytest
import typer
from paths import REPOSITORY

import asmc_pin
from asmc_pin.cli.dispatch import app

DOCS = REPOSITORY / "docs"
CITED = re.compile(r"\bdocs/[\w/-]+\.md\b")


def read(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def in_the_contents() -> set[str]:
    """Files that the contents of the site name, as paths from the top of the checkout, without their suffix."""
    named = re.findall(r"^```\{toctree\}\n(.*?)^```", read("index.md"), re.DOTALL | re.MULTILINE)
    entries = {line for block in named for line in block.splitlines() if re.fullmatch(r"[\w./-]*\w", line)}
    return {(DOCS / entry).resolve().relative_to(REPOSITORY).as_posix() for entry in entries}


def test_every_page_has_its_place_in_the_contents() -> None:
    pages = {*generate.pages(), *DOCS.glob("*/*.md"), *(REPOSITORY / "examples").glob("*.ipynb")} - {DOCS / "index.md"}
    there = {path.relative_to(REPOSITORY).with_suffix("").as_posix() for path in pages}
    howtos = {name for name in there if name.startswith("docs/howto/")} - {"docs/howto/index"}
    assert there - howtos <= in_the_contents()
    assert all(f"({Path(name).name}.md)" in read("howto/index.md") for name in howtos)
    for name in in_the_contents():
        assert list(REPOSITORY.glob(f"{name}.*")), f"the contents name {name}, which is not there"


def test_the_reference_has_every_public_name() -> None:
    rows = re.findall(r"^\| `asmc_pin\.(\w+)` \| (.*) \|$", read("python.md"), re.MULTILINE)
    assert sorted(name for name, _ in rows) == sorted(asmc_pin.__all__)
    assert all(said.strip() for _, said in rows), "a public name says nothing of itself"


def test_the_reference_has_every_command_and_every_option() -> None:
    group = typer.main.get_command(app)
    sections = dict(re.findall(r"^### (\S+)\n(.*?)(?=^##|\Z)", read("commands.md"), re.DOTALL | re.MULTILINE))
    assert set(sections) == set(group.list_commands(None))
    for name, text in sections.items():
        options = [opt for each in group.get_command(None, name).params for opt in each.opts if opt.startswith("-")]
        assert all(re.search(rf"^\| `[^`]*{re.escape(opt)}\b", text, re.MULTILINE) for opt in options), name


# What travels ---------------------------------------------------------------------------------------------------------


def words_of(source: str) -> Iterator[str]:
    """Texts of a module that may be shown: all but its docstrings."""
    tree = ast.parse(source)
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef
    bodies = (node.body for node in ast.walk(tree) if isinstance(node, kinds) and node.body)
    said = {id(body[0].value) for body in bodies if isinstance(body[0], ast.Expr)}
    texts = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in said)
    yield from (node.value for node in texts if isinstance(node.value, str))


def test_a_message_is_told_from_a_docstring() -> None:
    assert list(words_of('"""docs/a.md"""\ndef f():\n    """docs/b.md"""\n    return f"see docs/c.md, {f}"')) == [
        "see docs/c.md, "
    ]


@pytest.fixture(scope="module")
def cited() -> dict[str, str]:
    """Pages that messages, page templates and shipped files cite, each with one place that does."""
    found = {}
    shipped = (path for folder in ("asmc_pin", "experiments") for path in (REPOSITORY / folder).rglob("*.*"))
    for path in shipped:
        if path.suffix not in (".py", ".js", ".css", ".html", ".toml", ".json"):
            continue
        text = path.read_text(encoding="utf-8")
        for words in words_of(text) if path.suffix == ".py" else [text]:
            found |= dict.fromkeys(CITED.findall(words), path.relative_to(REPOSITORY).as_posix())
    return found


def test_every_page_that_a_message_or_a_shipped_file_cites_travels_in_the_wheel(cited: dict[str, str]) -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
    inside = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert len(cited) > 5
    for page, place in cited.items():
        assert (REPOSITORY / page).is_file(), f"{place} cites {page}, which is not there"
        assert inside.get(page) == f"asmc_pin/_data/{page}", f"{place} cites {page}, which the wheel has not"
