"""`report.html`: says what happened, opens offline, and is the same for the same result."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from browser import Browser, Page, shared_browser
from viewer_cases import HOSTILE, awkward_result

from asmc_pin.errors import ResultError
from asmc_pin.metrics import METRICS
from asmc_pin.pages.comparison_page import report_html, report_text
from asmc_pin.results.result_folder import Result


@pytest.fixture(scope="module")
def result() -> Result:
    return awkward_result()


SCRIPTS = 12
"""Data of the replay and of the curves, licences, Meshcat, the replay's own four, Bokeh and its API, curves, report."""


class Text(HTMLParser):
    """What a person reads, cell by cell, and what a browser fetches."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.cells: list[str] = []
        self.rows: list[list[str]] = []
        self.best: list[str] = []
        self.addresses: list[str] = []
        self.scripts: list[str] = []
        self._tags: list[tuple[str, str]] = []
        self.feed(page)
        self.text = " ".join(self.cells)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = dict(attrs)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "action")]
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag == "script":
            self.scripts.append("")
        if tag not in ("meta", "link", "br", "img"):
            self._tags.append((tag, named.get("class") or ""))

    def handle_endtag(self, tag: str) -> None:
        while self._tags and self._tags.pop()[0] != tag:
            pass

    def handle_data(self, data: str) -> None:
        inside = [tag for tag, _ in self._tags]
        if "script" in inside:
            self.scripts[-1] += data
        elif "style" not in inside:
            self.cells.append(data)
            if "td" in inside or "th" in inside:
                self.rows[-1][-1] += data
            if any(tag == "td" and "best" in kind for tag, kind in self._tags):
                self.best.append(data)


@pytest.fixture(scope="module")
def text(result: Result) -> Text:
    return Text(report_text(result))


def test_it_says_how_every_controller_ended(result: Result, text: Text) -> None:
    end = float(result.dataset.end_time.sel(controller="Wild").to_numpy()[0])
    assert "ran to the end" in text.text
    assert f"diverged at {end:.3g} s" in text.text
    assert f"Wild diverged at t = {end:.3f} s; it has no metrics" in text.text, "the warning of the comparison"


def test_its_figures_are_those_of_the_summary(result: Result, text: Text) -> None:
    rows = result.summary[result.summary.controller == HOSTILE]
    degrees = np.degrees(rows.rms_error.to_numpy())
    row = next(row for row in text.rows if row[0] == HOSTILE)
    np.testing.assert_allclose([float(cell) for cell in row[1:3]], degrees, rtol=0.005)
    wild = next(row for row in text.rows if row[0] == "Wild")
    assert wild[1:3] == ["–", "–"]
    assert row[1] in text.best


def test_of_two_laws_that_ran_the_better_is_marked() -> None:
    from asmc_pin.pages.html_fragments import table_html
    from asmc_pin.pages.tables.text_table import Table

    rows = [["one", "0.5", "2.0", "7"], ["two", "0.25", "–", "6"], ["three", "0.30", "3.0", "5"]]
    table = Table("", ["controller", "a", "b", "c"], rows, [None, "smallest", "largest", None])
    assert Text(table_html(table, {})).best == ["0.25", "3.0"]


def test_every_metric_is_defined(text: Text) -> None:
    defined = {row[0]: row[1:] for row in text.rows if len(row) == 4}
    for metric in METRICS.values():
        assert defined[metric.title] == [metric.unit, metric.formula, metric.source]


def test_whatever_comes_from_a_file_is_text(result: Result, text: Text) -> None:
    assert HOSTILE in text.text
    assert len(text.scripts) == SCRIPTS
    holding = [script for script in text.scripts if "alert(1)" in script]
    assert all(script.startswith("{") and "</script" not in script for script in holding), "as data, and closed nowhere"
    hostile = result.dataset.assign_attrs(warnings="<img src=x onerror=alert(2)>", notes="<script>alert(3)</script>")
    again = Text(report_text(dataclasses.replace(result, dataset=hostile)))
    assert "<img src=x onerror=alert(2)>" in again.text
    assert "<script>alert(3)</script>" in again.text
    assert len(again.scripts) == SCRIPTS


def test_nothing_is_fetched(text: Text) -> None:
    assert all(address.startswith(("data:", "#")) for address in text.addresses)
    figures = sum(address.startswith("data:image/png") for address in text.addresses)
    assert figures == 5, "the paper's four kinds, and the theorems"


def test_every_link_leads_to_what_the_page_holds(result: Result, text: Text) -> None:
    page = report_text(result)
    links = [address for address in text.addresses if address.startswith("#")]
    assert links
    assert all(f'id="{address[1:]}"' in page for address in links)


def test_it_says_in_words_who_won_and_what_to_do_next(result: Result, text: Text) -> None:
    assert "followed the same motion in simulation, 0.4 s of it, on two_link" in text.text
    assert f"{HOSTILE} (RMS tracking error). One run each: how sure that is, is not known." in text.text
    assert "Did not last" in text.cells
    assert "asmc-pin verify two_link --mbar 0.01 --certify" in text.text


def test_times_and_versions_do_not_reach_it(result: Result) -> None:
    later = {**result.provenance, "started": "2099-01-01", "finished": "2099-01-02", "packages": {"pin": "99"}}
    assert report_text(dataclasses.replace(result, provenance=later)) == report_text(result)
    assert (result.path / "report.html").read_text(encoding="utf-8") == report_text(result)


def test_where_it_lies_does_not_reach_it(result: Result) -> None:
    assert str(result.path) not in report_text(result)
    assert not re.search(r"/site-packages/|/home/|/tmp/", report_text(result))


def test_a_report_that_cannot_be_written_is_told(result: Result, tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="cannot be written"):
        report_html(result, tmp_path / "nowhere" / "report.html")


@pytest.fixture(scope="module")
def browser() -> Browser:
    return shared_browser()


@pytest.fixture(scope="module", params=[600, 1280])
def page(request: pytest.FixtureRequest, browser: Browser, result: Result) -> Iterator[Page]:
    with browser.page(request.param, 700) as page:
        page.open((result.path / "report.html").as_uri())
        yield page


def test_it_opens_without_a_word_or_a_request_and_fits_the_window(page: Page) -> None:
    assert page.messages == []
    assert [address for address in page.requests if not address.startswith("data:")] == page.requests[:1]
    assert page.run("document.scrollingElement.scrollWidth <= innerWidth")
    page.run("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
    assert page.run("document.scrollingElement.scrollWidth <= innerWidth"), "wide tables scroll by themselves"


def test_space_scrolls_the_page_until_the_replay_has_the_focus(page: Page) -> None:
    page.run("document.activeElement.blur()")
    page.key(" ", "Space")
    assert page.run("replays[0].playing") is False
    page.run("document.querySelector('.replay').focus()")
    page.key(" ", "Space")
    assert page.run("replays[0].playing") is True
    page.key(" ", "Space")
    assert page.run("replays[0].playing") is False
