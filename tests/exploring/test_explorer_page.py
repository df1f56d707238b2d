"""The explorer's page as a person meets it: sliders, fields, the arm itself, boxes, small screens, dark, and served."""

from __future__ import annotations

import base64
import json
import re
import socket
import threading
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path

import numpy as np
import pytest
from browser import Browser, Page, shared_browser

from asmc_pin import certify, explore, lemma1_norm, load_arm, verify
from asmc_pin.arms import Arm
from asmc_pin.condition.certificate.box_partition import OPEN, PROVEN, REFUTED
from asmc_pin.condition.checker.boxes.bisection import cells
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.errors import ParameterError
from asmc_pin.exploring.exploring_verb import checked_gains, look
from asmc_pin.exploring.live_server import live_answers
from asmc_pin.viewer import draw, make_server

MBAR = [0.05, 0.09]
"""Of the two-link arm: violated at some configurations of its second joint, proven at others."""

START = "explorer.go(explorer.data.start), document.querySelector('.mbar-back').click()"
GAINS = checked_gains(5.0, 5.0, 0.001)


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def address(arm: Arm, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("page") / "two_link.html"
    assert explore(arm, MBAR, budget=30.0, samples=2048, html=path) == path
    return path.as_uri()


@pytest.fixture(scope="module")
def opened(browser: Browser, address: str) -> Iterator[Page]:
    with browser.page(700, 560) as page:
        page.open(address)
        yield page


@pytest.fixture
def page(opened: Page) -> Page:
    opened.run(f"{START}, window.scrollTo(0, 0)")
    return opened


def text(page: Page, selector: str) -> str:
    return page.run(f"document.querySelector({json.dumps(selector)}).textContent")


def norm(page: Page) -> float:
    return float(page.run("explorer.here.norm"))


def drawn_map(page: Page) -> None:
    page.until("!explorer.map.busy && !document.querySelector('.map.is-stale')")


def test_it_opens_from_a_file_without_a_word_or_a_request(page: Page, address: str) -> None:
    drawn_map(page)
    assert page.messages == []
    assert page.requests == [address]


def test_a_slider_moves_the_arm_and_every_figure(page: Page, arm: Arm) -> None:
    before = {name: text(page, name) for name in (".norm", ".figures", ".direction", ".loop-words")}
    page.run(
        "(() => { const s = document.querySelectorAll('.joint input[type=range]')[1]; s.value = 75;"
        " s.dispatchEvent(new Event('input')); })()"
    )
    q = np.array([0.0, np.radians(75.0)])
    assert all(text(page, name) != was for name, was in before.items())
    expected = float(lemma1_norm(arm.mass_matrix(q), np.array(MBAR)))
    assert norm(page) == pytest.approx(expected, rel=1e-9)
    assert float(text(page, ".norm")) == pytest.approx(expected, rel=1e-5)
    assert page.run("document.querySelectorAll('.joint input[type=number]')[1].value") == "75"
    drawn = draw(arm)
    pose = drawn.poses(q)[drawn.tip[0]]
    tip = page.run("explorer.stage.arms[0].tip().toArray()")
    np.testing.assert_allclose(tip, pose[:3, :3] @ drawn.tip[1] + pose[:3, 3], atol=1e-6)


def test_joints_are_moved_with_the_keyboard_alone_and_are_named(page: Page) -> None:
    page.run("document.querySelectorAll('.joint input[type=range]')[1].focus()")
    page.key("ArrowRight", "ArrowRight")
    assert page.run("explorer.q[1]") > 0.0
    assert page.run("document.activeElement.getAttribute('aria-label')") == "joint_2"
    assert page.run("document.activeElement.getAttribute('aria-valuetext')").endswith("°")
    unnamed = page.run(
        "[...document.querySelectorAll('input, select, button')].filter((e) => !(e.labels?.length ||"
        " e.getAttribute('aria-label') || e.textContent.trim())).length"
    )
    assert unnamed == 0
    page.until("document.querySelector('.told').textContent.startsWith('Norm')")


def test_a_link_is_dragged_and_the_joint_above_it_follows(page: Page) -> None:
    point = (
        "(() => { const v = explorer.stage.arms[0].tip(), s = explorer.stage, r = s.canvas.getBoundingClientRect();"
        " s.arms[0].root.updateWorldMatrix(true, true); v.multiplyScalar(0.97).applyMatrix4(s.arms[0].root.matrixWorld)"
        ".project(s.viewer.camera); return [r.left + (v.x + 1) / 2 * r.width, r.top + (1 - v.y) / 2 * r.height]; })()"
    )
    x, y = page.run(point)
    camera = page.run("explorer.stage.viewer.camera.position.toArray()")
    page.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", buttons=1, clickCount=1)
    for k in range(1, 9):
        page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x - 2 * k, y=y - 4 * k, button="left", buttons=1)
    page.call("Input.dispatchMouseEvent", type="mouseReleased", x=x - 16, y=y - 32, button="left", clickCount=1)
    moved = page.run("Array.from(explorer.q)")
    assert moved[0] == 0.0
    assert abs(moved[1]) > 0.05
    assert page.run("explorer.stage.viewer.camera.position.toArray()") == camera, "the view stays"
    reached = page.run(point)
    assert np.hypot(reached[0] - x, reached[1] - y) > 10.0


