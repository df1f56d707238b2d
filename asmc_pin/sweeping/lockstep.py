"""Trials that differ in numbers only, built on one plant and run in lockstep.

A trial has its own tables; what they change of the arm's load, of friction, of limits, of the start or of a law's
numbers becomes a row of one batch. Whatever else differs, a motion or a drive, makes another batch. The engine gives a
trial the same bits in whatever batch it runs, so this decides about speed alone.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.baselines import knows_model
from asmc_pin.controllers import Controller, TdeLaw
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.controllers.tde import sliding_variable
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import AsmcPinError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.arm_keys import ArmTable, arm_table
from asmc_pin.experiment.checks.controller_checks import controller_problems
from asmc_pin.experiment.checks.experiment_checks import fail
from asmc_pin.experiment.toml_keys import PlantTable
from asmc_pin.experiment.variation.key_paths import Parts
from asmc_pin.parameters import parameters_of
from asmc_pin.plant import Friction, Plant
from asmc_pin.study.law_faults import told_of_its_law
from asmc_pin.study.stacked_settings import Stacked

_ROWS: tuple[Parts, ...] = (
    ("arm", "payload"),
    ("arm", "armature"),
    ("arm", "gravity"),
    ("plant", "friction"),
    ("plant", "effort_limit"),
    ("plant", "q0"),
    ("plant", "v0"),
)


def becomes_a_row(parts: Parts) -> bool:
    """Whether trials that differ in this key still run in one batch."""
    law = parts[0] == "defaults" or (parts[0] == "controllers" and len(parts) > 2 and parts[2] != "law")
    return parts[:2] in _ROWS or (law and len(parts) > 1)


@dataclass(frozen=True)
class TrialTables:
    """One trial to run.

    Attributes:
        trial: Its number in the sweep.
        draw: Number that seeds its noise and scatter, the same at every point.
        tables: The experiment's, as they are in this trial.
    """

    trial: int
    draw: int
    tables: Mapping[str, Any]


class Lockstep:
    """Trials of one batch, ready to run under any of their controllers.

    Attributes:
        jobs: The trials.
        plant: Theirs, a row for each where they differ.
        laws: Of each label, one for each trial; the same object where it is the same for all.
    """

    def __init__(self, base: Experiment, jobs: Sequence[TrialTables]) -> None:
        """Build the plant and the laws.

        Args:
            base: The experiment of any of the trials.
            jobs: Trials whose tables differ from it in keys that become rows.

        Raises:
            ExperimentError: a value that was drawn fits no experiment; says of which trial.
        """
        self.base, self.jobs = base, tuple(jobs)
        made = [PlantTable.model_validate(job.tables.get("plant", {})) for job in jobs]
        self.reference = base.build_reference()
        arms = self._arms()
        nv = arms[0].nv
        options = base.plant_options()
        options |= _friction(made, nv)
        if "effort_limit" in options:
            options["effort_limit"] = _rows([each.effort_limit for each in made], nv)
        self.plant = Plant(arms, seed=base.seed, **options)
        self.q0, self.v0 = (_rows([getattr(each, name) for each in made], nv) for name in ("q0", "v0"))
        self.laws = self._laws()

    def run(self, label: str) -> Rollout:
        """Run one controller in all trials."""
        laws = self.laws[label]
        if all(law is laws[0] for law in laws):
            return self._rollout(label, laws[0], slice(None))
        stacked = _stacked(laws, self.plant.nv)
        if stacked is not None:
            return _with_s(self._rollout(label, stacked, slice(None)), laws)
        # Laws that cannot share a batch, such as those that know the model of an arm that differs: one by one.
        alone = [self._rollout(label, law, slice(i, i + 1)) for i, law in enumerate(laws)]
        return _joined(alone)

    def _rollout(self, label: str, law: Any, which: slice) -> Rollout:
        jobs = self.jobs[which]
        plant = self.plant
        if len(jobs) < len(self.jobs):
            plant = _one_of(plant, which, len(self.jobs))
        with told_of_its_law(self.base, label):
            return rollout(
                plant,
                law,
                self.reference,
                self.base.duration,
                period=self.base.period,
                batch=len(jobs),
                q0=_row(self.q0, which),
                v0=_row(self.v0, which),
                trials=[job.draw for job in jobs],
            )

    def _arms(self) -> list[Arm]:
        """One arm if it is the same for all, else one for each trial; trials with equal tables share theirs."""
        keys = [json.dumps(job.tables["arm"], sort_keys=True, default=str) for job in self.jobs]
        made: dict[str, Arm] = {}
        own = self.base.build_arm()
        bare = own.replace(payload=None) if own.payload is not None else own
        for key, job in zip(keys, self.jobs, strict=True):
            if key not in made:
                options = ArmTable.model_validate(arm_table(job.tables["arm"])).model_dump(exclude_none=True)
                changed = {name: options.get(name) for name in ("payload", "armature", "gravity")}
                made[key] = bare.replace(**changed)
        return [made[keys[0]]] if len(made) == 1 else [made[key] for key in keys]

    def _laws(self) -> dict[str, list[Controller]]:
        """The laws of each label, one for each trial."""
        base = self.base
        keys = [json.dumps([job.tables.get("defaults"), job.tables["controllers"]], default=str) for job in self.jobs]
        made: dict[str, dict[str, Controller]] = {}
        for key, job in zip(keys, self.jobs, strict=True):
            if key not in made:
                laws, problems = controller_problems(job.tables, base.folder)
                fail(problems, base.origin)
                made[key] = laws
        found = {label: [made[key][label] for key in keys] for label in base.controllers}
        arms = self.plant.arms
        for label, given in found.items():
            if knows_model(given[0]):
                known: dict[tuple[int, int], Any] = {}
                for i, law in enumerate(given):
                    arm = arms[i % len(arms)]
                    if (id(law), id(arm)) not in known:
                        known[id(law), id(arm)] = law.with_arm(arm)  # type: ignore[attr-defined]
                    found[label][i] = known[id(law), id(arm)]
        return found


def _friction(made: Sequence[PlantTable], nv: int) -> dict[str, Friction]:
    """Friction with a row for each trial where it differs; nothing where the URDF's is taken."""
    tables = [each.friction for each in made]
    if tables[0] is None:
        return {}
    each = [Friction(**(table or {})) for table in tables]
    if all(table == tables[0] for table in tables):
        return {"friction": each[0]}
    for one in each:
        one.check(nv)
    names = parameters_of(Friction)
    return {"friction": Friction(**{name: np.array([one.spread(name, 1, nv)[0] for one in each]) for name in names})}


