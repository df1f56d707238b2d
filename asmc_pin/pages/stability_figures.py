"""Figures of the stable region. They compute nothing new: every point is a spectral radius of the frozen loop."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ParameterError
from asmc_pin.pages.figure_style import COLUMN, fitted, paper_style
from asmc_pin.sampled.critical_points import critical_set
from asmc_pin.sampled.frozen_arms import FrozenArms, frozen_arms
from asmc_pin.sampled.loop_analysis import spaces_of
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import workspace_of
from asmc_pin.words.media import for_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from asmc_pin.arms import Arm

# Blue where errors decay, red where they grow; both readable without colour through the boundary line.
_COLOURS = LinearSegmentedColormap.from_list("decay", ["#1f4e79", "#9ecae1", "#f7f7f7", "#f4a582", "#b2182b"])
_POINTS = 32


_Arguments = ParamSpec("_Arguments")


def _for_paper(draw: Callable[_Arguments, Figure]) -> Callable[_Arguments, Figure]:
    """Draw in the type of a paper."""

    @wraps(draw)
    def drawn(*args: _Arguments.args, **keywords: _Arguments.kwargs) -> Figure:
        with paper_style():
            return draw(*args, **keywords)

    return drawn


def save_figures(arm: Arm, loop: SampledLoop, folder: str | Path, *, box: BoxLike = None) -> list[Path]:
    """Write both figures of the stable region, as PNG for reading and PDF for printing.

    Args:
        arm: The arm.
        loop: The loop that is marked.
        folder: Where to; made if need be.
        box: Joint box; the arm's own by default.

    Returns:
        The files written.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for name, draw in (("stability_gains", gain_region_figure), ("stability_period", period_region_figure)):
        figure = draw(arm, loop, box=box)
        for suffix in ("png", "pdf"):
            written.append(Path(folder) / f"{name}.{suffix}")
            # Without the date, so that the same input gives the same bytes.
            undated = {"CreationDate": None} if suffix == "pdf" else None
            content = io.BytesIO()
            with paper_style():
                figure.savefig(content, format=suffix, metadata=undated)
            write_whole(written[-1], content.getvalue())
    return written


@_for_paper
def gain_region_figure(arm: Arm, loop: SampledLoop, *, box: BoxLike = None, span: float = 30.0) -> Figure:
    """β against k_s at the loop's period: the slowest decay anywhere in the workspace, and where it turns into growth.

    Args:
        arm: The arm.
        loop: The gains that are marked; K_s is scaled as a whole, and the axis shows its first value.
        box: Joint box; the arm's own by default.
        span: The axes go from gains/span to gains·span.

    Returns:
        A figure, not shown and not registered with pyplot.
    """
    arms = frozen_arms(arm, box)
    factors = np.geomspace(1.0 / span, span, _POINTS)
    family = [[loop.scaled(ks=x, beta=y) for x in factors] for y in factors]
    figure, axes = _blank()
    _region(axes, arms, loop, factors * loop.ks[0], factors * loop.beta[0], family)
    axes.plot(loop.ks[0], loop.beta[0], "o", color="black", markerfacecolor="white", label="these gains", zorder=3)
    one = bool(np.all(loop.ks == loop.ks[0]))
    axes.set_xlabel("$k_s$ (1/s)" if one else "$k_{s1}$ (1/s), the others in proportion to it")
    axes.set_ylabel("β (1/s)")
    _title(axes, f"{for_figure(arm.name)}, L = {1e3 * loop.period:g} ms{_timing(loop)}")
    axes.legend(loc="lower left", frameon=True)
    return figure


@_for_paper
def period_region_figure(arm: Arm, loop: SampledLoop, *, box: BoxLike = None, span: float = 30.0) -> Figure:
    """L against the gains (β and K_s scaled together).

    Args:
        arm: The arm.
        loop: The loop that is marked.
        box: Joint box; the arm's own by default.
        span: The axes go from the loop's values/span to values·span.

    Returns:
        A figure, not shown and not registered with pyplot.
    """
    arms = frozen_arms(arm, box)
    factors = np.geomspace(1.0 / span, span, _POINTS)
    family = [[loop.scaled(period=x, ks=y, beta=y) for x in factors] for y in factors]
    figure, axes = _blank()
    _region(axes, arms, loop, 1e3 * factors * loop.period, factors * loop.beta[0], family, relative=True)
    axes.plot(1e3 * loop.period, loop.beta[0], "o", color="black", markerfacecolor="white", label="this loop", zorder=3)
    axes.set_xlabel("L (ms)")
    axes.set_ylabel(r"β (1/s), $K_s$ in proportion to it")
    _title(axes, f"{for_figure(arm.name)}, β : k_s = {loop.beta[0]:g} : {loop.ks[0]:g}{_timing(loop)}")
    axes.legend(loc="lower left", frameon=True)
    return figure


