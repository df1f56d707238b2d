"""The replay as a person meets it: in a browser, from a file, without a network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import TICK, Browser, Page, shared_browser
from viewer_cases import HOSTILE, bent_arm, swing, swung

from asmc_pin.arms import load_arm
from asmc_pin.viewer import draw, replay_element, replay_page


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.fixture(scope="module")
def ur5(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("page") / "ur5.html"
    path.write_text(replay_page("UR5", "two motions", replay_element(swing())), encoding="utf-8")
    return path.as_uri()


@pytest.fixture(scope="module")
def opened(browser: Browser, ur5: str) -> Iterator[Page]:
    with browser.page(760, 520) as page:
        page.open(f"{ur5}#t=0")
        yield page


@pytest.fixture
def page(opened: Page) -> Page:
    """The UR5's page, paused at the beginning, as it was opened."""
    opened.run(
        "(() => { const r = replays[0]; document.activeElement.blur(); r.motions.magnify = 1; r.speed = 1;"
        " r.loop.checked = true; r.pause(); r.seek(0); })()"
    )
    return opened


def stage(page: Page) -> np.ndarray:
    """The pixels of the scene, labels and controls cut off."""
    page.run(TICK)
    x, y, width, height = page.run(
        "(() => { const r = document.querySelector('.replay-stage').getBoundingClientRect();"
        " return [r.x, r.y, r.width, r.height].map(Math.round); })()"
    )
    page.run("document.querySelector('.replay-labels').style.visibility = 'hidden'")
    return page.pixels()[y : y + height, x : x + width].astype(int)


def seek(page: Page, time: float) -> None:
    page.run(f"replays[0].pause(), replays[0].seek({time}), {TICK}")


def test_the_page_opens_from_a_file_without_a_word_or_a_request(page: Page, ur5: str) -> None:
    page.run("replays[0].play()")
    page.until("replays[0].time > 0.2")
    assert page.messages == []
    assert page.requests == [f"{ur5}#t=0".partition("#")[0]]


def test_the_scene_shows_arms_that_move(page: Page) -> None:
    before = stage(page)
    assert before.std() > 10.0, "a blank canvas has hardly any contrast"
    dark = (before.max(axis=2) < 90).mean()
    assert 0.01 < dark < 0.5, "the UR5's dark housings are in the picture, and do not fill it"
    seek(page, 0.9)
    after = stage(page)
    moved = np.abs(after - before).max(axis=2) > 40
    assert moved.mean() > 0.01
    seek(page, 0.0)
    assert (np.abs(stage(page) - before).max(axis=2) > 40).mean() < 0.001, "back at t = 0, the first picture is back"


def test_both_arms_are_in_sight_and_their_labels_on_the_stage(page: Page) -> None:
    page.run(TICK)
    boxes = page.run(
        "[...document.querySelectorAll('.replay-label')].map((l) => { const r = l.getBoundingClientRect(),"
        " s = document.querySelector('.replay-stage').getBoundingClientRect();"
        " return [r.left - s.left, s.right - r.right, r.top - s.top, s.bottom - r.bottom]; })"
    )
    assert len(boxes) == 2
    assert np.min(boxes) >= 0.0
    picture = stage(page)
    dark = picture.max(axis=2) < 90
    half = dark.shape[1] // 2
    assert dark[:, :half].mean() > 0.005
    assert dark[:, half:].mean() > 0.005
    assert not dark[:, :3].any(), "no arm is cut off at the side"
    assert not dark[:, -3:].any()


def test_labels_are_text_whatever_they_say(page: Page) -> None:
    assert page.run("document.querySelector('.replay-label b').textContent") == HOSTILE
    assert page.run("document.querySelectorAll('.replay-label script').length") == 0


def test_play_pause_and_time(page: Page) -> None:
    assert page.run("document.querySelector('.replay-clock').textContent") == "0.00 s / 2.00 s"
    page.click(".replay-play")
    page.until("replays[0].time > 0.1")
    page.click(".replay-play")
    time = page.run("replays[0].time")
    page.run(TICK)
    assert page.run("replays[0].time") == time, "paused"
    assert page.run("Number(document.querySelector('input[type=range]').value)") == pytest.approx(time)
    assert page.run("document.querySelector('.replay-clock').textContent") == f"{time:.2f} s / 2.00 s"
    page.run(
        "(() => { const slider = document.querySelector('input[type=range]'); slider.value = 1.25;"
        " slider.dispatchEvent(new Event('input')); })()"
    )
    assert page.run("replays[0].time") == 1.25


