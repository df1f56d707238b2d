"""One page on M̄ that a reviewer can check: condition, arm, hash, bounds, method, figures; HTML or Markdown."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from asmc_pin.condition import ConditionReport, DesignReport
from asmc_pin.disk.files import write_whole
from asmc_pin.pages.condition_figures import COLOURS, along_figure, distribution_figure, maps_figure, trade_off_figure
from asmc_pin.pages.condition_words import facts, headline, joint_table, meaning, sentence
from asmc_pin.pages.html_fragments import scroll, table_html
from asmc_pin.pages.plates import Plate, framed, is_html, write_beside
from asmc_pin.pages.tables.text_table import Table, markdown_table
from asmc_pin.viewer.drawing.drawn_bodies import draw
from asmc_pin.viewer.played_motion import PlayedMotion, describe
from asmc_pin.viewer.player_page import replay_element
from asmc_pin.words.media import for_html, for_markdown

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_WORST = "#D55E00"


def write_condition_report(report: ConditionReport | DesignReport, arm: Arm, path: str | Path) -> None:
    """Write the page.

    Args:
        report: What `verify` or `design` said.
        arm: The arm that was asked about.
        path: Ends in ``.html`` (one file, figures and the arm in its worst configuration inside, opens offline) or in
            ``.md`` (figures as PNG files beside it).

    Raises:
        ParameterError: Another suffix.
        ResultError: The file cannot be written.
    """
    path = Path(path)
    html, plates = is_html(path), list(_plates(report))
    if html:
        write_whole(path, _html(report, arm, plates))
        return
    write_beside(path, plates)
    write_whole(path, _markdown(report, arm, plates, path.stem))


def _plates(report: ConditionReport | DesignReport) -> list[Plate]:
    check = report.check if isinstance(report, DesignReport) else report
    plates = []
    if isinstance(report, DesignReport) and len(report.trade_off) > 1:
        caption = "Norm against the slowest mode of the estimate, from least norm to largest guaranteed bandwidth."
        plates.append(Plate("trade_off", trade_off_figure(report), caption))
    if check is None:
        return plates
    if check.times is not None:
        caption = "The norm over time" + (", largest of each slice of the tube." if check.scope == "tube" else ".")
        plates.append(Plate("along", along_figure(check), caption))
    caption = "How often the samples have which norm; dashed, the largest that was found by local maximisation."
    plates.append(Plate("distribution", distribution_figure(check), caption))
    maps = maps_figure(check, check.subject)
    if maps is not None:
        caption = "The norm over pairs of joints, the others as in the worst configuration (cross). Axes in rad (m)."
        plates.append(Plate("maps", maps, caption))
    return plates


def _html(report: ConditionReport | DesignReport, arm: Arm, plates: list[Plate]) -> str:
    check = report.check if isinstance(report, DesignReport) else report
    body = [
        f"<h1>{for_html(headline(report))}</h1>",
        f'<p class="lead">{for_html(report.formula)}</p>',
        f"<p>{for_html(sentence(report))}</p>",
    ]
    notes = list(check.notes) if check is not None else []
    if notes:
        body.append('<ul class="notes">' + "".join(f'<li class="note">{for_html(n)}</li>' for n in notes) + "</ul>")
    if isinstance(report, DesignReport):
        body.append("<h2>Why this M̄, and what would help</h2>")
        body += [f"<p>{for_html(line)}</p>" for line in report.reasons()]
    helpful = _what_would_help(check)
    if helpful:
        body.append("<h2>What would help</h2>")
        body.append("<ul>" + "".join(f"<li>{for_html(line)}</li>" for line in helpful) + "</ul>")
    body += ["<h2>What was asked and how</h2>", "<dl>"]
    body += [f"<dt>{for_html(term)}</dt><dd>{for_html(value)}</dd>" for term, value in facts(report, arm)]
    body.append("</dl>")
    if check is not None:
        head, rows = joint_table(check)
        title = "Joints and the worst configuration"
        body += [f"<h2>{title}</h2>", scroll(title, table_html(Table("", head, rows), {}))]
        body.append(f"<h3>{for_html(check.subject.name)} in its worst configuration</h3>")
        body.append(f'<div class="panel">{_posture(check)}</div>')
        if check.motion is not None:
            body.append("<h3>The motion, coloured by the norm: dark where it is least, bright where it is largest</h3>")
            body.append(f'<div class="panel">{_along(check)}</div>')
        body.append("<h2>Figures</h2>")
    body += [plate.html() for plate in plates]
    body.append("<h2>What the condition means</h2>")
    body += [f"<p>{for_html(line)}</p>" for line in meaning(report.condition)]
    return framed(headline(report), body, player=check is not None)


def _markdown(report: ConditionReport | DesignReport, arm: Arm, plates: list[Plate], stem: str) -> str:
    check = report.check if isinstance(report, DesignReport) else report
    lines = [
        f"# {for_markdown(headline(report))}",
        "",
        f"`{report.formula}`",
        "",
        for_markdown(sentence(report)),
    ]
    if check is not None and check.notes:
        lines += ["", *(f"- {for_markdown(note)}" for note in check.notes)]
    if isinstance(report, DesignReport):
        lines += [
            "",
            "## Why this M̄, and what would help",
            "",
            *(f"- {for_markdown(line)}" for line in report.reasons()),
        ]
    helpful = _what_would_help(check)
    if helpful:
        lines += ["", "## What would help", "", *(f"- {for_markdown(line)}" for line in helpful)]
    lines += [
        "",
        "## What was asked and how",
        "",
        *(f"- **{term}**: {for_markdown(value)}" for term, value in facts(report, arm)),
    ]
    if check is not None:
        head, rows = joint_table(check)
        lines += ["", "## Joints and the worst configuration", "", markdown_table(Table("", head, rows))]
    for plate in plates:
        lines += plate.markdown(f"{stem}_")
    lines += ["", "## What the condition means", "", "\n\n".join(meaning(report.condition))]
    return "\n".join(lines) + "\n"


def _what_would_help(check: ConditionReport | None) -> list[str]:
    """Of a violation: which joint is to blame, and what multiple of M̄ a search leaves."""
    lines = [] if check is None or check.remedy is None else check.remedy.lines()
    return [f"{line[:1].upper()}{line[1:]}." for line in lines]


def _posture(check: ConditionReport) -> str:
    """The arm in its worst configuration."""
    drawn = draw(check.subject)
    label = f"norm {check.lower:.6g}"
    motion = PlayedMotion(label=label, colour=_WORST, q=check.worst_q[None, :])
    description = describe(drawn, check.joints, np.zeros(1), [motion], None)
    return replay_element(description, drawn.notes, embedded=True)


def _along(check: ConditionReport) -> str:
    """The arm on its motion, coloured by the norm from dark (least) to bright (largest)."""
    assert check.times is not None
    assert check.norms is not None
    assert check.motion is not None
    span = float(np.ptp(check.norms))
    shades = colormaps[COLOURS]((check.norms - check.norms.min()) / (span or 1.0))[:, :3]
    motion = PlayedMotion("along the motion", _WORST, check.motion, shades=shades, reading=("norm", check.norms))
    drawn = draw(check.subject)
    description = describe(drawn, check.joints, check.times - check.times[0], [motion], None)
    return replay_element(description, drawn.notes, embedded=True)