def same_friction(tables: Mapping[str, Any]) -> str:
    """What trials of one batch have in common in their friction, beyond numbers: which terms there are."""
    friction = tables.get("plant", {}).get("friction")
    if not isinstance(friction, Mapping):
        return "the URDF's"
    try:
        made = Friction(**friction)
    except AsmcPinError:
        return "wrong"  # told where the trial is built
    return f"{made.constant} {made.yields} {sorted(made.terms)}"


def _rows(values: Sequence[Any], nv: int) -> Array | None:
    """(nv,) where all trials have the same, else (batch, nv); None where they have none."""
    if values[0] is None:
        return None
    if all(value == values[0] for value in values):
        return np.asarray(values[0], dtype=np.float64)
    return np.array([np.broadcast_to(value, (nv,)) for value in values], dtype=np.float64)


def _row(value: Array | None, which: slice) -> Array | None:
    return value[which] if value is not None and value.ndim == 2 else value


def _one_of(plant: Plant, which: slice, count: int) -> Plant:
    """The plant of some of the trials."""
    arms = plant.arms[which] if len(plant.arms) == count and count > 1 else plant.arms
    names = {name: getattr(plant.friction, name) for name in parameters_of(Friction)}
    friction = Friction(**{name: value[which] if value.ndim == 2 else value for name, value in names.items()})
    limit = plant.effort_limit[which] if plant.effort_limit.ndim == 2 else plant.effort_limit
    made = copy(plant)
    for name, value in {"arms": arms, "friction": friction, "effort_limit": limit}.items():
        object.__setattr__(made, name, value)
    return made


def _stacked(laws: Sequence[Any], nv: int) -> Stacked | None:
    if not all(isinstance(law, TdeLaw) for law in laws):
        return None
    try:
        return Stacked(laws, nv)
    except ParameterError:
        return None


def _with_s(run: Rollout, laws: Sequence[Any]) -> Rollout:
    """The run with s = ė + K_s e of each trial's own K_s, which a stacked law does not show to the engine."""
    ks = np.array([np.broadcast_to(law.ks, (run.q.shape[2],)) for law in laws])[:, None]
    measured = run.q_measured is not None
    q, v = (run.q_measured, run.v_measured) if measured else (run.q, run.v)
    wanted = Setpoint(*(x[None] for x in (run.q_ref, run.v_ref, run.a_ref)))
    return replace(run, s=sliding_variable(ks, Sample(q, v, v), wanted))


def _joined(runs: Sequence[Rollout]) -> Rollout:
    """Runs of single trials as one run."""
    first = runs[0]
    stacked: dict[str, Any] = {
        name: np.concatenate([getattr(run, name) for run in runs])
        for name, value in vars(first).items()
        if (isinstance(value, np.ndarray) and value.ndim == 3) or name in ("end_time", "held_torque")
    }
    status = tuple(word for run in runs for word in run.status)
    return replace(first, **stacked, status=status, limit_violations=())