def test_space_plays_and_pauses_and_arrows_step(page: Page) -> None:
    page.key(" ", "Space")
    assert page.run("replays[0].playing") is True
    page.key(" ", "Space")
    assert page.run("replays[0].playing") is False
    seek(page, 1.0)
    page.run("document.activeElement.blur()")
    page.key("ArrowRight", "ArrowRight")
    assert page.run("replays[0].time") == pytest.approx(1.0 + 1.0 / 60.0)


def test_playing_ends_at_the_end_and_begins_anew(page: Page) -> None:
    page.run("replays[0].loop.checked = false, replays[0].speed = 4, replays[0].seek(1.9), replays[0].play()")
    page.until("!replays[0].playing")
    assert page.run("replays[0].time") == 2.0
    page.run("replays[0].play()")
    assert page.run("replays[0].time") < 1.0


def test_the_label_shows_the_error_and_then_the_divergence(page: Page) -> None:
    joint = np.arange(6)
    for frame in (30, 90):
        time = frame / 60.0
        seek(page, time)
        error = np.degrees(0.01 * np.abs(np.sin(5.0 * time + joint)).max())
        text = page.run("document.querySelector('.replay-label span').textContent")
        assert float(text.removesuffix("°")) == pytest.approx(error, abs=2e-3)
    assert page.run("document.querySelectorAll('.replay-label span')[1].textContent") == "diverged at 1 s"


def tips(page: Page, replay: int = 0) -> np.ndarray:
    stage = f"replays[{replay}].stage"
    return np.array(page.run(f"[...{stage}.arms, ...{stage}.ghosts].map((arm) => arm.tip().toArray())"))


def test_magnified_errors_start_from_the_reference(page: Page) -> None:
    seek(page, 0.5)
    arm, _, ghost, _ = tips(page)
    page.run("replays[0].motions.magnify = 5, replays[0].seek(0.5)")
    magnified, _, same, _ = tips(page)
    np.testing.assert_allclose(same, ghost, atol=1e-12)
    np.testing.assert_allclose(magnified - ghost, 5 * (arm - ghost), rtol=0.1, atol=1e-3)


def test_arms_in_the_browser_stand_where_pinocchio_puts_them(browser: Browser, tmp_path: Path) -> None:
    names = ["kinova", "panda", str(bent_arm(tmp_path))]
    drawn = [draw(load_arm(name), triangles=1500) for name in names]
    elements = [replay_element(swing(name, triangles=1500), embedded=True) for name in names]
    path = tmp_path / "arms.html"
    path.write_text(replay_page("several on one page", "", "\n".join(elements)), encoding="utf-8")
    with browser.page(500, 800) as page:
        page.open(path.as_uri())
        for replay, (name, arm) in enumerate(zip(names, drawn, strict=True)):
            body, point = arm.tip
            for frame in (0, 47, 119):
                time = frame / 60.0
                page.run(f"replays[{replay}].seek({time})")
                pose = arm.poses(swung(name, time))[body]
                # Between the 200 samples per second of the motion, its resampling is linear.
                np.testing.assert_allclose(tips(page, replay)[2], pose[:3, :3] @ point + pose[:3, 3], atol=2e-5)
        assert page.messages == []


def test_without_webgl_the_page_says_so(browser: Browser, ur5: str) -> None:
    with browser.page() as page:
        page.call(
            "Page.addScriptToEvaluateOnNewDocument",
            source="HTMLCanvasElement.prototype.getContext = () => null;",
        )
        page.open(ur5)
        text = page.run("document.querySelector('.replay-message').innerText")
        assert text.startswith("The motion cannot be shown: Error creating WebGL context")
        assert page.run("getComputedStyle(document.querySelector('.replay-controls')).display") == "none"


def test_a_dark_page_is_dark(browser: Browser, ur5: str) -> None:
    with browser.page(dark=True) as page:
        page.open(f"{ur5}#t=0")
        assert np.median(stage(page)) < 60
        assert page.pixels()[:20].mean() < 60
