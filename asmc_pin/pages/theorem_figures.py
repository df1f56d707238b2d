"""The figure of the theorems: Lemma 1's norm, the TDE error and its contraction; gains, V, (16) and ‖s‖ of each law."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from asmc_pin._typing import Array, BoolArray
from asmc_pin.pages.curves import running_max, thinned
from asmc_pin.pages.figure_style import GREY, PAGE, line_look, paper_style, save
from asmc_pin.viewer.colours import PALETTE, controller_colors
from asmc_pin.words.media import for_figure

NAME = "theorems"
CAPTION = (
    "The paper's theorems: Lemma 1's norm, the TDE error, and its largest ratio from tick to tick (dotted: what "
    "I − M⁻¹M̄ alone leaves of it); of each law that Theorem 1 speaks of, its gains with their bound, V of (12) and "
    "V̇ + β‖s‖² (orange where (16) is broken), and ‖s‖ with its bound."
)
TIME = "Time [s]"
BROKEN = "#D55E00"


def draw_theorems(monitors: xr.Dataset, folder: Path) -> Path | None:
    """Write the figure as PDF and PNG.

    Args:
        monitors: See `asmc_pin.monitors.monitor_dataset`; the first trial is shown.
        folder: Where to; made if need be.

    Returns:
        The PNG file; None where no law has an M̄, so that there is nothing to show.
    """
    if not np.isfinite(monitors.lemma1_norm.to_numpy()).any():
        return None
    folder.mkdir(parents=True, exist_ok=True)
    with paper_style():
        save(theorem_figure(monitors.isel(trial=0)), folder / NAME)
    return folder / f"{NAME}.png"


def theorem_figure(monitors: xr.Dataset) -> Figure:
    """The figure of one trial; dimensions controller, time, joint."""
    labels = [str(label) for label in monitors.controller.to_numpy()]
    colors = controller_colors(labels)
    known = [label for label in labels if np.isfinite(monitors.lemma1_norm.sel(controller=label)).any()]
    proved = [label for label in labels if np.isfinite(monitors.lyapunov.sel(controller=label)).any()]
    figure = Figure(figsize=(PAGE, 2.2 + 3.3 * len(proved)), layout="constrained")
    shared, *own = figure.subfigures(1 + len(proved), 1, squeeze=False, height_ratios=[2.2, *[3.3] * len(proved)])[:, 0]
    _shared_panels(shared.subplots(1, 3), monitors, known, colors)
    for part, label in zip(own, proved, strict=True):
        one = monitors.sel(controller=label)
        part.suptitle(for_figure(label), x=0.02, ha="left", color=colors[label], fontsize=8.0)
        _own_panels(part.subplots(2, 2), one)
        joints = [
            Line2D([], [], label=f"joint {i + 1}", **line_look(i, _joint_color(i))) for i in range(one.sizes["joint"])
        ]
        part.legend(handles=joints, loc="outside upper right", ncols=len(joints), fontsize=6.5)
    for axis in figure.axes:
        axis.set_xlim(monitors.time[0], monitors.time[-1])
        axis.set_xlabel(TIME)
    lines = [
        Line2D([], [], **line_look(labels.index(label), colors[label]), label=for_figure(label), linewidth=1.2)
        for label in known
    ]
    shared.legend(handles=lines, loc="outside upper center", ncols=min(len(lines), 5))
    return figure


def _shared_panels(axes: Array, monitors: xr.Dataset, labels: list[str], colors: dict[str, str]) -> None:
    time = monitors.time.to_numpy()
    places = {str(label): k for k, label in enumerate(monitors.controller.to_numpy())}

    def line(axis: Axes, label: str, when: Array, values: Array) -> None:
        axis.plot(when, values, **line_look(places[label], colors[label], len(when)))

    for label in labels:
        one = monitors.sel(controller=label)
        line(axes[0], label, *thinned(time, one.lemma1_norm.to_numpy()))
        size = np.sqrt(np.sum(one.tde_error.to_numpy() ** 2, axis=1))
        line(axes[1], label, *running_max(time, size))
        # The largest of each window, as the claim is about every tick; what (I − M⁻¹M̄) leaves of N is the dotted one.
        line(axes[2], label, *_positive(*running_max(time, _ratio(size))))
        carried = running_max(time, one.tde_carried.to_numpy())
        axes[2].plot(*_positive(*carried), color=colors[label], linestyle=":", linewidth=0.7)
    axes[0].axhline(1.0, color=GREY, linestyle="--", linewidth=0.6)
    axes[0].set_ylabel(r"Lemma 1: $\|I - M^{-1}\bar{M}\|_2$")
    axes[1].set_yscale("log")
    axes[1].set_ylabel(r"TDE error $\|N\|_2$ [rad/s$^2$]")
    axes[2].axhline(1.0, color=GREY, linestyle="--", linewidth=0.6)
    axes[2].set_yscale("log")
    axes[2].set_ylabel(r"$\|N_k\|_2\,/\,\|N_{k-1}\|_2$")


def _own_panels(axes: Array, one: xr.Dataset) -> None:
    """k̂ with its bound, V of (12), what breaks (16), and ‖s‖₂ with bound (21), of one controller."""
    time = one.time.to_numpy()
    (gains, lyapunov), (decrease, size) = axes
    for i in range(one.sizes["joint"]):
        middle, largest = running_max(time, one.gain.to_numpy()[:, i])
        gains.plot(*_positive(middle, largest), **line_look(i, _joint_color(i), len(middle)))
        bound = thinned(time, one.gain_bound.to_numpy()[:, i])
        gains.plot(*bound, color=_joint_color(i), linestyle=":", linewidth=0.7)
    gains.set_yscale("log")
    gains.set_ylabel(r"$\hat{k}_i$, bound dotted [rad/s$^2$]")
    _lyapunov(lyapunov, time, one)
    _violations(decrease, time, one)
    size.plot(*running_max(time, one.s_norm.to_numpy()), color="black")
    size.axhline(float(one.s_bound), color=GREY, linestyle="--", linewidth=0.8)
    if np.isfinite(one.t_eps):
        size.axvline(float(one.t_eps), color=GREY, linestyle=":", linewidth=0.8)
    size.set_yscale("log")
    size.set_ylabel(r"$\|s\|_2$, bound (21) dashed [rad/s]")


def _joint_color(joint: int) -> str:
    return PALETTE[joint % len(PALETTE)]


def _positive(time: Array, values: Array) -> tuple[Array, Array]:
    """The curve with gaps where a logarithmic axis has no place for it."""
    return time, np.where(values > 0.0, values, np.nan)


def _ratio(size: Array) -> Array:
    """‖N_k‖/‖N_{k−1}‖, shape (T,); NaN at the first tick and where N was round-off of the largest."""
    ratio = np.full_like(size, np.nan)
    least = 1e-9 * np.max(size, initial=0.0, where=np.isfinite(size))
    np.divide(size[1:], size[:-1], out=ratio[1:], where=size[:-1] > least)
    return ratio


def _excess(one: xr.Dataset) -> tuple[Array, BoolArray]:
    """V̇ + β‖s‖² where (16) speaks of it, else NaN, and where (16) is broken; both of shape (T,)."""
    excess = np.where(one.claimed.to_numpy() > 0.0, one.excess.to_numpy(), np.nan)
    return excess, excess > 0.0


def _lyapunov(axis: Axes, time: Array, one: xr.Dataset) -> None:
    value = one.lyapunov.to_numpy()
    axis.plot(*thinned(time, value), color="black")
    _, over = _excess(one)
    axis.plot(time[over], value[over], ".", color=BROKEN, markersize=2.0, rasterized=True)
    positive = value[value > 0.0]
    if positive.size and positive.max() > 100.0 * positive.min():
        axis.set_yscale("log")
    axis.set_ylabel(r"$V$ of (12) [rad$^2$/s$^2$]")


def _violations(axis: Axes, time: Array, one: xr.Dataset) -> None:
    claimed = one.claimed.to_numpy() > 0.0
    excess, over = _excess(one)
    axis.set_ylabel(r"$\dot{V} + \beta\|s\|^2$ [rad$^2$/s$^3$]")
    if not claimed.any():
        axis.text(0.5, 0.5, r"$\|s\|_\infty < \varepsilon$ throughout", transform=axis.transAxes, ha="center")
        return
    axis.plot(time[claimed & ~over], excess[claimed & ~over], ".", color=GREY, markersize=1.0, rasterized=True)
    axis.plot(time[over], excess[over], ".", color=BROKEN, markersize=2.0, rasterized=True)
    axis.set_yscale("symlog", linthresh=max(_linear_until(excess[claimed]), 1e-12))
    axis.axhline(0.0, color="black", linewidth=0.6)


def _linear_until(values: Array) -> float:
    """Where a symmetric logarithmic axis turns linear: three decades below the largest value."""
    largest = np.max(np.abs(values), initial=0.0, where=np.isfinite(values))
    return float(10.0 ** (np.ceil(np.log10(largest)) - 3.0)) if largest > 0.0 else 1.0
