"""The findings of a tuning as tables and sentences: for a terminal, Markdown and HTML."""

from __future__ import annotations

from typing import Any

import numpy as np

from asmc_pin.experiment.variation.key_units import unit_of_key
from asmc_pin.metrics import METRICS
from asmc_pin.pages.sweeps.sweep_tables import AT_LEAST, spread_text, unit_on
from asmc_pin.pages.tables.text_table import Table, number
from asmc_pin.pages.tunings.tune_findings import TunedController, TuneFindings

OVER = " (over a limit)"
"""Beside what was found of a controller none of whose candidates kept the limits."""

HOW_JUDGED = (
    f"Train: geometric mean over joints and training trials ({AT_LEAST}). Held out: median, and in brackets the 5 % "
    "and 95 % quantiles, of trials that no gain was chosen on; a run that failed is worse than any figure (∞) and "
    "never left out. Tuned / file: geometric mean of the ratio over the held-out draws with its 95 % interval (BCa); "
    "the median where failures make it infinite. Over: held-out trials beyond a limit, or "
    "failed; gains of the file that break a limit may well have less error than the best that keep it."
)
HOW_COMPARED = (
    "Tuned controllers on the held-out draws, in which all meet the same plant, start, noise and motion. Ratio: the "
    "better one's figure over the other's, with a 95 % interval. p: Wilcoxon's signed-rank test, adjusted by Holm over "
    "the rows. Sure: the interval excludes 1, on at least 6 draws; it is about "
    "the gains that this budget found, and another may find others."
)
HOW_GAINS = "Searched by a factor on the file's value, within the range beside it; a list as a whole unless [i] stands."


def result_table(findings: TuneFindings) -> Table:
    """How every controller did, in training and held out."""
    unit = unit_on(findings.kinds, findings.experiment.tune.objective)
    title = METRICS[findings.experiment.tune.objective].title
    header = ["controller", "candidates", f"train [{unit}]", f"held out [{unit}]", "failed", "over", "over (file)"]
    header.append("tuned / file")
    rows = []
    for item in findings.controllers:
        train = number(float(item.errors[item.winner])) + ("" if item.keeps_limits else OVER)
        change = f"{number(item.change.ratio)} [{number(item.change.low)}, {number(item.change.high)}]"
        share = f"{item.failed} of {item.held_out.size}"
        rows.append(
            [
                item.shown,
                str(item.trials),
                train,
                spread_text(item.held_out),
                share,
                str(item.over),
                str(item.over_start),
                change,
            ]
        )
    return Table(title, header, rows)


def gains_table(findings: TuneFindings) -> Table:
    """What was searched, from where, and what won."""
    rows = []
    for item in findings.controllers:
        if not item.ranges:
            rows.append([item.shown, "nothing that says what it is", "", "", ""])
        for name in item.setting:
            ends = [f"×{low:.3g} … {high:.3g}" for key, (low, high) in item.ranges.items() if key.split("[")[0] == name]
            unit = unit_of_key({"controllers": findings.experiment.controllers}, ("controllers", item.label, name))
            gain = f"{name} [{unit}]" if unit else name
            rows.append([item.shown, gain, _values(item.start[name]), _values(item.setting[name]), "; ".join(ends[:1])])
    return Table("Gains", ["controller", "gain", "file", "tuned", "range"], rows)


def pair_rows(findings: TuneFindings) -> Table:
    """Every pair of tuned controllers, held out; who kept no limit is marked, since that may be why it is better."""
    kept = {item.shown: item.shown + ("" if item.keeps_limits else OVER) for item in findings.controllers}
    rows = [
        [
            kept[each.better],
            kept[each.worse],
            f"{number(each.ratio)} [{number(each.low)}, {number(each.high)}]",
            number(each.p),
            f"{100.0 * each.improvement:.0f} %",
            "yes" if each.certain else "no",
        ]
        for each in findings.comparisons
    ]
    return Table("Held-out draws", ["better", "worse", "ratio [95 %]", "p", "chance", "sure"], rows)


def result_lines(findings: TuneFindings) -> list[str]:
    """What was asked, and what has to be said of each controller."""
    tune = findings.experiment.tune
    train, held = tune.train * findings.points, tune.held_out * findings.points
    told = [
        f"objective: {findings.objective}",
        f"{findings.budget} candidates of each controller on the same {train} training trial{'s' * (train > 1)}, seed "
        f"{findings.experiment.seed}; the best judged on {held} other{'s' * (held > 1)}",
    ]
    if tune.stable:
        told.append("only gains were run whose sampled loop is stable where it was searched, which is no proof")
    for item in findings.controllers:
        told += _remarks(item)
    return told


def _remarks(item: TunedController) -> list[str]:
    found = []
    if not item.ranges:
        found.append(f"{item.shown}: it has nothing that could be searched, and ran as it stands")
    if not np.isfinite(item.errors[item.winner]):
        found.append(f"{item.shown}: every candidate failed in training; the file's gains stand")
    elif not item.keeps_limits:
        found.append(f"{item.shown}: no candidate kept the limits; the one that exceeds them least stands")
    if item.refused:
        found.append(f"{item.shown}: {item.refused} of {item.trials} candidates were refused and count as failed")
    if item.failed:
        found.append(f"{item.shown}: failed in {item.failed} of {item.held_out.size} held-out trials")
    return found


def _values(value: Any) -> str:
    return ", ".join(f"{x:.4g}" for x in value) if isinstance(value, list) else f"{value:.4g}"
