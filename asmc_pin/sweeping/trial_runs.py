"""Running trials: batches of what can run in lockstep, and what each controller made of each trial."""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.baselines import knows_model, shown_label
from asmc_pin.errors import AsmcPinError, ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.variation.key_paths import MISSING, value_at
from asmc_pin.metrics import METRICS, MetricSettings
from asmc_pin.sweeping.lockstep import Lockstep, TrialTables, becomes_a_row, same_friction
from asmc_pin.sweeping.sweep_plan import SweepPlan
from asmc_pin.tool_error import tool_error

_KEPT = 64
"""Experiments, with arm and motion built, that a process keeps for the next block."""


@dataclass(frozen=True)
class TrialOutcome:
    """What one controller made of one trial.

    Attributes:
        arm: Name of the arm.
        joints: Names and kinds of its joints.
        law: Name of the law.
        shown: Label as results show it.
        knows_model: Whether the law computes with a model of the arm.
        status: ``"ok"`` or ``"diverged"``.
        end_time: End of the run, s.
        figures: Metric -> (nv,), SI; NaN where not defined.
        tool: Column of `TOOL` -> its figure, where the experiment names a tool; NaN for a run that diverged.
    """

    arm: str
    joints: tuple[tuple[str, str], ...]
    law: str
    shown: str
    knows_model: bool
    status: str
    end_time: float
    figures: Mapping[str, Array]
    tool: Mapping[str, float] = field(default_factory=dict)

    def failed(self, until: Mapping[str, float]) -> bool:
        """Whether it diverged, or a joint's figure is beyond its limit; a figure that is not defined is not."""
        return self.status != "ok" or any(bool(np.any(self.figures[name] > limit)) for name, limit in until.items())


class TrialRuns:
    """Runs trials of one sweep, in one process.

    Args:
        plan: The sweep.
        metrics: What is measured; all metrics when omitted.
    """

    def __init__(self, plan: SweepPlan, metrics: Iterable[str] | None = None) -> None:
        self._plan = plan
        self._metrics = tuple(METRICS if metrics is None else metrics)
        self._bases: OrderedDict[str, Experiment] = OrderedDict()
        # What makes batches differ: every key that varies and does not become a row.
        self._splitting = [axis.parts for axis in plan.variation.axes if not becomes_a_row(axis.parts)]
        self._friction = any(axis.parts[:2] == ("plant", "friction") for axis in plan.variation.axes)

    def __call__(
        self, jobs: Sequence[TrialTables], labels: Iterable[str] | None = None
    ) -> dict[tuple[int, str], TrialOutcome]:
        """Run trials.

        Args:
            jobs: The trials.
            labels: Controllers; all when omitted.

        Returns:
            By position in `jobs`, and label.

        Raises:
            ExperimentError: a value that was drawn fits no experiment (names the trial), or a law of one's own raised.
        """
        groups: dict[str, list[int]] = {}
        for i, job in enumerate(jobs):
            groups.setdefault(self._group(job), []).append(i)
        found: dict[tuple[int, str], TrialOutcome] = {}
        wanted = list(self._plan.experiment.controllers if labels is None else labels)
        for name, members in groups.items():
            batch = self._built(name, [jobs[i] for i in members])
            settings = _settings(batch)
            for label in wanted:
                for i, outcome in zip(members, _outcomes(batch, label, settings, self._metrics), strict=True):
                    found[i, label] = outcome
        return found

    def _group(self, job: TrialTables) -> str:
        values = [value_at(job.tables, parts) for parts in self._splitting]
        values += [same_friction(job.tables)] if self._friction else []
        return json.dumps([None if value is MISSING else value for value in values], sort_keys=True, default=str)

    def _built(self, name: str, jobs: Sequence[TrialTables]) -> Lockstep:
        experiment = self._plan.experiment
        try:
            if name not in self._bases:
                self._bases[name] = experiment.replace(**{**jobs[0].tables, "sweep": None})
                if len(self._bases) > _KEPT:
                    self._bases.popitem(last=False)
            self._bases.move_to_end(name)
            return Lockstep(self._bases[name], jobs)
        except (AsmcPinError, ValueError) as error:  # pydantic's errors are values'
            for job in jobs:  # which of them it was
                try:
                    alone = experiment.replace(**{**job.tables, "sweep": None})
                    alone.build_plant()
                    alone.build_controllers()
                    Lockstep(alone, [job])
                except AsmcPinError as found:
                    raise ExperimentError("sweep", f"trial {job.trial}: {found}") from error
            raise


def _settings(batch: Lockstep) -> MetricSettings:
    """What the metrics are told, with the torque limits of each trial."""
    settings, limit = batch.base.metric_settings(), np.asarray(batch.plant.effort_limit)
    return replace(settings, effort_limit=limit[:, None, :] if limit.ndim == 2 else limit)


def _outcomes(batch: Lockstep, label: str, settings: MetricSettings, metrics: Iterable[str]) -> list[TrialOutcome]:
    run = batch.run(label)
    figures = {name: METRICS[name](run, settings) for name in metrics}
    law: Any = batch.laws[label][0]
    arm, tool = batch.plant.arm, batch.base.metrics.tool
    at_tool = {} if tool is None else tool_error(arm, run, tool).figures()
    return [
        TrialOutcome(
            arm=arm.name,
            joints=tuple(zip(arm.joint_names, arm.joint_kinds, strict=True)),
            law=str(batch.base.controllers[label]["law"]),
            shown=shown_label(label, law),
            knows_model=knows_model(law),
            status=run.status[i],
            end_time=float(run.end_time[i]),
            figures={name: values[i] for name, values in figures.items()},
            tool={f"tool_{name}": float(values[i]) for name, values in at_tool.items()},
        )
        for i in range(len(batch.jobs))
    ]
