"""The figures of a comparison, of the kinds that the paper has: reference, gains and s, torques, errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator
from matplotlib.transforms import ScaledTranslation

from asmc_pin._typing import Array
from asmc_pin.pages.comparisons.figure_panels import (
    TIME,
    add_legend,
    angle_unit,
    by_controller,
    controllers_of,
    draw_line,
    finish,
    joint_grid,
    joint_titles,
    linear_until,
    show_whole_run,
    symmetric_ticks,
    title_panel,
)
from asmc_pin.pages.curves import running_max, spread, thinned
from asmc_pin.pages.figure_style import (
    BAND,
    COLUMN,
    GREY,
    PAGE,
    fitted,
    folded,
    paper_style,
    save,
    shade,
    shade_sizes,
)

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
    figure, axes = joint_grid(dataset)
    time = dataset.time.to_numpy()
    for i, axis in enumerate(axes):
        factor, unit = angle_unit(dataset, i)
        axis.plot(*thinned(time, factor * dataset.q_ref.to_numpy()[:, i]), color="black")
        axis.set_ylabel(rf"$q_{{d,{i + 1}}}$ [{unit}]")
    return figure


@_figure(f"Tracking error of every joint. {BAND}")
def errors_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """Tracking error of every joint, all controllers; its size on a logarithmic axis where they are far apart."""
    figure, axes = joint_grid(dataset)
    time = dataset.time.to_numpy()
    error = dataset.q_ref.to_numpy() - by_controller(dataset, "q")
    logarithmic = spread(error) > FAR_APART
    for i, axis in enumerate(axes):
        factor, unit = angle_unit(dataset, i)
        for _, color, k in controllers_of(dataset):
            if logarithmic:
                draw_line(axis, k, color, *running_max(time, factor * np.abs(error[k, :, i])))
                shade_sizes(axis, dataset.isel(controller=k), i, factor, color)
            else:
                draw_line(axis, k, color, *thinned(time, factor * error[k, :, i]))
                shade(axis, dataset.isel(controller=k), "error", i, factor, color)
        if logarithmic:
            axis.set_yscale("log")
            low, high = axis.get_ylim()
            axis.set_ylim(bottom=max(low, 1e-5 * high))  # what starts on the reference starts at 0
        axis.set_ylabel(rf"$|e_{{{i + 1}}}|$ [{unit}]" if logarithmic else rf"$e_{{{i + 1}}}$ [{unit}]")
    add_legend(figure, dataset)
    return figure


@_figure(f"Switching gains and sliding variables. {BAND}")
def gains_and_s_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """Adaptive gain and sliding variable of every joint; gains of the laws that have one."""
    count = dataset.sizes["joint"]
    gains, s = by_controller(dataset, "gain"), by_controller(dataset, "s")
    adaptive = [k for _, _, k in controllers_of(dataset) if np.isfinite(gains[k]).any()]
    columns = 2 if adaptive else 1
    width = PAGE if adaptive else COLUMN
    figure = Figure(figsize=(width, 0.5 + 1.05 * count), layout="constrained")
    axes = figure.subplots(count, columns, sharex=True, squeeze=False)
    time = dataset.time.to_numpy()
    far_apart = spread(s) > FAR_APART
    for i, name in enumerate(joint_titles(dataset)):
        title_panel(axes[i, 0], name, 72.0 * width / columns)
        metre = "m" if dataset.joint_kind.to_numpy()[i] == "prismatic" else "rad"
        for _, color, k in controllers_of(dataset):
            draw_line(axes[i, -1], k, color, *thinned(time, s[k, :, i]), linewidth=0.6)
            shade(axes[i, -1], dataset.isel(controller=k), "s", i, 1.0, color)
            if k in adaptive:
                draw_line(axes[i, 0], k, color, *thinned(time, gains[k, :, i]))
                shade(axes[i, 0], dataset.isel(controller=k), "gain", i, 1.0, color)
        axes[i, -1].set_ylabel(rf"$s_{{{i + 1}}}$ [{metre}/s]")
        if adaptive:
            axes[i, 0].set_ylabel(rf"$\hat{{k}}_{{{i + 1}}}$ [{metre}/s$^2$]")
            axes[i, 0].set_ylim(bottom=0.0)
            axes[i, 0].yaxis.set_label_coords(-0.12, 0.5)
        axes[i, -1].yaxis.set_label_coords(-0.15, 0.5)
        if far_apart:
            linear = linear_until(s[:, :, i])
            axes[i, -1].set_yscale("symlog", linthresh=linear)
            axes[i, -1].yaxis.set_major_locator(FixedLocator(symmetric_ticks(axes[i, -1].get_ylim(), linear)))
    finish(figure, axes[-1], dataset)
    return figure


@_figure(f"Torque of every joint, after the drive's limits. {BAND}")
def torques_figure(dataset: xr.Dataset, limit: Array) -> Figure:
    """Torque of every joint (rows) under every controller (columns), with the limit where it is near."""
    count, controllers = dataset.sizes["joint"], list(controllers_of(dataset))
    figure = Figure(figsize=(PAGE, 0.45 + 1.05 * count), layout="constrained")
    axes = figure.subplots(count, len(controllers), sharex=True, sharey="row", squeeze=False)
    time, torque = dataset.time.to_numpy(), by_controller(dataset, "torque")
    for i, name in enumerate(joint_titles(dataset)):
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
    show_whole_run(figure, time)
    return figure
