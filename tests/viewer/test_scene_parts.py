"""What the scene shows besides the arms: torques, magnification, all arms on one base, and where to look."""

from __future__ import annotations

import base64
import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import TICK, Browser, Page, shared_browser
from viewer_cases import AWKWARD, HOSTILE, awkward_result, swing

from asmc_pin.arms import load_arm
from asmc_pin.experiment import Experiment
from asmc_pin.viewer import PlayedMotion, describe, draw, replay_element, replay_page
from asmc_pin.viewer.time_marks import time_marks

STAGE = "replays[0].stage"


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.fixture(scope="module")
def opened(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    path = tmp_path_factory.mktemp("parts") / "two_link.html"
    path.write_text(replay_page("two links", "", replay_element(swing("two_link", triangles=500))), encoding="utf-8")
    with browser.page(760, 520) as page:
        page.open(f"{path.as_uri()}#t=0.5")
        yield page
        assert page.messages == []


@pytest.fixture
def page(opened: Page) -> Iterator[Page]:
    yield opened
    opened.run(f"{STAGE}.gather(false), {STAGE}.hide('Wild', false), replays[0].seek(0.5)")


def control(page: Page, name: str, act: str) -> None:
    page.run(
        f"(() => {{ const label = [...document.querySelectorAll('.replay-controls label')].find((l) => "
        f"l.textContent.startsWith('{name}')), own = label.querySelector('input, select'); {act}; }})()"
    )


def choose(page: Page, name: str, value: str) -> None:
    control(page, name, f"own.value = '{value}'; own.dispatchEvent(new Event('change'))")


def arcs(page: Page) -> list[tuple[int, str]]:
    """Of the first arm's joints: how many segments of the arc are drawn, and its colour."""
    return page.run(
        f"{STAGE}.arms[0].arcs.map(({{ mesh }}) => [mesh.geometry.drawRange.count / 36, "
        "mesh.material.color.getHexString()])"
    )


def test_arcs_are_as_long_as_the_torque_and_red_at_the_limit(page: Page) -> None:
    for time in (0.2, 0.5):
        page.run(f"replays[0].seek({time})")
        (one, colour), (other, _) = arcs(page)
        share = 1.5 * math.sin(math.pi * time / 2.0)
        assert one == pytest.approx(48 * min(share, 1.0), abs=1.1)
        assert other == pytest.approx(48 * min(share * math.cos(1.0), 1.0), abs=1.1)
        assert colour == ("d4141c" if share >= 1.0 else "0072b2")
    control(page, "Torque", "own.click()")
    assert page.run(f"{STAGE}.arms[0].arcs.some(({{ turned }}) => turned.visible)") is False
    control(page, "Torque", "own.click()")


def test_a_torque_at_its_limit_for_one_tick_is_not_lost_between_frames() -> None:
    arm, time = load_arm("two_link"), np.arange(0.0, 1.0005, 0.001)
    torque = np.full((len(time), 2), 0.999)
    torque[507, 1] = -1.0
    motion = PlayedMotion("", "#000000", np.zeros((len(time), 2)), torque=torque)
    told = describe(draw(arm, 500), arm.joint_names, time, [motion], None)
    shares = np.frombuffer(base64.b64decode(told["motions"][0]["torque"]), dtype=np.int8).reshape(-1, 2)
    assert len(shares) == 61
    assert np.abs(shares[:, 0]).max() == 126, "almost at the limit is not at it"
    assert (shares[:, 1] == -127).sum() == 1


def test_the_picture_says_that_errors_are_magnified(page: Page) -> None:
    badge = "document.querySelector('.replay-badge')"
    assert page.run(f"{badge}.hidden")
    choose(page, "Errors", "100")
    assert page.run(f"[{badge}.offsetParent !== null, {badge}.textContent]") == [True, "Errors ×100"]
    choose(page, "Errors", "1")
    assert page.run(f"{badge}.hidden")


def test_on_one_base_all_arms_stand_there_tinted_and_the_reference_is_solid(page: Page) -> None:
    control(page, "On one base", "own.click()")
    page.run(TICK)
    roots = page.run(f"[...{STAGE}.arms, {STAGE}.ghosts[0]].map(({{ root }}) => root.position.toArray())")
    assert roots == [[0, 0, 0]] * 3
    seen = page.run(
        f"[...{STAGE}.arms, ...{STAGE}.ghosts].map((arm) => [arm.root.visible, arm.meshes[0].material.transparent, "
        "arm.meshes[0].material.color.getHexString()])"
    )
    assert seen[0] == [True, True, "0072b2"]
    assert seen[1] == [True, True, "cc79a7"]
    assert seen[2][:2] == [True, False]
    assert seen[3][0] is False, "one reference is enough"
    labels = page.run(
        "[...document.querySelectorAll('.replay-label')].map((l) => { const r = l.getBoundingClientRect();"
        " return [r.left, r.right]; })"
    )
    assert labels[0][1] < labels[1][0], "labels beside each other"
    control(page, "On one base", "own.click()")
    assert page.run(f"{STAGE}.arms[0].meshes[0].material.transparent") is False
    assert page.run(f"{STAGE}.arms[0].root.position.x !== {STAGE}.arms[1].root.position.x")


def test_who_is_hidden_is_hidden_on_one_base_too_and_the_reference_stays(page: Page) -> None:
    page.run(f"{STAGE}.gather(true)")
    for label, hidden in ((HOSTILE, 0), ("Wild", 1)):
        detail = f"{{ detail: {{ label: {label!r}, on: false }} }}"
        page.run(f"document.dispatchEvent(new CustomEvent('controller-shown', {detail})), {TICK}")
        shown = page.run(f"{STAGE}.arms.map(({{ root }}) => root.visible)")
        assert shown == [hidden != 0, hidden != 1]
        assert page.run(f"{STAGE}.ghosts[0].root.visible && {STAGE}.rings[0].visible")
        assert page.run(f"{STAGE}.labels.map(({{ label }}) => label.hidden)") == [hidden == 0, hidden == 1]
        page.run(f"document.dispatchEvent(new CustomEvent('controller-shown', {detail.replace('false', 'true')}))")


def test_outer_arms_are_seen_from_the_same_side_as_inner_ones(page: Page) -> None:
    angles = page.run(
        f"(() => {{ const {{ camera }} = {STAGE}.viewer; return {STAGE}.offsets.map(([x, y]) => "
        "Math.atan2(-camera.position.z - y, camera.position.x - x)); })()"
    )
    assert np.degrees(np.ptp(np.unwrap(angles))) < 10.0


def test_marks_stand_on_the_time_line_and_the_list_takes_the_scene_there(page: Page) -> None:
    box = page.run(
        "(({ x, width }) => [x.baseVal.value, width.baseVal.value])(document.querySelector('.replay-mark-push'))"
    )
    assert box == pytest.approx([250.0, 250.0])
    assert page.run("document.querySelectorAll('.replay-chart rect').length") == 1, "a place is in the list alone"
    choose(page, "Go to", "0")
    assert page.run("replays[0].time") == pytest.approx(0.5)
    choose(page, "Go to", "1")
    assert page.run("replays[0].time") == pytest.approx(1.4)


def test_a_still_for_paper_carries_the_labels(page: Page) -> None:
    page.run(TICK)
    inside = (
        f"(() => {{ const made = {STAGE}.photograph(), pen = made.getContext('2d'), r = {STAGE}.host"
        ".getBoundingClientRect(), l = document.querySelector('.replay-label').getBoundingClientRect(),"
        " s = made.width / r.width; return [...pen.getImageData(s * (l.left - r.left + l.width / 2),"
        " s * (l.top - r.top) + 1, 1, 1).data]; })()"
    )
    assert page.run(inside)[:3] == [0x00, 0x72, 0xB2], "the label's upper edge, in the controller's colour"


def test_pushes_loads_and_the_times_of_trouble_are_told_in_order() -> None:
    plant = {
        "disturbances": [
            {"profile": "pulse", "torque": [3.0, -5.0], "start": 0.3, "duration": 0.5},
            {"profile": "step", "torque": 1.0, "start": 9.0},
        ],
        "payload_changes": [{"time": 0.2, "payload": 0.5}, {"time": 0.1}],
    }
    result = dataclasses.replace(awkward_result(), experiment=Experiment.from_dict({**AWKWARD, "plant": plant}))
    marks = time_marks(result, 0)
    assert [mark.start for mark in marks] == sorted(mark.start for mark in marks)
    told = [(mark.kind, mark.start, mark.end, mark.words) for mark in marks]
    assert ("load", 0.1, None, "Nothing is carried from 0.1 s on") in told
    assert ("load", 0.2, None, "Load of 0.5 kg from 0.2 s on") in told
    assert ("push", 0.3, 0.4, "Push (pulse), torques of up to 5: 0.3 s to 0.4 s") in told
    assert not any(mark.start > 0.4 for mark in marks), "what would come after the end"
    error = np.abs(result.dataset.q_ref - result.dataset.q.sel(controller=HOSTILE).isel(trial=0)).max("joint")
    at = float(result.dataset.time[int(error.to_numpy().argmax())])
    assert any(mark.start == at and HOSTILE in mark.words for mark in marks)
    norm = result.monitors.lemma1_norm.isel(trial=0)
    worst = next(mark for mark in marks if mark.words.startswith("Worst configuration"))
    assert float(norm.sel(time=worst.start).max()) == float(norm.max())


def test_a_page_at_rest_has_no_player(browser: Browser, tmp_path: Path) -> None:
    arm = load_arm("two_link")
    told = describe(draw(arm, 500), arm.joint_names, np.zeros(1), [PlayedMotion("", "#000000", np.ones((1, 2)))], None)
    path = tmp_path / "rest.html"
    path.write_text(replay_page("rest", "", replay_element(told)), encoding="utf-8")
    with browser.page() as page:
        page.open(path.as_uri())
        shown = page.run(
            "[...document.querySelectorAll('.replay-controls button, .replay-controls input, .replay-controls select')]"
            ".filter((own) => own.offsetParent !== null).map((own) => own.textContent)"
        )
        assert shown == ["Reset view"]
