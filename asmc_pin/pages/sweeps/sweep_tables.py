"""The findings of a sweep as tables and sentences: for a terminal, Markdown and HTML."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.metrics import METRICS, QUANTITIES
from asmc_pin.pages.sweeps.sweep_findings import FAILURE, Compared, SweepFindings
from asmc_pin.pages.tables.text_table import NOTHING, Table, number
from asmc_pin.statistics.order_statistics import spread_of

AT_LEAST = "a joint below 1e-6, 1e-12 for a square, counts as that"
"""What `asmc_pin.statistics.joint_mean` does, for the notes under tables."""
HOW_SCORED = (
    f"The figure of a trial is the geometric mean over the joints, in SI units ({AT_LEAST}). Median, and in brackets "
    "the 5 % and 95 % quantiles over the trials; a run that failed is worse than any figure (∞) and never left out."
)
HOW_COMPARED = (
    "Trials are paired: in each, all controllers meet the same plant, start, noise and motion. The ratio is the better "
    "one's figure over the other's, its geometric mean over the draws with a 95 % bootstrap interval (BCa); the median "
    "where failures make it infinite. p: Wilcoxon's signed-rank test, adjusted by Holm over the rows of a table. "
    "Chance: that a trial of the better one has a smaller figure than one of the other. Sure: the interval excludes 1, "
    "on at least 6 draws."
)
HOW_SCANNED = (
    "One key at a time from the start of its scan up a ladder of 8 steps to the first failure, then by bisection; all "
    "else as drawn, grids at the file's own value. A failure between two steps that both pass is not seen."
)
PASSED_ALL = "no failure seen up to"
ALIKE = "nothing in this experiment is random: all draws are the same trial, and there is nothing to be sure of"


def distribution_table(findings: SweepFindings, point: int | None) -> Table:
    """Median and quantiles of every controller.

    Args:
        findings: The sweep's.
        point: Of the grids; None for all trials of all points.
    """
    where = "all trials" if point is None else findings.points[point]
    header = ["controller", "failed"]
    header += [f"{METRICS[name].title} [{unit_of(findings, name)}]" for name in findings.scores]
    rows = []
    for label in findings.labels:
        figures = [by_label[label] for by_label in findings.scores.values()]
        flat = [x.ravel() if point is None else x[:, point] for x in figures]
        failed = int(np.isinf(flat[0]).sum()) if flat else 0
        rows.append([label, f"{failed} of {flat[0].size}", *map(spread_text, flat)])
    return Table(where, header, rows)


def scan_table(findings: SweepFindings, path: str) -> Table:
    """How far each controller came along a scan."""
    header = ["controller", "first failure at", "no failure seen up to the end"]
    rows = []
    axis = next(axis for axis in findings.experiment.variation.scans if axis.path == path)
    low, high = axis.scan or (math.nan, math.nan)
    for label, ends in findings.fails_at[path].items():
        rows.append([label, _reach_text(ends, high), f"{int(np.isinf(ends).sum())} of {ends.size}"])
    factor = ", as a factor" if axis.factor else ""
    until = "".join(f", or {name} above {limit:g}" for name, limit in axis.until.items())
    return Table(f"{path} from {low:g} to {high:g}{factor}: fails where it diverges{until}", header, rows)


def scan_lines(findings: SweepFindings) -> list[str]:
    """How far each controller came along each scan, a line for each."""
    found = []
    for path in findings.fails_at:
        table = scan_table(findings, path)
        for label, reach, _ in table.rows:
            found.append(
                f"{table.title}: {label} {reach if reach.startswith(PASSED_ALL) else f'first seen at {reach}'}"
            )
    return found


def _reach_text(ends: Array, end: float) -> str:
    """First failures in words: an infinite one lies beyond the scan's end, or nowhere."""
    if np.isinf(ends).all():
        return f"{PASSED_ALL} {end:g}"
    return spread_text(ends).replace(number(math.inf), f"beyond {end:g}")


