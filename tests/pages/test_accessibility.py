"""Every kind of page: as axe-core judges it on a desk and on a phone, light and dark; and on paper.

Left out is what is not our markup: the canvas that Meshcat draws into and the plots that Bokeh builds. Both have names
from the elements around them, which are judged.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from browser import TICK, Browser, shared_browser
from matplotlib.figure import Figure
from paths import REPOSITORY
from sweep_cases import tiny
from tune_cases import small
from two_link_log import EXPERIMENT, found
from viewer_cases import awkward_result

from asmc_pin import bench, certify, design, explore, law_on_log, mbar_on_log, sweep, tune, verify
from asmc_pin.arms import load_arm
from asmc_pin.condition.certificate.search_and_proof import certified
from asmc_pin.inspection.inspection_page import inspection_page
from asmc_pin.pages.condition_page import write_condition_report
from asmc_pin.pages.identified.identification_page import write_identification_page
from asmc_pin.pages.plates import Plate
from asmc_pin.pages.stability_page import write_stability_page
from asmc_pin.pages.tables.findings_page import FindingsPage, Section, experiment_details
from asmc_pin.pages.tables.text_table import Table
from asmc_pin.sampled import stability
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sweeping.watching.run_follower import followed_page
from asmc_pin.viewer import write_replay

NOT_OURS = [".replay-pane", ".signals-body"]
WINDOWS = {"desk": (1000, 700), "phone": (390, 844)}


@cache
def axe() -> str:
    return (files("axe_core_python") / "axe.min.js").read_text(encoding="utf-8")


def write_condition(path: Path) -> None:
    arm = load_arm("two_link")
    write_condition_report(verify(arm, mbar=0.5, samples=64), arm, path)


def write_stability(path: Path) -> None:
    arm = load_arm("two_link")
    write_stability_page(stability(arm, 0.02, 12.0, 12.0, 0.001, samples=64, limits=False), frozen_arms(arm), path)


def write_findings(path: Path) -> None:
    """Sections of several tables, which are named, and a table wider than any page."""
    table = Table("at one point", ["controller", *map(str, range(12))], [["PPC", *["0.123456"] * 12]] * 3)
    plate = Plate("curve", Figure(figsize=(2, 1)), "A curve")
    sections = [Section(title, "As told", [table], named=True) for title in ("Medians", "Failures")]
    appendix = experiment_details("The experiment", "name = 'x'\n")
    FindingsPage("tiny", ["12 trials"], sections, [plate], {"PPC": "#0072B2"}, appendix).write(path)


def write_proven(path: Path) -> None:
    arm = load_arm("two_link")
    write_condition_report(certified(verify(arm, 0.02), certify(arm, 0.02, budget=5.0)), arm, path)


def write_design(path: Path) -> None:
    arm = load_arm("two_link")
    write_condition_report(design(arm, budget=5.0), arm, path)


def write_identification(path: Path) -> None:
    experiment = path.with_suffix(".toml")
    experiment.write_text(EXPERIMENT)
    ran = law_on_log(found(), experiment, "TDC")
    write_identification_page(found(), path, along=mbar_on_log(found(), ran.mbar), ran=ran)


def written_by(run: Any) -> Any:
    """A page that a study leaves beside its rows."""

    def write(path: Path) -> None:
        run(path.parent / "out")
        path.write_bytes((path.parent / "out" / "report.html").read_bytes())

    return write


def write_gallery(path: Path) -> None:
    """The index of viz/, whose scenes are players."""
    frame = (REPOSITORY / "viz" / "gallery.py").read_text(encoding="utf-8").split('"""')[3]
    path.write_text(frame.format(items='<li><a href="a.html"><img src="data:," alt="">An arm</a></li>'))


PART = {"arms": ["rv4fd"], "tasks": ["reach"], "laws": ["ppc", "bsmc"], "quick": True, "workers": 1}

