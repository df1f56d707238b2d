"""One controller tuned: searched on the training draws, judged on the others, and looked at about what won."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.baselines import shown_label
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.checks.controller_checks import controller_problems
from asmc_pin.experiment.law_lookup import load_law
from asmc_pin.pages.tunings.tune_findings import TunedController
from asmc_pin.statistics.paired_ratio import ratio_interval
from asmc_pin.sweeping.trial_runs import TrialOutcome
from asmc_pin.tuning.candidate_runs import CandidateRuns
from asmc_pin.tuning.fair_score import CHATTER, Judge, Score, trial_figure
from asmc_pin.tuning.gain_study import Candidate, GainStudy, best
from asmc_pin.tuning.search_space import search_space
from asmc_pin.tuning.stable_region import StableRegion

STEPS = tuple(2.0**x for x in (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0))
"""Factors on one gain of the winner at which its sensitivity is looked at."""

_REFUSED = Score(float("inf"), float("inf"), float("inf"), 0)

Tell = Callable[[int], None]
"""Told how many candidates are done."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Outcomes on the held-out draws, draw by draw, point by point.

    Attributes:
        tuned: Of the winner.
        start: Of the file's gains.
    """

    tuned: Sequence[TrialOutcome]
    start: Sequence[TrialOutcome]


class ControllerTuning:
    """The tuning of one controller of an experiment.

    Attributes:
        space: What is searched.
        candidates: What was tried, once `search` has run.
    """

    def __init__(self, experiment: Experiment, label: str) -> None:
        """Read what is to be done.

        Raises:
            ExperimentError: see `search_space`, `Judge` and `draws_of`.
        """
        self.experiment, self.space = experiment, search_space(experiment, label)
        self.candidates: list[Candidate] = []
        self._judge = Judge(experiment)
        self._runs = CandidateRuns(experiment, self.space, self._judge.metrics)
        tune = experiment.tune
        self.train = range(tune.train)
        self.held_out = range(tune.train, tune.train + tune.held_out)

    def check(self, storage: Path, key: str) -> None:
        """Refuse a journal of another tuning; see `GainStudy.check`."""
        GainStudy(self.space, self.experiment.seed, storage, key).check()

    def search(self, trials: int, storage: Path | None, key: str, tell: Tell = lambda _done: None) -> Candidate:
        """Try candidates up to the budget, and say which of them won.

        Args:
            trials: The budget.
            storage: Journal that keeps them; None for none.
            key: Of all that they depend on.
            tell: Told now and then.
        """
        study = GainStudy(self.space, self.experiment.seed, storage, key)
        self.candidates = study.run(trials, self.scores, tell)
        return best(self.candidates)

    def scores(self, settings: Sequence[Mapping[str, Any]]) -> list[Score]:
        """Scores of settings on the training draws; what the law or the stable region refuses is not run, and +∞."""
        found = [_REFUSED] * len(settings)
        run = [i for i, setting in enumerate(settings) if not self._refuses(setting)]
        outcomes = self._runs([settings[i] for i in run], self.train) if run else []
        for i, each in zip(run, outcomes, strict=True):
            found[i] = self._judge.score(each)
        return found

    def judged(self, winner: Candidate) -> HeldOut:
        """The winner and the file's gains on the held-out draws, by every metric."""
        runs = CandidateRuns(self.experiment, self.space)
        settings = [winner.setting, self.space.start()]
        if runs.refused(settings[0]):  # nothing that was tried could be run
            settings[0] = settings[1]
        tuned, start = runs(settings, self.held_out)
        return HeldOut(tuned, start)

    def sensitivity(self, winner: Candidate) -> dict[str, tuple[Array, Array]]:
        """Objective over the winner's when one gain alone is multiplied, on the training draws."""
        if not np.isfinite(winner.score.error):
            return {}
        moved: list[tuple[str, float, dict[str, Any]]] = []
        for gain in self.space.gains:
            value = winner.setting[gain.name]
            for step in STEPS:
                times = [step * x for x in value] if isinstance(value, list) else step * value
                moved.append((gain.name, step, {**winner.setting, gain.name: times}))
        scores = self.scores([setting for *_, setting in moved])
        found: dict[str, tuple[Array, Array]] = {}
        for gain in self.space.gains:
            here = [(1.0, winner.score.error)]
            here += [(step, s.error) for (name, step, _), s in zip(moved, scores, strict=True) if name == gain.name]
            factors, errors = (np.array(x) for x in zip(*sorted(here), strict=True))
            found[gain.name] = factors, errors / winner.score.error
        return found

    def found(self, winner: Candidate, judged: HeldOut, sensitivity: Mapping[str, Any]) -> TunedController:
        """What pages and tables are made from."""
        objective = self.experiment.tune.objective
        law = load_law(self.space.law, self.experiment.folder)
        tuned, start = (np.array([trial_figure(x, objective) for x in side]) for side in (judged.tuned, judged.start))
        scores = [item.score for item in self.candidates]
        return TunedController(
            label=self.space.label,
            shown=shown_label(self.space.label, law),
            law=self.space.law,
            start=self.space.start(),
            setting=winner.setting,
            ranges=self.space.ranges,
            errors=np.array([score.error for score in scores]),
            chatters=np.array([score.chatter for score in scores]),
            within=np.array([score.within for score in scores]),
            winner=winner.number,
            refused=sum(math.isinf(score.error) and score.failed == 0 for score in scores),
            held_out=tuned,
            held_out_start=start,
            held_out_chatter=np.array([trial_figure(x, CHATTER) for x in judged.tuned]),
            over=self.over(judged.tuned),
            over_start=self.over(judged.start),
            change=ratio_interval(self.by_draw(tuned), self.by_draw(start), self.experiment.seed),
            sensitivity=sensitivity,
        )

    def over(self, outcomes: Sequence[TrialOutcome]) -> int:
        """Trials beyond a limit, or failed."""
        return sum(not self._judge.score([outcome]).within for outcome in outcomes)

    def by_draw(self, figures: Array) -> Array:
        """Geometric mean over the points of each draw, (draws,): a draw counts once, as its trials depend."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(np.mean(np.log(figures.reshape(-1, self._runs.points)), axis=1)))

    def _refuses(self, setting: Mapping[str, Any]) -> bool:
        if self._runs.refused(setting):
            return True
        if not self.experiment.tune.stable:
            return False
        tables = {**self._runs.tables(range(1))[0], "controllers": {self.space.label: self._table(setting)}}
        law = controller_problems(tables, self.experiment.folder)[0][self.space.label]
        return not self._region.holds(law)

    def _table(self, setting: Mapping[str, Any]) -> dict[str, Any]:
        return {"law": self.space.law, **self.space.table, **setting}

    @cached_property
    def _region(self) -> StableRegion:
        tables = self._runs.tables(self.train)
        return StableRegion([self.experiment.replace(**{**each, "sweep": None, "tune": None}) for each in tables])
