"""What a report says first: what was compared, who won at what and how surely, whether M̄ was allowed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from asmc_pin.condition.hypotheses import Premises
from asmc_pin.metrics import METRICS
from asmc_pin.pages.tables.text_table import number
from asmc_pin.results.ensemble_summary import (
    alike,
    ends,
    failed_words,
    failures,
    figures_by_trial,
    labels_of,
    paired,
    starts_words,
)
from asmc_pin.statistics.joint_mean import joint_mean
from asmc_pin.statistics.order_statistics import spread_of
from asmc_pin.statistics.pairwise import PairedComparison

_AT = {
    "rms_error": ("Follows the motion best", "RMS tracking error"),
    "max_error": ("Is never far off", "largest tracking error"),
    "torque_variation": ("Has the calmest torque", "chatter"),
}
"""What the smallest figure of a metric means to a person, and what the figure is; others by their own title."""


def compared(
    labels: list[str], about: Premises, duration: float, period: float, summary: pd.DataFrame, deviation: float
) -> str:
    """One sentence: which controllers, on which arm, for how long."""
    who = f"{_listed(labels)} followed" if len(labels) > 1 else f"{labels[0]} alone followed"
    trials = summary.trial.nunique()
    starts = "all alike" if alike(summary) else f"from {starts_words(deviation)}"
    each = f"; each ran {trials} times, {starts}" if trials > 1 else "; each ran once"
    return (
        f"{who} the same motion in simulation, {duration:g} s of it, on {about.title}, with a torque every "
        f"{1e3 * period:g} ms{each}."
    )


def winners(summary: pd.DataFrame) -> list[tuple[str, str]]:
    """Who won at what, and how surely: a heading and a sentence for each metric that a person reads first."""
    found = [(title, said) for title, said in map(lambda name: _winner(summary, name), _judged()) if said]
    over = [
        f"{label}: {failed_words(failed, ended)}"
        for label, failed, ended in zip(labels_of(summary), failures(summary), ends(summary), strict=True)
        if failed.any()
    ]
    return [*found, ("Did not last", "; ".join(over) + ".")] if over else found


def mbar_verdicts(claims: pd.DataFrame | None) -> dict[str, str]:
    """Of Lemma 1's condition along the motion by label, without laws that have no M̄.

    ``violated``; ``cut short`` where a trial diverged before the condition was broken; else ``unrefuted``.
    """
    if claims is None:
        return {}
    rows = claims[(claims.claim == "lemma1") & claims.status.isin(["held", "broken", "not tested after"])]
    by_rank = ("broken", "violated"), ("not tested after", "cut short"), ("held", "unrefuted")
    return {
        str(label): next(verdict for status, verdict in by_rank if (each.status == status).any())
        for label, each in rows.groupby("controller", sort=False)
    }


def allowed(verdicts: Mapping[str, str], trials: int = 1) -> str:
    """Whether the M̄ of each controller was allowed along the motion, in one or two sentences.

    Args:
        verdicts: See `mbar_verdicts`; they are about the first trial.
        trials: How many there are.
    """
    if not verdicts:
        return "Not known: the result holds no check of it, or no law here has an M̄."
    broken = [label for label, verdict in verdicts.items() if verdict == "violated"]
    short = [label for label, verdict in verdicts.items() if verdict == "cut short"]
    kept = [label for label in verdicts if label not in broken + short]
    said = []
    if broken:
        said.append(f"No, for {_listed(broken)}: the condition was broken on the way, and the theory promises nothing.")
    if kept:
        begin = "As far as the run shows" if broken or short else "Yes"
        where = "this motion" if trials == 1 else f"the first of {trials} trials"
        said.append(f"{begin}, for {_listed(kept)}: at every tick of {where} the condition held.")
    if short:
        said.append(f"Not known to its end, for {_listed(short)}: the condition held until the trial diverged.")
    if kept or short:
        said.append("Whether it holds at the other angles that the joints can take was not asked here.")
    return " ".join(said)


_OVER = "as the geometric mean over the joints"


def _judged() -> list[str]:
    return [name for name, metric in METRICS.items() if metric.main and metric.best == "smallest"]


def _winner(summary: pd.DataFrame, name: str) -> tuple[str, str]:
    heading, figure = _AT.get(name, (f"Smallest {METRICS[name].title}", METRICS[name].title))
    if summary.controller.nunique() < 2:
        return heading, ""
    pairs = [item for item in paired(summary) if item.metric == name]
    if pairs and (failures(summary).mean(axis=1) > 0.5).all():
        return heading, f"No one: all diverged in most of their trials ({figure})."
    return (heading, _by_pairs(pairs, figure)) if pairs else (heading, _by_medians(summary, name, figure))


def _by_pairs(pairs: list[PairedComparison], figure: str) -> str:
    """The controller that is ahead of all others, if its order to each is certain."""
    labels = list(dict.fromkeys(label for item in pairs for label in (item.better, item.worse)))
    ahead = {label: [item for item in pairs if item.better == label] for label in labels}
    best = max(labels, key=lambda label: len(ahead[label]))
    if len(ahead[best]) < len(labels) - 1:
        return f"No one is ahead of all others ({figure})."
    nearest = max(ahead[best], key=lambda item: item.ratio)
    unsure = [item.worse for item in ahead[best] if not item.certain]
    if unsure:
        return f"{best}, but its order to {_listed(unsure)} is not certain ({figure})."
    share = f"{number(nearest.ratio)} times that of {nearest.worse}, the next"
    return (
        f"{best}: its {figure}, {_OVER}, is {share} (95 %: {number(nearest.low)} … {number(nearest.high)}). Certain "
        "for this plant and these gains; other plants or gains may turn it round."
    )


def _by_medians(summary: pd.DataFrame, name: str, figure: str) -> str:
    """Of single runs the order alone: there is nothing to be certain by."""
    once = "Trials all alike" if summary.trial.nunique() > 1 else "One run each"
    medians = spread_of(np.moveaxis(figures_by_trial(summary, name), 1, 0)).median
    mean = joint_mean(medians, METRICS[name].least)
    order = [k for k in np.argsort(mean) if np.isfinite(mean[k])]
    labels = labels_of(summary)
    if not order:
        return ""
    if len(order) == 1:
        return f"{labels[order[0]]} ({figure}). {once}: how sure that is, is not known."
    share = number(float(mean[order[0]] / mean[order[1]]))
    return (
        f"{labels[order[0]]}: its {figure}, {_OVER}, is {share} times that of {labels[order[1]]}, the next. {once}: "
        "how sure that is, is not known."
    )


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
