"""Small URDFs on which the tool once was wrong, and what each must give; the names say what is odd about them."""

from __future__ import annotations

from pathlib import Path

import pytest
from paths import CASES

from asmc_pin import load_arm
from asmc_pin.cli import main
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.checker import check
from asmc_pin.condition.hypotheses import Condition

INPUTS = CASES / "urdf"


def ran(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    out, err = capsys.readouterr()
    assert isinstance(stop.value.code, int)
    return stop.value.code, out, err


@pytest.mark.parametrize(
    ("name", "said"), [("gbk", "gbk"), ("huge_l2", "mass"), ("planar_joint", "planar")], ids=lambda text: text
)
def test_what_cannot_be_read_is_one_message_that_names_the_cause(
    name: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status, out, err = ran(capsys, "verify", str(INPUTS / f"{name}.urdf"), "--mbar", "0.01")
    assert (status, out) == (2, "")
    assert said in err
    assert "nothing resists" not in err
    assert "Traceback" not in err


def test_names_are_printed_as_they_are_and_no_markup_is_interpreted(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = ran(capsys, "verify", str(INPUTS / "rich.urdf"), "--mbar", "0.01", "--samples", "64")
    assert status in (0, 1)
    assert "[/joint_1]" in out


def test_a_colour_that_is_a_word_is_drawn_grey_with_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    urdf = str(INPUTS / "colour_word.urdf")
    status, _, err = ran(capsys, "verify", urdf, "--mbar", "0.01", "--samples", "64", "--report", str(page))
    assert status in (0, 1)
    assert page.stat().st_size > 10_000
    assert "grey" in err


def test_an_arm_next_to_singular_has_a_design_or_a_message(capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = ran(capsys, "design", str(INPUTS / "p7.urdf"), "--condition", "weighted")
    assert status in (0, 1, 2)
    assert "Traceback" not in err


@pytest.mark.parametrize("condition", ["weighted", "lemma1"])
def test_point_masses_in_a_plane_are_proven_to_a_percent(condition: Condition, tmp_path: Path) -> None:
    # The last link has no inertia about its own point: a metric that is singular there lost without bound.
    arm = load_arm(INPUTS / "pt3planar.urdf")
    found = certify(arm, 0.01, condition=condition, gap=0.01, budget=300.0, levels=False)
    assert found.gap <= 0.01
    assert found.scale_refuted == pytest.approx(1.40, abs=0.01)
    replayed = check(found.save(tmp_path / "points.cert"))
    assert replayed.valid, replayed.problems