def comparison_table(findings: SweepFindings, point: int | None) -> Table:
    """Every pair of controllers, at one point or over all together."""
    header = ["better", "worse", "by", "ratio [95 %]", "p", "chance", "sure"]
    rows = []
    for item in findings.comparisons:
        if item.point == point:
            each = item.paired
            interval = f"{number(each.ratio)} [{number(each.low)}, {number(each.high)}]"
            won = f"{100.0 * each.improvement:.0f} %"
            sure = "yes" if each.certain else "no"
            rows.append([each.better, each.worse, measure(each.metric), interval, number(each.p), won, sure])
    return Table("all draws" if point is None else findings.points[point], header, rows)


def verdict_lines(findings: SweepFindings) -> list[str]:
    """Who is better by each metric, over all points, and how sure that is."""
    if findings.alike and len(findings.labels) > 1:
        return [ALIKE]
    overall = [item for item in findings.comparisons if item.point is None]
    return [_verdict(findings, name, overall) for name in dict.fromkeys(item.paired.metric for item in overall)]


def _verdict(findings: SweepFindings, metric: str, overall: list[Compared]) -> str:
    pairs = [item.paired for item in overall if item.paired.metric == metric]
    beaten = {label: [p for p in pairs if p.better == label and p.certain] for label in findings.labels}
    winner = next((label for label in findings.labels if len(beaten[label]) == len(findings.labels) - 1), None)
    if winner is None:
        return f"{measure(metric)}: no controller is better than all others with certainty"
    closest = max(beaten[winner], key=lambda p: p.ratio)
    ratio = f"{number(closest.ratio)} [{number(closest.low)}, {number(closest.high)}]"
    over, unlike = "", _points_without(findings, metric, winner)
    if unlike is not None:
        over = f" in the mean over {len(findings.points)} points"
    said = f"{measure(metric)}: {winner} is better than all others{over}; next is {closest.worse}, ratio {ratio}"
    if unlike:
        where = f" ({findings.points[unlike[0]]})" if len(unlike) == 1 else ""
        said += f"; not surely so at {len(unlike)} of the points{where}"
    # A few trials that went badly can decide a mean, while in most the order is the other one.
    doubted = [
        f"{pair.worse} (p {number(pair.p)}, chance {100.0 * pair.improvement:.0f} %)"
        for pair in beaten[winner]
        if not pair.certain_in_family
    ]
    return f"{said}; sure by the mean alone, not by ranks, against {', '.join(doubted)}" if doubted else said


def _points_without(findings: SweepFindings, metric: str, winner: str) -> list[int] | None:
    """Points of the grids at which the winner of the mean over all is not surely ahead of all; None without points."""
    ahead: dict[int, int] = {}
    for item in findings.comparisons:
        if item.point is not None and item.paired.metric == metric:
            mine = item.paired.better == winner and item.paired.certain
            ahead[item.point] = ahead.get(item.point, 0) + mine
    return [point for point, beaten in ahead.items() if beaten < len(findings.labels) - 1] if ahead else None


def failure_lines(findings: SweepFindings) -> list[str]:
    """Which controllers diverged in how many runs; nothing where none did."""
    return [f"{label} diverged in {count} of {findings.runs} runs" for label, count in findings.failed.items() if count]


def shown_points(findings: SweepFindings, most: int = 12) -> Iterator[int]:
    """Points of the grids that have a table of their own; none where there is one point only, or too many to read."""
    if 1 < len(findings.points) <= most:
        yield from range(len(findings.points))


def measure(metric: str) -> str:
    """What a comparison is by, in words."""
    if metric.startswith(FAILURE):
        return f"way to the first failure along {metric.removeprefix(FAILURE)}"
    return METRICS[metric].title


def unit_of(findings: SweepFindings, metric: str) -> str:
    """Its SI unit on the joints of these arms."""
    return unit_on(findings.kinds, metric)


def unit_on(kinds: frozenset[str], metric: str) -> str:
    """SI unit of a metric on joints of these kinds, ``"revolute"`` and ``"prismatic"``."""
    revolute, prismatic = QUANTITIES[METRICS[metric].quantity]
    units = [unit for kind, unit in (("revolute", revolute), ("prismatic", prismatic)) if kind in kinds]
    return " or ".join(dict.fromkeys(units))


def spread_text(figures: Array) -> str:
    """Median with its quantiles."""
    if np.isnan(figures).any():
        return NOTHING
    found = spread_of(figures)
    middle, low, high = (number(float(x)) for x in (found.median, found.low, found.high))
    return f"{middle} [{low}, {high}]"
