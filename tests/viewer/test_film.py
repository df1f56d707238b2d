"""Claims about pictures of a replay: what they show is what the page shows at that time."""

from __future__ import annotations

import io
import signal
from pathlib import Path

import av
import needs
import numpy as np
import pytest
from PIL import Image
from viewer_cases import awkward_result, swing

from asmc_pin import view
from asmc_pin.cli.entry import main
from asmc_pin.errors import ParameterError
from asmc_pin.viewer import replay_element, replay_page
from asmc_pin.viewer.film import replay_pictures
from asmc_pin.viewer.film.headless_browser import browser_program, headless_browser
from asmc_pin.viewer.film.replay_pictures import take_film, take_still

needs.program("browser")


@pytest.fixture(scope="module")
def html() -> str:
    return replay_page("two links", "", replay_element(swing("two_link", triangles=500, duration=0.5)))


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay_pictures, "SIZE", (320, 240))


def pixels(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def test_a_still_shows_the_arm_where_it_is_at_that_time(html: str, small: None, tmp_path: Path) -> None:
    for name, time in (("early", 0.0), ("late", 0.45), ("again", 0.0)):
        take_still(html, tmp_path / f"{name}.png", time)
    early, late, again = (pixels(tmp_path / f"{name}.png") for name in ("early", "late", "again"))
    assert early.shape == (240, 320, 3)
    assert early.std() > 10.0
    assert (np.abs(late - early).max(axis=2) > 40).mean() > 0.003, "it moved"
    assert (np.abs(again - early).max(axis=2) > 40).mean() < 0.001, "the same time gives the same picture"


def test_a_time_outside_the_motion_is_refused(html: str, small: None, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"0 to 0\.5 s expected"):
        take_still(html, tmp_path / "late.png", 2.0)
    assert not list(tmp_path.iterdir())


def test_a_film_has_the_time_of_the_motion_and_moves(html: str, small: None, tmp_path: Path) -> None:
    take_film(html, tmp_path / "film.mp4", fps=10.0)
    with av.open(io.BytesIO((tmp_path / "film.mp4").read_bytes())) as film:
        frames = [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(video=0)]
    assert len(frames) == 6, "0, 0.1, …, 0.5 s"
    assert frames[0].shape == (240, 320, 3)
    assert np.abs(frames[-1] - frames[0]).max() > 60


def test_view_writes_the_file_that_was_asked_for(small: None, tmp_path: Path) -> None:
    still = tmp_path / "still.png"
    assert view(awkward_result(), png=still, time=0.2) == still
    assert pixels(still).std() > 10.0


def test_without_a_browser_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CHROMIUM", raising=False)
    with pytest.raises(ParameterError, match="install one, or name it: CHROMIUM="):
        browser_program()
    monkeypatch.setenv("CHROMIUM", "nowhere")
    with pytest.raises(ParameterError, match="CHROMIUM names 'nowhere'"):
        browser_program()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--png", "still.jpg"], "ends in .png"),
        (["--mp4", "film.avi"], "ends in .mp4"),
        (["--follow", "--html", "page.html"], "leave --html"),
    ],
)
def test_what_cannot_be_written_is_said_before_anything_is_read(
    words: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["view", str(awkward_result().path), *words])
    assert ended.value.code == 2
    assert says in capsys.readouterr().err


DEAF = """#!/bin/sh
trap '' TERM
for word in "$@"; do
    case $word in --user-data-dir=*) echo 1 > "${word#*=}/DevToolsActivePort" ;; esac
done
while :; do sleep 1; done
"""


def test_a_browser_that_does_not_end_when_asked_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "deaf"
    program.write_text(DEAF)
    program.chmod(0o755)
    monkeypatch.setenv("CHROMIUM", str(program))
    monkeypatch.setattr("asmc_pin.viewer.film.headless_browser._FAREWELL", 0.1)
    with headless_browser() as browser:
        assert browser.process.poll() is None
    assert browser.process.returncode == -signal.SIGKILL
