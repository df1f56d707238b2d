"""Every kind of page that the package writes, small and quick to make: scenes with and without motion, and none."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from viewer_cases import awkward_result

from asmc_pin import explore, verify
from asmc_pin.arms import load_arm
from asmc_pin.condition import Recording
from asmc_pin.inspection.inspection_page import inspection_page
from asmc_pin.pages.condition_page import write_condition_report
from asmc_pin.pages.plates import Plate
from asmc_pin.pages.stability_page import write_stability_page
from asmc_pin.pages.tables.findings_page import FindingsPage, Section, experiment_details
from asmc_pin.pages.tables.text_table import Table
from asmc_pin.sampled import stability
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.viewer import write_replay


def _condition(path: Path) -> None:
    arm = load_arm("two_link")
    write_condition_report(verify(arm, mbar=0.5, samples=64), arm, path)


def _condition_along(path: Path) -> None:
    """With a second scene, which moves."""
    arm, time = load_arm("two_link"), np.linspace(0.0, 1.0, 101)
    log = Recording("log", time, 0.8 * np.sin(2.0 * np.pi * time[:, None] + np.array([0.0, 1.0])))
    write_condition_report(verify(arm, mbar=0.01, along=log, samples=64), arm, path)


def _stability(path: Path) -> None:
    arm = load_arm("two_link")
    write_stability_page(stability(arm, 0.02, 12.0, 12.0, 0.001, samples=64, limits=False), frozen_arms(arm), path)


def _findings(path: Path) -> None:
    """The page of sweeps, tunings and benchmarks."""
    table = Table("at one point", ["controller", *map(str, range(12))], [["PPC", *["0.123456"] * 12]] * 3)
    plate = Plate("curve", Figure(figsize=(2, 1)), "A curve")
    sections = [Section(title, "As told", [table], named=True) for title in ("Medians", "Failures")]
    appendix = experiment_details("The experiment", "name = 'x'\n")
    FindingsPage("tiny", ["12 trials"], sections, [plate], {"PPC": "#0072B2"}, appendix).write(path)


def _explorer(path: Path) -> None:
    explore(load_arm("two_link"), [0.05, 0.09], samples=64, html=path)


PAGES: dict[str, Callable[[Path], object]] = {
    "report": lambda path: path.write_bytes((awkward_result().path / "report.html").read_bytes()),
    "player": lambda path: write_replay(awkward_result(), path),
    "condition": _condition,
    "condition along a motion": _condition_along,
    "stability": _stability,
    "findings": _findings,
    "inspection": lambda path: path.write_text(inspection_page(load_arm("two_link")), encoding="utf-8"),
    "explorer": _explorer,
}
"""What writes each of them."""


@cache
def _folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="asmc-pages-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def page_address(kind: str) -> str:
    """Where the page of a kind lies, as a browser wants it; written once for all tests of a process."""
    path = _folder() / f"{kind.replace(' ', '_')}.html"
    PAGES[kind](path)
    return path.as_uri()
