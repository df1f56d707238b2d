"""The README says what the code does."""

import importlib.util
import re
import tomllib

import pytest
from paths import REPOSITORY

ROOT = REPOSITORY


def _generator():
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_generated_tables_are_fresh():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert _generator().rendered(text) == text, "run make docs"


def test_a_stale_table_is_noticed():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    stale = text.replace("| ur5 |", "| ur55 |")
    assert stale != text
    assert _generator().rendered(stale) == text


@pytest.mark.parametrize("path", sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]), ids=lambda p: p.name)
def test_links_lead_to_files_of_the_repository(path):
    prose = re.sub(r"```.*?```|`[^`\n]*`", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\((?!https?:|#)([^)#\s]+)", prose):
        assert (path.parent / target).exists(), f"{path.name} links to {target}"


def test_the_python_example_runs(tmp_path, monkeypatch):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"## In Python\n\n```python\n(.*?)```", text, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 12
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {}
    exec(example, namespace)
    assert namespace["report"].verdict == "unrefuted"
    assert set(namespace["comparison"].rows["controller"]) == {"PPC", "BSMC", "Existing", "Proposed"}


def test_the_version_is_one_and_has_its_section_in_the_changelog():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    sections = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sections[0] == version
    assert sections == sorted(set(sections), key=lambda x: [int(n) for n in x.split(".")], reverse=True)


def test_contributing_names_commands_that_make_has():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    lines = re.findall(r"^make (.*?)(?: +#.*)?$", text, re.MULTILINE) + re.findall(r"`make ([^`]*)`", text)
    named = {word for line in lines for word in line.split() if "=" not in word}
    assert named >= {"demo", "test", "lint", "typecheck", "test-all", "fuzz", "docs"}
    assert named <= targets


def test_files_that_contributing_and_the_hooks_name_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:asmc_pin|tests|urdf|\.ci)/[\w./]*)`", text):
        assert (ROOT / name).exists(), name
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    assert set(re.findall(r"repo: (.*)", hooks)) == {"local"}
    assert "run: .ci/run" in (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert (ROOT / ".ci" / "run").exists()
