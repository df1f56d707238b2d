"""Figures of a tuning: error against chatter, how the search converged, and what each gain does about the winner."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from asmc_pin.metrics import METRICS
from asmc_pin.pages.figure_style import PAGE, line_look, paper_style
from asmc_pin.pages.plates import Plate
from asmc_pin.pages.sweeps.sweep_figures import label_decades
from asmc_pin.pages.sweeps.sweep_tables import unit_on
from asmc_pin.pages.tunings.tune_findings import TuneFindings
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_figure

_COLUMNS = 3
_TICKS = (0.25, 0.5, 1.0, 2.0, 4.0)


def tune_plates(findings: TuneFindings) -> Iterator[Plate]:
    """Every figure that these findings have."""
    yield Plate(
        "pareto",
        _pareto(findings),
        "Error against chatter on the training draws: every candidate, and joined those that no other candidate of the "
        "controller beats in both. Ring: the one that won. Cross: over a limit. Candidates that failed are not drawn.",
    )
    yield Plate(
        "convergence",
        _convergence(findings),
        "Least error among the candidates within the limits so far; a curve begins with the first of them.",
    )
    if any(item.sensitivity for item in findings.controllers):
        yield Plate(
            "sensitivity",
            _sensitivity(findings),
            "Error over the winner's when one gain alone is multiplied, on the training draws; limits are left aside, "
            "so less error may cost more chatter. Runs of this figure were made after the search and could not win. A "
            "line that ends has failed beyond, or the law takes no more.",
        )


def _named(findings: TuneFindings) -> tuple[str, str]:
    objective = findings.experiment.tune.objective
    error = f"{METRICS[objective].title} [{unit_on(findings.kinds, objective)}]"
    return for_figure(error), for_figure(
        f"{METRICS['torque_variation'].title} [{unit_on(findings.kinds, 'torque_variation')}]"
    )


def _pareto(findings: TuneFindings) -> Figure:
    error, chatter = _named(findings)
    with paper_style():
        figure = _empty(3.2)
        ax = figure.subplots()
        colours = controller_colors([item.shown for item in findings.controllers])
        for k, item in enumerate(findings.controllers):
            colour = colours[item.shown]
            known = np.isfinite(item.errors) & np.isfinite(item.chatters)
            for kept, mark in ((known & item.within, "."), (known & ~item.within, "x")):
                ax.plot(item.chatters[kept], item.errors[kept], mark, ms=2.5, color=colour, alpha=0.6)
            front = [i for i in item.front() if known[i]]
            look = line_look(k, colour, len(front))
            ax.plot(item.chatters[front], item.errors[front], label=for_figure(item.shown), **look)
            if known[item.winner]:
                ax.plot(
                    item.chatters[item.winner], item.errors[item.winner], "o", ms=6, mfc="none", color=colour, mew=1.2
                )
        _log(ax, "both")
        ax.set_xlabel(chatter)
        ax.set_ylabel(error)
        _legend(figure, ax)
    return figure


def _convergence(findings: TuneFindings) -> Figure:
    with paper_style():
        figure = _empty(2.6)
        ax = figure.subplots()
        colours = controller_colors([item.shown for item in findings.controllers])
        for k, item in enumerate(findings.controllers):
            least = item.convergence()
            finite = np.isfinite(least)
            number = np.arange(1, len(least) + 1)
            look = line_look(k, colours[item.shown], int(finite.sum()))
            ax.step(number[finite], least[finite], where="post", label=for_figure(item.shown), **look)
        _log(ax, "y")
        ax.set_xlim(1, max(2, findings.budget))
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        ax.set_xlabel("candidates tried")
        ax.set_ylabel(_named(findings)[0])
        _legend(figure, ax)
    return figure


def _sensitivity(findings: TuneFindings) -> Figure:
    shown = [item for item in findings.controllers if item.sensitivity]
    rows = math.ceil(len(shown) / _COLUMNS)
    with paper_style():
        figure = _empty(0.4 + 2.0 * rows)
        grid = figure.subplots(rows, min(_COLUMNS, len(shown)), squeeze=False)
        for ax in grid.ravel()[len(shown) :]:
            ax.set_visible(False)
        for ax, item in zip(grid.ravel(), shown, strict=False):
            for k, (name, (factors, ratios)) in enumerate(item.sensitivity.items()):
                finite = np.isfinite(ratios)
                ax.plot(factors[finite], ratios[finite], label=for_figure(name), **line_look(k, f"C{k}", 1))
            _log(ax, "both")
            ax.set_xticks(_TICKS, [f"{x:g}" for x in _TICKS])
            ax.xaxis.set_minor_formatter(NullFormatter())
            ax.set_title(for_figure(item.shown))
            ax.legend(fontsize=6, ncols=2)
            ax.set_xlabel("factor on the gain")
        for row in grid:
            row[0].set_ylabel("error over the winner's")
    return figure


def _empty(height: float) -> Figure:
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _log(ax: Axes, which: str) -> None:
    """Logarithmic axes, where there is something to draw."""
    if ax.lines and any(np.size(line.get_xdata()) for line in ax.lines):
        if which == "both":
            ax.set_xscale("log")
            label_decades(ax.xaxis)
        ax.set_yscale("log")
        label_decades(ax.yaxis)


def _legend(figure: Figure, ax: Axes) -> None:
    handles, names = ax.get_legend_handles_labels()
    if handles:
        figure.legend(handles, names, loc="outside upper center", ncols=min(len(names), 6))
