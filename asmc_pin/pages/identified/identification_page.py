"""One page on an arm's log: is the URDF right, what explains the rest, and how sure the estimates are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from asmc_pin.disk.files import write_whole
from asmc_pin.identification.identification_report import Identification
from asmc_pin.identification.mbar_along_log import MbarAlongLog
from asmc_pin.log_rerun import LawOnLog
from asmc_pin.pages.figure_style import GREY, PAGE, paper_style
from asmc_pin.pages.html_fragments import scroll, table_html
from asmc_pin.pages.identified.hindsight_section import hindsight_sections
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.words.media import for_figure, for_html, for_markdown

_BLUE, _OUT = "#0072B2", "#F3E3C3"


def write_identification_page(
    found: Identification,
    path: str | Path,
    *,
    along: MbarAlongLog | None = None,
    ran: LawOnLog | None = None,
) -> None:
    """Write the page.

    Args:
        found: What `identify` found.
        path: Ends in ``.html`` (one file) or in ``.md`` (figures as PNG files beside it).
        along: What an M̄ would have done along the log, of `mbar_on_log`.
        ran: What a law did in the log's place, of `law_on_log`.

    Raises:
        ParameterError: Another suffix.
        ResultError: The file cannot be written.
    """
    path = Path(path)
    plates = [
        Plate("torque", torque_figure(found), _TORQUE + (_SHADED if found.fit is not None else "")),
        Plate("residual", residual_figure(found), _RESIDUAL),
    ]
    after = hindsight_sections(along, ran)
    title = f"Is the URDF of {found.arm.name} right?"
    left = Table("", *found.table())
    estimates = Table("", *found.table_of_estimates()) if found.parameters else None
    remarks = [line for line in found.remarks() if not line.startswith(("estimates", "  "))]
    if is_html(path):
        body = [
            f"<h1>{for_html(title)}</h1>",
            "<ul>",
            *(f"<li>{for_html(line)}</li>" for line in found.lines()),
            "</ul>",
        ]
        body += ["<h2>What is left of each joint's torque</h2>", f"<p>{for_html(_STAGES)}</p>"]
        body += [scroll("What is left of each joint's torque", table_html(left, {}))]
        body += [plate.html() for plate in plates]
        if estimates is not None:
            body += [
                "<h2>Estimates, 95 %</h2>",
                scroll("Estimates", table_html(estimates, {})),
            ]
        body += [f"<p>{for_html(line)}</p>" for line in remarks]
        for section in after:
            body += [f"<h2>{for_html(section.title)}</h2>", *(f"<p>{for_html(line)}</p>" for line in section.lines)]
            body.append(scroll(section.title, table_html(section.table, {})))
            body += [plate.html() for plate in section.plates]
        write_whole(path, framed(title, body, player=False))
        return
    write_beside(path, [*plates, *(plate for section in after for plate in section.plates)])
    lines = [f"# {for_markdown(title)}", "", *(f"- {for_markdown(line)}" for line in found.lines())]
    lines += ["", "## What is left of each joint's torque", "", for_markdown(_STAGES), "", markdown_table(left)]
    for plate in plates:
        lines += plate.markdown(f"{path.stem}_")
    if estimates is not None:
        lines += ["", "## Estimates, 95 %", "", markdown_table(estimates)]
    lines += ["", *(f"- {for_markdown(line)}" for line in remarks)]
    for section in after:
        lines += ["", f"## {for_markdown(section.title)}", "", *(f"- {for_markdown(line)}" for line in section.lines)]
        lines += ["", markdown_table(section.table)]
        for plate in section.plates:
            lines += plate.markdown(f"{path.stem}_")
    write_whole(path, "\n".join(lines) + "\n")


_STAGES = (
    "RMS in N·m: of the logged torque about its mean; of logged − model torque as more of the model is there, on the "
    "rows that were fitted; of the same on rows held out; and how many times longer the residual is correlated than "
    "white noise through the same filter."
)
_TORQUE = "Logged torque (grey) and the model's with all that was estimated (blue), over time."
_SHADED = " Shaded: held out."
_RESIDUAL = "Logged − model torque over angle, velocity and time: of the URDF alone (grey), with all estimates (blue)."


def torque_figure(found: Identification) -> Figure:
    """Logged and model torque over time, joint by joint."""
    model, nv = found.model, found.arm.nv
    delay = 0.0 if found.fit is None else float(found.fit.values[model.index("delay")])
    logged = model.logged(delay)
    with paper_style():
        figure = Figure(figsize=(PAGE, 0.95 * nv + 0.4), layout="constrained")
        FigureCanvasAgg(figure)
        for j, axes in enumerate(figure.subplots(nv, 1, sharex=True, squeeze=False)[:, 0]):
            axes.plot(model.time, logged[:, j], color=GREY, linewidth=1.4)
            axes.plot(model.time, logged[:, j] - found.residual[:, j], color=_BLUE, linewidth=0.8)
            for first, last in _stretches(found.held_out.any(axis=1)):
                axes.axvspan(model.time[first], model.time[last], color=_OUT, linewidth=0.0, zorder=0)
            axes.set_ylabel(for_figure(found.arm.joint_names[j]) + "\n(N·m)", fontsize=6.0)
        axes.set_xlabel("t (s)")
    return figure


def residual_figure(found: Identification) -> Figure:
    """The residual of each joint over angle, velocity and time."""
    model, nv = found.model, found.arm.nv
    before, _ = model.residual(model.start())
    rows = model.motion.rows
    with paper_style():
        figure = Figure(figsize=(PAGE, 0.95 * nv + 0.4), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(nv, 3, sharex="col" if nv == 1 else False, sharey="row", squeeze=False)
        for j in range(nv):
            over = (model.motion.q[rows, j], model.motion.v[rows, j], model.time)
            usable = model.usable[:, j]
            for axes, x, label in zip(grid[j], over, ("q (rad)", "v (rad/s)", "t (s)"), strict=True):
                axes.plot(x[usable], before[usable, j], ".", color=GREY, markersize=1.2)
                if found.fit is not None:
                    axes.plot(x[usable], found.residual[usable, j], ".", color=_BLUE, markersize=1.2)
                if j == nv - 1:
                    axes.set_xlabel(label)
            grid[j, 0].set_ylabel(for_figure(found.arm.joint_names[j]) + "\n(N·m)", fontsize=6.0)
    return figure


def _stretches(inside: object) -> list[tuple[int, int]]:
    """First and last rows of what is held out, gaps of joints that rest closed."""
    places = np.flatnonzero(np.asarray(inside))
    if not places.size:
        return []
    breaks = np.flatnonzero(np.diff(places) > 40)
    firsts, lasts = [places[0], *places[breaks + 1]], [*places[breaks], places[-1]]
    return [(int(first), int(last)) for first, last in zip(firsts, lasts, strict=True)]
