"""Figures of a benchmark: performance profiles and mean ranks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from asmc_pin.pages.benches.bench_findings import BenchFindings
from asmc_pin.pages.figure_style import PAGE, line_look, paper_style
from asmc_pin.pages.plates import Plate
from asmc_pin.statistics.over_tasks import performance_profile
from asmc_pin.words.media import for_figure

_LARGEST = 100.0  # factor up to which profiles are drawn


def bench_plates(findings: BenchFindings) -> Iterator[Plate]:
    """Every figure that these findings have."""
    yield Plate(
        "profiles",
        _profiles(findings),
        "Performance profiles: share of the problems that a law does within a factor of the best law of each. Left "
        "end: how often it is the best; what is missing at the right: failures, and figures beyond.",
    )
    yield Plate(
        "ranks",
        _ranks(findings),
        "Mean rank of each law over the problems, 1 is the best, with its 95 % interval over which problems it might "
        "have been. The proposed law is drawn bold.",
    )


def _profiles(findings: BenchFindings) -> Figure:
    factors = np.geomspace(1.0, _LARGEST, 400)
    shares = performance_profile(findings.figures, factors)
    colours = colormaps["tab10"].colors  # type: ignore[attr-defined]
    with paper_style():
        figure = _empty(3.4)
        ax = figure.subplots()
        for place, k in enumerate(findings.order):
            own = findings.laws[k] == findings.proposed
            look = line_look(place, colours[place % 10], factors.size) | {"linewidth": 2.0 if own else 0.9}
            ax.step(factors, shares[k], where="post", label=for_figure(findings.laws[k]), **look)
        ax.set_xscale("log")
        ax.set_xlim(1.0, _LARGEST)
        ax.set_ylim(-0.02, 1.02)
        ax.set_xlabel("factor of the best law's figure")
        ax.set_ylabel("share of the problems")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def _ranks(findings: BenchFindings) -> Figure:
    with paper_style():
        figure = _empty(0.8 + 0.2 * len(findings.laws))
        ax = figure.subplots()
        for place, k in enumerate(findings.order):
            mean = findings.ranks[k]
            own = findings.laws[k] == findings.proposed
            ax.plot([mean.low, mean.high], [place, place], "-", color="k", lw=2.0 if own else 0.9)
            ax.plot([mean.rank], [place], "o", color="k", ms=6 if own else 4)
        ax.set_yticks(range(len(findings.laws)), [for_figure(findings.laws[k]) for k in findings.order])
        ax.set_ylim(len(findings.laws) - 0.5, -0.5)
        ax.set_xlim(0.5, len(findings.laws) + 0.5)
        ax.set_xlabel("mean rank")
    return figure


def _empty(height: float) -> Figure:
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure
