"""The explorer's page: one file that opens without a network, whatever it is mailed to."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from string import Template
from typing import Any

from asmc_pin.condition import ConditionReport
from asmc_pin.condition.hypotheses import formula
from asmc_pin.pages.condition_words import sentence
from asmc_pin.pages.html_fragments import definition_list
from asmc_pin.viewer.player_page import POLICY, inert, json_text, scene_scripts, static
from asmc_pin.words.media import for_html

_SCRIPTS = (
    "mass_matrix.js",
    "small_matrices.js",
    "condition_at.js",
    "proven_cells.js",
    "norm_map.js",
    "norm_search.js",
    "arm_dragging.js",
    "explorer_fields.js",
    "explorer.js",
)

LIVE_POLICY = f"{POLICY}; connect-src 'self'"
"""The policy of a page that may ask its own server, and nobody else."""

LOOP_NOTE = (
    "PPC with one k_s and one β for all joints, its torque held over the period L, linear and frozen at this "
    "configuration, without gravity. asmc-pin stability looks at the whole joint box, with gravity."
)


def explorer_page(report: ConditionReport, data: dict[str, Any], notes: tuple[str, ...]) -> str:
    """HTML of the page.

    Args:
        report: What a search of the box found for M̄.
        data: What `explored_arm.described` returned.
        notes: What a person should know of the picture.
    """
    facts = [*report.hypotheses.rows(), ("How the worst was searched", "; ".join(report.method))]
    facts += [("Of the search", note) for note in report.notes]
    facts += [("Picture", note) for note in notes]
    return Template(script("explorer.html")).substitute(
        policy=LIVE_POLICY if data["live"] else POLICY,
        title=for_html(f"Exploring M̄ on {report.hypotheses.title}"),
        style=static("player.css") + script("explorer.css"),
        verdict=for_html(_verdict(report, data)),
        formula=for_html(formula(report.condition).partition(" < ")[0]),
        worst=for_html(f"Worst found: {report.lower:.6g}"),
        loop_note=for_html(LOOP_NOTE),
        facts=definition_list(facts),
        data=json_text(data),
        scripts=scene_scripts() + "\n" + _own_scripts(),
    )


def _verdict(report: ConditionReport, data: dict[str, Any]) -> str:
    """What is known over the whole joint box, claiming no more than was searched or proven."""
    if report.verdict == "violated":
        found = f"at the configuration of “Worst found” the norm is {report.lower:.6g}, not below 1"
        return f"On {report.hypotheses.title}, M̄ violates the condition: {found}. {data['cellsNote']}".strip()
    if not data["proven"]:
        return f"{sentence(report)} {data['cellsNote']}".strip()
    found = f"the largest norm found over the joint box below is {report.lower:.6g}"
    return f"On {report.hypotheses.title}, {found}. {data['cellsNote']}"


@cache
def _own_scripts() -> str:
    return "\n".join(f"<script>{inert(script(name))}</script>" for name in _SCRIPTS)


def script(name: str) -> str:
    """A script, style or template that travels with the explorer."""
    return (files("asmc_pin.exploring") / "static" / name).read_text(encoding="utf-8")
