"""What is made small, and what may not be exceeded, of a controller's training trials.

A failure is +∞ and stays in the mean, so gains that fail in one trial are worse than any that fail in none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.pages.sweeps.sweep_tables import unit_on
from asmc_pin.statistics.joint_mean import joint_mean
from asmc_pin.sweeping.trial_runs import TrialOutcome

CHATTER = "torque_variation"
LIMITED = {"chatter": CHATTER, "torque_noise": "torque_noise", "torque_rate": "torque_step"}
"""Limit of ``[tune] limits`` -> metric that it is about; of a rate, the metric times the period."""


@dataclass(frozen=True)
class Score:
    """What the trials of one setting come to.

    Attributes:
        error: The objective, geometric mean over joints and trials; +∞ where a trial failed.
        excess: Largest figure over its limit, of all joints, trials and limits; 0 without limits, +∞ for a failure.
        chatter: Torque variation, geometric mean over joints and trials, N·m/s (N/s); +∞ for a failure.
        failed: Trials that diverged, or in which the objective is not defined.
    """

    error: float
    excess: float
    chatter: float
    failed: int

    @property
    def within(self) -> bool:
        """Whether no trial failed and no limit is exceeded."""
        return self.failed == 0 and self.excess <= 1.0

    @property
    def value(self) -> float:
        """What the search makes small: the error, times the square of what is above the limits."""
        return self.error * max(1.0, self.excess) ** 2

    @property
    def rank(self) -> tuple[bool, float, float]:
        """By which settings are ordered: those within the limits by their error, then the rest by their excess."""
        return (False, self.error, 0.0) if self.within else (True, self.excess, self.error)


class Judge:
    """Scores outcomes by an experiment's objective and limits.

    Attributes:
        objective: Metric that is made small.
        limits: Metric -> largest figure of each joint, (nv,).
        kinds: Of the joints, ``"revolute"`` and ``"prismatic"``.
    """

    def __init__(self, experiment: Experiment) -> None:
        """Read ``[tune]``.

        Raises:
            ExperimentError: a limit is for another number of joints.
        """
        self.objective = experiment.tune.objective
        self.limits: dict[str, Array] = {}
        arm = experiment.build_arm()
        nv = arm.nv
        self.kinds = frozenset("prismatic" if kind == "prismatic" else "revolute" for kind in arm.joint_kinds)
        for key, metric in LIMITED.items():
            given = getattr(experiment.tune.limits, key)
            if given is None:
                continue
            values = np.asarray(given, dtype=np.float64)
            if values.ndim and values.size != nv:
                told = f"has {values.size} values, and the arm {nv} joints; give one number, or one for each joint"
                raise ExperimentError(f"tune.limits.{key}", told)
            scale = experiment.period if key == "torque_rate" else 1.0
            self.limits[metric] = np.array(np.broadcast_to(values * scale, (nv,)))

    @property
    def metrics(self) -> tuple[str, ...]:
        """What has to be measured."""
        return tuple(dict.fromkeys([self.objective, CHATTER, *self.limits]))

    def score(self, outcomes: Sequence[TrialOutcome]) -> Score:
        """What the trials of one setting come to."""
        figures = [trial_figure(each, self.objective) for each in outcomes]
        excess = 0.0
        for each in outcomes:
            for metric, limit in self.limits.items():
                shares = each.figures[metric] / limit
                excess = max(excess, float(np.max(np.where(np.isnan(shares), np.inf, shares))))
        failed = sum(not np.isfinite(x) for x in figures)
        chatter = [trial_figure(each, CHATTER) for each in outcomes]
        return Score(_mean(figures), np.inf if failed else excess, _mean(chatter), failed)

    def words(self) -> str:
        """Objective and limits in words."""
        said = [f"{METRICS[self.objective].title}, geometric mean over joints and trials"]
        for metric, limit in self.limits.items():
            numbers = ", ".join(f"{x:.4g}" for x in (limit[:1] if np.all(limit == limit[0]) else limit))
            said.append(f"{METRICS[metric].title} at most {numbers} {unit_on(self.kinds, metric)}")
        return "; ".join(said)


def trial_figure(outcome: TrialOutcome, metric: str) -> float:
    """A metric of one trial: its geometric mean over the joints, +∞ for one that failed or where it is not defined."""
    return figure_of(outcome.figures, metric, outcome.status)


def figure_of(figures: Mapping[str, Array], metric: str, status: str) -> float:
    """The same of the figures of a trial, (nv,)."""
    values = np.asarray(figures[metric], dtype=np.float64)
    if status != "ok" or np.isnan(values).any():
        return float("inf")
    return float(joint_mean(values, METRICS[metric].least))


def _mean(figures: Sequence[float]) -> float:
    """Geometric mean over trials; +∞ where one is."""
    return float(np.exp(np.mean(np.log(figures))))
