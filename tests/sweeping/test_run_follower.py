"""Claims about `view --follow`: it waits, counts what is written, and shows a comparison when it is whole."""

from __future__ import annotations

from pathlib import Path

from sweep_cases import tiny
from viewer_cases import awkward_result

from asmc_pin.sweeping import sweep
from asmc_pin.sweeping.watching.run_follower import followed_page


def test_what_is_not_there_yet_is_waited_for(tmp_path: Path) -> None:
    page = followed_page(tmp_path / "nothing<b>")
    assert "is not there yet" in page
    assert 'http-equiv="refresh"' in page
    assert "nothing<b>" not in page


def test_a_comparison_is_replayed_once_it_is_whole() -> None:
    page = followed_page(awkward_result().path)
    assert 'class="replay"' in page
    assert 'http-equiv="refresh"' not in page


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
    assert 'http-equiv="refresh"' not in end
