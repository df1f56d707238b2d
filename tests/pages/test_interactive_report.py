"""The report as a person meets it in a browser: curves and scene together, small screens, dark, keyboard, paper."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

import numpy as np
import pytest
from browser import TICK, Browser, Page, shared_browser
from viewer_cases import HOSTILE, awkward_result

READY = "Promise.all(signalFigures.map((figure) => figure.ready))"
LEGEND = ".legend button"


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.fixture(scope="module")
def address() -> str:
    return (awkward_result().path / "report.html").as_uri()


@pytest.fixture(scope="module")
def page(browser: Browser, address: str) -> Iterator[Page]:
    with browser.page(1000, 700) as page:
        page.open(f"{address}#t=0.25")
        page.run(READY)
        yield page


def curves(page: Page) -> list[list[list[bool]]]:
    """Whether each drawn part is visible, by plot and controller."""
    return page.run("signalFigures[0].plots.map(({ renderers }) => renderers.map((own) => own.map((r) => r.visible)))")


def test_it_opens_without_a_word_at_the_time_that_its_address_asks_for(browser: Browser, address: str) -> None:
    with browser.page(1000, 700) as page:
        page.open(f"{address}#t=0.25")
        page.run(READY)
        assert page.messages == []
        assert page.run("replays[0].time") == 0.25
        assert page.run("signalFigures[0].cursorTime(0)") == pytest.approx(0.25, abs=1e-3)


def test_the_cursor_stands_where_the_scene_is(page: Page) -> None:
    for time in (0.1, 0.3):
        page.run(f"replays[0].seek({time})")
        for plot in range(2):
            assert page.run(f"signalFigures[0].cursorTime({plot})") == pytest.approx(time, abs=1e-3)


def test_a_click_on_a_curve_takes_the_scene_to_that_time(page: Page) -> None:
    x, y = over_first_plot(page)
    for kind in ("mousePressed", "mouseReleased"):
        page.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    page.run("new Promise((done) => setTimeout(done, 600))")  # a second click would make it a double one
    assert page.run("replays[0].time") == pytest.approx(0.2, abs=0.005)
    assert page.run("signalFigures[0].cursorTime(0)") == pytest.approx(page.run("replays[0].time"), abs=1e-3)


def over_first_plot(page: Page) -> tuple[float, float]:
    return page.run(
        "(() => { const { body, view } = signalFigures[0].plots[0]; body.scrollIntoView({ block: 'center' });"
        " const { left, top } = body.getBoundingClientRect(), f = view.frame.bbox;"
        " return [left + f.left + 0.5 * f.width, top + f.top + 0.5 * f.height]; })()"
    )


def test_values_stand_under_the_pointer(page: Page) -> None:
    x, y = over_first_plot(page)
    for step in (0, 1, 2):
        page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + step, y=y)
    page.run(
        "window.told = () => { const found = []; const walk = (node) => { for (const e of node.querySelectorAll('*'))"
        " { if (e.className.includes?.('bk-tooltip-row-value')) found.push(e.textContent);"
        " if (e.shadowRoot) walk(e.shadowRoot); } }; walk(document); return found; }, 0"
    )
    page.until("told().length > 1")
    value, time = page.run("told()")[:2]
    assert float(time.strip().removesuffix(" s")) == pytest.approx(0.2, abs=0.01)
    result = awkward_result()
    run = result.dataset.isel(trial=0).sel(controller=HOSTILE)
    error = np.degrees((run.q_ref - run.q).sel(time=slice(0.18, 0.22)).isel(joint=0).to_numpy())
    assert error.min() * (1 - 1e-2) - 1e-6 <= float(value) <= error.max() * (1 + 1e-2) + 1e-6
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=2, y=2)


def test_the_wheel_zooms_after_a_click_and_the_cursor_stays_at_its_time(page: Page) -> None:
    x, y = over_first_plot(page)
    wheel = {"type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": -240}
    span = "signalFigures[0].range.end - signalFigures[0].range.start"
    for kind in ("mousePressed", "mouseReleased"):
        page.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    page.run("new Promise((done) => setTimeout(done, 600))")  # as above
    page.call("Input.dispatchMouseEvent", **wheel)
    page.until(f"{span} < 0.35")
    page.run(TICK)
    assert page.run("signalFigures[0].cursorTime(0)") == pytest.approx(page.run("replays[0].time"), abs=1e-3)
    page.run("signalFigures[0].reset()")
    page.until(f"Math.abs({span} - 0.4) < 1e-6")


def test_the_legend_hides_a_controller_in_curves_scene_and_tables_and_brings_it_back(page: Page) -> None:
    def seen() -> tuple[list, bool, list]:
        stage = "replays[0].stage"
        scene = page.run(f"[0, 1].map((k) => [{stage}.arms[k].root.visible, {stage}.ghosts[k].root.visible])")
        rows = page.run(
            "[...document.querySelectorAll('[data-controller]')].map((e) => [e.dataset.controller,"
            " e.offsetParent !== null || e.closest('details:not([open])') !== null])"
        )
        return curves(page), scene, rows

    page.run(f"document.querySelector('{LEGEND}').scrollIntoView({{ block: 'center' }})")
    before = seen()
    page.click(LEGEND)
    hidden, scene, rows = seen()
    assert not any(part for plot in hidden for part in plot[0])
    assert all(part for plot in hidden for part in plot[1])
    assert scene == [[False, False], [True, True]]
    assert {label for label, there in rows if not there} == {HOSTILE}
    assert page.run(f"document.querySelector('{LEGEND}').getAttribute('aria-pressed')") == "false"
    page.click(LEGEND)
    assert seen() == before


def test_a_logarithmic_axis_another_quantity_and_one_joint_can_be_had_with_the_keyboard_alone(page: Page) -> None:
    page.run("signalFigures[0].select.focus()")
    page.key("ArrowDown", "ArrowDown")
    page.run(READY)
    assert page.run("signalFigures[0].signal.key") == "s"
    page.run("signalFigures[0].log.focus()")
    page.key(" ", "Space")
    page.run(READY)
    assert page.run("signalFigures[0].plots[0].plot.y_scale.type") == "LogScale"
    page.run("document.querySelectorAll('.signals-joints input')[0].focus()")
    page.key(" ", "Space")
    assert page.run("signalFigures[0].plots.map(({ figure }) => figure.offsetParent === null)") == [True, False]
    page.key(" ", "Space")
    page.run(
        "signalFigures[0].log.click(), signalFigures[0].select.value = 'error', "
        "signalFigures[0].select.dispatchEvent(new Event('change'))"
    )
    page.run(READY)
    assert page.messages == []


def test_the_camera_turns_with_the_keyboard(page: Page) -> None:
    where = "replays[0].stage.viewer.camera.position.toArray()"
    before = page.run(where)
    page.run("replays[0].host.focus()")
    page.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowLeft", code="ArrowLeft", modifiers=8)
    assert np.abs(np.subtract(page.run(where), before)).max() > 1e-3
    page.run("replays[0].stage.resetView()")
    np.testing.assert_allclose(page.run(where), before, rtol=1e-6)


def test_every_figure_and_every_control_has_a_name_for_who_cannot_see_it(page: Page) -> None:
    tree = page.call("Accessibility.getFullAXTree")["nodes"]
    nodes = [(node["role"]["value"], node.get("name", {}).get("value", "")) for node in tree if not node.get("ignored")]
    for role in ("button", "checkbox", "combobox", "slider", "figure", "region"):
        named = [name for kind, name in nodes if kind == role]
        assert named, role
        assert all(named), role
    figures = [name for kind, name in nodes if kind == "figure" and name.startswith("Tracking error")]
    assert len(figures) == 2
    assert "at most" in figures[0]


def test_paper_gets_all_of_it_open_with_a_still_of_the_scene(browser: Browser, address: str) -> None:
    with browser.page(720, 1000) as page:
        page.open(address)
        page.run(READY)
        page.run(TICK)
        page.run("dispatchEvent(new Event('beforeprint'))")  # which comes before the medium changes
        page.call("Emulation.setEmulatedMedia", media="print")
        page.run("document.querySelector('.replay-still').decode()")
        assert page.run("[...document.querySelectorAll('details')].every((fold) => fold.open)")
        assert (
            page.run(
                "[...document.querySelectorAll('.scroll, pre, .paper, main')]"
                ".filter((box) => box.scrollWidth > box.clientWidth + 1).length"
            )
            == 0
        ), "nothing is cut"
        still = page.run(
            "(() => { const i = document.querySelector('.replay-still'), c = document.createElement('canvas');"
            " c.width = 60; c.height = 40; const x = c.getContext('2d'); x.drawImage(i, 0, 0, 60, 40);"
            " return [i.offsetParent !== null, i.alt, [...x.getImageData(0, 0, 60, 40).data]]; })()"
        )
        assert still[0]
        assert still[1].startswith("The scene at 0.00 s")
        assert np.std(still[2]) > 10.0, "not blank"
        assert page.run("getComputedStyle(document.querySelector('.replay-stage')).display") == "none"
        broken = page.run(
            "[...document.querySelectorAll('th')].filter((th) => { const r = document.createRange();"
            " const texts = [...th.childNodes].filter((n) => n.nodeType === 3); return texts.some((n) => "
            "[...n.data.matchAll(/[\\p{L}\\d]+/gu)].some((w) => { r.setStart(n, w.index);"
            " r.setEnd(n, w.index + w[0].length); return r.getClientRects().length > 1; })); })"
            ".map((th) => th.textContent)"
        )
        assert broken == [], "no heading breaks within a word"
        page.run("dispatchEvent(new Event('afterprint'))")
        assert not page.run("document.querySelector('details').open")
        pdf = page.pdf()
        assert len(re.findall(rb"/Type ?/Page\b(?!s)", pdf)) > 3


def test_on_a_phone_it_fits_says_where_there_is_more_and_a_swipe_over_the_scene_scrolls(
    browser: Browser, address: str
) -> None:
    with browser.page(390, 844) as page:
        page.call("Emulation.setTouchEmulationEnabled", enabled=True)
        page.open(address)
        page.run(READY)
        page.run("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
        page.run(TICK)
        assert page.run("document.scrollingElement.scrollWidth <= innerWidth")
        told = json.loads(
            page.run(
                "JSON.stringify([...document.querySelectorAll('.scroll')].map((box) => ["
                "box.scrollWidth > box.clientWidth + 4, getComputedStyle(box.nextElementSibling).display !== 'none']))"
            )
        )
        assert any(wide for wide, _ in told)
        assert all(wide == said for wide, said in told)
        for selector in (".replay-stage", ".signals-body"):
            page.run(f"document.querySelector('{selector}').scrollIntoView({{ block: 'center' }})")
            page.run(TICK)
            before = page.run("scrollY")
            x, y = page.run(
                f"(() => {{ const r = document.querySelector('{selector}').getBoundingClientRect();"
                " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
            )
            page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
            for step in range(1, 11):
                page.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": x, "y": y - 15 * step}])
            page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
            page.until(f"scrollY > {before} + 50")


def test_a_dark_page_has_dark_figures(browser: Browser, address: str) -> None:
    with browser.page(1000, 700, dark=True) as page:
        page.open(address)
        page.run(READY)
        page.run("document.querySelector('.signals-grid').scrollIntoView()")
        page.run(TICK)
        picture = page.pixels().astype(int)
        assert np.median(picture) < 60
        assert (picture.max(axis=2) > 140).mean() > 0.001, "curves and words show on it"
        assert page.messages == []
