"""How sure the order of two controllers is, as a table, and the words beside tables of medians."""

from __future__ import annotations

import pandas as pd

from asmc_pin.metrics import METRICS
from asmc_pin.pages.tables.text_table import Table, number
from asmc_pin.results.ensemble_summary import alike, paired, starts_words

PAIRS_READ = (
    "Geometric mean over joints and trials of the better figure over the worse in the same trial, with the 95 % "
    "interval of BCa's bootstrap; the order is certain if that excludes 1. p: Wilcoxon's signed-rank test, adjusted by "
    "Holm over all rows. Improvement: how probable it is that a trial of the better has the smaller figure. All of it "
    "is about numerical sensitivity, for this plant and these gains; plants that differ may turn the order round."
)


def figures_read(summary: pd.DataFrame, deviation: float) -> str:
    """How the figures of a table are to be read, for the words beside it."""
    trials = summary.trial.nunique()
    tripped = " (under “trips”: never)" if summary.trip_time.notna().any() else ""
    if trials == 1:
        return f"Marked: the best figure of a column, in this single run. Dash: not defined{tripped}."
    if alike(summary):
        return (
            f"All {trials} trials are the same to the last bit: how sure a figure is, is not known. Marked: the best "
            f"figure of a column. Dash: not defined{tripped}."
        )
    return (
        f"Figures are medians of {trials} trials from {starts_words(deviation)}, with their 5 % … 95 % where "
        "that differs: numerical sensitivity for this plant and these gains. A trial that diverged counts as worse "
        "than any figure. Marked: the best figure of a column, where its paired ratio to every other excludes 1. "
        f"Dash: not defined{tripped}, or most trials diverged."
    )


def pair_table(summary: pd.DataFrame) -> Table | None:
    """Every pair of controllers by the metrics that come first; None of one controller, or a single trial."""
    found = paired(summary)
    if not found:
        return None
    rows, ranges = [], {}
    for i, item in enumerate(found):
        order = "certain" if item.certain else "not certain"
        figures = [number(item.ratio), number(item.p, 2), number(item.improvement, 2)]
        rows.append([f"{METRICS[item.metric].title}: {item.better} < {item.worse}", *figures, order])
        ranges[i, 1] = number(item.low), number(item.high)
    header = ["figures of two controllers", "better / worse", "p", "improvement", "order"]
    return Table("How sure the order of two controllers is", header, rows, ranges=ranges)