def test_the_worst_configuration_has_the_norm_that_python_found_there(page: Page, arm: Arm) -> None:
    found = verify(arm, MBAR, samples=2048)
    assert found.verdict == "violated"
    page.click(".to-worst")
    np.testing.assert_allclose(page.run("Array.from(explorer.q)"), found.worst_q, atol=0)
    assert norm(page) == pytest.approx(found.lower, rel=1e-9)
    assert "violated" in text(page, ".state")
    assert f"{found.lower:.6g}" in text(page, ".to-worst")


def test_the_map_has_the_norms_of_its_points_and_a_click_moves_the_joints(page: Page, arm: Arm) -> None:
    drawn_map(page)
    norms, plane, x, y = page.run(
        "(() => { const m = explorer.map, places = (k) => Array.from({ length: 48 }, (_, i) => m.place(k, i));"
        " return [Array.from(m.norms), m.plane, ...m.plane.map(places)]; })()"
    )
    q = np.zeros((48, 48, 2))
    q[..., plane[0]], q[..., plane[1]] = np.meshgrid(x, y)
    expected = lemma1_norm(arm.mass_matrix(q), np.array(MBAR))
    np.testing.assert_allclose(np.array(norms).reshape(48, 48), expected, rtol=1e-9)
    share = 100.0 * (expected >= 1.0).mean()
    assert float(re.search(r"on ([\d.]+) %", text(page, ".map-words"))[1]) == pytest.approx(share, rel=1e-2)
    page.run("document.querySelector('.map').scrollIntoView({ block: 'center' })")
    page.click(".map")
    # A pixel is some hundredth of a radian.
    np.testing.assert_allclose(page.run("Array.from(explorer.q)"), resolve_box(arm).centre, atol=0.03)


def test_a_proven_box_holds_no_violation_a_refuted_one_does_and_they_cover_the_plane(page: Page, arm: Arm) -> None:
    lower, upper = arm.box
    met = page.run("explorer.cells.meeting([0, 1], explorer.q)")
    marks = {cell["mark"] for cell in met}
    assert {PROVEN, REFUTED} <= marks <= {PROVEN, REFUTED, OPEN}
    area = sum((cell["x1"] - cell["x0"]) * (cell["y1"] - cell["y0"]) for cell in met)
    assert area == pytest.approx(np.prod(upper - lower))
    for cell in met:
        ends = np.linspace([cell["x0"], cell["y0"]], [cell["x1"], cell["y1"]], 400)
        largest = lemma1_norm(arm.mass_matrix(ends), np.array(MBAR)).max()
        if cell["mark"] == PROVEN:
            assert largest < 1.0
        elif cell["mark"] == REFUTED:
            assert largest >= 0.995, "the configuration itself may lie between two of these"
    drawn_map(page)
    assert f"{sum(cell['mark'] == PROVEN for cell in met)} are proven" in text(page, ".cells-words")


