"""One Optuna study for one law: proposes settings, runs them in lockstep, remembers the best."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers import REQUIRED, TdeLaw, parameters_of
from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.study.stacked_settings import Stacked
from asmc_pin.study.tuning_objective import Objective

_DIGITS = 4  # of a suggested value: what is tried is what a file can show


@dataclass(frozen=True)
class LawTuning:
    """What the study of one law found.

    Attributes:
        label: Of the controller in the experiment.
        law: Name of the law.
        parameters: Best values of the searched parameters, as TOML takes them; empty if there was none to search.
        value: Objective of the best.
        untuned: Objective of the file's own values, which are the first trial of each study.
        trials: Number of settings that were run.
        diverged: How many of them diverged.
    """

    label: str
    law: str
    parameters: Mapping[str, float | list[float]]
    value: float
    untuned: float
    trials: int
    diverged: int


def own_parameters(experiment: Experiment, label: str) -> dict[str, float | list[float]]:
    """The parameters of a controller that are its law's own, required and not 0, with the file's values."""
    law = experiment.build_controllers()[label]
    if not isinstance(law, TdeLaw):
        raise ExperimentError(
            f"controllers.{label}",
            f"the law '{experiment.controllers[label]['law']}' is no TdeLaw with described parameters, so there is "
            "nothing known to tune; see docs/controllers.md",
        )
    shared = parameters_of(TdeLaw)
    table = {**experiment.defaults, **experiment.controllers[label]}
    own = {n: table[n] for n, p in parameters_of(type(law)).items() if n not in shared and p.default is REQUIRED}
    # A range of ratios around 0 is none, nor is one around a word.
    return {name: value for name, value in own.items() if not isinstance(value, str) and np.all(np.asarray(value) > 0)}


class LawStudy:
    """One law's study: proposes settings, runs them in lockstep, remembers the best."""

    def __init__(
        self,
        experiment: Experiment,
        label: str,
        objective: Objective,
        span: float,
        seed: int,
        storage: str | Path | None,
        trials: int,
    ) -> None:
        import optuna

        self.experiment, self.label, self.objective, self.span = experiment, label, objective, span
        self.start = own_parameters(experiment, label)
        self.plant, self.reference = experiment.build_plant(), experiment.build_reference()
        fingerprint = {
            "experiment": experiment.to_toml(),
            "objective": objective.text,
            "span": span,
            "seed": seed,
            "trials": trials,
        }
        with quiet_optuna():
            backend = None
            if storage is not None:
                from optuna.storages.journal import JournalFileBackend

                Path(storage).parent.mkdir(parents=True, exist_ok=True)
                backend = optuna.storages.JournalStorage(JournalFileBackend(str(storage)))
            self.study = optuna.create_study(
                storage=backend,
                study_name=f"{experiment.name}/{label}",
                sampler=optuna.samplers.TPESampler(seed=seed, multivariate=True, constant_liar=True),
                load_if_exists=True,
            )
        known = self.study.user_attrs.get("of")
        if known is not None and known != fingerprint:
            raise ResultError(
                storage or "",
                f"{storage} holds a tuning of {experiment.name}/{label} with another experiment, objective or budget; "
                "give another file, or remove it",
            )
        if known is None:
            self.study.set_user_attr("of", fingerprint)
        if not self._told():
            self.study.enqueue_trial(self._flat(self.start))

    def run(self, trials: int, batch: int, progress: Callable[[float], None]) -> LawTuning:
        """Run settings until there are `trials` of them (one, if there is nothing to search); see `tune_own_gains`."""
        if not self.start:
            trials = 1
        with quiet_optuna():
            done = len(self._told())
            while done < trials:
                progress(done / trials)
                asked = [self.study.ask() for _ in range(min(batch, trials - done))]
                settings = [self._suggest(trial) for trial in asked]
                values, diverged = self.evaluate(settings)
                for trial, setting, value, bad in zip(asked, settings, values, diverged, strict=True):
                    trial.set_user_attr("parameters", setting)
                    trial.set_user_attr("diverged", bool(bad))
                    self.study.tell(trial, float(value))
                done += len(asked)
            told = self._told()
        best = min(told, key=lambda item: (item.value, item.number))
        first = min(told, key=lambda item: item.number)

        def value_of(item: Any) -> float:
            return math.nan if item.user_attrs["diverged"] else float(item.value)

        return LawTuning(
            label=self.label,
            law=str(self.experiment.controllers[self.label]["law"]),
            parameters=best.user_attrs["parameters"],
            value=value_of(best),
            untuned=value_of(first),
            trials=len(told),
            diverged=sum(bool(item.user_attrs["diverged"]) for item in told),
        )

    def _told(self) -> list[Any]:
        from optuna.trial import TrialState

        return list(self.study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)))

    def evaluate(self, settings: Sequence[Mapping[str, Any]]) -> tuple[Array, list[bool]]:
        """Objective of each setting, and whether it diverged."""
        table = self.experiment.controllers[self.label]
        labels = [f"{self.label} {i}" for i in range(len(settings))]
        candidates = {label: {**table, **setting} for label, setting in zip(labels, settings, strict=True)}
        laws = self.experiment.replace(controllers=candidates).build_controllers()
        world = self.experiment.plant
        run = rollout(
            self.plant,
            Stacked([law for law in laws.values() if isinstance(law, TdeLaw)], self.plant.nv),
            self.reference,
            self.experiment.duration,
            batch=len(settings),
            q0=world.q0,
            v0=world.v0,
        )
        return self.objective(run), [status != "ok" for status in run.status]

    def _suggest(self, trial: Any) -> dict[str, float | list[float]]:
        flat = {
            name: _rounded(trial.suggest_float(name, value / self.span, value * self.span, log=True), value)
            for name, value in self._flat(self.start).items()
        }
        return {
            name: [flat[f"{name}[{i}]"] for i in range(len(value))] if isinstance(value, list) else flat[name]
            for name, value in self.start.items()
        }

    @staticmethod
    def _flat(values: Mapping[str, float | list[float]]) -> dict[str, float]:
        flat: dict[str, float] = {}
        for name, value in values.items():
            if isinstance(value, list):
                flat |= {f"{name}[{i}]": x for i, x in enumerate(value)}
            else:
                flat[name] = value
        return flat


def _rounded(value: float, start: float) -> float:
    """To a few digits; the file's own value to all of its digits."""
    near = math.isclose(value, start, rel_tol=1e-12)
    return start if near else float(f"{value:.{_DIGITS}g}")


@contextlib.contextmanager
def quiet_optuna() -> Iterator[None]:
    """Optuna without its line per trial and without its notes on experimental arguments."""
    import optuna

    level = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            yield
    finally:
        optuna.logging.set_verbosity(level)