@_for_paper
def workspace_figure(
    arm: Arm, loop: SampledLoop, joints: tuple[int, int], q: Array, *, box: BoxLike = None, gravity: bool = False
) -> Figure:
    """The spectral radius over two joints, the others held.

    Args:
        arm: The arm.
        loop: Gains and timing.
        joints: Indices of the joints on the horizontal and the vertical axis.
        q: Where the other joints are held, shape (nv,), rad.
        box: Joint box; the arm's own by default.
        gravity: Whether gravity's stiffness is part of the map.

    Raises:
        ParameterError: the joints are not two different ones of the arm.
    """
    across, up = joints
    if across == up or not (0 <= across < arm.nv and 0 <= up < arm.nv):
        raise ParameterError("joints", f"got {joints}; expected two different indices from 0 to {arm.nv - 1}")
    workspace = workspace_of(arm, box, samples=1, gravity=gravity)
    lower, upper = workspace.arms.box.lower, workspace.arms.box.upper
    x, y = (np.linspace(lower[j], upper[j], 61) for j in (across, up))
    points = np.tile(np.asarray(q, dtype=np.float64), (y.size, x.size, 1))
    points[..., across], points[..., up] = x, y[:, None]
    held = np.repeat(workspace.points[:1], y.size * x.size, axis=0)
    held[:, 1 : 1 + arm.nv] = points.reshape(-1, arm.nv)
    radii = workspace.radii(loop, held).reshape(y.size, x.size)
    figure, axes = _blank()
    _paint(axes, x, y, -np.log(radii) / loop.period, "slowest decay, −ln ρ / L (1/s)")
    for axis, j in ((axes.set_xlabel, across), (axes.set_ylabel, up)):
        axis(f"{for_figure(arm.joint_names[j])} ({'rad' if arm.joint_kinds[j] == 'revolute' else 'm'})")
    _title(axes, f"{for_figure(arm.name)}, largest radius {radii.max():.5f}" + (", about rest" if gravity else ""))
    return figure


def _blank() -> tuple[Figure, Axes]:
    figure = Figure(figsize=(COLUMN, 2.8), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def _title(axes: Axes, words: str) -> None:
    text, size = fitted(words, 68.0 * COLUMN)
    axes.figure.suptitle(text, fontsize=size)  # over the bar of colours too


def _region(
    axes: Axes,
    arms: FrozenArms,
    loop: SampledLoop,
    x: Array,
    y: Array,
    family: list[list[SampledLoop]],
    *,
    relative: bool = False,
) -> None:
    """Paint the decay of a family of loops; relative to the slowest pole of (8) where axes span many time scales."""
    spaces = spaces_of(arms, samples=512, seed=0)
    critical = critical_set(spaces, loop, [space.worst(loop)[1] for space in spaces])

    def decay(member: SampledLoop) -> float:
        slowest = min(float(member.beta.min()), float(member.ks.min())) if relative else 1.0
        return -math.log(critical.radius(member)) / (member.period * slowest)

    axes.set_xscale("log")
    axes.set_yscale("log")
    label = "slowest decay, −ln ρ / L, over min(β, k_s)" if relative else "slowest decay, −ln ρ / L (1/s)"
    _paint(axes, x, y, np.array([[decay(member) for member in row] for row in family]), label)


def _paint(axes: Axes, x: Array, y: Array, decay: Array, label: str) -> None:
    """Decay rates in colour, symmetric about zero, and the line where they are zero."""
    # Growth soon exceeds any decay by far; the scale follows the decay, or what there is of growth if there is none.
    top = float(decay.max()) if decay.max() > 0.0 else float(-decay.min())
    norm = TwoSlopeNorm(0.0, -top, top)
    mesh = axes.pcolormesh(
        x, y, np.clip(decay, -top, top), cmap=_COLOURS.reversed(), norm=norm, shading="gouraud", rasterized=True
    )
    axes.figure.colorbar(mesh, ax=axes).set_label(label)
    if decay.min() < 0.0 < decay.max():
        axes.contour(x, y, decay, levels=[0.0], colors="black", linewidths=1.4)
        axes.plot([], [], color="black", linewidth=1.4, label="ρ = 1")


def _timing(loop: SampledLoop) -> str:
    parts = [f"estimate from {loop.acceleration}"]
    parts += [f"filter {loop.filter_hz:g} Hz"] if loop.filter_hz is not None else []
    parts += [f"delay {loop.delay:g} L"] if loop.delay else []
    return ", " + ", ".join(parts)
