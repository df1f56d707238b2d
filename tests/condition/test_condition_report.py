"""Maps, figures and the one-page report on M̄: they show what was found and claim no more."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest
from condition_cases import UR5_MBAR, explained_two_link_design

from asmc_pin import load_arm, verify
from asmc_pin.arms import Arm
from asmc_pin.condition import Recording, design, lemma1_norm, weighted_norm
from asmc_pin.condition.search.norm_maps import heatmap, pairs
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.pages.condition_figures import distribution_figure, maps_figure
from asmc_pin.pages.condition_page import write_condition_report


@pytest.fixture(scope="module")
def ur5() -> Arm:
    return load_arm("ur5")


def test_a_map_is_the_norm_with_the_other_joints_held(ur5: Arm) -> None:
    q = np.array([0.0, 0.3, -0.4, 0.5, 0.6, 0.7])
    found = heatmap(ur5, UR5_MBAR, "elbow_joint", "wrist_2_joint", condition="weighted", q=q, resolution=5)
    there = q.copy()
    there[2], there[4] = found.x[3], found.y[1]
    assert found.norms.shape == (5, 5)
    assert found.norms[1, 3] == pytest.approx(weighted_norm(ur5.mass_matrix(there), np.array(UR5_MBAR)), rel=1e-9)
    armed = heatmap(ur5, UR5_MBAR, "elbow_joint", "wrist_2_joint", q=q, resolution=5, armature=np.full(6, 0.2))
    mass = ur5.mass_matrix(there) + 0.2 * np.eye(6)
    assert armed.norms[1, 3] == pytest.approx(lemma1_norm(mass, np.array(UR5_MBAR)), rel=1e-9)


def test_the_map_of_largest_values_lies_above_every_map_through_it(ur5: Arm) -> None:
    largest = heatmap(ur5, UR5_MBAR, "elbow_joint", "wrist_1_joint", others="largest", resolution=8, samples=2**14)
    held = heatmap(ur5, UR5_MBAR, "elbow_joint", "wrist_1_joint", resolution=9)
    centres = held.norms[:-1, :-1]
    assert np.nanmax(largest.norms) <= verify(ur5, UR5_MBAR).lower + 1e-12
    # The middle of each cell of 1/8 turn differs from its corner by less than the norm moves within it.
    assert np.nanmin(largest.norms - centres) > -0.03


def test_pairs_leave_out_joints_that_do_not_matter(ur5: Arm) -> None:
    assert len(pairs(ur5)) == 10
    assert not any("shoulder_pan_joint" in pair for pair in pairs(ur5))
    assert len(pairs(ur5, {"elbow_joint": (0.1, 0.1)})) == 6


@pytest.mark.parametrize(
    ("joints", "options", "message"),
    [
        (("elbow_joint", "elbow"), {}, "not a joint"),
        (("elbow_joint", "elbow_joint"), {}, "given twice"),
        (("elbow_joint", "wrist_1_joint"), {"others": "best"}, "held or largest"),
        (("elbow_joint", "wrist_1_joint"), {"resolution": 1}, "at least 2"),
    ],
)
def test_bad_maps_are_one_clear_message(ur5: Arm, joints: tuple[str, str], options: dict, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        heatmap(ur5, UR5_MBAR, *joints, **options)


def test_figures_of_violated_and_unrefuted_mbars_are_drawn(ur5: Arm) -> None:
    for scale in (1.0, 1.2, 30.0):
        report = verify(ur5, scale * np.array(UR5_MBAR), samples=1024)
        figure = distribution_figure(report)
        low, high = figure.axes[0].get_xlim()
        assert low <= 1.0 <= high
        maps = maps_figure(report, ur5, resolution=7)
        assert maps is not None
        assert len([axes for axes in maps.axes if axes.get_xlabel()]) == 10
    assert maps_figure(verify(load_arm("two_link"), 0.01, samples=64), load_arm("two_link")) is None


def test_page_states_condition_arm_hash_bounds_method_and_worst_configuration(ur5: Arm, tmp_path: Path) -> None:
    report = verify(ur5, UR5_MBAR, payload=(0.0, 0.5), samples=1024)
    write_condition_report(report, ur5, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    for expected in ("‖I − M⁻¹M̄‖₂ < 1", ur5.sha256, "ur5_robot.urdf", repr(report.lower), repr(UR5_MBAR[3])):
        assert expected in text
    assert "none: sampled only" in text
    assert "not a proof" in text
    assert "payload 0.5 kg" in text
    assert "unrefuted" in text.splitlines()[0]
    pictures = re.findall(r"\]\(<(.+?)>\)", text)
    assert len(pictures) == 2
    assert all((tmp_path / name).is_file() for name in pictures)
    assert f"{report.worst_q[3]:.6f}" in text


def test_html_page_is_one_file_without_network(ur5: Arm, tmp_path: Path) -> None:
    report = verify(ur5, 30 * np.array(UR5_MBAR), condition="weighted", samples=256)
    write_condition_report(report, ur5, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [tmp_path / "page.html"]
    assert "not a statement about Lemma 1" in text
    assert "violates the condition" in text
    assert text.count("<img alt=") == 2
    assert not re.findall(r'(?:src|href)="(?!data:)[^"#]', text)


def test_page_along_a_motion_colours_the_arm_by_the_norm(tmp_path: Path) -> None:
    arm = load_arm("two_link")
    time = np.linspace(0.0, 1.0, 61)
    log = Recording("log", time, np.stack((0.0 * time, 3.0 * time), axis=-1))
    report = verify(arm, 0.01, along=log)
    write_condition_report(report, arm, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    played = [json.loads(found) for found in re.findall(r'<script type="application/json">(.*?)</script>', text)][-1]
    (motion,) = played["motions"]
    floats = {key: np.frombuffer(base64.b64decode(motion[key]), dtype="<f4") for key in ("q", "shades")}
    readings = np.frombuffer(base64.b64decode(motion["reading"]["values"]), dtype="<f4")
    assert report.norms is not None
    np.testing.assert_allclose(readings, report.norms, rtol=1e-6)
    np.testing.assert_allclose(floats["q"].reshape(-1, 2), log.q, atol=1e-6)
    # The norm falls from the stretched arm on, and so does the brightness of its colour.
    brightness = floats["shades"].reshape(-1, 3) @ [0.21, 0.72, 0.07]
    assert np.all(np.diff(report.norms) < 0)
    assert np.all(np.diff(brightness) < 1e-3)
    assert brightness[0] > brightness[-1] + 0.5


def test_design_page_shows_trade_off_and_what_limits(tmp_path: Path) -> None:
    arm = load_arm("two_link")
    report = explained_two_link_design()
    write_condition_report(report, arm, tmp_path / "design.md")
    text = (tmp_path / "design.md").read_text(encoding="utf-8")
    assert "joint_2" in text
    assert "trade-off" in text
    assert (tmp_path / "design_trade_off.png").is_file()
    write_condition_report(design(arm, bounds=(1.0, None)), arm, tmp_path / "none.md")
    assert "No M̄ within the bounds satisfies" in (tmp_path / "none.md").read_text(encoding="utf-8")


def test_other_endings_and_unwritable_places_are_refused(ur5: Arm, tmp_path: Path) -> None:
    report = verify(load_arm("two_link"), 0.01, samples=64)
    with pytest.raises(ParameterError, match="ending chooses the form"):
        write_condition_report(report, ur5, tmp_path / "page.pdf")
    with pytest.raises(ResultError, match="cannot be written"):
        write_condition_report(report, ur5, tmp_path / "none" / "page.html")
    with pytest.raises(ResultError, match="cannot be written"):
        write_condition_report(report, ur5, tmp_path / "none" / "page.md")
