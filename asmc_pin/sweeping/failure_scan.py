"""Where a controller fails along one axis: up a ladder to the first failure, then bisection.

What is found is the first failure that the ladder meets, and between its last rung without one and that rung, by
bisection, a value that passes next to one that fails. Failures between two rungs that both pass are not seen.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asmc_pin.experiment.variation.axes import VariedKey
from asmc_pin.sweeping.lockstep import TrialTables
from asmc_pin.sweeping.trial_runs import TrialOutcome, TrialRuns

RUNGS = 8
"""Steps of the ladder from one end of the scan to the other."""

HALVINGS = 6
"""Bisections between two rungs: the point of failure is known to 1/512 of the scan."""


@dataclass(frozen=True)
class ScanEnd:
    """How far one controller came in one trial.

    Attributes:
        reached: Largest value that passed before the first failure; the start where that failed itself.
        passed: Whether it did.
        fails_at: Smallest value that failed; infinite where the end of the scan passed.
        outcome: What the controller made of the trial at `reached`.
    """

    reached: float
    passed: bool
    fails_at: float
    outcome: TrialOutcome


def scan_ends(
    runs: TrialRuns, axis: VariedKey, jobs: Sequence[TrialTables], labels: Sequence[str]
) -> dict[tuple[int, str], ScanEnd]:
    """Scan one axis in several trials, all of them and all controllers a stage at a time.

    A controller that has not got the scanned key runs once in each trial: wherever the key stands, it does the same.

    Args:
        runs: Runs trials.
        axis: What is scanned.
        jobs: The trials, whose tables hold everything but the scanned value.
        labels: Controllers.

    Returns:
        By position in `jobs`, and label.
    """
    assert axis.scan is not None
    start, end = axis.scan
    found: dict[tuple[int, str], ScanEnd] = {}
    rungs = [start + (end - start) * rung / RUNGS for rung in range(RUNGS)] + [end]
    pairs = [(i, label) for i in range(len(jobs)) for label in labels]
    for pair, outcome in _at(runs, axis, jobs, {p: start for p in pairs if not axis.concerns(p[1])}).items():
        fails = outcome.failed(axis.until)
        found[pair] = ScanEnd(start if fails else end, not fails, start if fails else math.inf, outcome)
    climbing = [pair for pair in pairs if pair not in found]
    for value in rungs:
        outcomes = _at(runs, axis, jobs, {pair: value for pair in climbing})
        for pair in list(climbing):
            if outcomes[pair].failed(axis.until):
                before = found.get(pair)
                found[pair] = ScanEnd(
                    value if before is None else before.reached,
                    before is not None,
                    value,
                    outcomes[pair] if before is None else before.outcome,
                )
                climbing.remove(pair)
            else:
                found[pair] = ScanEnd(value, True, math.inf, outcomes[pair])
    for _ in range(HALVINGS):
        between = {
            pair: 0.5 * (each.reached + each.fails_at)
            for pair, each in found.items()
            if each.passed and math.isfinite(each.fails_at)
        }
        for pair, outcome in _at(runs, axis, jobs, between).items():
            value, each = between[pair], found[pair]
            if outcome.failed(axis.until):
                found[pair] = ScanEnd(each.reached, True, value, each.outcome)
            else:
                found[pair] = ScanEnd(value, True, each.fails_at, outcome)
    return found


def _at(
    runs: TrialRuns, axis: VariedKey, jobs: Sequence[TrialTables], values: Mapping[tuple[int, str], float]
) -> dict[tuple[int, str], TrialOutcome]:
    """What each pair of trial and controller makes of its own value."""
    found: dict[tuple[int, str], TrialOutcome] = {}
    for label in dict.fromkeys(label for _, label in values):
        members = [(i, value) for (i, other), value in values.items() if other == label]
        placed = [TrialTables(jobs[i].trial, jobs[i].draw, axis.placed(jobs[i].tables, value)) for i, value in members]
        for (k, _), outcome in runs(placed, [label]).items():
            found[members[k][0], label] = outcome
    return found
