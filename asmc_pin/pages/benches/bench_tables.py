"""The findings of a benchmark as tables and sentences: for a terminal, Markdown and HTML."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from asmc_pin.pages.benches.bench_findings import SHIFT, BenchFindings
from asmc_pin.pages.sweeps.sweep_tables import AT_LEAST
from asmc_pin.pages.tables.text_table import Table, number
from asmc_pin.statistics.over_tasks import performance_ratios
from asmc_pin.statistics.pairwise import FAMILY_LEVEL, PairedComparison

HOW_RANKED = (
    "A problem is an arm with a task. Figure of a law on a problem: median over its held-out trials of the geometric "
    f"mean over the joints ({AT_LEAST}); ∞ where most trials failed, or no gains that were tried kept the limit. "
    "Rank 1 is the best law of a problem; equal figures, failures among them, share a rank. In brackets the 95 % "
    "interval (BCa) of the mean rank over which problems it might have been. Best in: problems in which the law is the "
    "first."
)
HOW_MEANT = (
    f"Shifted geometric mean (Π (x + s))^(1/n) − s of a law's n figures, s = {SHIFT:g}, so that neither the hardest "
    "nor the easiest problem rules it; of each task over the arms, and of all problems. ∞ where the law failed in one."
)
HOW_FAILED = (
    "Figure over that of the best law on the problem. Failed: no figure, since most held-out trials failed. Limit: no "
    "gains that were tried kept the noise limit. In brackets held-out trials that failed, or went beyond the limit."
)
HOW_PAIRED = (
    "Ratio: geometric mean over the problems of the better law's figure over the other's, with its 95 % interval (BCa "
    "bootstrap over problems); the median where failures make it infinite. p: Wilcoxon's signed-rank test over the "
    "problems, adjusted by Holm over all pairs of laws. Sure: yes where the interval excludes 1 and p is below "
    f"{FAMILY_LEVEL}; pair where only the interval does, which holds for that pair alone, not for all pairs at once."
)


def rank_table(findings: BenchFindings) -> Table:
    """Every law by its mean rank."""
    best = np.min(findings.figures, axis=0)
    ratios = performance_ratios(findings.figures)
    rows = []
    for k in findings.order:
        mean = findings.ranks[k]
        first = int(np.sum(np.isfinite(findings.figures[k]) & (findings.figures[k] == best)))
        within = float(np.mean(ratios[k] <= 2.0))
        name = findings.laws[k] + (" (proposed)" if findings.laws[k] == findings.proposed else "")
        rows.append(
            [
                name,
                f"{mean.rank:.2f} [{mean.low:.2f}, {mean.high:.2f}]",
                str(first),
                f"{100.0 * within:.0f} %",
                str(int(findings.lost[k])),
                str(int(findings.failed[k].sum())),
                str(int(findings.over[k].sum())),
            ]
        )
    header = ["law", "mean rank [95 %]", "best in", "within 2× of best", "problems failed", "trials failed"]
    return Table(f"{len(findings.problems)} problems", [*header, "trials over"], rows)


def mean_table(findings: BenchFindings) -> Table:
    """Every law by its shifted geometric means."""
    columns = [findings.means(task) for task in (*findings.tasks, None)]
    rows = [[findings.laws[k], *(number(float(x[k])) for x in columns)] for k in findings.order]
    header = ["law", *(f"{name} [{findings.unit}]" for name in (*findings.tasks, "all"))]
    return Table("Shifted geometric means", header, rows)


def problem_table(findings: BenchFindings) -> Table:
    """Every law on every problem, over the best there."""
    ratios = performance_ratios(findings.figures)
    header = ["law", *(f"{arm} {task}" for arm, task in findings.problems)]
    rows = []
    for k in findings.order:
        cells = []
        for j in range(len(findings.problems)):
            note = [
                f"{n} {word}" for n, word in ((findings.failed[k, j], "failed"), (findings.over[k, j], "over")) if n
            ]
            told = "limit" if findings.unkept[k, j] else "failed" if np.isinf(ratios[k, j]) else number(ratios[k, j])
            cells.append(told + (f" ({note[0]})" if note and told not in ("limit", "failed") else ""))
        rows.append([findings.laws[k], *cells])
    return Table("Figure over the best law's", header, rows)


def pair_table_of(findings: BenchFindings, law: str) -> Table:
    """A law against each other one."""
    rows = []
    for other, each in findings.verdicts_on(law):
        ratio = f"{number(each.ratio)} [{number(each.low)}, {number(each.high)}]"
        rows.append([other, each.better, ratio, number(each.p), _sure(each)])
    return Table(f"{law} against each", ["against", "better", "better / worse [95 %]", "p", "sure"], rows)


def bench_lines(findings: BenchFindings) -> list[str]:
    """What was run, who is ahead, where the proposed law stands, and who fails where."""
    told = [f"conditions {findings.sha256[:16]}: {findings.conditions}"]
    if findings.scope:
        told.append(f"a part of the suite only, no result of {findings.suite}: {findings.scope}")
    first = findings.order[0]
    mean = findings.ranks[first]
    told.append(
        f"smallest mean rank: {findings.laws[first]}, {mean.rank:.2f} [{mean.low:.2f}, {mean.high:.2f}] of "
        f"{len(findings.laws)} laws on {len(findings.problems)} problems"
    )
    told += _proposed(findings)
    return [*told, *failure_lines(findings)]


def _proposed(findings: BenchFindings) -> Iterator[str]:
    law = findings.proposed
    if law not in findings.laws:
        return
    k = list(findings.laws).index(law)
    mean, place = findings.ranks[k], findings.order.index(k) + 1
    pairs = findings.verdicts_on(law)
    yield (
        f"the proposed law, {law}: place {place} of {len(findings.laws)} by mean rank, {mean.rank:.2f} "
        f"[{mean.low:.2f}, {mean.high:.2f}]; failed in {int(findings.lost[k])} of {len(findings.problems)} problems"
    )
    for sure, note in (("yes", ""), ("pair", " (pair by pair, not adjusted for all pairs at once)")):
        how = "surely " if sure == "yes" else ""
        for better, order in ((True, "better than"), (False, "worse than")):
            names = [other for other, each in pairs if _sure(each) == sure and (each.better == law) == better]
            if names:
                yield f"{law} is {how}{order} {', '.join(names)}{note}"
    open_ = [other for other, each in pairs if not each.certain]
    if open_:
        yield f"{law} is not surely apart from {', '.join(open_)}"


def _sure(each: PairedComparison) -> str:
    """How sure the order of a pair is: for all pairs at once, for this one by itself, or not."""
    if not each.certain:
        return "no"
    return "yes" if each.certain_in_family else "pair"


def failure_lines(findings: BenchFindings) -> Iterator[str]:
    """Which law fails in which problems; nothing of those that fail nowhere."""
    for k in findings.order:
        where = [f"{arm} {task}" for j, (arm, task) in enumerate(findings.problems) if findings.unkept[k, j]]
        if where:
            yield f"{findings.laws[k]}: no gains that were tried kept the limit in {', '.join(where)}"
        lost = np.isinf(findings.figures[k]) & ~findings.unkept[k]
        where = [f"{arm} {task}" for j, (arm, task) in enumerate(findings.problems) if lost[j]]
        if where:
            yield f"{findings.laws[k]}: most held-out trials failed in {', '.join(where)}"
