"""The paper's figures, measured: a law is told apart on grey paper too, and a legend names what is drawn."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from asmc_pin.pages.figure_style import paper_style
from asmc_pin.reproduction.paper_figures import _gains

RANGE = "range of the paper's figure"


def drawn(largest_in_the_paper):
    """Gains and s of two laws, 1.0 at most, beside ranges of the paper's figure."""
    time = np.linspace(0.0, 1.0, 200)
    curve = np.abs(np.sin(9.0 * time))[None, :, None] * np.array([1.0, 0.8])[:, None, None] * np.ones(2)
    dataset = xr.Dataset(
        {"gain": (("controller", "time", "joint"), curve), "s": (("controller", "time", "joint"), curve)},
        {"controller": ["Existing", "Proposed"], "time": time},
    )
    item = {
        "set": "as printed",
        "scale": {"s": 1.0, "gain": 1.0},
        "paper": {"gain": {"Existing": largest_in_the_paper}, "s": [largest_in_the_paper] * 2},
    }
    with paper_style():
        return _gains([(item, dataset)])


def look(line):
    return tuple(line._unscaled_dash_pattern[1]), line.get_marker()


def test_curves_of_two_laws_differ_by_dashes_and_markers_as_their_legend_does():
    figure = drawn(1.5)
    (legend,) = figure.legends
    named = {line.get_label(): look(line) for line in legend.get_lines() if line.get_label() != RANGE}
    assert named["Existing"][0] != named["Proposed"][0]
    assert named["Existing"][1] != named["Proposed"][1]
    for axis in figure.axes:
        curves = [look(line) for line in axis.lines if line.get_label() != RANGE]
        assert curves == [named["Existing"], named["Proposed"]]


@pytest.mark.parametrize(("largest", "lines"), [(1.5, True), (8000.0, False)])
def test_the_range_of_the_paper_stands_in_the_legend_only_where_it_is_a_line(largest, lines):
    figure = drawn(largest)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert (RANGE in labels) == lines
    assert any(line.get_label() == RANGE for axis in figure.axes for line in axis.lines) == lines
    said = any("paper's figure: to" in text.get_text() for axis in figure.axes for text in axis.texts)
    assert said != lines
