"""The paper's theorems held against the runs, as tables and text."""

from __future__ import annotations

import pandas as pd

from asmc_pin.monitors import CAUSES, STATEMENTS
from asmc_pin.pages.summary_tables import Table, markdown_table, number
from asmc_pin.words.media import for_latex, for_markdown

TITLE = "The paper's theorems, held against these runs"
INTRODUCTION = (
    "Claims about the arm as it is simulated, with the armature, payload and locked joints named at the top. "
    "Computed from the trajectories and the plant, which knows Γ (docs/monitors.md). Γ* is the largest TDE error of "
    "the run itself, so the bounds made from it are checks of consistency, no predictions. The proofs are in "
    "continuous time: a sampled loop may break them, and the reason is given."
)


def theorem_table(claims: pd.DataFrame) -> Table:
    """A row for each claim, a column for each controller.

    Args:
        claims: See `asmc_pin.monitors.claim_rows`.
    """
    labels = list(dict.fromkeys(claims.controller))
    rows = []
    for key, statement in STATEMENTS.items():
        cells = [_cell(claims[(claims.controller == label) & (claims.claim == key)]) for label in labels]
        rows.append([f"{statement.title}: {statement.text}", *cells])
    return Table(TITLE, ["claim", *labels], rows)


def _cell(rows: pd.DataFrame) -> str:
    """One claim on all trials of a controller: the verdict, and the worst of what is broken."""
    broken = rows[rows.status == "broken"]
    if broken.empty:
        states = list(dict.fromkeys(rows.status))
        return " or ".join(states)
    worst = broken.iloc[int(broken.amount.argmax())]
    unit = "" if worst.unit == "1" else f" {worst.unit}"
    text = f"broken at {number(broken.first_time.min())} s, by up to {number(worst.amount)}{unit}"
    if worst.checked > 1:
        share = broken.broken.sum() / rows.checked.sum()
        text += f", {number(100.0 * share, 2)} % of the ticks"
    causes = [cause for cause in CAUSES if broken[cause].sum() > 0]
    text += f" ({', '.join(causes)})" if causes else ""
    return text if len(rows) == 1 else f"{text}; {len(broken)} of {len(rows)} trials"


def reasons(claims: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Controller by controller: what was seen and why, a line for each claim on its first trial that is not held.

    Claims that are not applicable for one and the same reason share a line.
    """
    found = []
    for label, rows in claims.groupby("controller", sort=False):
        lines: dict[str, list[str]] = {}
        order = {"broken": 0, "not tested": 1, "held": 2, "not applicable": 3}
        for key, each in rows.groupby("claim", sort=False):
            first = each.iloc[each.status.map(order).argmin()]
            if first.reason:
                where = f" in trial {first.trial}" if len(each) > 1 else ""
                lines.setdefault(f"{first.status}{where}: {first.reason}", []).append(STATEMENTS[str(key)].title)
        found.append((str(label), [f"{', '.join(titles)} {text}" for text, titles in lines.items()]))
    return found


def theorems_latex(claims: pd.DataFrame, about: str) -> str:
    """A ``table`` environment: a row for each controller, a column for each claim; it needs ``booktabs``.

    A broken claim has the share of the ticks in which it is, where it is judged tick by tick.

    Args:
        claims: See `asmc_pin.monitors.claim_rows`.
        about: The arm with all that is supposed about it.
    """
    lines = [
        r"\begin{table}[t]",
        r"  \centering",
        rf"  \caption{{The theorems of Baek, Jin and Han (2016), held against the runs on {for_latex(about)}.}}",
        r"  \label{tab:theorems}",
        rf"  \begin{{tabular}}{{l{'l' * len(STATEMENTS)}}}",
        r"    \toprule",
        "    Controller & " + " & ".join(item.latex for item in STATEMENTS.values()) + r" \\",
        r"    \midrule",
    ]
    for label, rows in claims.groupby("controller", sort=False):
        cells = [_latex_cell(rows[rows.claim == key]) for key in STATEMENTS]
        lines.append("    " + " & ".join([for_latex(str(label)), *cells]) + r" \\")
    lines += [r"    \bottomrule", r"  \end{tabular}", r"\end{table}", ""]
    return "\n".join(lines)


def _latex_cell(rows: pd.DataFrame) -> str:
    broken = rows[rows.status == "broken"]
    if broken.empty:
        return " or ".join("--" if status == "not applicable" else str(status) for status in rows.status.unique())
    share = 100.0 * broken.broken.sum() / max(rows.checked.sum(), 1)
    return "broken" if rows.checked.max() <= 1 else rf"broken ({number(share, 2)}\,\%)"


def theorem_lines(claims: pd.DataFrame) -> list[str]:
    """A line for each controller that all claims speak of, for a terminal."""
    lines = []
    for label, rows in claims.groupby("controller", sort=False):
        if (rows.status == "not applicable").any():
            continue
        parts = []
        for status in ("held", "not tested"):
            of_status = [key for key, each in rows.groupby("claim", sort=False) if set(each.status) == {status}]
            if of_status:
                parts.append(f"{', '.join(STATEMENTS[str(key)].title for key in of_status)} {status}")
        for key, each in rows.groupby("claim", sort=False):
            if (each.status == "broken").any():
                parts.append(f"{STATEMENTS[str(key)].title} {_cell(each)}")
        lines.append(f"theorems on {label}: {'; '.join(parts)}")
    return lines


def theorems_markdown(claims: pd.DataFrame) -> str:
    """The table and the reasons."""
    parts = [f"## {TITLE}", "", INTRODUCTION, "", markdown_table(theorem_table(claims)), ""]
    for label, lines in reasons(claims):
        parts += [f"**{for_markdown(label)}**", "", *(f"- {for_markdown(line)}" for line in lines), ""]
    return "\n".join(parts)
