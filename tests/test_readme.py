"""The README says what the code does."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


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


@pytest.mark.parametrize("path", sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")]), ids=lambda p: p.name)
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