PAGES: dict[str, Any] = {
    "report": lambda path: path.write_bytes((awkward_result().path / "report.html").read_bytes()),
    "player": lambda path: write_replay(awkward_result(), path),
    "condition": write_condition,
    "stability": write_stability,
    "findings": write_findings,
    "proven": write_proven,
    "design": write_design,
    "identification": write_identification,
    "explorer": lambda path: explore(load_arm("two_link"), [0.05, 0.09], budget=30.0, samples=256, html=path),
    "sweep": written_by(lambda out: sweep(tiny(), 4, out, workers=1)),
    "tuning": written_by(lambda out: tune(small(), 2, out)),
    "benchmark": written_by(lambda out: bench(out=out, **PART)),
    "followed": lambda path: path.write_text(followed_page(path.parent / "nothing"), encoding="utf-8"),
    "gallery": write_gallery,
    "inspection": lambda path: path.write_text(inspection_page(load_arm("two_link")), encoding="utf-8"),
}


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.fixture(scope="module", params=list(PAGES))
def address(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("axe") / f"{request.param}.html"
    PAGES[request.param](path)
    return path.as_uri()


@pytest.mark.long
def test_axe_finds_nothing_in_our_markup(browser: Browser, address: str) -> None:
    found = []
    with browser.page() as page:
        for window, dark in ((window, dark) for window in WINDOWS for dark in (False, True)):
            page.size(*WINDOWS[window], dark=dark)
            page.open(f"{address}#t=0.1")
            page.run("Promise.all((window.signalFigures ?? []).map((figure) => figure.ready))")
            page.run("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
            page.run(TICK)
            assert page.messages == []
            page.run(f"{axe()}; 0")
            exclude = json.dumps([[part] for part in NOT_OURS])
            report = page.run(f"axe.run({{ exclude: {exclude} }}, {{ resultTypes: ['violations'] }})")
            found += [
                (window, dark, each["id"], node["html"][:120], node["failureSummary"][:300])
                for each in report["violations"]
                for node in each["nodes"]
            ]
        assert not found, "\n".join(map(str, found))


PAPER = (688, 1017)
"""An A4 page less margins of 14 mm, CSS pixels."""

BEYOND_THE_PAGE = """[...document.querySelectorAll('body *')].filter((part) => {
    const { width, right } = part.getBoundingClientRect(), box = part.closest('.scroll, pre, .paper');
    return (width > 1 && right > innerWidth + 1) || (part === box && part.scrollWidth > part.clientWidth + 1);
}).map((part) => part.outerHTML.slice(0, 120))"""

SPREAD_OF_COLOURS = """((picture) => {
    const small = document.createElement('canvas'), pen = small.getContext('2d');
    small.width = small.height = 40;
    pen.drawImage(picture, 0, 0, 40, 40);
    const red = [...pen.getImageData(0, 0, 40, 40).data].filter((_, k) => k % 4 === 0);
    return [picture.getBoundingClientRect().height, Math.max(...red) - Math.min(...red), red[0]];
})"""


@pytest.mark.long
def test_on_paper_nothing_is_cut_all_is_open_scenes_are_stills_and_the_ground_is_white(
    browser: Browser, address: str
) -> None:
    with browser.page(*PAPER, dark=True) as page:
        page.open(address)
        page.run("Promise.all((window.signalFigures ?? []).map((figure) => figure.ready))")
        page.run("dispatchEvent(new Event('beforeprint'))")  # which comes before the medium changes
        page.call("Emulation.setEmulatedMedia", media="print")  # and light, as browsers print
        page.run("Promise.allSettled([...document.images].map((image) => image.decode()))")
        page.run(TICK)
        assert page.messages == []
        assert page.run("[...document.querySelectorAll('details')].every((fold) => fold.open)")
        assert page.run(BEYOND_THE_PAGE) == []
        scenes = page.run("document.querySelectorAll('.replay').length")
        stills = page.run(f"[...document.querySelectorAll('.replay-still')].map({SPREAD_OF_COLOURS})")
        assert len(stills) == scenes
        assert all(corner > 200 for _, _, corner in stills), "a dark screen's scene is light on paper"
        stills += page.run(f"[...document.querySelectorAll('canvas.map')].map({SPREAD_OF_COLOURS})")
        assert all(height > 100 and spread > 30 for height, spread, _ in stills), stills
        assert page.run("[...document.querySelectorAll('.replay-stage')].every((stage) => !stage.offsetParent)")
        ground = page.run("getComputedStyle(document.body).backgroundColor")
        assert ground in ("rgb(255, 255, 255)", "rgba(0, 0, 0, 0)")
        assert page.run("getComputedStyle(document.querySelector('h1')).color") in ("rgb(0, 0, 0)", "rgb(29, 36, 48)")


def test_axe_would_find_what_is_wrong(browser: Browser, tmp_path: Path) -> None:
    (tmp_path / "bad.html").write_text("<!doctype html><html lang=en><title>x</title><main><h1>x</h1><img src=data:,>")
    with browser.page() as page:
        page.open((tmp_path / "bad.html").as_uri())
        page.run(f"{axe()}; 0")
        assert [each["id"] for each in page.run("axe.run()")["violations"]] == ["image-alt"]
