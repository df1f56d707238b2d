"""What a page on a violated M̄ says would help: it does help, and no page says it of an M̄ that stands."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from asmc_pin import load_arm, verify
from asmc_pin.arms import Arm
from asmc_pin.condition import Condition, ConditionReport, Recording, lemma1_norm, weighted_norm
from asmc_pin.pages.condition_page import write_condition_report

HEADING = "What would help"
BLAMED = r"To blame at the worst q: m̄ of joint '(\w+)' is too (large|small) there\."
MULTIPLE = r"A short search refutes no multiple of this M̄ below ([\d.e-]+)\."


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_arm("two_link")


def section(report: ConditionReport, arm: Arm, folder: Path) -> list[str]:
    """The lines below the heading; those of the HTML page, which are the same in the Markdown one."""
    write_condition_report(report, arm, folder / "page.md")
    write_condition_report(report, arm, folder / "page.html")
    markdown, html = ((folder / name).read_text(encoding="utf-8") for name in ("page.md", "page.html"))
    lines = re.findall(rf"## {HEADING}\n\n(.*?)\n\n## ", markdown, re.DOTALL)
    items = re.findall(rf"<h2>{HEADING}</h2>\s*<ul>(.*?)</ul>", html, re.DOTALL)
    told = [line.removeprefix("- ") for part in lines for line in part.split("\n")]
    assert [item.replace("&#x27;", "'") for part in items for item in re.findall("<li>(.*?)</li>", part)] == told
    return told


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
@pytest.mark.parametrize("mbar", [(2.0, 2.0), (0.02, 0.5), (2.0, 0.002)])
def test_changing_the_blamed_joint_as_the_page_says_lowers_the_worst_norm_more_than_changing_any_other(
    arm: Arm, condition: Condition, mbar: tuple[float, float], tmp_path: Path
) -> None:
    report = verify(arm, mbar, condition=condition, samples=256)
    name, side = re.fullmatch(BLAMED, section(report, arm, tmp_path)[0]).groups()
    norm = lemma1_norm if condition == "lemma1" else weighted_norm
    mass = arm.mass_matrix(report.worst_q)
    factor = 0.99 if side == "large" else 1.01
    changed = [np.where(np.arange(2) == joint, factor, 1.0) * mbar for joint in range(2)]
    norms = [norm(mass, each) for each in changed]
    assert min(norms) < report.lower
    assert arm.joint_names[int(np.argmin(norms))] == name


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_the_multiple_on_the_page_is_where_the_condition_begins_to_break(
    arm: Arm, condition: Condition, tmp_path: Path
) -> None:
    mbar = np.array([2.0, 2.0])
    told = section(verify(arm, mbar, condition=condition, samples=256), arm, tmp_path)
    scale = float(re.fullmatch(MULTIPLE, told[1])[1])
    assert verify(arm, scale * mbar, condition=condition).verdict == "unrefuted"
    assert verify(arm, 1.001 * scale * mbar, condition=condition).verdict == "violated"


def test_where_no_multiple_would_do_the_page_says_so_and_none_does(arm: Arm, tmp_path: Path) -> None:
    mbar = np.array([1.0, 0.01])
    told = section(verify(arm, mbar, samples=256), arm, tmp_path)
    assert told[1] == "No multiple of this M̄ satisfies the condition: its joints do not suit each other."
    for scale in 10.0 ** np.arange(-4.0, 1.0):
        assert verify(arm, scale * mbar, samples=256).verdict == "violated"


def test_along_a_motion_a_joint_is_blamed_and_no_multiple_promised(arm: Arm, tmp_path: Path) -> None:
    time = np.linspace(0.0, 1.0, 21)
    log = Recording("log", time, np.stack((0.0 * time, 3.0 * time), axis=-1))
    told = section(verify(arm, [2.0, 2.0], along=log), arm, tmp_path)
    assert len(told) == 1
    assert re.fullmatch(BLAMED, told[0])


def test_a_page_on_an_mbar_that_was_not_refuted_has_no_such_section(arm: Arm, tmp_path: Path) -> None:
    report = verify(arm, 0.01, samples=64)
    assert report.verdict == "unrefuted"
    assert section(report, arm, tmp_path) == []
