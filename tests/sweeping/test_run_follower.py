"""Claims about `view --follow`: it waits, counts what is written, and shows a comparison when it is whole."""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path

import pytest
from browser import shared_browser
from sweep_cases import tiny
from viewer_cases import awkward_result

from asmc_pin.sweeping import sweep
from asmc_pin.sweeping.watching import run_follower
from asmc_pin.sweeping.watching.run_follower import followed_page
from asmc_pin.viewer import make_server

LOOKS_AGAIN = "fetch(location.href"


def test_what_is_not_there_yet_is_waited_for(tmp_path: Path) -> None:
    page = followed_page(tmp_path / "nothing<b>")
    assert "is not there yet" in page
    assert LOOKS_AGAIN in page
    assert "nothing<b>" not in page


def test_a_comparison_is_replayed_once_it_is_whole() -> None:
    page = followed_page(awkward_result().path)
    assert 'class="replay"' in page
    assert LOOKS_AGAIN not in page


def test_a_sweep_is_counted_as_its_blocks_are_written_and_is_complete_with_all_of_them(tmp_path: Path) -> None:
    seen: list[str] = []
    sweep(
        tiny(),
        4,
        tmp_path / "out",
        workers=1,
        block=4,
        progress=lambda _what, _share: seen.append(followed_page(tmp_path / "out")),
    )
    assert any("<td>4</td>" in page and "running" in page for page in seen), "half of the eight trials"
    end = followed_page(tmp_path / "out")
    assert end.count("<td>8</td><td>0</td>") == 2, "two controllers, no failure"
    assert "complete" in end
    assert LOOKS_AGAIN not in end


@pytest.mark.long
def test_the_page_shows_what_is_new_and_does_not_load_anew_until_there_is_a_replay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_follower, "EVERY", 0.02)
    folder, pages = tmp_path / "out", iter(["not there yet", "nothing is written yet"])
    with make_server(lambda: followed_page(folder)) as server, shared_browser().page() as page:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page.open(f"http://127.0.0.1:{server.server_port}/")
        page.run("window.first = true")
        assert next(pages) in page.run("document.querySelector('main').textContent")
        folder.mkdir()
        (folder / "experiment.toml").touch()
        page.until(f"document.querySelector('main').textContent.includes('{next(pages)}')")
        assert page.run("window.first")
        folder.joinpath("experiment.toml").unlink()
        folder.rmdir()
        folder.symlink_to(awkward_result().path)
        replayed = False
        while not replayed:
            with suppress(RuntimeError):  # between the two pages there is none to ask
                replayed = page.run("Boolean(window.replays)")
        assert page.run("window.first ?? null") is None
        server.shutdown()
