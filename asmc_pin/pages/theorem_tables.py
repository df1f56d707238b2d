"""The paper's theorems held against the runs, as tables and text."""

from __future__ import annotations

import math

import pandas as pd

from asmc_pin.monitors import BAEK, CAUSES, STATEMENTS
from asmc_pin.monitors.claim_texts import tick_share, verdict_text
from asmc_pin.pages.tables.text_table import Table, markdown_table, number
from asmc_pin.words.media import for_latex, for_markdown

TITLE = "The paper's theorems, held against these runs"
INTRODUCTION = (
    "Of the first trial of each controller. Claims about the arm as it is simulated, with the armature, payload and "
    "locked joints named at the top. Computed from the trajectories and the plant, which knows Γ (docs/monitors.md). "
    "Γ* is the largest TDE error of the run itself, so the bounds made from it are checks of consistency, no "
    "predictions. The proofs are in continuous time: a sampled loop may break them, and the reason is given."
)


def asked(claims: pd.DataFrame) -> list[str]:
    """Keys of the claims that are shown: those of the paper, and of other sources those that a controller is asked."""
    speaking = set(claims.claim[claims.status != "not applicable"])
    return [key for key in STATEMENTS if key in BAEK or key in speaking]


def theorem_table(claims: pd.DataFrame) -> Table:
    """A row for each claim that is `asked`, a column for each controller.

    Args:
        claims: See `asmc_pin.monitors.claim_rows`.
    """
    labels = list(dict.fromkeys(claims.controller))
    rows = []
    for key in asked(claims):
        statement = STATEMENTS[key]
        cells = [_cell(claims[(claims.controller == label) & (claims.claim == key)]) for label in labels]
        rows.append([f"{statement.title}: {statement.text}", *cells])
    return Table(TITLE, ["claim", *labels], rows)


def _cell(rows: pd.DataFrame) -> str:
    """One claim on all trials of a controller: the verdict, and the worst of what is broken; empty without rows."""
    if rows.empty:
        return ""
    key, broken = str(rows.claim.iloc[0]), rows[rows.status == "broken"]
    if broken.empty:
        ends = {status: rows.until[rows.status == status].min() for status in rows.status.unique()}
        return " or ".join(verdict_text(key, status, math.nan, math.nan, "", [], end) for status, end in ends.items())
    share = tick_share(key, int(broken.broken.sum()), int(rows.checked.sum()))
    until = math.nan if len(rows) > 1 else broken.until.iloc[0]
    text = verdict_text(key, "broken", broken.first_time.min(), broken.amount.max(), share, _causes(broken), until)
    if len(rows) == 1:
        return text
    diverged = int(rows.until.notna().sum())
    return f"{text}; {len(broken)} of {len(rows)} trials broken" + (f"; {diverged} diverged" if diverged else "")


def _causes(broken: pd.DataFrame) -> list[str]:
    """The causes where they account for every broken tick; else none is named."""
    ticks = {cause: int(broken[cause].sum()) for cause in CAUSES}
    return [cause for cause, count in ticks.items() if count] if sum(ticks.values()) == broken.broken.sum() else []


def reasons(claims: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Controller by controller: what was seen and why, a line for each claim on its first trial that is not held.

    Claims that are not applicable for one and the same reason share a line.
    """
    found = []
    for label, rows in claims.groupby("controller", sort=False):
        lines: dict[str, list[str]] = {}
        order = {"broken": 0, "not tested": 1, "not tested after": 2, "held": 3, "not applicable": 4}
        for key, each in rows.groupby("claim", sort=False):
            first = each.iloc[each.status.map(order).argmin()]
            if first.reason:
                where = f" in trial {first.trial}" if len(each) > 1 else ""
                status = f"{first.status} {first.until:.4g} s" if first.status == "not tested after" else first.status
                lines.setdefault(f"{status}{where}: {first.reason}", []).append(STATEMENTS[str(key)].title)
        found.append((str(label), [f"{', '.join(titles)} {text}" for text, titles in lines.items()]))
    return found


def theorems_latex(claims: pd.DataFrame, about: str) -> str:
    """A ``table`` environment: a row for each controller, a column for each claim; it needs ``booktabs``.

    A broken claim has the share of the ticks checked in which it is, where it is judged tick by tick.

    Args:
        claims: See `asmc_pin.monitors.claim_rows`.
        about: The arm with all that is supposed about it.
    """
    shown = asked(claims)
    # Across both columns of a page; what is broken by what takes more than a line.
    size, gap, label_share, share = (
        (r"\footnotesize", 3, 0.15, 0.12) if len(shown) <= 6 else (r"\scriptsize", 2, 0.11, 0.07)
    )
    lines = [
        r"\begin{table*}[t]",
        rf"  \centering{size}\setlength{{\tabcolsep}}{{{gap}pt}}",
        rf"  \caption{{The theorems of Baek, Jin and Han (2016), held against the runs on {for_latex(about)}.}}",
        r"  \label{tab:theorems}",
        rf"  \begin{{tabular}}{{l{'l' * len(shown)}}}",
        r"    \toprule",
        "    Controller & " + " & ".join(STATEMENTS[key].latex for key in shown) + r" \\",
        r"    \midrule",
    ]
    for label, rows in claims.groupby("controller", sort=False):
        cells = [_narrow(_latex_cell(rows[rows.claim == key]), share) for key in shown]
        lines.append("    " + " & ".join([_narrow(for_latex(str(label)), label_share), *cells]) + r" \\")
    lines += [r"    \bottomrule", r"  \end{tabular}", r"\end{table*}", ""]
    return "\n".join(lines)


def _narrow(text: str, share: float) -> str:
    """A cell that breaks its lines, and has a share of the page's width."""
    return rf"\parbox[t]{{{share:.3g}\textwidth}}{{\raggedright {text}}}"


def _latex_cell(rows: pd.DataFrame) -> str:
    broken = rows[rows.status == "broken"]
    if broken.empty:
        end = rows.until.min()
        said = {"not applicable": "--", "not tested after": rf"not tested after {end:.4g}\,s"}
        return " or ".join(said.get(status, str(status)) for status in rows.status.unique())
    by = f" by {' and '.join(_causes(broken))}" if _causes(broken) else ""
    share = 100.0 * broken.broken.sum() / max(rows.checked.sum(), 1)
    return f"broken{by}" if rows.checked.max() <= 1 else rf"broken{by} ({number(share, 2)}\,\%)"


def theorem_lines(claims: pd.DataFrame) -> list[str]:
    """A line for each controller of whose own source a claim is judged, for a terminal."""
    lines = []
    everywhere = [key for key, item in BAEK.items() if not item.adaptive]
    for label, every in claims.groupby("controller", sort=False):
        rows = every[every.status != "not applicable"]
        if rows.claim.isin(everywhere).all():
            continue
        alike: dict[str, list[str]] = {}
        for key, each in rows.groupby("claim", sort=False):
            alike.setdefault(_cell(each), []).append(STATEMENTS[str(key)].title)
        ordered = sorted(alike.items(), key=lambda item: item[0].startswith("broken"))
        parts = [f"{', '.join(titles)} {said}" for said, titles in ordered]
        lines.append(f"theorems on {label}: {'; '.join(parts)}")
    return lines


def theorems_markdown(claims: pd.DataFrame) -> str:
    """The table and the reasons."""
    parts = [f"## {TITLE}", "", INTRODUCTION, "", markdown_table(theorem_table(claims)), ""]
    for label, lines in reasons(claims):
        parts += [f"**{for_markdown(label)}**", "", *(f"- {for_markdown(line)}" for line in lines), ""]
    return "\n".join(parts)
