"""What an M̄, or a law, would have done along a log: the sections of the page, with figures over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from asmc_pin._typing import Array
from asmc_pin.identification.mbar_along_log import MbarAlongLog
from asmc_pin.log_rerun import LawOnLog
from asmc_pin.pages.condition_figures import along_figure
from asmc_pin.pages.curves import thinned
from asmc_pin.pages.figure_style import GREY, PAGE, paper_style
from asmc_pin.pages.plates import Plate
from asmc_pin.pages.tables.text_table import Table
from asmc_pin.words.media import for_figure

_BLUE = "#0072B2"


@dataclass(frozen=True, eq=False)
class HindsightSection:
    """One section: words, a table and figures."""

    title: str
    lines: tuple[str, ...]
    table: Table
    plates: tuple[Plate, ...]


def hindsight_sections(along: MbarAlongLog | None, ran: LawOnLog | None) -> list[HindsightSection]:
    """The sections, as far as they were asked for."""
    found = []
    if along is not None:
        plates = (
            Plate("lemma1", along_figure(along.report), "Lemma 1's norm along the log, of the arm as measured."),
            Plate("tde_error", tde_error_figure(along), "TDE error N that M̄ would have made, over time."),
        )
        found.append(
            HindsightSection("What would M̄ have done?", tuple(along.lines()), Table("", *along.table()), plates)
        )
    if ran is not None:
        plates = (
            Plate(
                "law_torque", law_torque_figure(ran), "Torque: measured (grey), of the law in the log's place (blue)."
            ),
            Plate(
                "law_tracking",
                law_tracking_figure(ran),
                "Logged angles less the motion that was followed (grey); tracking error of the law (blue).",
            ),
        )
        found.append(
            HindsightSection(
                "Measured against simulated, with the law in the log's place",
                tuple(ran.lines()),
                Table("", *ran.table()),
                plates,
            )
        )
    return found


def tde_error_figure(along: MbarAlongLog) -> Figure:
    """The TDE error of each joint over time."""
    assert along.report.times is not None
    names, kinds = along.found.arm.joint_names, along.found.arm.joint_kinds
    units = ["m/s²" if kind == "prismatic" else "rad/s²" for kind in kinds]
    return _over_time(along.report.times[1:], [(along.error, _BLUE, 0.7)], names, units)


def law_torque_figure(ran: LawOnLog) -> Figure:
    """Measured and simulated torque of each joint over time."""
    assert ran.measured.torque is not None
    arm = ran.found.arm
    units = ["N" if kind == "prismatic" else "N·m" for kind in arm.joint_kinds]
    curves = [(ran.measured.torque, GREY, 1.4), (ran.torque, _BLUE, 0.8)]
    return _over_time(ran.measured.time, curves, arm.joint_names, units)


def law_tracking_figure(ran: LawOnLog) -> Figure:
    """Tracking error of each joint over time, beside what smoothing took from the log."""
    arm = ran.found.arm
    units = ["m" if kind == "prismatic" else "rad" for kind in arm.joint_kinds]
    curves = [(ran.smoothed_off, GREY, 0.8), (ran.error, _BLUE, 0.8)]
    return _over_time(ran.measured.time, curves, arm.joint_names, units)


def _over_time(time: Array, curves: list[tuple[Array, str, float]], names: tuple[str, ...], units: list[str]) -> Figure:
    nv = len(names)
    with paper_style():
        figure = Figure(figsize=(PAGE, 0.95 * nv + 0.4), layout="constrained")
        FigureCanvasAgg(figure)
        for j, axes in enumerate(figure.subplots(nv, 1, sharex=True, squeeze=False)[:, 0]):
            for values, colour, width in curves:
                axes.plot(*thinned(time, np.asarray(values[:, j])), color=colour, linewidth=width)
            axes.set_ylabel(f"{for_figure(names[j])}\n({units[j]})", fontsize=6.0)
        axes.set_xlabel("t (s)")
    return figure
