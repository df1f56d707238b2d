"""The summary as a LaTeX table, for a paper."""

from __future__ import annotations

import re
from collections.abc import Sequence

import pandas as pd

from asmc_pin.metrics import METRICS, MOVED
from asmc_pin.pages.summary_tables import metric_table
from asmc_pin.results.ensemble_summary import alike
from asmc_pin.words.media import for_latex


def latex_table(summary: pd.DataFrame, metrics: Sequence[str] | None = None) -> str:
    """A ``table`` environment: a block for each metric, a row for each controller, a column for each joint.

    It needs ``booktabs`` and nothing else. Joints are numbered, base first; the caption names them.

    Args:
        summary: Rows of a comparison.
        metrics: Which metrics to show; those that a person reads first when omitted.
    """
    joints = list(dict.fromkeys(summary.joint))
    experiment, arm = str(summary.experiment.iloc[0]), str(summary.arm.iloc[0])
    names = [key for key, metric in METRICS.items() if metric.main] if metrics is None else list(metrics)
    listed = ", ".join(f"{i + 1}: {for_latex(joint)}" for i, joint in enumerate(joints))
    count = len(joints)
    environment, size = _room(summary, joints, names)
    spread = (
        rf" Medians of {summary.trial.nunique()} trials with 5\,\% below and 95\,\% above; bold: best with certainty."
        if not alike(summary)
        else ""
    )
    refined = r" $\pm$: what half the integration step changes." if f"{MOVED}rms_error" in summary else ""
    lines = [
        r"% Needs \usepackage{booktabs}.",
        rf"\begin{{{environment}}}[t]",
        r"  \centering",
        *([] if size is None else [rf"  {size}\setlength{{\tabcolsep}}{{3pt}}"]),
        rf"  \caption{{Comparison ``{for_latex(experiment)}'' on {for_latex(arm)}; joints {listed}.{spread}{refined}}}",
        rf"  \label{{tab:{re.sub(r'[^A-Za-z0-9-]', '-', experiment)}}}",
        rf"  \begin{{tabular}}{{l{'r' * count}}}",
        r"    \toprule",
        rf"    & \multicolumn{{{count}}}{{c}}{{Joint}} \\",
        rf"    \cmidrule(l){{2-{count + 1}}}",
        "    Controller & " + " & ".join(str(i + 1) for i in range(count)) + r" \\",
    ]
    for name in names:
        table = metric_table(summary, name)
        units = re.findall(r"\[(.+?)\]$", table.title)
        title = for_latex(table.title.partition(" [")[0]) + (f" [{for_latex(units[0])}]" if units else "")
        lines += [r"    \midrule", rf"    \multicolumn{{{count + 1}}}{{l}}{{\emph{{{title}}}}} \\"]
        rows = [[for_latex(cell) for cell in row] for row in table.rows]
        for row, column in table.marked():
            rows[row][column] = rf"\textbf{{{rows[row][column]}}}"
        for (row, column), (low, high) in table.ranges.items():
            rows[row][column] += rf" $_{{{_math(low)}}}^{{{_math(high)}}}$"
        lines += ["    " + " & ".join(row) + r" \\" for row in rows]
    lines += [r"    \bottomrule", r"  \end{tabular}", rf"\end{{{environment}}}", ""]
    return "\n".join(lines)


def _room(summary: pd.DataFrame, joints: Sequence[str], names: Sequence[str]) -> tuple[str, str | None]:
    """The environment of a table that is to fit a two-column journal, and a smaller type where it needs one.

    Counted in digits of 5 pt: a column of such a page has room for some 46 of them, both together for some 98. Figures
    in an index are two thirds as wide.
    """
    widths = [max(len(str(label)) for label in dict.fromkeys(summary.controller))] + [1] * len(joints)
    for name in names:
        table = metric_table(summary, name)
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row[1:], start=1):
                ends = table.ranges.get((i, j))
                index = 0.7 * max(map(len, ends)) if ends else 0.0
                widths[j] = max(widths[j], round(len(cell) + index + 0.5))
    digits = sum(widths) + 2.4 * len(widths)
    environment = "table" if digits <= 46 else "table*"  # across both columns of a page
    return environment, r"\footnotesize" if digits > 98 else None


def _math(figure: str) -> str:
    return {"∞": r"\infty"}.get(figure, figure)