def test_another_mbar_changes_the_figures_at_once_and_hides_the_boxes(page: Page, arm: Arm) -> None:
    set_field = (
        "(([id, value]) => { const f = document.getElementById(id); f.value = value;"
        " f.dispatchEvent(new Event('input')); })"
    )
    page.run(f"{set_field}(['mbar-1', '0.02'])")
    expected = float(lemma1_norm(arm.mass_matrix(np.zeros(2)), np.array([MBAR[0], 0.02])))
    assert norm(page) == pytest.approx(expected, rel=1e-9)
    drawn_map(page)
    assert page.run("explorer.map.cells.length") == 0
    assert "not shown" in text(page, ".cells-words")
    assert "not the one that was asked about" in text(page, ".mbar-note")
    page.run(f"{set_field}(['mbar-1', '-3'])")
    assert page.run("document.getElementById('mbar-1').getAttribute('aria-invalid')") == "true"
    assert norm(page) == pytest.approx(expected, rel=1e-9), "what is no inertia is not taken"
    page.run("document.querySelector('.mbar-back').click()")
    page.run(f"{set_field}(['mbar-scale', '0.25'])")
    page.run("document.querySelector('.search').click()")
    page.until("document.querySelector('.mbar-note').textContent.startsWith('Largest')")
    found = verify(arm, 0.25 * np.array(MBAR), samples=2048).lower
    assert norm(page) == pytest.approx(found, rel=1e-4), "the search in the page comes to what Python's does"
    assert norm(page) <= found * (1.0 + 1e-9)


def test_gains_are_changed_in_the_page(page: Page) -> None:
    assert "No β and no k_s are stable here" in text(page, ".loop-words"), "M̄ is too large for any"
    page.run("explorer.move(1, 2.0)")
    assert text(page, ".loop-words").startswith("Stable")
    page.run(
        "(() => { const f = document.getElementById('gain-beta'); f.value = 9000;"
        " f.dispatchEvent(new Event('input')); f.value = 10; })()"
    )
    assert text(page, ".loop-words").startswith("Unstable")
    page.run("explorer.gains.beta = 10")


@pytest.mark.parametrize(
    ("width", "height", "dark"),
    [
        (1280, 900, False),
        (390, 844, True),
        pytest.param(1280, 900, True, marks=pytest.mark.long),
        pytest.param(390, 844, False, marks=pytest.mark.long),
    ],
)
def test_nothing_is_cut_off_on_any_screen_light_or_dark(
    browser: Browser, address: str, width: int, height: int, dark: bool
) -> None:
    with browser.page(width, height, dark=dark) as page:
        page.open(address)
        drawn_map(page)
        assert page.messages == []
        assert page.run("document.documentElement.scrollWidth") == width
        cut = page.run(
            "[...document.querySelectorAll('main *')].filter((e) => e.scrollWidth > e.clientWidth + 1 && e.clientWidth"
            " && !['INPUT', 'SELECT'].includes(e.tagName) && getComputedStyle(e).display !== 'inline'"
            " && !e.closest('.replay-stage')).map((e) => e.className)"
        )
        assert cut == []
        assert page.run("document.querySelector('.norm').getBoundingClientRect().bottom") < height
        corner = page.pixels()[height - 4, 2].mean()
        assert (corner < 60.0) == dark


def test_without_webgl_all_figures_are_there(browser: Browser, address: str) -> None:
    with browser.page() as page:
        hide = "const g = HTMLCanvasElement.prototype.getContext; HTMLCanvasElement.prototype.getContext ="
        only = "function (kind, ...rest) { return kind === '2d' ? g.call(this, kind, ...rest) : null; };"
        page.call("Page.addScriptToEvaluateOnNewDocument", source=f"{hide} {only}")
        page.open(address)
        assert "cannot be drawn" in text(page, ".scene-message")
        drawn_map(page)
        assert norm(page) > 0.0


