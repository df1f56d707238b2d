"""Figures 3 to 8 and 10 to 13 of Baek, Jin, Han (2016), measured; the paper's ranges as dashed lines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from asmc_pin._typing import Array
from asmc_pin.pages.curves import running_max, thinned
from asmc_pin.pages.figure_style import COLUMN, GREY, PAGE, line_look, paper_style, save, shade, shade_sizes
from asmc_pin.reproduction.printed_tables import TUNED_SUFFIX
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_figure

SCHEMES = ("PPC", "BSMC", "Existing", "Proposed")
_TIME = "Time [s]"
_RANGE = "range of the paper's figure"
Pair = Sequence[tuple[Mapping[str, Any], xr.Dataset]]
"""An experiment's figures and trajectories, as printed and as reconciled, or one of them."""


def draw_reproduction(data: Mapping[str, Any], datasets: Mapping[str, xr.Dataset], folder: Path) -> dict[str, str]:
    """Write every figure of the paper that the experiments at hand have, as PDF and PNG.

    Args:
        data: What the page is made from.
        datasets: Trajectories by the names of the experiments.
        folder: Where to; made if need be.

    Returns:
        Caption by the name of the file, in the paper's order.
    """
    folder.mkdir(parents=True, exist_ok=True)
    bases: dict[str, list[tuple[Mapping[str, Any], xr.Dataset]]] = {}
    for name, item in data["experiments"].items():
        bases.setdefault(name.removesuffix("_reconciled"), []).append((item, datasets[name].isel(trial=0)))
    drawn: dict[int, tuple[str, str]] = {}
    with paper_style():
        for pair in bases.values():
            for kind, number in pair[0][0]["figures"].items():
                draw, caption = _KINDS[kind]
                path = folder / f"fig{number:02d}"
                save(draw(pair), path)
                drawn[number] = (path.name, f"Fig. {number}. {caption} {pair[0][0]['title']}.")
    return {name: caption for _, (name, caption) in sorted(drawn.items())}


def shown_labels(dataset: xr.Dataset) -> dict[str, str]:
    """The label that stands for each scheme of the paper: of a law without printed gains the tuned row."""
    labels = [str(label) for label in dataset.controller.to_numpy()]
    found = {}
    for scheme in SCHEMES:
        free = scheme in ("BSMC", "Existing") and scheme + TUNED_SUFFIX in labels
        if scheme in labels:
            found[scheme] = scheme + TUNED_SUFFIX if free else scheme
    return found


def _motion(pair: Pair) -> Figure:
    dataset = pair[0][1]
    figure = Figure(figsize=(COLUMN, 1.5), layout="constrained")
    axis = figure.subplots()
    time = dataset.time.to_numpy()
    for i, style in enumerate(("-", "--")):
        axis.plot(time, np.degrees(dataset.q_ref.to_numpy()[:, i]), "k", linestyle=style, label=f"joint {i + 1}")
    axis.set_ylabel(r"$q_d$ [deg]")
    axis.set_xlabel(_TIME)
    axis.set_xlim(time[0], time[-1])
    figure.legend(loc="outside upper center", ncols=2)
    return figure


def _gains(pair: Pair) -> Figure:
    figure, grid = _grid(pair, 4, 4.7)
    for column, (item, dataset) in enumerate(pair):
        time, of_s, of_gain = dataset.time.to_numpy(), item["scale"]["s"], item["scale"]["gain"]
        unit = "deg" if of_s > 1.0 else "rad"
        schemes = {
            scheme: label for scheme, label in shown_labels(dataset).items() if scheme in ("Existing", "Proposed")
        }
        for scheme, label in schemes.items():
            run = dataset.sel(controller=label)
            for i in range(2):
                gain, s = of_gain * run.gain.to_numpy()[:, i], of_s * run.s.to_numpy()[:, i]
                _plot(grid[i][column], scheme, *thinned(time, gain))
                _plot(grid[2 + i][column], scheme, *thinned(time, s), linewidth=0.6)
                shade(grid[i][column], run, "gain", i, of_gain, _color(scheme))
                shade(grid[2 + i][column], run, "s", i, of_s, _color(scheme))
        for i in range(2):
            _limit(grid[i][column], max(item["paper"]["gain"].values()))
            _limit(grid[2 + i][column], item["paper"]["s"][i], both=True)
            grid[i][column].set_ylim(bottom=0.0)
            grid[i][column].set_ylabel(rf"$\hat{{k}}_{i + 1}$ [{unit}/s$^2$]")
            grid[2 + i][column].set_ylabel(rf"$s_{i + 1}$ [{unit}/s]")
    return _legend(figure, ("Existing", "Proposed"), pair)


