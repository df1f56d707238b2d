"""`report.html`: what a comparison found, on one page that opens offline and can be mailed.

Nothing in it depends on when or where it was made: the same result gives the same bytes. Plain words come first; motion
and curves are interactive; the PNG files of the result follow as they would stand in a paper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np
import pandas as pd

from asmc_pin.disk.files import write_whole
from asmc_pin.metrics import METRICS, MOVED
from asmc_pin.pages.comparisons.arm_and_origin import arm_and_experiment, origin, simulated_arm
from asmc_pin.pages.comparisons.paper_figures_section import paper_figures
from asmc_pin.pages.html_fragments import definitions, details, legend, scroll, table_html
from asmc_pin.pages.interactive.figure_element import figure_element, figure_scripts
from asmc_pin.pages.plain_words.after_comparison import after_comparison
from asmc_pin.pages.plain_words.first_screen import allowed, compared, mbar_verdicts, winners
from asmc_pin.pages.plain_words.terms import term_link, terms_html
from asmc_pin.pages.plates import page_script
from asmc_pin.pages.summary_tables import (
    figure_of_all,
    metric_table,
    moves,
    overview,
    per_joint,
    short_names,
    tool_table,
)
from asmc_pin.pages.tables.pair_tables import PAIRS_READ, figures_read, pair_table
from asmc_pin.pages.tables.text_table import NOTHING, UNCONVERGED, Table
from asmc_pin.pages.theorem_section import theorem_section
from asmc_pin.results.ensemble_summary import ends, failed_words, failures
from asmc_pin.results.result_folder import Result
from asmc_pin.viewer import controller_colors, player_scripts, replay_fragment, static
from asmc_pin.viewer.player_page import POLICY
from asmc_pin.words.media import for_html


def report_html(result: Result, path: str | Path) -> None:
    """Write the report of a comparison.

    Args:
        result: See `asmc_pin.results.result_folder.load_result`. Its figures are embedded where its folder has them.
        path: Where to, usually ``report.html`` in the result's folder.

    Raises:
        ResultError: The arm cannot be loaded any more, or the page cannot be written.
    """
    write_whole(path, report_text(result))


def report_text(result: Result) -> str:
    """The page itself; see `report_html`."""
    replay = replay_fragment(result)
    body = [
        *_head(result),
        '<h2 id="motion">Motion and curves</h2>',
        legend(_label_list(result)),
        f'<div class="panel">{replay}</div>',
        '<p class="soft">Drag to turn, scroll to zoom after a click, space plays and pauses; on a touch screen a '
        "finger sideways turns, two zoom; with the keyboard, arrows step, shift and arrows turn the view, + and − "
        "zoom. The translucent arm is the reference; <em>Errors</em> magnifies the differences from it.</p>",
        figure_element(result, short_names(list(map(str, result.dataset.joint.to_numpy())))),
        *_remarks(result),
        *_tables(result),
        *paper_figures(result),
        *([] if result.claims is None else theorem_section(result.claims, controller_colors(_label_list(result)))),
        *arm_and_experiment(result),
        '<h2 id="metrics">How the figures are defined</h2>',
        f'<p class="soft">Computed from {_computed_from(result)}, for each joint; e = q<sub>d</sub> − q. A law that '
        "diverged has no figures.</p>",
        scroll("Definitions of the metrics", definitions(METRICS.values())),
        '<h2 id="terms">What the terms mean</h2>',
        details("Glossary", f'<div class="body terms">{terms_html()}</div>'),
        *origin(result),
    ]
    return Template(_static("report.html")).substitute(
        policy=POLICY,
        title=for_html(f"{result.experiment.name}: {' · '.join(_label_list(result))}"),
        style=static("player.css") + _static("report.css"),
        body="\n".join(body),
        scripts="\n".join([player_scripts(), figure_scripts(), f"<script>{page_script()}</script>"]),
    )


def _computed_from(result: Result) -> str:
    every = result.experiment.log_every
    return (
        "the recorded trajectories" if every == 1 else f"every control tick, also those {every - 1} of {every} not kept"
    )


def _head(result: Result) -> Iterator[str]:
    experiment = result.experiment
    about, _ = simulated_arm(result)
    yield f"<h1>{for_html(experiment.name)}</h1>"
    said = compared(
        _label_list(result),
        about,
        experiment.duration,
        experiment.period,
        result.summary,
        experiment.ensemble.q0_deviation,
    )
    yield f'<p class="lead">{for_html(said)}</p>'
    yield '<dl class="findings">'
    for heading, sentence in winners(result.summary):
        yield f"<dt>{for_html(heading)}</dt><dd>{for_html(sentence)}</dd>"
    verdicts = mbar_verdicts(result.claims)
    question = f"Was {term_link('mbar', 'M̄')} allowed?"
    condition = f" ({term_link('lemma1', 'Lemma 1')})" if verdicts else ""
    yield f"<dt>{question}</dt><dd>{for_html(allowed(verdicts, result.summary.trial.nunique()))}{condition}</dd>"
    step = after_comparison(experiment, verdicts, experiment.name)
    yield f"<dt>What to do next</dt><dd>{for_html(step.what[:1].upper() + step.what[1:])}: "
    yield f"<code>{for_html(step.command)}</code></dd></dl>"
    yield '<ul class="cards">'
    yield from _cards(result)
    yield "</ul>"
    warnings = str(result.dataset.attrs.get("warnings", "")).splitlines()
    yield from _notes([("warning", line) for line in warnings])


def _remarks(result: Result) -> Iterator[str]:
    """What is worth knowing and is no warning."""
    _, arm = simulated_arm(result)
    attributes = result.dataset.attrs
    lines = [("note", line) for line in str(attributes.get("notes", "")).splitlines()]
    yield from _notes([*lines, *(("note", f"URDF: {line}") for line in arm.warnings)])


def _notes(lines: list[tuple[str, str]]) -> Iterator[str]:
    if lines:
        yield '<ul class="notes">'
        for kind, line in lines:
            sign = "Warning: " if kind == "warning" else ""
            yield f'<li class="{kind}">{sign}{for_html(line)}</li>'
        yield "</ul>"


def _cards(result: Result) -> Iterator[str]:
    """One card for each controller: did it hold, and its RMS error at the worst joint."""
    dataset, colours = result.dataset, controller_colors(_label_list(result))
    summary, trials = result.summary, result.summary.trial.nunique()
    _, units, errors = per_joint(summary, "rms_error")
    unit = "deg" if "deg" in units else units[0]
    alike = np.array(units) == unit
    worst = figure_of_all(errors[:, :, alike], moves(summary, "rms_error")[:, alike], np.max, METRICS["rms_error"].best)
    failed, ended = failures(summary), ends(summary)
    for k, label in enumerate(_label_list(result)):
        over = bool(failed[k].any())
        ran = "ran to the end" if trials == 1 else f"all {trials} trials ran to the end"
        state = failed_words(failed[k], ended[k]) if over else ran
        value, _, unsure = worst.texts[k].partition(" (")
        figure = value if value == NOTHING else f"{value} {unit}{' (' + unsure if unsure else ''}"
        span = worst.ranges[k]
        figure += f'<span class="range">{for_html(" … ".join(span))}</span>' if span else ""
        yield (
            f'<li data-controller="{for_html(label)}" style="--colour:{colours[label]}">'
            f"<strong>{for_html(label)}</strong>"
            f'<span class="law">{for_html(str(dataset.law.to_numpy()[k]))}</span>'
            f'<span class="figure">{figure}<small>RMS error, worst joint</small></span>'
            f'<span class="state{" is-over" if over else ""}">{for_html(state)}</span></li>'
        )


def _tables(result: Result) -> Iterator[str]:
    colours = controller_colors(_label_list(result))

    def html(table: Table) -> str:
        return scroll(table.title, table_html(table, colours))

    summary = result.summary
    table = overview(summary)
    yield '<h2 id="summary">Comparison</h2>'
    yield f"<p>{for_html(table.title)} of each joint; the worst error of all, and the chatter of the torque.</p>"
    yield html(table)
    read = figures_read(summary, result.experiment.ensemble.q0_deviation)
    refined = f" {UNCONVERGED}" if any(str(name).startswith(MOVED) for name in summary) else ""
    yield (
        '<p class="soft">Worst error: the largest of all joints over the run. Chatter: torque '
        f"variation per second, summed over the joints. {for_html(read)}{for_html(refined)}</p>"
    )
    yield from _pairs(summary, html)
    tool = tool_table(summary)
    if tool is not None:
        yield f"<h3>{for_html(tool.title)}</h3>"
        yield '<p class="soft">Distance of the frame from where the reference has it, and angle of the turn.</p>'
        yield html(tool)
    names = sorted(METRICS, key=lambda name: not METRICS[name].main)
    rest = [name for name in names if name != "rms_error" and summary[name].notna().any()]
    parts = []
    for name in rest:
        table = metric_table(summary, name)
        parts.append(
            f'<h3>{for_html(table.title)}</h3><p class="soft"><code>{for_html(METRICS[name].formula)}</code></p>'
        )
        parts.append(html(table))
    yield details("All metrics, joint by joint", f'<div class="body">{"".join(parts)}</div>')


def _pairs(summary: pd.DataFrame, html: Callable[[Table], str]) -> Iterator[str]:
    """How sure the order of every two controllers is."""
    table = pair_table(summary)
    if table is not None:
        text = f'<p class="soft">{for_html(PAIRS_READ)}</p>'
        yield details(table.title, f'<div class="body">{text}{html(table)}</div>')


def _label_list(result: Result) -> list[str]:
    return [str(label) for label in result.dataset.controller.to_numpy()]


@cache
def _static(name: str) -> str:
    return (files("asmc_pin.pages") / "static" / name).read_text(encoding="utf-8")