def test_boxes_of_a_certificate_are_its_own_and_only_of_multiples_that_it_proves(
    browser: Browser, arm: Arm, tmp_path: Path
) -> None:
    proof = certify(arm, MBAR, gap=0.05, budget=10.0)
    assert 0.0 < proof.scale_proven < 1.0
    file, html = proof.save(tmp_path / "two_link.cert"), tmp_path / "page.html"
    explore(arm, MBAR, certificate=file, samples=256, html=html)
    with browser.page() as page:
        page.open(html.as_uri())
        drawn_map(page)
        assert "not shown" in text(page, ".cells-words"), "the proof is of a smaller M̄"
        page.run(f"explorer.scale = {proof.scale_proven!r}, explorer.newMbar()")
        page.until("explorer.map.cells.length > 0")
        met = page.run("explorer.map.cells")
        record = base64.b64decode(page.run("explorer.data.cells.records[0]"))
    box = resolve_box(arm)
    assert record == proof.proofs[0].record.tobytes()
    centre, half = next(cells(np.frombuffer(record, dtype=np.uint8), 2)).boxes(box.lower, box.upper)
    expected = sorted((c - h).round(9).tolist() for c, h in zip(centre, half, strict=True))
    assert {cell["mark"] for cell in met} == {PROVEN}
    # In the plane of the page the first axis is joint 2.
    assert sorted([round(cell["y0"], 9), round(cell["x0"], 9)] for cell in met) == pytest.approx(np.array(expected))


def test_a_certificate_of_something_else_is_refused(arm: Arm, tmp_path: Path) -> None:
    file = certify(arm, 0.02, gap=0.3, budget=10.0).save(tmp_path / "other.cert")
    with pytest.raises(ParameterError, match="about something else than what is asked: see its mbar"):
        explore(arm, MBAR, certificate=file, samples=64, html=tmp_path / "page.html")
    with pytest.raises(ParameterError, match="leave the budget out"):
        explore(arm, MBAR, certificate=file, budget=1.0, html=tmp_path / "page.html")


@pytest.fixture(scope="module")
def served(arm: Arm) -> Iterator[int]:
    explored = look(load_arm("ur5"), 0.05, condition="weighted", box=None, budget=None, certificate=None, samples=64)
    answers = live_answers(explored.arm, explored.box)
    with make_server(explored.page(GAINS, live=True), answers=answers) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        yield server.server_port
        server.shutdown()
        thread.join()
    assert not thread.is_alive()
    with socket.socket() as closed:
        assert closed.connect_ex(("127.0.0.1", server.server_port)) != 0


FOLDED = [0.0, -1.0, 3.1, 0.0, 0.0, 0.0]
"""A UR5 with its forearm back in its upper arm."""


def test_a_served_page_says_whether_links_collide_and_an_offline_one_asks_nobody(
    browser: Browser, served: int, page: Page
) -> None:
    assert text(page, ".collisions") == ""
    with browser.page() as live:
        live.open(f"http://127.0.0.1:{served}/")
        live.until("document.querySelector('.collisions').textContent")
        assert text(live, ".collisions").startswith("No links collide here.")
        live.run(f"explorer.go({json.dumps(FOLDED)})")
        live.until("document.querySelector('.collisions').textContent.startsWith('Links collide here: ')")
        assert "upper_arm_link" in text(live, ".collisions")
        assert live.messages == []


def test_the_server_answers_this_machine_and_sound_questions_alone(served: int) -> None:
    def asked(path: str, host: str = "127.0.0.1") -> int:
        connection = HTTPConnection("127.0.0.1", served, timeout=60)
        connection.request("GET", path, headers={"Host": host})
        status = connection.getresponse().status
        connection.close()
        return status

    assert asked("/collisions?q=0,0,0,0,0,0") == 200
    assert asked("/collisions?q=0,0,0,0,0,0", host="attacker.example") == 403
    for wrong in ("0,0", "0,0,0,0,0,nan", "a,b,c,d,e,f", ""):
        assert asked(f"/collisions?q={wrong}") == 400
    with socket.socket() as other:
        other.settimeout(60)
        assert other.connect_ex(("127.0.0.2", served)) != 0


def test_of_an_arm_without_shapes_it_is_said_that_nothing_is_known(arm: Arm) -> None:
    said = json.loads(live_answers(arm, resolve_box(arm))["/collisions"]("q=0,0"))
    assert said == {
        "known": False,
        "pairs": [],
        "text": "Whether links collide is not known: the URDF gives no collision shapes.",
    }
