"""The site has every page, name and command, and the wheel has every page that the program cites."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import generate
import pytest
import typer
from import_graph import reduced, room_graph
from paths import REPOSITORY
from rooms_drawing import placed
from site_hosts import in_page, in_site

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


# Without a network ----------------------------------------------------------------------------------------------------

AWAY = "https://cdn.example.org/a"


@pytest.mark.parametrize(
    "html",
    [
        f'<script src="{AWAY}.js"></script>',
        f'<script type="module">import thing from "{AWAY}.mjs"; thing();</script>',
        f'<script>const loaded = import("{AWAY}.mjs")</script>',
        f'<link rel="stylesheet" href="{AWAY}.css">',
        f"<link rel=preload as=font href={AWAY}.woff2>",
        f"<style>@font-face {{ src: url({AWAY}.woff2) }}</style>",
        f'<style>@import "{AWAY}.css";</style>',
        f'<p style="background: url({AWAY}.png)">x</p>',
        f'<img src="{AWAY}.png">',
        f'<img srcset="small.png 1x, {AWAY}.png 2x">',
        '<img src="//cdn.example.org/a.png">',
        f'<svg><image href="{AWAY}.png"/></svg>',
        f'<iframe srcdoc="&lt;img src={AWAY}.png&gt;"></iframe>',
    ],
)
def test_what_a_page_loads_from_another_host_is_found(html: str) -> None:
    assert len(in_page(html)) == 1


@pytest.mark.parametrize(
    "html",
    [
        f'<a href="{AWAY}">a link to follow</a>',
        f'<link rel="canonical" href="{AWAY}">',
        '<script src="_static/a.js"></script><img src="data:image/png;base64,xx">',
        f"<p>import it from &quot;{AWAY}.js&quot;</p>",
        f'<script>const named = "{AWAY}"; // {AWAY}</script>',
    ],
)
def test_a_link_to_follow_is_nothing_loaded(html: str) -> None:
    assert not in_page(html)


def test_styles_and_scripts_of_a_site_are_looked_at_too(tmp_path: Path) -> None:
    (tmp_path / "a.css").write_text(f"@import url('{AWAY}.css');")
    (tmp_path / "a.js").write_text(f'import {{ b }} from "{AWAY}.mjs";')
    (tmp_path / "a.html").write_text("<link rel=stylesheet href=a.css><script src=a.js></script>")
    assert [path.name for path, _ in in_site(tmp_path)] == ["a.css", "a.js"]


# The picture of the rooms ---------------------------------------------------------------------------------------------


def test_the_picture_of_the_rooms_has_them_all_and_every_arrow_points_down() -> None:
    graph = room_graph()
    places, ways = placed(graph)
    assert set(places) == set(graph)
    assert set(ways) == {(room, other) for room, others in reduced(graph).items() for other in others}
    assert all(down > up for way in ways.values() for (_, up), (_, down) in pairwise(way))
    assert all(x == places[pair[0]][0] for pair, ((x, _), *_) in ways.items())


def test_in_the_picture_no_boxes_overlap_and_no_arrow_goes_through_one() -> None:
    places, ways = placed(room_graph())
    rows: dict[int, list[int]] = {}
    for x, y in places.values():
        rows.setdefault(y, []).append(x)
    assert all(right - left > 112 for row in rows.values() for left, right in pairwise(sorted(row)))
    for way in ways.values():
        for x, y in way[1:-1]:
            assert all(abs(x - at) > 56 for row, ats in rows.items() for at in ats if abs(y - row) <= 15)


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