def _torques(pair: Pair) -> Figure:
    schemes = list(shown_labels(pair[0][1]))
    figure = Figure(figsize=(PAGE, 0.5 + 2.1 * len(pair)), layout="constrained")
    grid = figure.subplots(2 * len(pair), len(schemes), sharex=True, sharey="row", squeeze=False)
    for block, (item, dataset) in enumerate(pair):
        time = dataset.time.to_numpy()
        for i in range(2):
            row = grid[2 * block + i]
            for column, label in enumerate(shown_labels(dataset).values()):
                torque = dataset.sel(controller=label).torque.to_numpy()[:-1, i]
                row[column].plot(*thinned(time[:-1], torque, 600), color=_color(schemes[column]), linewidth=0.5)
                _limit(row[column], item["paper"]["torque"], both=item["table"] != "III")
                row[column].set_xlim(time[0], time[-1])
                if block == 0 and i == 0:
                    row[column].set_title(for_figure(label))
            row[0].set_ylabel(f"{item['set']}\n" + rf"$\tau_{i + 1}$ [N·m]")
    for axis in grid[-1]:
        axis.set_xlabel(_TIME)
        axis.xaxis.set_major_locator(MaxNLocator(4, prune="upper"))  # or the last number meets the next panel's first
    figure.align_ylabels(grid[:, 0])
    figure.legend(handles=_paper_line(figure), loc="outside upper center")
    return figure


def _errors(pair: Pair) -> Figure:
    figure, grid = _grid(pair, 2, 2.7)
    for column, (item, dataset) in enumerate(pair):
        time, unit = dataset.time.to_numpy(), item["paper"]["unit"]
        to_unit = 1.0 if unit == "rad" else 180.0 / np.pi
        for scheme, label in shown_labels(dataset).items():
            error = np.abs(dataset.q_ref.to_numpy() - dataset.sel(controller=label).q.to_numpy()) * to_unit
            for i in range(2):
                _plot(grid[i][column], scheme, *running_max(time, error[:, i]))
                shade_sizes(grid[i][column], dataset.sel(controller=label), i, to_unit, _color(scheme))
        for i in range(2):
            axis = grid[i][column]
            axis.set_yscale("log")
            axis.minorticks_off()
            _limit(axis, item["paper"]["max_error_deg"][i] * (np.pi / 180.0 if unit == "rad" else 1.0))
            low, high = axis.get_ylim()
            axis.set_ylim(bottom=max(low, 1e-6 * high))
            axis.set_ylabel(rf"$|e_{i + 1}|$ [{unit}]")
    return _legend(figure, tuple(shown_labels(pair[0][1])), pair)


_KINDS: Mapping[str, tuple[Callable[[Pair], Figure], str]] = {
    "motion": (_motion, "The reference, ours inside the paper's range."),
    "gains": (_gains, "Adaptive gains and sliding variable."),
    "torque": (_torques, "Joint torques."),
    "error": (_errors, "Tracking errors, the largest in each of 150 windows."),
}


def _grid(pair: Pair, rows: int, height: float) -> tuple[Figure, Any]:
    figure = Figure(figsize=(PAGE if len(pair) > 1 else COLUMN, height), layout="constrained")
    grid = figure.subplots(rows, len(pair), sharex=True, squeeze=False)
    for column, (item, dataset) in enumerate(pair):
        time = dataset.time.to_numpy()
        grid[0][column].set_title(item["set"])
        grid[-1][column].set_xlabel(_TIME)
        for axis in grid[:, column]:
            axis.set_xlim(time[0], time[-1])
            axis.yaxis.set_label_coords(-0.13, 0.5)
    return figure, grid


def _limit(axis: Axes, value: float, both: bool = False) -> None:
    """The range of the paper's figure: a line, or where it would flatten the curves, words."""
    largest = max((float(np.nanmax(np.abs(line.get_ydata()), initial=0.0)) for line in axis.lines), default=0.0)
    if value > 4.0 * largest:
        text = f"paper's figure: to {'±' if both else ''}{value:g}"
        place: Any = {"transform": axis.transAxes, "ha": "right", "va": "top", "color": GREY, "fontsize": 7.0}
        behind = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
        axis.text(0.98, 0.93, text, bbox=behind, **place)
        return
    for side in (-value, value) if both else (value,):
        axis.axhline(side, color=GREY, linestyle="--", linewidth=0.7, label=_RANGE)


def _plot(axis: Axes, scheme: str, time: Array, values: Array, **look: Any) -> None:
    axis.plot(time, values, **line_look(SCHEMES.index(scheme), _color(scheme), len(time)), **look)


def _color(scheme: str) -> str:
    return controller_colors(SCHEMES)[scheme]


def _paper_line(figure: Figure) -> list[Line2D]:
    """The line of the paper's range for a legend, if it is drawn anywhere."""
    if not any(line.get_label() == _RANGE for axis in figure.axes for line in axis.lines):
        return []
    return [Line2D([], [], color=GREY, linestyle="--", linewidth=0.8, label=_RANGE)]


def _legend(figure: Figure, schemes: Sequence[str], pair: Pair) -> Figure:
    labels = shown_labels(pair[0][1])
    lines = [
        Line2D([], [], label=labels[x], linewidth=1.2, **line_look(SCHEMES.index(x), _color(x)))
        for x in schemes
        if x in labels
    ]
    figure.legend(handles=[*lines, *_paper_line(figure)], loc="outside upper center", ncols=5)
    return figure
