"""Panels of a comparison's figures: one for each joint, the controllers' curves in their colours, axes and legend."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from asmc_pin._typing import Array
from asmc_pin.pages.figure_style import COLUMN, PAGE, fitted, line_look
from asmc_pin.pages.summary_tables import short_names
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_figure

TIME = "Time [s]"


def draw_line(axis: Axes, k: int, color: str, time: Array, values: Array, linewidth: float = 0.9) -> None:
    """The curve of the controller with index k."""
    axis.plot(time, values, **line_look(k, color, len(time)), linewidth=linewidth)


def joint_grid(dataset: xr.Dataset) -> tuple[Figure, list[Axes]]:
    """A panel for each joint: one above the other for few joints, side by side across the page for more."""
    count = dataset.sizes["joint"]
    columns = {1: 1, 2: 1, 3: 1, 4: 2, 5: 3, 6: 3, 9: 3}.get(count, 4)
    rows = -(-count // columns)
    size = (COLUMN if columns == 1 else PAGE, 0.45 + 1.15 * rows)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    axes = list(grid.ravel())
    for axis in axes[count:]:
        axis.remove()
    for i, (axis, name) in enumerate(zip(axes, joint_titles(dataset), strict=False)):
        title_panel(axis, name, 72.0 * size[0] / columns)
        if i + columns >= count:  # nothing below it
            axis.tick_params(labelbottom=True)
        if i // columns == rows - 1:
            axis.set_xlabel(TIME)
    show_whole_run(figure, dataset.time.to_numpy())
    return figure, axes[:count]


def title_panel(axis: Axes, name: str, room: float) -> None:
    """A joint's name above its panel, which has so much of the figure's width, pt, its labels included."""
    text, size = fitted(name, room - 42.0)
    axis.set_title(text, loc="left", fontsize=size)


def joint_titles(dataset: xr.Dataset) -> list[str]:
    """Names of the joints as Matplotlib draws them."""
    return [for_figure(name) for name in short_names(list(dataset.joint.to_numpy()))]


def by_controller(dataset: xr.Dataset, name: str) -> Array:
    """A variable of one trial, shape (controllers, T, nv)."""
    values: Array = dataset[name].transpose("controller", "time", "joint").to_numpy()
    return values


def controllers_of(dataset: xr.Dataset) -> Iterator[tuple[str, str, int]]:
    """Label, colour and index of each controller."""
    labels = [str(label) for label in dataset.controller.to_numpy()]
    colors = controller_colors(labels)
    return ((for_figure(label), colors[label], k) for k, label in enumerate(labels))


def linear_until(values: Array) -> float:
    """Where a symmetric logarithmic axis turns linear: within what the law with the smallest values shows."""
    largest = np.fmax.reduce(np.abs(values), axis=1)
    smallest = np.min(largest[np.isfinite(largest) & (largest > 0.0)], initial=np.inf)
    return float(10.0 ** np.floor(np.log10(smallest))) if np.isfinite(smallest) else 1.0


def symmetric_ticks(view: tuple[float, float], linear: float) -> list[float]:
    """Zero and powers of ten to both sides, so far apart on a symmetric logarithmic axis that five labels fit.

    Zero and the end of the linear part are as far apart as two powers of ten.
    """
    reach = [1.0 + np.log10(max(abs(end) / linear, 0.1)) for end in view]
    apart = max(1, int(np.ceil(sum(reach) / 4.5)))
    sides = [linear * 10.0 ** (np.arange(apart, end + 1e-9, apart) - 1.0) for end in reach]
    return [*(-sides[0][::-1]).tolist(), 0.0, *sides[1].tolist()]


def angle_unit(dataset: xr.Dataset, joint: int) -> tuple[float, str]:
    """Factor on what is in rad (m), and the unit in which a person reads it: deg, or mm of a sliding joint."""
    prismatic = dataset.joint_kind.to_numpy()[joint] == "prismatic"
    return (1e3, "mm") if prismatic else (180.0 / np.pi, "deg")


def finish(figure: Figure, lowest: Array, dataset: xr.Dataset) -> None:
    """Name the time below the lowest panels, show the whole run, and add the legend."""
    for axis in lowest:
        axis.set_xlabel(TIME)
    show_whole_run(figure, dataset.time.to_numpy())
    add_legend(figure, dataset)


def show_whole_run(figure: Figure, time: Array) -> None:
    """From the first sample to the last, in every panel."""
    for axis in figure.axes:
        axis.set_xlim(time[0], time[-1])


def add_legend(figure: Figure, dataset: xr.Dataset) -> None:
    """The controllers, above all panels."""
    lines = [
        Line2D([], [], **line_look(k, color), label=label, linewidth=1.2) for label, color, k in controllers_of(dataset)
    ]
    # So many beside each other as the width has room for: a letter takes some 0.06 inch, a line 0.4.
    longest = max(len(str(line.get_label())) for line in lines)
    columns = int(figure.get_figwidth() // (0.06 * longest + 0.4))
    figure.legend(
        handles=lines, loc="outside upper center", ncols=max(1, min(len(lines), 5, columns)), handlelength=2.6
    )
