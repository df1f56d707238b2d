"""The scripts in examples/ run, and use nothing but what is public."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest
from paths import REPOSITORY

import asmc_pin

ROOT = REPOSITORY
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))

by_name = pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)


def test_there_are_eight_and_the_readme_names_them():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(EXAMPLES) == 8
    assert "`examples/`" in readme


@by_name
def test_an_example_says_what_it_shows_and_is_short(path):
    source = path.read_text(encoding="utf-8")
    assert ast.get_docstring(ast.parse(source))
    assert 10 <= len(source.splitlines()) <= 45


@by_name
def test_an_example_needs_only_what_is_public(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert private_imports(tree) == {"asmc_pin"}
    used = {n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and getattr(n.value, "id", "") == "asmc_pin"}
    assert used | names_from_the_package(tree) <= set(asmc_pin.__all__)


@pytest.mark.long
@by_name
def test_an_example_runs(path, tmp_path):
    run = subprocess.run([sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()
    assert not list(tmp_path.iterdir()), "an example leaves nothing behind"


def private_imports(tree: ast.AST) -> set[str]:
    """Modules within the package that a script imports."""
    modules = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    modules |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    return {name for name in modules if name.partition(".")[0] == "asmc_pin"}


def names_from_the_package(tree: ast.AST) -> set[str]:
    froms = (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module == "asmc_pin")
    return {alias.name for node in froms for alias in node.names}


def test_an_import_from_within_the_package_is_noticed():
    assert private_imports(ast.parse("from asmc_pin.arms import Arm")) == {"asmc_pin.arms"}
    assert private_imports(ast.parse("def f():\n    import asmc_pin.plant")) == {"asmc_pin.plant"}
    assert names_from_the_package(ast.parse("from asmc_pin import plant")) == {"plant"}
