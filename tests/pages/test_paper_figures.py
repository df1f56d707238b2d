"""Figures for papers: the widths of a two-column journal, one font, labels that fit, lines told apart in grey."""

from __future__ import annotations

import re
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from asmc_pin.pages.comparison_figures import FIGURES
from asmc_pin.pages.figure_style import COLUMN, PAGE, line_look, paper_style, save
from asmc_pin.pages.sweeps.sweep_figures import _round_figures

LABELS = ["PPC", "Existing law", "A label of some length", "Proposed", "Boundary layer"]
SLACK = 1.0
"""Pixels by which boxes of text may overlap: their edges are not ink."""


def run_of(joints: int) -> xr.Dataset:
    """Smooth curves of every signal under five controllers, with long names and wide ranges."""
    rng, time = np.random.default_rng(1), np.linspace(0.0, 4.0, 201)
    shape = (len(LABELS), len(time), joints)
    axes = ("controller", "time", "joint")
    scale = np.geomspace(1e-3, 10.0, len(LABELS))[:, None, None]
    signals = {
        name: (axes, scale * rng.normal(size=shape).cumsum(axis=1)) for name in ("q", "v", "torque", "s", "gain")
    }
    signals["gain"] = (axes, np.abs(signals["gain"][1]))
    return xr.Dataset(
        signals | {"q_ref": (("time", "joint"), np.zeros((len(time), joints)))},
        {
            "controller": LABELS,
            "time": time,
            "joint": [f"a_rather_long_name_{i}_joint" for i in range(joints)],
            "joint_kind": ("joint", ["prismatic"] * (joints > 2) + ["revolute"] * (joints - (joints > 2))),
        },
    )


def drawn(name: str, joints: int) -> Figure:
    with paper_style():
        figure = FIGURES[name].draw(run_of(joints), np.full(joints, 3.0))
        FigureCanvasAgg(figure).draw()
    return figure


def texts(figure: Figure) -> dict[Text, Bbox]:
    """All that is written, with its box, pixels."""
    out_of_view = set()  # labels of ticks that matplotlib keeps and does not draw
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            if not low <= tick.get_loc() <= high:
                out_of_view |= {tick.label1, tick.label2}
    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return {text: text.get_window_extent() for text in shown if text not in out_of_view}


@pytest.mark.parametrize("joints", [2, pytest.param(7, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_as_wide_as_one_or_two_columns_and_all_its_words_fit(name: str, joints: int) -> None:
    figure = drawn(name, joints)
    assert figure.get_figwidth() in (COLUMN, PAGE)
    boxes = texts(figure)
    assert len(boxes) > 10
    page = figure.bbox.padded(SLACK)
    for text, box in boxes.items():
        assert page.x0 <= box.x0 < box.x1 <= page.x1, text.get_text()
        assert page.y0 <= box.y0 < box.y1 <= page.y1, text.get_text()
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        assert not Bbox.intersection(a.padded(-SLACK), b.padded(-SLACK)), (one.get_text(), other.get_text())


def test_a_pdf_has_one_font_and_none_that_journals_refuse(tmp_path: Path) -> None:
    for name in ("errors", "gains_and_s"):  # letters and formulas
        with paper_style():
            save(FIGURES[name].draw(run_of(2), np.full(2, 3.0)), tmp_path / name)
        pdf = (tmp_path / f"{name}.pdf").read_bytes()
        fonts = {font.rpartition(b"+")[2] for font in re.findall(rb"/BaseFont /([\w+-]+)", pdf)}
        assert fonts
        assert all(font.startswith(b"STIX") for font in fonts), fonts
        assert b"/Type3" not in pdf


def test_lines_of_two_controllers_in_one_panel_differ_in_dashes_or_markers() -> None:
    for name in ("errors", "gains_and_s"):
        for axes in drawn(name, 2).axes:
            looks = [(str(line._unscaled_dash_pattern), line.get_marker()) for line in axes.lines]
            assert len(looks) >= 2
            assert len(set(looks)) == len(looks)


def test_thirty_lines_are_told_apart_in_grey() -> None:
    looks = [line_look(k, "black", 100) for k in range(32)]
    assert len({(str(look["linestyle"]), look["marker"]) for look in looks}) == 32
    assert all(one["linestyle"] != other["linestyle"] for one, other in pairwise(looks[:8]))


@pytest.mark.parametrize(("low", "high"), [(0.0121, 0.0241), (0.9, 1.1), (41.0, 92.0), (3e-5, 8e-4), (0.2, 30.0)])
def test_an_axis_of_less_than_a_decade_has_a_few_round_labels(low: float, high: float) -> None:
    found = _round_figures(low, high)
    assert 2 <= len(found) <= 7
    assert all(low <= x <= high for x in found)
    assert found == sorted(found)
