"""What a sweep says of who is better: no more than both its interval and its test bear out."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from sweep_cases import tiny

from asmc_pin.pages.sweeps.sweep_findings import Compared, SweepFindings
from asmc_pin.pages.sweeps.sweep_tables import comparison_table, distribution_table, verdict_lines
from asmc_pin.statistics.pairwise import pairwise

BASE = np.exp(np.random.default_rng(8).normal(size=20))
"""What the draws do to all controllers alike."""


def findings(**figures):
    """A sweep of one point whose controllers have these RMS errors in its draws."""
    scores = {"rms_error": {label: x[:, None] for label, x in figures.items()}}
    return SweepFindings(
        experiment=tiny(),
        draws=len(BASE),
        labels=list(figures),
        points=[""],
        scores=scores,
        fails_at={},
        drawn={},
        failed=dict.fromkeys(figures, 0),
        kinds=frozenset({"revolute"}),
        alike=False,
        comparisons=[Compared(None, item) for item in pairwise({"rms_error": figures})],
    )


def test_who_is_better_in_nearly_every_draw_is_said_with_the_nearest_and_its_interval():
    (line,) = verdict_lines(findings(A=0.8 * BASE, B=BASE, C=3.0 * BASE))
    assert line == "RMS tracking error: A is better than all others; next is B, ratio 0.800 [0.800, 0.800]"


def test_a_mean_that_a_few_bad_draws_decide_against_the_ranks_is_told_as_that():
    """B has the smaller figure in 14 of 20 draws, and a hundred times the larger one in six."""
    found = findings(A=BASE, B=BASE * np.where(np.arange(20) < 14, 0.9, 100.0))
    (pair,) = (item.paired for item in found.comparisons)
    assert (pair.better, pair.certain) == ("A", True)
    assert pair.p > 0.05
    (line,) = verdict_lines(found)
    assert "A is better than all others; next is B" in line
    assert line.endswith("; sure by the mean alone, not by ranks, against B (p 1.00, chance 61 %)")


def test_where_no_order_is_sure_nobody_is_called_better():
    near = BASE * np.exp(0.05 * np.tile([1.0, -1.0], 10))
    (line,) = verdict_lines(findings(A=BASE, B=near))
    assert line == "RMS tracking error: no controller is better than all others with certainty"


def test_draws_that_failed_are_counted_and_reach_the_figures_that_they_are_part_of():
    found = findings(A=BASE, B=np.where(np.arange(20) < 3, math.inf, BASE))
    rows = {row[0]: row[1:] for row in distribution_table(found, None).rows}
    assert rows["A"][0] == "0 of 20"
    assert rows["B"][0] == "3 of 20"
    assert rows["B"][1].endswith(", ∞]")
    assert not rows["B"][1].startswith("∞")
    (row,) = comparison_table(found, None).rows
    assert row[:2] == ["A", "B"]
    assert float(row[4]) == pytest.approx(found.comparisons[0].paired.p, rel=0.01)


def test_a_mean_over_a_grid_says_that_it_is_one_and_at_how_many_points_the_order_is_another():
    """At the first point nobody is better, at the second A is: the mean over both alone says A."""
    two = {"A": np.stack([BASE, 0.1 * BASE], axis=1), "B": np.stack([BASE, BASE], axis=1)}
    over = {label: np.exp(np.log(x).mean(axis=1)) for label, x in two.items()}
    pairs = [Compared(None, item) for item in pairwise({"rms_error": over})]
    for point in range(2):
        here = {label: x[:, point] for label, x in two.items()}
        pairs += [Compared(point, item) for item in pairwise({"rms_error": here})]
    found = dataclasses.replace(findings(**over), points=["gain = 0", "gain = 5"], comparisons=pairs)
    (line,) = verdict_lines(found)
    assert line.startswith("RMS tracking error: A is better than all others in the mean over 2 points; next is B")
    assert line.endswith("; not surely so at 1 of the points (gain = 0)")
    (everywhere,) = verdict_lines(dataclasses.replace(found, comparisons=[c for c in pairs if c.point != 0]))
    assert "not surely so" not in everywhere
