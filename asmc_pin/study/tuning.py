"""Tuning control laws on one motion: one Optuna study for each law, all with the same budget.

Only a law's own parameters are searched; what the file shares "for fairness" (M̄, K_s, β, L) stays. A parameter given as
a list is searched joint by joint, one given as a number as one number for all joints; parameters with a default stay.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.study.law_study import LawStudy, LawTuning
from asmc_pin.study.tuning_objective import Objective

Progress = Callable[[str, float], None]
TRIALS, BATCH, SPAN = 96, 16, 100.0


@dataclass(frozen=True)
class Tuning:
    """Laws tuned on one experiment.

    Attributes:
        experiment: As given.
        objective: What was made small.
        laws: By label.
        trials: Budget of each law.
        span: Each parameter was searched from its value / span to its value · span, logarithmically.
        seed: Of every study's sampler.
    """

    experiment: Experiment
    objective: Objective
    laws: Mapping[str, LawTuning]
    trials: int
    span: float
    seed: int

    def tuned(self) -> Experiment:
        """The experiment with the best values in the place of its own."""
        tables = {label: dict(table) for label, table in self.experiment.controllers.items()}
        for label, law in self.laws.items():
            tables[label] |= law.parameters
        return self.experiment.replace(controllers=tables)

    def lines(self) -> list[str]:
        """What a person reads."""
        out = [f"objective: {self.objective.text}", f"{self.trials} trials for each law, seed {self.seed}"]
        for item in self.laws.values():
            found = ", ".join(f"{name} = {value}" for name, value in item.parameters.items()) or "nothing to tune"
            out.append(f"{item.label}: {item.untuned:.4g} -> {item.value:.4g} ({item.diverged} diverged); {found}")
        return out

    def to_json_dict(self) -> dict[str, Any]:
        """The same as valid JSON; null for the objective of a setting that diverged."""
        return {
            "experiment": self.experiment.name,
            "objective": self.objective.text,
            "trials": self.trials,
            "span": self.span,
            "seed": self.seed,
            "laws": {
                item.label: {
                    "law": item.law,
                    "parameters": dict(item.parameters),
                    "value": item.value if math.isfinite(item.value) else None,
                    "untuned": item.untuned if math.isfinite(item.untuned) else None,
                    "trials": item.trials,
                    "diverged": item.diverged,
                }
                for item in self.laws.values()
            },
        }


def tune_own_gains(
    experiment: Experiment,
    labels: Sequence[str] | None = None,
    *,
    objective: Objective | None = None,
    trials: int = TRIALS,
    batch: int = BATCH,
    span: float = SPAN,
    seed: int | None = None,
    storage: str | Path | None = None,
    progress: Progress | None = None,
) -> Tuning:
    """Tune controllers of an experiment, each by a study of its own with the same number of trials.

    Optuna's TPE sampler proposes `batch` settings at a time, which run in lockstep; the first is the file's own, so the
    result is never worse than that. The same arguments give the same result.

    Args:
        experiment: The motion, the plant, and the values to start from.
        labels: Controllers to tune; all when omitted.
        objective: What to make small.
        trials: Settings to run for each law, at least 1.
        batch: Settings in one rollout.
        span: Above 1; each parameter p is searched in [p/span, p·span].
        seed: Of the samplers; the experiment's when omitted.
        storage: Journal file that keeps every trial, and from which an interrupted tuning goes on; in memory when
            omitted.
        progress: Called now and then.

    Raises:
        ParameterError: an argument is out of range.
        ExperimentError: a label is unknown, or a law's parameters do not say what they are.
        ResultError: the journal holds studies of another tuning.
    """
    for name, value, good in (("trials", trials, trials >= 1), ("batch", batch, batch >= 1), ("span", span, span > 1)):
        if not good:
            raise ParameterError(name, f"{value} given; expected {'more than 1' if name == 'span' else 'at least 1'}")
    wanted = list(experiment.controllers) if labels is None else list(labels)
    unknown = [label for label in wanted if label not in experiment.controllers]
    if unknown:
        raise ExperimentError(
            "controllers",
            f"there is no {unknown[0]!r} in {experiment.name}; it has {', '.join(experiment.controllers)}",
        )
    aim = objective or Objective()
    number = experiment.seed if seed is None else seed
    tell = progress or (lambda _what, _share: None)
    found = {}
    for i, label in enumerate(wanted):
        study = LawStudy(experiment, label, aim, span, number, storage, trials)

        def part(share: float, label: str = label, i: int = i) -> None:
            tell(label, (i + share) / len(wanted))

        found[label] = study.run(trials, batch, part)
    tell("done", 1.0)
    return Tuning(experiment, aim, found, trials, span, number)
