"""The figures of a comparison, of the kinds that the paper has: reference, gains and s, torques, errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator
from matplotlib.transforms import ScaledTranslation

from asmc_pin._typing import Array
from asmc_pin.pages.curves import running_max, spread, thinned
from asmc_pin.pages.figure_style import (
    BAND,
    COLUMN,
    GREY,
    PAGE,
    fitted,
    folded,
    line_look,
    paper_style,
    save,
    shade,
    shade_sizes,
)
from asmc_pin.pages.summary_tables import short_names
from asmc_pin.viewer.colours import controller_colors
from asmc_pin.words.media import for_figure

TIME = "Time [s]"
FAR_APART = 15.0
"""From this ratio on between the laws' RMS values a linear axis would show the largest only."""


_Draw = Callable[[xr.Dataset, Array], Figure]


class Drawing(NamedTuple):
    """One figure of a comparison.

    Attributes:
        caption: What it shows.
        draw: Draws it from one trial, with the bands of all where there are such, and the torque limits, shape (nv,),
            N·m.
    """

    caption: str
    draw: _Draw


_REGISTRY: dict[str, Drawing] = {}
FIGURES: Mapping[str, Drawing] = MappingProxyType(_REGISTRY)
"""The figures by the names of their files, in the order of the report."""


def _figure(caption: str) -> Callable[[_Draw], _Draw]:
    """Make a function one of the figures, under its name without ``_figure``; they are drawn in the order below."""

    def register(draw: _Draw) -> _Draw:
        _REGISTRY[draw.__name__.removesuffix("_figure")] = Drawing(caption, draw)
        return draw

    return register


