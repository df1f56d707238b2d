"""Pages as axe-core judges them: names, roles, contrast; on a desk and on a phone, light and dark.

Left out is what is not our markup: the canvas that Meshcat draws into and the plots that Bokeh builds. Both have names
from the elements around them, which are judged.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from pathlib import Path

import pytest
from browser import TICK, Browser, shared_browser
from every_page import PAGES, page_address

NOT_OURS = [".replay-pane", ".signals-body"]
WINDOWS = {"desk": (1000, 700), "phone": (390, 844)}


@cache
def axe() -> str:
    return (files("axe_core_python") / "axe.min.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.mark.long
@pytest.mark.parametrize("kind", PAGES)
def test_axe_finds_nothing_in_our_markup(browser: Browser, kind: str) -> None:
    address, found = page_address(kind), []
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


def test_axe_would_find_what_is_wrong(browser: Browser, tmp_path: Path) -> None:
    (tmp_path / "bad.html").write_text("<!doctype html><html lang=en><title>x</title><main><h1>x</h1><img src=data:,>")
    with browser.page() as page:
        page.open((tmp_path / "bad.html").as_uri())
        page.run(f"{axe()}; 0")
        assert [each["id"] for each in page.run("axe.run()")["violations"]] == ["image-alt"]
