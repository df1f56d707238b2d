"""A law that this project does not have, once registered, passes every test that runs over the registered laws."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from paths import TESTS

NAME = "super_twisting"
OVER_ALL_LAWS = re.compile(r'parametrize\("name", CONTROLLERS\)')

LAW = (TESTS.parent / "docs" / "controllers.md").read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
"""The law that docs/controllers.md writes; a test of its own runs it from an experiment."""

REGISTER = f'''
from asmc_pin.controllers import CONTROLLERS

SuperTwisting.title, SuperTwisting.equation, SuperTwisting.reference = "super-twisting", "τ = PPC + M̄ w", "Levant"
CONTROLLERS["{NAME}"] = SuperTwisting
'''


def judged(folder: Path, law: str, files: list[Path]) -> subprocess.CompletedProcess[str]:
    """Run the tests of some files that take a law's name, on a law that is registered before they are collected."""
    (folder / "registers_a_law.py").write_text(law + REGISTER, encoding="utf-8")
    path = os.pathsep.join([str(folder), str(TESTS.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "pytest", "-q", "-p", "registers_a_law", "-p", "no:cacheprovider", "-k", NAME]
    return subprocess.run(
        [*command, *map(str, files)],
        cwd=TESTS.parent,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.long
def test_a_correct_new_law_passes_every_test_that_runs_over_the_registered_laws(tmp_path: Path) -> None:
    files = [path for path in sorted(TESTS.rglob("test_*.py")) if OVER_ALL_LAWS.search(path.read_text("utf-8"))]
    assert len(files) >= 2
    done = judged(tmp_path, LAW, files)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    passed = re.search(r"(\d+) passed", done.stdout)
    assert passed
    assert int(passed[1]) >= 15
    assert "skipped" not in done.stdout


@pytest.mark.parametrize(
    ("right", "wrong", "broken"),
    [
        ("np.cumsum(self.period * signed(self.k2, s), axis=1)", "0.0", "switching_term_that_it_states"),
        ("w = state.w +", "state.w[:] += 1.0\n        w = state.w +", "steps_are_pure"),
        ("np.sqrt(np.abs(s))", "np.sqrt(np.abs(s).max())", "alone_and_in_a_batch"),
    ],
    ids=["term misstated", "state written", "trials mixed"],
)
def test_a_wrong_new_law_does_not(tmp_path: Path, right: str, wrong: str, broken: str) -> None:
    assert right in LAW
    done = judged(tmp_path, LAW.replace(right, wrong), [TESTS / "controllers" / "test_controllers.py"])
    assert done.returncode == 1
    assert broken in done.stdout