def draw_figures(dataset: xr.Dataset, folder: Path, effort_limit: Array | None = None) -> list[Path]:
    """Write every figure as PDF and PNG.

    Args:
        dataset: Trajectories; the first trial is shown, and the band of all trials.
        folder: Where to; made if need be.
        effort_limit: Torque limits, shape (nv,), N·m; infinite where there is none.

    Returns:
        The PNG files, in the order of `FIGURES`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    limit = np.full(dataset.sizes["joint"], np.inf) if effort_limit is None else np.asarray(effort_limit)
    limit = np.broadcast_to(limit, (dataset.sizes["joint"],))
    paths = []
    with paper_style():
        for name, drawing in FIGURES.items():
            save(drawing.draw(dataset.isel(trial=0), limit), folder / name)
            paths.append(folder / f"{name}.png")
    return paths


@_figure("The motion to follow: desired positions of the joints.")
def reference_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """The desired motion of every joint."""
    figure, axes = _joint_grid(dataset)
    time = dataset.time.to_numpy()
    for i, axis in enumerate(axes):
        factor, unit = _angle(dataset, i)
        axis.plot(*thinned(time, factor * dataset.q_ref.to_numpy()[:, i]), color="black")
        axis.set_ylabel(rf"$q_{{d,{i + 1}}}$ [{unit}]")
    return figure


@_figure(f"Tracking error of every joint. {BAND}")
def errors_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """Tracking error of every joint, all controllers; its size on a logarithmic axis where they are far apart."""
    figure, axes = _joint_grid(dataset)
    time = dataset.time.to_numpy()
    error = dataset.q_ref.to_numpy() - _by_controller(dataset, "q")
    logarithmic = spread(error) > FAR_APART
    for i, axis in enumerate(axes):
        factor, unit = _angle(dataset, i)
        for _, color, k in _controllers(dataset):
            if logarithmic:
                _line(axis, k, color, *running_max(time, factor * np.abs(error[k, :, i])))
                shade_sizes(axis, dataset.isel(controller=k), i, factor, color)
            else:
                _line(axis, k, color, *thinned(time, factor * error[k, :, i]))
                shade(axis, dataset.isel(controller=k), "error", i, factor, color)
        if logarithmic:
            axis.set_yscale("log")
            low, high = axis.get_ylim()
            axis.set_ylim(bottom=max(low, 1e-5 * high))  # what starts on the reference starts at 0
        axis.set_ylabel(rf"$|e_{{{i + 1}}}|$ [{unit}]" if logarithmic else rf"$e_{{{i + 1}}}$ [{unit}]")
    _legend(figure, dataset)
    return figure


@_figure(f"Switching gains and sliding variables. {BAND}")
def gains_and_s_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """Adaptive gain and sliding variable of every joint; gains of the laws that have one."""
    count = dataset.sizes["joint"]
    gains, s = _by_controller(dataset, "gain"), _by_controller(dataset, "s")
    adaptive = [k for _, _, k in _controllers(dataset) if np.isfinite(gains[k]).any()]
    columns = 2 if adaptive else 1
    width = PAGE if adaptive else COLUMN
    figure = Figure(figsize=(width, 0.5 + 1.05 * count), layout="constrained")
    axes = figure.subplots(count, columns, sharex=True, squeeze=False)
    time = dataset.time.to_numpy()
    far_apart = spread(s) > FAR_APART
    for i, name in enumerate(_titles(dataset)):
        _title(axes[i, 0], name, 72.0 * width / columns)
        metre = "m" if dataset.joint_kind.to_numpy()[i] == "prismatic" else "rad"
        for _, color, k in _controllers(dataset):
            _line(axes[i, -1], k, color, *thinned(time, s[k, :, i]), linewidth=0.6)
            shade(axes[i, -1], dataset.isel(controller=k), "s", i, 1.0, color)
            if k in adaptive:
                _line(axes[i, 0], k, color, *thinned(time, gains[k, :, i]))
                shade(axes[i, 0], dataset.isel(controller=k), "gain", i, 1.0, color)
        axes[i, -1].set_ylabel(rf"$s_{{{i + 1}}}$ [{metre}/s]")
        if adaptive:
            axes[i, 0].set_ylabel(rf"$\hat{{k}}_{{{i + 1}}}$ [{metre}/s$^2$]")
            axes[i, 0].set_ylim(bottom=0.0)
            axes[i, 0].yaxis.set_label_coords(-0.12, 0.5)
        axes[i, -1].yaxis.set_label_coords(-0.15, 0.5)
        if far_apart:
            linear = _linear_until(s[:, :, i])
            axes[i, -1].set_yscale("symlog", linthresh=linear)
            axes[i, -1].yaxis.set_major_locator(FixedLocator(_symmetric_ticks(axes[i, -1].get_ylim(), linear)))
    _finish(figure, axes[-1], dataset)
    return figure


@_figure(f"Torque of every joint, after the drive's limits. {BAND}")
def torques_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """Torque of every joint (rows) under every controller (columns), with the limit where it is near."""
    count, controllers = dataset.sizes["joint"], list(_controllers(dataset))
    figure = Figure(figsize=(PAGE, 0.45 + 1.05 * count), layout="constrained")
    axes = figure.subplots(count, len(controllers), sharex=True, sharey="row", squeeze=False)
    time, torque = dataset.time.to_numpy(), _by_controller(dataset, "torque")
    for i, name in enumerate(_titles(dataset)):
        unit = "N" if dataset.joint_kind.to_numpy()[i] == "prismatic" else "N·m"
        largest = np.fmax.reduce(np.abs(torque[:, :, i]), axis=None)
        for label, color, k in controllers:
            axis = axes[i, k]
            axis.plot(*thinned(time[:-1], torque[k, :-1, i], points=600), color=color, linewidth=0.5)
            shade(axis, dataset.isel(controller=k), "torque", i, 1.0, color)
            if largest > 0.6 * limit[i]:
                for side in (-limit[i], limit[i]):
                    axis.axhline(side, color=GREY, linestyle="--", linewidth=0.6)
            if i == 0:
                text, size = fitted(label, 72.0 * PAGE / len(controllers) - 14.0)
                axis.set_title(text, fontsize=size)
        lines = [fitted(line, 66.0) for line in folded(name).split("\n")]  # a panel is some 70 pt high
        said = "\n".join(line for line, _ in lines) + "\n" + rf"$\tau_{{{i + 1}}}$ [{unit}]"
        axes[i, 0].set_ylabel(said, fontsize=min(size for _, size in lines))
        # One below the other, beside figures of five signs; aligning them afterwards costs seconds.
        beside = ScaledTranslation(-27.0 / 72.0, 0.0, figure.dpi_scale_trans)
        axes[i, 0].yaxis.set_label_coords(0.0, 0.5, transform=axes[i, 0].transAxes + beside)
    for axis in axes[-1]:
        axis.set_xlabel(TIME)
    _whole_run(figure, time)
    return figure


def _line(axis: Axes, k: int, color: str, time: Array, values: Array, linewidth: float = 0.9) -> None:
    axis.plot(time, values, **line_look(k, color, len(time)), linewidth=linewidth)


def _joint_grid(dataset: xr.Dataset) -> tuple[Figure, list[Axes]]:
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
    for i, (axis, name) in enumerate(zip(axes, _titles(dataset), strict=False)):
        _title(axis, name, 72.0 * size[0] / columns)
        if i + columns >= count:  # nothing below it
            axis.tick_params(labelbottom=True)
        if i // columns == rows - 1:
            axis.set_xlabel(TIME)
    _whole_run(figure, dataset.time.to_numpy())
    return figure, axes[:count]


def _title(axis: Axes, name: str, room: float) -> None:
    """A joint's name above its panel, which has so much of the figure's width, pt, its labels included."""
    text, size = fitted(name, room - 42.0)
    axis.set_title(text, loc="left", fontsize=size)


def _titles(dataset: xr.Dataset) -> list[str]:
    return [for_figure(name) for name in short_names(list(dataset.joint.to_numpy()))]


def _by_controller(dataset: xr.Dataset, name: str) -> Array:
    values: Array = dataset[name].transpose("controller", "time", "joint").to_numpy()
    return values


def _controllers(dataset: xr.Dataset) -> Iterator[tuple[str, str, int]]:
    """Label, colour and index of each controller."""
    labels = [str(label) for label in dataset.controller.to_numpy()]
    colors = controller_colors(labels)
    return ((for_figure(label), colors[label], k) for k, label in enumerate(labels))


def _linear_until(values: Array) -> float:
    """Where a symmetric logarithmic axis turns linear: within what the law with the smallest values shows."""
    largest = np.fmax.reduce(np.abs(values), axis=1)
    smallest = np.min(largest[np.isfinite(largest) & (largest > 0.0)], initial=np.inf)
    return float(10.0 ** np.floor(np.log10(smallest))) if np.isfinite(smallest) else 1.0


def _symmetric_ticks(view: tuple[float, float], linear: float) -> list[float]:
    """Zero and powers of ten to both sides, so far apart on a symmetric logarithmic axis that five labels fit.

    Zero and the end of the linear part are as far apart as two powers of ten.
    """
    reach = [1.0 + np.log10(max(abs(end) / linear, 0.1)) for end in view]
    apart = max(1, int(np.ceil(sum(reach) / 4.5)))
    sides = [linear * 10.0 ** (np.arange(apart, end + 1e-9, apart) - 1.0) for end in reach]
    return [*(-sides[0][::-1]).tolist(), 0.0, *sides[1].tolist()]


def _angle(dataset: xr.Dataset, joint: int) -> tuple[float, str]:
    prismatic = dataset.joint_kind.to_numpy()[joint] == "prismatic"
    return (1e3, "mm") if prismatic else (180.0 / np.pi, "deg")


def _finish(figure: Figure, lowest: Array, dataset: xr.Dataset) -> None:
    for axis in lowest:
        axis.set_xlabel(TIME)
    _whole_run(figure, dataset.time.to_numpy())
    _legend(figure, dataset)


def _whole_run(figure: Figure, time: Array) -> None:
    for axis in figure.axes:
        axis.set_xlim(time[0], time[-1])


def _legend(figure: Figure, dataset: xr.Dataset) -> None:
    lines = [
        Line2D([], [], **line_look(k, color), label=label, linewidth=1.2) for label, color, k in _controllers(dataset)
    ]
    # So many beside each other as the width has room for: a letter takes some 0.06 inch, a line 0.4.
    longest = max(len(str(line.get_label())) for line in lines)
    columns = int(figure.get_figwidth() // (0.06 * longest + 0.4))
    figure.legend(
        handles=lines, loc="outside upper center", ncols=max(1, min(len(lines), 5, columns)), handlelength=2.6
    )
