"""Figures of a sweep: distributions over the trials, how far scans came, and figures against what was drawn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter, NullLocator

from asmc_pin._typing import Array
from asmc_pin.experiment.variation.key_units import unit_of_key
from asmc_pin.metrics import METRICS
from asmc_pin.pages.figure_style import PAGE, dot_look, line_look, paper_style
from asmc_pin.pages.plates import Plate
from asmc_pin.pages.sweeps.sweep_findings import SweepFindings
from asmc_pin.pages.sweeps.sweep_tables import unit_of
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_figure

_MOST_DOTS = 2000
_STEPS = 400  # of a curve of shares, so that a figure of 100,000 trials is no larger than one of 100


def sweep_plates(findings: SweepFindings) -> Iterator[Plate]:
    """Every figure that these findings have."""
    yield Plate(
        "distributions",
        _distributions(findings),
        "Share of the trials with at most this figure. A curve that ends below 1 has failures; further left is better.",
    )
    if findings.fails_at:
        yield Plate("failures", _failures(findings), "Share of the trials that have not failed yet along each scan.")
    if findings.drawn and findings.draws > 2:
        yield Plate(
            "dependence",
            _dependence(findings),
            "Figure of each trial against what was drawn in it; a run that failed stands as a cross on the upper edge.",
        )


def _distributions(findings: SweepFindings) -> Figure:
    with paper_style():
        figure = _empty(2.5)
        axes = _row(figure, len(findings.scores))
        for ax, (name, by_label) in zip(axes, findings.scores.items(), strict=True):
            for k, (label, colour) in enumerate(controller_colors(findings.labels).items()):
                _shares(ax, by_label[label].ravel(), label, k, colour)
            ax.set_xscale("log")
            label_decades(ax.xaxis)
            ax.set_xlabel(for_figure(f"{METRICS[name].title} [{unit_of(findings, name)}]"))
            ax.set_ylim(0.0, 1.02)
        _finish(figure, axes, "Share of trials")
    return figure


def label_decades(axis: Axis) -> None:
    """Labels on a logarithmic axis: powers of ten, or a few round figures where fewer than two of them are in view."""
    low, high = axis.get_view_interval()
    if np.floor(np.log10(high)) - np.ceil(np.log10(low)) < 1.0:
        axis.set_major_locator(FixedLocator(_round_figures(low, high)))
        axis.set_major_formatter(FuncFormatter(lambda value, _position: f"{value:g}"))
        axis.set_minor_locator(NullLocator())
    else:
        axis.set_minor_formatter(NullFormatter())


def _round_figures(low: float, high: float) -> list[float]:
    """Two to four figures from low to high, which are less than two decades apart."""
    decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)))
    for factors in ((1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)):
        inside = [float(x) for x in np.outer(decades, factors).ravel() if low <= x <= high]
        if len(inside) > 1:
            return inside
    return [float(x) for x in MaxNLocator(3).tick_values(low, high) if low <= x <= high]


def _shares(ax: Axes, values: Array, label: str, place: int, colour: str) -> None:
    ordered = np.sort(values)
    share = np.arange(1, ordered.size + 1) / ordered.size
    finite = np.isfinite(ordered)
    x, y = ordered[finite], share[finite]
    kept = np.unique(np.linspace(0, x.size - 1, min(x.size, _STEPS)).astype(int)) if x.size else np.empty(0, dtype=int)
    # Up from 0 at the smallest, so that a curve of few trials is whole.
    ax.step(
        [*x[:1], *x[kept]],
        [*np.zeros_like(x[:1]), *y[kept]],
        where="post",
        label=for_figure(label),
        **line_look(place, colour, x.size + 1),
    )


def _failures(findings: SweepFindings) -> Figure:
    with paper_style():
        figure = _empty(2.5)
        axes = _row(figure, len(findings.fails_at))
        scans = {axis.path: axis for axis in findings.experiment.variation.scans}
        for ax, (path, by_label) in zip(axes, findings.fails_at.items(), strict=True):
            start, end = scans[path].scan or (0.0, 1.0)
            colours = controller_colors(findings.labels)
            for k, (label, ends) in enumerate(by_label.items()):
                way = np.sort(np.abs(ends - start))  # a scan may run downwards
                share = 1.0 - np.arange(1, way.size + 1) / way.size
                finite = np.isfinite(way)
                x = start + np.sign(end - start) * way[finite]
                left = [1.0, *share[finite]]
                xs = np.array([start, *x, end])
                ax.step(
                    xs,
                    [*left, left[-1]],
                    where="post",
                    label=for_figure(label),
                    **line_look(k, colours[label], xs.size),
                )
            ax.set_xlim(start, end)
            ax.set_ylim(-0.02, 1.04)
            ax.set_xlabel(for_figure(_axis_words(findings, path)))
        _finish(figure, axes, "Share without failure")
    return figure


def _dependence(findings: SweepFindings) -> Figure:
    names, drawn = list(findings.scores), dict(list(findings.drawn.items())[:4])
    with paper_style():
        figure = _empty(0.6 + 1.7 * len(names))
        grid = np.atleast_2d(figure.subplots(len(names), len(drawn), sharey="row", sharex="col", squeeze=False))
        for row, name in enumerate(names):
            for column, (path, at) in enumerate(drawn.items()):
                ax = grid[row, column]
                every = np.concatenate([x.ravel() for x in findings.scores[name].values()])
                top = float(np.max(every[np.isfinite(every)], initial=1e-300)) * 1.5
                for k, (label, colour) in enumerate(controller_colors(findings.labels).items()):
                    values = findings.scores[name][label]
                    x = np.repeat(at[:, None], values.shape[1], axis=1).ravel()[:_MOST_DOTS]
                    y = values.ravel()[:_MOST_DOTS]
                    over = np.isinf(y)
                    ax.plot(x[~over], y[~over], label=for_figure(label), rasterized=True, **dot_look(k, colour))
                    ax.plot(x[over], np.full(int(over.sum()), top), "x", ms=3.0, color=colour, rasterized=True)
                ax.set_yscale("log")
                label_decades(ax.yaxis)
                if row == len(names) - 1:
                    ax.set_xlabel(for_figure(_axis_words(findings, path)))
                if column == 0:
                    ax.set_ylabel(f"{for_figure(METRICS[name].title)}\n[{for_figure(unit_of(findings, name))}]")
        _finish(figure, list(grid.ravel()), None)
    return figure


def _axis_words(findings: SweepFindings, path: str) -> str:
    """What varies along an axis, with its unit."""
    varied = next(axis for axis in findings.experiment.variation.axes if axis.path == path)
    if varied.factor:
        return f"factor on {path}"
    unit = unit_of_key(findings.experiment.variation.data, varied.parts)
    return f"{path} [{unit}]" if unit else path


def _empty(height: float) -> Figure:
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _row(figure: Figure, count: int) -> list[Axes]:
    return list(figure.subplots(1, count, sharey=True, squeeze=False)[0])


def _finish(figure: Figure, axes: list[Axes], ylabel: str | None) -> None:
    if ylabel is not None:
        axes[0].set_ylabel(ylabel)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=min(len(names), 6))
