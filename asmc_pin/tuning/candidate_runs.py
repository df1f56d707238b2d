"""Trials of many settings of one controller, in as few batches as their plants allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.checks.controller_checks import controller_problems
from asmc_pin.experiment.variation.axes import Variation
from asmc_pin.sweeping.lockstep import TrialTables
from asmc_pin.sweeping.sweep_plan import sweep_plan
from asmc_pin.sweeping.trial_runs import TrialOutcome, TrialRuns
from asmc_pin.tuning.search_space import SearchSpace

Setting = Mapping[str, Any]


def draws_of(experiment: Experiment) -> Variation:
    """What varies from trial to trial in a tuning: ``[sweep]`` without its scans, which stand where the file has them.

    Raises:
        ExperimentError: a gain varies there, or nothing does at random.
    """
    variation = experiment.variation
    axes = tuple(axis for axis in variation.axes if axis.scan is None)
    gains = [axis.path for axis in axes if axis.parts[0] in ("defaults", "controllers")]
    if gains:
        told = "varies gains, which tune searches; take the line away, or give it a scan, which tune leaves alone"
        raise ExperimentError(f'sweep."{gains[0]}"', told)
    if not any(axis.draw is not None for axis in axes) and experiment.plant.spread is None:
        raise ExperimentError(
            "sweep",
            "nothing in it is drawn at random, so the held-out trials would be the training trials again; vary motion, "
            'load or friction, such as "arm.payload" = { uniform = [0.0, 2.0] } (docs/tuning.md)',
        )
    return Variation({key: value for key, value in variation.data.items() if key != "tune"}, axes, variation.seed)


class CandidateRuns:
    """Runs settings of one controller on draws, in one process.

    Args:
        experiment: With ``[sweep]``; ``[tune]`` is not read.
        space: The controller.
        metrics: What is measured; all metrics when omitted.
    """

    def __init__(self, experiment: Experiment, space: SearchSpace, metrics: Iterable[str] | None = None) -> None:
        self._space = space
        self._variation = draws_of(experiment)
        alone = experiment.replace(
            tune=None, defaults=None, controllers={space.label: {"law": space.law, **space.table}}
        )
        self._folder = experiment.folder
        self._runs = TrialRuns(sweep_plan(alone, 1, None, ""), metrics)

    @property
    def points(self) -> int:
        """Trials of a draw: points of the grids."""
        return self._variation.grid_points

    def refused(self, setting: Setting) -> bool:
        """Whether the law itself refuses a setting."""
        found = controller_problems({**self._variation.data, **self._controllers(setting)}, self._folder)[1]
        return bool(found)

    def __call__(self, settings: Sequence[Setting], draws: range) -> list[list[TrialOutcome]]:
        """Run every setting on every draw, at every point of the grids.

        Returns:
            For each setting its outcomes, draw by draw, point by point.

        Raises:
            ExperimentError: a value that was drawn fits no experiment, or a law of one's own raised.
        """
        plain = [(draw, self._drawn(draw, point)) for draw in draws for point in range(self.points)]
        jobs = [
            TrialTables(draw, draw, {**tables, **self._controllers(setting)})
            for setting in settings
            for draw, tables in plain
        ]
        found = self._runs(jobs, [self._space.label])
        each = [found[i, self._space.label] for i in range(len(jobs))]
        return [each[i : i + len(plain)] for i in range(0, len(each), len(plain))]

    def tables(self, draws: range) -> list[dict[str, Any]]:
        """The experiment's tables at every draw and point, with the controller as it stands."""
        return [{**self._drawn(draw, point), **self._controllers({})} for draw in draws for point in range(self.points)]

    def _drawn(self, draw: int, point: int) -> dict[str, Any]:
        try:
            # Scans are left out, so the points are the grids' alone.
            return self._variation.tables(self._variation.quantities(draw * self._variation.points + point))
        except ValueError as error:
            raise ExperimentError("", f"draw {draw}: {error}") from None

    def _controllers(self, setting: Setting) -> dict[str, Any]:
        table = {"law": self._space.law, **self._space.table, **setting}
        return {"defaults": {}, "controllers": {self._space.label: table}}
