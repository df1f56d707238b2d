"""Figures of the condition on M̄: the norm's distribution, its maps over pairs of joints, its course along a motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from asmc_pin.condition import ConditionReport, DesignReport
from asmc_pin.condition.search.norm_maps import heatmap, pairs
from asmc_pin.pages.figure_style import COLUMN, GREY, PAGE, paper_style
from asmc_pin.viewer.colours import PALETTE
from asmc_pin.words.media import for_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from asmc_pin.arms import Arm

SYMBOL = {"lemma1": r"$\Vert I - M^{-1}\bar{M}\Vert_2$", "weighted": r"$\max|1 - \lambda(M^{-1}\bar{M})|$"}
LIMIT = PALETTE[3]
COLOURS = "viridis"


def distribution_figure(report: ConditionReport) -> Figure:
    """How often the samples of the box have which norm, with the largest found and the limit of 1."""
    with paper_style():
        figure, axes = _canvas(COLUMN, 2.2)
        values = report.samples[np.isfinite(report.samples)]
        top = max(float(np.quantile(values, 0.995)), min(report.lower, 1.0))
        right = max(top, 1.0) if report.lower < 1.0 else max(top, 1.05)
        if report.lower - right < 0.1 * (right - min(float(values.min()), 1.0)):
            right = max(right, report.lower)  # it lies just beyond, and is to be seen
        axes.hist(np.clip(values, None, right), bins=80, color=PALETTE[0], density=False)
        if report.lower <= right:
            axes.axvline(report.lower, color="#000000", linestyle="--", label=f"largest found, {report.lower:.5g}")
        else:
            axes.plot([], [], color="#000000", linestyle="--", label=f"largest found, {report.lower:.4g}, lies beyond")
        axes.axvline(1.0, color=LIMIT, label="limit of the condition")
        axes.set_xlabel(SYMBOL[report.condition])
        axes.set_ylabel("samples")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2, ncols=2)
    return figure


def along_figure(report: ConditionReport) -> Figure:
    """The norm over time along a motion, or the worst of each slice of a tube."""
    assert report.times is not None
    assert report.norms is not None
    with paper_style():
        figure, axes = _canvas(COLUMN, 2.2)
        step = "post" if report.scope == "tube" else None
        if step:
            axes.step(report.times, report.norms, where="post", color=PALETTE[0])
        else:
            axes.plot(report.times, report.norms, color=PALETTE[0])
        if report.lower > 0.5 * (1.0 + float(report.norms.min())) or report.lower >= 1.0:
            axes.axhline(1.0, color=LIMIT)
        axes.set_xlabel("time (s)")
        axes.set_ylabel(SYMBOL[report.condition])
    return figure


def maps_figure(report: ConditionReport, arm: Arm, *, resolution: int = 61) -> Figure | None:
    """The norm over every pair of joints, the others as in the worst configuration; None where no two are free.

    Args:
        report: Of `arm`.
        arm: The arm of the worst case: with its payload and locks.
        resolution: Values per axis.
    """
    chosen = pairs(arm, report.box)
    if not chosen:
        return None
    options = {"condition": report.condition, "box": report.box, "q": report.worst_q, "armature": report.worst_armature}
    maps = [heatmap(arm, report.mbar, *pair, resolution=resolution, **options) for pair in chosen]  # type: ignore[arg-type]
    low = min(float(np.nanmin(item.norms)) for item in maps)
    high = max(max(float(np.nanmax(item.norms)) for item in maps), report.lower)
    # A violation may reach norms of a hundred: what matters is where the limit is crossed, and how close it is else.
    high = min(high, 1.0 + 2.0 * (1.0 - low)) if low < 1.0 < high else high
    columns = min(len(maps), 4)
    rows = math.ceil(len(maps) / columns)
    with paper_style():
        figure = Figure(figsize=(PAGE, 1.75 * rows + 0.35), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, item in zip(grid.ravel(), maps, strict=False):
            image = axes.pcolormesh(
                item.x, item.y, item.norms, vmin=low, vmax=high, cmap=COLOURS, shading="nearest", rasterized=True
            )
            if float(np.nanmax(item.norms)) > 1.0 > float(np.nanmin(item.norms)):
                axes.contour(item.x, item.y, item.norms, levels=[1.0], colors=[LIMIT], linewidths=0.9)
            axes.plot(*(report.worst_q[arm.joint_names.index(joint)] for joint in item.joints), "x", color=LIMIT, ms=4)
            axes.set_xlabel(for_figure(item.joints[0]))
            axes.set_ylabel(for_figure(item.joints[1]))
            axes.grid(False)
        for axes in grid.ravel()[len(maps) :]:
            axes.set_axis_off()
        figure.colorbar(
            image,
            ax=grid,
            label=SYMBOL[report.condition],
            fraction=0.025,
            extend="max" if report.lower > high else "neither",
        )
    return figure


def _canvas(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#DDDDDD")
    axes.tick_params(color=GREY)
    return figure, axes


def trade_off_figure(report: DesignReport) -> Figure:
    """Norm against λ_min(M⁻¹M̄) of the designs between the two objectives."""
    with paper_style():
        figure, axes = _canvas(COLUMN, 2.2)
        norms = [point.norm for point in report.trade_off]
        speeds = [point.bandwidth for point in report.trade_off]
        axes.plot(speeds, norms, "o-", color=PALETTE[0], ms=3.5)
        axes.axhline(1.0, color=LIMIT)
        axes.annotate("least norm", (speeds[0], norms[0]), textcoords="offset points", xytext=(6, -4))
        end = speeds[-1], norms[-1]
        axes.annotate("largest bandwidth", end, textcoords="offset points", xytext=(-6, 2), ha="right")
        axes.margins(y=0.2)
        axes.set_xlabel(r"$\lambda_{\min}(M^{-1}\bar{M})$, guaranteed")
        axes.set_ylabel(SYMBOL[report.condition])
    return figure
