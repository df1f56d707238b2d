"""One page on a sampled loop: what was found, and how slow it may run; HTML or Markdown."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from asmc_pin._typing import Array, BoolArray
from asmc_pin.disk.files import write_whole
from asmc_pin.pages.figure_style import PAGE, paper_style
from asmc_pin.pages.html_fragments import scroll, table_html
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.sampled.frozen_arms import FrozenArms
from asmc_pin.sampled.loop_curves import LoopCurve, LoopCurves, loop_curves
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.stability_report import StabilityReport
from asmc_pin.sampled.workspace_worst import workspace_of
from asmc_pin.words.media import for_figure, for_html, for_markdown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_SAMPLES = 256
_ROUNDING = 1e-8
_UNSTABLE = "#F4D9D0"
_AXES = {"period": ("L (ms)", 1e3), "filter_hz": ("filter_hz (Hz)", 1.0), "delay": ("delay (periods)", 1.0)}
_SAID = {"period": "period L", "filter_hz": "filter of the estimate", "delay": "transport delay"}


def write_stability_page(
    report: StabilityReport, arms: FrozenArms, path: str | Path, *, sensor: LoopSensor | None = None
) -> None:
    """Write the page.

    Args:
        report: What `stability` said.
        arms: The arms that were asked about, see `frozen_arms`.
        path: Ends in ``.html`` (one file) or in ``.md`` (figures as PNG files beside it).
        sensor: The sensors, for the noise.

    Raises:
        ParameterError: Another suffix.
        ResultError: The file cannot be written.
    """
    path = Path(path)
    html = is_html(path)
    heavy = arms.heavy
    spaces = [workspace_of(arms, samples=_SAMPLES, gravity=gravity) for gravity in (False, True)[: 1 + heavy]]
    drift = np.ones(arms.nv)
    if heavy:
        drift = np.abs(arms.stiffness(spaces[-1].points)).sum(axis=-1).max(axis=0)
        drift[drift < _ROUNDING * drift.max()] = 0.0
    curves = loop_curves(spaces, report.loop, drift, sensor, [report.worst_q, report.rest_q])
    plates = [_plate(report, curves, curve) for curve in curves.curves]
    title = f"{report.about.title}: how slow may the loop run?"
    table = _ranges(curves)
    if html:
        body = [f"<h1>{for_html(title)}</h1>", "<ul>"]
        body += [f"<li>{for_html(line)}</li>" for line in report.lines()]
        body += ["</ul>", f"<h2>Ranges</h2><p>{for_html(_method(curves, heavy))}</p>"]
        body += [scroll("Ranges", table_html(table, {})), "<h2>Figures</h2>"]
        body += [plate.html() for plate in plates]
        write_whole(path, framed(title, body, player=False))
        return
    write_beside(path, plates)
    lines = [f"# {for_markdown(title)}", "", *(f"- {for_markdown(line)}" for line in report.lines())]
    lines += ["", "## Ranges", "", for_markdown(_method(curves, heavy)), "", markdown_table(table)]
    for plate in plates:
        lines += plate.markdown(f"{path.stem}_")
    write_whole(path, "\n".join(lines) + "\n")


def _method(curves: LoopCurves, heavy: bool) -> str:
    return (
        f"One of period, filter and delay varies, all else as above. At each value {curves.configurations} "
        "configurations are looked at, among them the worst that were found for the loop itself"
        + (", with gravity's stiffness at rest and without" if heavy else "")
        + ". A search refutes stability; it does not prove it. The error is that under a load that drifts at "
        + ", ".join(f"{x:.3g}" for x in curves.drift)
        + (" N·m/s, as gravity's does with all joints at 1 rad/s." if heavy else " N·m/s.")
    )


def _ranges(curves: LoopCurves) -> Table:
    """Where each curve is stable, from its own point on."""
    rows = []
    for curve in curves.curves:
        _, factor = _AXES[curve.name]
        stable = curve.stable
        inside = curve.values[stable] * factor
        span = "nowhere" if not stable.any() else f"{inside[0]:.3g} to {inside[-1]:.3g}"
        gaps = (
            " with gaps"
            if stable.any() and not stable[np.argmax(stable) : stable.size - stable[::-1].argmax()].all()
            else ""
        )
        here = "none" if curve.here is None else f"{curve.here * factor:.4g}"
        rows.append(
            [
                _AXES[curve.name][0],
                here,
                f"{curve.values[0] * factor:.3g} to {curve.values[-1] * factor:.3g}",
                span + gaps,
            ]
        )
    return Table("", ["what varies", "this loop", "looked at", "stable"], rows)


def _plate(report: StabilityReport, curves: LoopCurves, curve: LoopCurve) -> Plate:
    label, factor = _AXES[curve.name]
    noisy = curve.torque_rms is not None
    with paper_style():
        figure = Figure(figsize=(PAGE, 4.4 if noisy else 3.1), layout="constrained")
        FigureCanvasAgg(figure)
        panels = list(figure.subplots(3 if noisy else 2, 1, sharex=True))
        x = curve.values * factor
        panels[0].plot(x, -np.log(curve.radius) / _periods(curves, curve), color="black")
        panels[0].axhline(0.0, color="black", linewidth=0.6)
        panels[0].set_ylabel("slowest decay (1/s)")
        _clip(panels[0], -np.log(curve.radius) / _periods(curves, curve))
        _joints(panels[1], x, np.rad2deg(curve.drift_error), report.joints, "error under drift (deg)")
        if curve.torque_rms is not None:
            _joints(panels[2], x, curve.torque_rms, report.joints, "torque noise, RMS (N·m)")
        for panel in panels:
            panel.set_xscale("linear" if curve.name == "delay" else "log")
            _shade(panel, x, ~curve.stable)
            if curve.here is not None:
                panel.axvline(curve.here * factor, color="black", linestyle=":", linewidth=0.9)
        panels[-1].set_xlabel(label)
        panels[1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    caption = (
        f"Over the {_SAID[curve.name]}: slowest decay anywhere (below 0 the loop is unstable, shaded), error under the "
        "drifting load" + (", and torque noise of the sensors" if noisy else "") + "; dotted, this loop."
    )
    return Plate(curve.name, figure, caption)


def _periods(curves: LoopCurves, curve: LoopCurve) -> Array | float:
    return curve.values if curve.name == "period" else curves.loop.period


def _clip(axes: Axes, decay: Array) -> None:
    """Growth soon exceeds any decay by far: the axis follows the decay, or what there is of growth if there is none."""
    top = float(decay.max()) if decay.max() > 0.0 else float(-decay.min())
    axes.set_ylim(-top, 1.1 * top)


def _joints(axes: Axes, x: Array, values: Array, joints: tuple[str, ...], label: str) -> None:
    shown = np.where(values > 0.0, values, np.nan)  # a joint that gravity leaves alone has no error to show
    for i, name in enumerate(joints):
        axes.plot(x, shown[:, i], label=for_figure(name))
    if np.isfinite(shown).any():
        axes.set_yscale("log")
    axes.set_ylabel(label)


def _shade(axes: Axes, x: Array, unstable: BoolArray) -> None:
    """Shade where the loop is unstable, up to half-way to the next value that is stable."""
    edges = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    for i in np.flatnonzero(unstable):
        axes.axvspan(edges[i], edges[i + 1], color=_UNSTABLE, linewidth=0.0, zorder=0)
    axes.set_xlim(x[0], x[-1])
