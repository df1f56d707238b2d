"""What holds on every page that the package writes, on a phone: its address, its player, swipes, tables, the view."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import test_accessibility
from browser import TICK, Browser, Page, shared_browser

from asmc_pin import Recording, explore, load_arm, verify
from asmc_pin.pages.condition_page import write_condition_report


def write_along(path: Path) -> None:
    """Of a condition along a motion: beside the scene of the worst configuration it has one that moves."""
    arm, time = load_arm("two_link"), np.linspace(0.0, 1.0, 101)
    log = Recording("log", time, 0.8 * np.sin(2.0 * np.pi * time[:, None] + np.array([0.0, 1.0])))
    write_condition_report(verify(arm, mbar=0.01, along=log, samples=64), arm, path)


PAGES: dict[str, Callable[[Path], object]] = {
    **test_accessibility.PAGES,
    "explorer": lambda path: explore(load_arm("two_link"), [0.05, 0.09], samples=64, html=path),
    "condition along a motion": write_along,
}

QUICK = ("condition along a motion",)
"""A page with a scene that moves, one that does not, and a table."""

KINDS = [pytest.param(kind, marks=[] if kind in QUICK else pytest.mark.long) for kind in PAGES]

STAGES = "[...(window.replays ?? []).map(({ stage }) => stage), ...(window.explorer ? [explorer.stage] : [])]"

LEAN = (
    f"{STAGES}.map((stage) => stage.offsets.map(([x, y]) => {{ const {{ camera }} = stage.viewer;"
    " const at = (z) => new MeshCat.THREE.Vector3(x, z, -y).project(camera), low = at(0), high = at(stage.reach);"
    " return Math.abs(Math.atan((high.x - low.x) * camera.aspect / (high.y - low.y))) * 180 / Math.PI; }))"
)
"""How far a vertical through each arm's base leans in the picture, degrees."""


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.mark.parametrize("kind", KINDS)
def test_on_a_phone_it_keeps_what_every_page_promises(browser: Browser, kind: str, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    PAGES[kind](path)
    with browser.page(390, 844) as page:
        page.call("Emulation.setTouchEmulationEnabled", enabled=True)
        page.open(f"{path.as_uri()}#t=0.1")
        page.run("Promise.all((window.signalFigures ?? []).map((figure) => figure.ready))")
        page.run("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
        page.run(TICK)
        assert page.messages == []
        it_opens_at_the_time_of_its_address(page)
        it_has_no_player_where_nothing_moves(page)
        tables_that_go_on_to_the_right_say_so(page)
        outer_arms_do_not_lean(page)
        a_swipe_over_a_picture_scrolls(page)
        assert page.messages == []


def it_opens_at_the_time_of_its_address(page: Page) -> None:
    for time, duration in page.run("(window.replays ?? []).map(({ time, duration }) => [time, duration])"):
        assert time == min(0.1, duration)


def it_has_no_player_where_nothing_moves(page: Page) -> None:
    shown = "(selector) => host.querySelector(selector).getClientRects().length > 0"
    for duration, *parts in page.run(
        f"(window.replays ?? []).map(({{ host, duration }}) => {{ const shown = {shown};"
        " return [duration, ...['.replay-play', '.replay-track input', '.replay-clock'].map(shown)]; })"
    ):
        assert parts == [duration > 0.0] * 3
    assert page.run("document.querySelectorAll('.replay').length") == page.run(f"{STAGES}.length")


def tables_that_go_on_to_the_right_say_so(page: Page) -> None:
    assert page.run("document.scrollingElement.scrollWidth <= innerWidth")
    boxes = page.run(
        "[...document.querySelectorAll('table')].map((table) => { const box = table.closest('.scroll');"
        " return [box !== null, box && box.scrollWidth > box.clientWidth + 4,"
        " box && getComputedStyle(box.nextElementSibling).display !== 'none']; })"
    )
    for inside, wide, said in boxes:
        assert inside
        assert wide == said


def outer_arms_do_not_lean(page: Page) -> None:
    assert max((lean for leans in page.run(LEAN) for lean in leans), default=0.0) < 1.5


def a_swipe_over_a_picture_scrolls(page: Page) -> None:
    if page.run("document.scrollingElement.scrollHeight <= innerHeight"):
        return
    for selector in ("[data-embedded=true] .replay-stage", ".map"):
        for number in range(page.run(f"document.querySelectorAll({json.dumps(selector)}).length")):
            picture = f"document.querySelectorAll({json.dumps(selector)})[{number}]"
            page.run(f"{picture}.scrollIntoView({{ block: 'center' }})")
            page.run(TICK)
            joints = page.run("window.explorer ? Array.from(explorer.q) : []")
            before = page.run("scrollY")
            x, y = page.run(
                f"(() => {{ const r = {picture}.getBoundingClientRect(); return [r.x + 12, r.bottom - 12]; }})()"
            )
            # Up, or down where the page ends below.
            way = -1 if page.run("scrollY + innerHeight < document.scrollingElement.scrollHeight - 60") else 1
            y = y if way < 0 else y - 160
            page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
            for step in range(1, 11):
                page.call(
                    "Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": x, "y": y + way * 15 * step}]
                )
            page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
            page.until(f"{-way} * (scrollY - {before}) > 40")
            np.testing.assert_array_equal(page.run("window.explorer ? Array.from(explorer.q) : []"), joints)
