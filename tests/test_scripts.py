"""Claims about the scripts of viz/, benchmarks/ and docs/: what they do not know is said, not taken for a folder."""

import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = sorted(
    script
    for folder in ("viz", "benchmarks", "docs")
    for script in (ROOT / folder).glob("*.py")
    if "__main__" in script.read_text(encoding="utf-8")
)


def run(script, monkeypatch, *words):
    """Exit status of a script with these words, as a shell would start it."""
    loaded = set(sys.modules)
    monkeypatch.setattr(sys, "argv", [str(script), *words])
    monkeypatch.syspath_prepend(str(script.parent))
    try:
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(script), run_name="__main__")
    finally:
        for name in set(sys.modules) - loaded:  # another folder may have a module of that name
            if Path(getattr(sys.modules[name], "__file__", None) or ".").parent == script.parent:
                del sys.modules[name]
    return ended.value.code


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: f"{script.parent.name}-{script.stem}")
def test_a_script_says_how_it_is_used_and_takes_no_option_that_it_does_not_have(script, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(script, monkeypatch, "--help") == 0
    assert capsys.readouterr().out.startswith("usage:")
    assert run(script, monkeypatch, "x", "--nonsense") == 2
    assert "--nonsense" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_scene_does_not_go_where_a_file_lies(monkeypatch, tmp_path, capsys):
    (tmp_path / "notes").write_text("mine")
    assert run(ROOT / "viz" / "every_arm.py", monkeypatch, str(tmp_path / "notes")) == 2
    assert "not a folder" in capsys.readouterr().err
    assert (tmp_path / "notes").read_text() == "mine"
