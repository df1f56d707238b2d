"""The text of ``summary.md``."""

from __future__ import annotations

from asmc_pin.pages.summary_tables import metric_tables_markdown, tool_table
from asmc_pin.pages.tables.pair_tables import PAIRS_READ, figures_read, pair_table
from asmc_pin.pages.tables.text_table import UNCONVERGED, markdown_table
from asmc_pin.pages.theorem_tables import theorems_markdown
from asmc_pin.study.comparison import Comparison
from asmc_pin.words.media import for_markdown


def summary_markdown(comparison: Comparison) -> str:
    """The text of ``summary.md``."""
    experiment, arm = comparison.experiment, comparison.arm
    table = comparison.overview()
    lines = [
        f"# {for_markdown(experiment.name)}",
        "",
        f"{for_markdown(comparison.about.title)}, {arm.nv} joints, {experiment.duration:g} s, "
        f"control period {1e3 * experiment.period:g} ms.",
        "",
        *(f"- {for_markdown(line)}" for line in comparison.notes),
        *(f"- Warning: {for_markdown(line)}" for line in comparison.warnings),
        *(f"- URDF: {for_markdown(line)}" for line in arm.warnings),
        "",
        f"## {for_markdown(table.title)}, worst error and chatter",
        "",
        markdown_table(table),
        "",
        "Worst error: the largest of all joints. Chatter: torque variation per second, summed over the joints. "
        + figures_read(comparison.rows, experiment.ensemble.q0_deviation).replace("Marked:", "Bold:"),
        *([] if comparison.refinement is None else [UNCONVERGED]),
        "",
        metric_tables_markdown(comparison.rows),
        "",
        theorems_markdown(comparison.theorems.claims),
    ]
    pairs = pair_table(comparison.rows)
    if pairs is not None:
        lines += ["", f"## {for_markdown(pairs.title)}", "", for_markdown(PAIRS_READ), "", markdown_table(pairs), ""]
    for extra in (tool_table(comparison.rows), comparison.refinement and comparison.refinement.table()):
        lines += ["", f"## {for_markdown(extra.title)}", "", markdown_table(extra), ""] if extra else []
    return "\n".join(lines)
