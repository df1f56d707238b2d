"""An experiment, checked, and the objects that it describes."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import PrivateAttr, ValidationError

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, arm_names, load_arm
from asmc_pin.arms.loading import load_carried
from asmc_pin.arms.robot_limits import ROBOT_LIMITS, RobotLimits
from asmc_pin.arms.sources.carried import CarriedUrdf
from asmc_pin.baselines import knows_model
from asmc_pin.controllers import Controller, Sample, Setpoint
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment.checks import controller_checks, experiment_checks
from asmc_pin.experiment.checks.tune_checks import tune_problems
from asmc_pin.experiment.constructors import Mistake
from asmc_pin.experiment.law_lookup import is_own
from asmc_pin.experiment.measured_values import with_values
from asmc_pin.experiment.named_robot import tighter_rate, trip_limits
from asmc_pin.experiment.plant_parts import LISTS, TABLES, plant_parts
from asmc_pin.experiment.toml_keys import ExperimentTables
from asmc_pin.experiment.toml_text import parse_toml, write_toml
from asmc_pin.experiment.variation.axes import Variation
from asmc_pin.experiment.variation.sweep_table import sweep_problems, variation_of
from asmc_pin.metrics import MetricSettings
from asmc_pin.plant import Plant
from asmc_pin.references import OnAnArm, Reference
from asmc_pin.words.interface import speaking
from asmc_pin.words.shown import Cells, Shown
from asmc_pin.words.text import counted


class Experiment(Shown, ExperimentTables):
    """One comparison: an arm, a motion, and the controllers that are to follow it.

    Made by `load_experiment` or `Experiment.from_dict`; the attributes are the keys of the file (docs/experiments.md).
    Immutable: `replace` gives a changed one.
    """

    _data: dict[str, Any] = PrivateAttr(default_factory=dict)
    _folder: Path = PrivateAttr(default_factory=Path.cwd)
    _origin: str = PrivateAttr(default="experiment")
    _text: str | None = PrivateAttr(default=None)
    _import_laws: bool = PrivateAttr(default=True)
    _arm: Arm | None = PrivateAttr(default=None)
    _carried: CarriedUrdf | None = PrivateAttr(default=None)
    _reference: Reference | None = PrivateAttr(default=None)

    @classmethod
    def from_dict(
        cls,
        data: Mapping[str, Any],
        *,
        folder: Path | None = None,
        origin: str = "experiment",
        text: str | None = None,
        import_laws: bool = True,
    ) -> Self:
        """Check the content of a file.

        Args:
            data: Tables as TOML gives them.
            folder: Where relative paths and laws of one's own are looked for; the working directory when omitted.
            origin: What to call the experiment in errors.
            text: The TOML that `data` was read from, if it was; kept so that comments survive.
            import_laws: Whether laws of one's own are imported, which runs their code, and a xacro file is expanded,
                which runs it. Without them the experiment has its arm, if that is no xacro file, its motion and its
                plant, and `build_controllers` refuses.

        Raises:
            ExperimentError: lists every mistake with the path of its key.
        """
        content = with_values(copy.deepcopy(dict(data)))
        folder = folder or Path.cwd()
        tables, problems = cls._judged(content, folder, import_laws)
        if not problems and "sweep" in content:
            problems = sweep_problems(content, lambda varied: cls._judged(varied, folder, import_laws)[1])
        experiment_checks.fail(problems, origin)
        assert tables is not None
        tables._data, tables._folder, tables._origin, tables._text = content, folder, origin, text
        tables._import_laws = import_laws
        return tables

    @classmethod
    def _judged(cls, content: dict[str, Any], folder: Path, import_laws: bool) -> tuple[Self | None, list[Mistake]]:
        """The tables as far as pydantic takes them, and every mistake but those of ``[sweep]``."""
        problems: list[Mistake] = []
        tables = None
        try:
            tables = cls.model_validate(content)
        except ValidationError as error:
            problems += experiment_checks.table_problems(error)
        problems += experiment_checks.reference_problems(content.get("reference"), folder)[1]
        problems += plant_parts(content.get("plant"))[1]
        problems += experiment_checks.delay_problems(content)
        problems += controller_checks.controller_problems(content, folder, import_laws)[1]
        problems += tune_problems(content, folder, import_laws)
        return tables, problems

    @property
    def variation(self) -> Variation:
        """What varies from trial to trial, as ``[sweep]`` says."""
        return variation_of(self._data)

    @property
    def folder(self) -> Path:
        """Where relative paths and laws of one's own are looked for."""
        return self._folder

    @property
    def origin(self) -> str:
        """What errors call it."""
        return self._origin

    def replace(self, **changes: Any) -> Self:
        """The experiment with other values for keys at the top of the file, checked anew.

        Args:
            changes: Key and value as TOML would give it; None takes the key away.
        """
        data = {**self._data, **changes}
        data = {key: value for key, value in data.items() if value is not None}
        return type(self).from_dict(data, folder=self._folder, origin=self._origin, import_laws=self._import_laws)

    def with_plant(self, **changes: Any) -> Self:
        """The experiment with other values for keys of ``[plant]``, checked anew."""
        return self.replace(plant={**self._data.get("plant", {}), **changes})

    def to_toml(self) -> str:
        """TOML text of the experiment: the file as it was read, or new text if it was made or changed in Python."""
        if self._text is not None and parse_toml(self._text, self._origin) == self._data:
            return self._text
        return write_toml(self._data)

    def lines(self) -> list[str]:
        """What it is about: arm, motion, timing."""
        return [
            f"{self.name}: {counted(len(self.controllers), 'controller')} on {self.arm.words()}",
            f"motion: {self.reference['kind']}, {self.duration:g} s in periods of {self.period:g} s; seed {self.seed}",
        ]

    def table(self) -> Cells:
        """The controllers, and what each is given beyond the defaults."""
        rows = []
        for label, values in self.controllers.items():
            own = ", ".join(f"{key} = {value}" for key, value in values.items() if key != "law")
            rows.append([label, str(values["law"]), own])
        return ["controller", "law", "its own parameters"], rows

    @property
    def time(self) -> Array:
        """Control ticks t_k = k·L, k = 0 … round(duration/L), s."""
        ticks = round(self.duration / self.period) + 1
        return np.asarray(np.arange(ticks) * self.period, dtype=np.float64)

    def build_arm(self) -> Arm:
        """The arm.

        Raises:
            ArmError: the URDF cannot be used.
            ExperimentError: a value of ``[arm]`` does not fit it.
        """
        if self._arm is None:
            source = self.arm.source
            beside = self._folder / source
            if source not in arm_names() and beside.is_file():
                source = str(beside)
            options = self.arm.model_dump(exclude={"source"}, exclude_none=True)
            if "package" in options:
                options["package"] = {name: self._folder / where for name, where in options["package"].items()}
            try:
                with speaking("experiment"):
                    if self._carried is not None:
                        # The inertias that were estimated stand in it already, and the xacro file was run.
                        kept = {k: value for k, value in options.items() if k not in ("xacro", "estimate_inertia")}
                        self._arm = load_carried(Path(source), self._carried, **kept)
                    else:
                        self._arm = load_arm(source, run_xacro=self._import_laws, **options)
            except ParameterError as error:
                experiment_checks.fail([Mistake.of("arm", error)], self._origin)
        assert self._arm is not None
        return self._arm

    def build_reference(self) -> Reference:
        """The motion to follow.

        Raises:
            ExperimentError: it is for another number of joints than the arm has.
        """
        arm = self.build_arm()
        if self._reference is not None:
            return self._reference
        reference, problems = experiment_checks.reference_problems(self.reference, self._folder)
        if not problems and reference.nv != arm.nv:
            problems = [Mistake("reference", f"moves {reference.nv} joints, but {experiment_checks.joints_of(arm)}")]
        experiment_checks.fail(problems, self._origin)
        if isinstance(reference, OnAnArm):
            experiment_checks.fail(
                experiment_checks.angle_problems("reference.start", arm, np.array(reference.start)), self._origin
            )
            try:
                reference = reference.on(arm)
            except ParameterError as error:
                problems = [Mistake.of("reference", error)]
        experiment_checks.fail(
            problems or experiment_checks.motion_problems(reference, arm, self.duration), self._origin
        )
        self._reference = reference
        made: Reference = reference
        return made

    def setpoints(self) -> tuple[Array, Setpoint]:
        """Ticks, shape (T,), s, and the reference at each of them, fields of shape (T, nv)."""
        time = self.time
        return time, self.build_reference().evaluate(time)

    def build_controllers(self) -> dict[str, Controller]:
        """The controllers by label, in the order of the file.

        Raises:
            ExperimentError: a parameter does not fit the arm.
        """
        own = [] if self._import_laws else [key for key, table in self.controllers.items() if is_own(table["law"])]
        if own:
            told = "its law is code of somebody's own, and this experiment was read without importing any"
            experiment_checks.fail([Mistake(f"controllers.{label}.law", told) for label in own], self._origin)
        arm = self.build_arm()
        experiment_checks.fail(controller_checks.controller_size_problems(self, self._folder, arm), self._origin)
        made, problems = controller_checks.controller_problems(self._data, self._folder)
        at_rest = np.zeros((1, arm.nv))
        for label, law in made.items() if not problems else ():
            try:
                if knows_model(law):
                    law = made[label] = law.with_arm(self.build_plant().arm)
                law.init(Sample(at_rest, at_rest.copy(), at_rest.copy()))
            except ParameterError as error:
                problems.append(Mistake.of(f"controllers.{label}", error))
            except (Exception, SystemExit) as error:  # a law that ends the process is no fault of ours
                if not is_own(self.controllers[label]["law"]):
                    raise
                problems.append(Mistake(f"controllers.{label}", f"init raised {type(error).__name__}: {error}"))
        experiment_checks.fail(problems, self._origin)
        return made

    def plant_options(self) -> dict[str, Any]:
        """What ``[plant]`` gives to the plant, as keywords of `asmc_pin.Plant`; where it starts is not among them."""
        elsewhere = {"q0", "v0", "limits", *TABLES, *LISTS}
        options = self.plant.model_dump(exclude=elsewhere, exclude_unset=True, exclude_none=True)
        return options | plant_parts(self._data.get("plant"))[0]

    def build_plant(self) -> Plant:
        """The simulated arm.

        Raises:
            ExperimentError: a value of ``[plant]`` does not fit the arm.
        """
        arm = self.build_arm()
        experiment_checks.fail(experiment_checks.plant_size_problems(self, arm), self._origin)
        if self.plant.q0 is not None:
            q0 = np.broadcast_to(self.plant.q0, (arm.nv,))
            experiment_checks.fail(experiment_checks.angle_problems("plant.q0", arm, q0), self._origin)
        options = self.plant_options()
        try:
            return Plant(arm, seed=self.seed, first_trial=self.trial, **options)
        except ParameterError as error:
            raise ExperimentError(f"plant.{error.parameter}", error.said) from error

    @property
    def robot_limits(self) -> RobotLimits | None:
        """What is published of the robot that ``plant.limits`` names."""
        return None if self.plant.limits is None else ROBOT_LIMITS[self.plant.limits]

    @property
    def torque_rate_limit(self) -> Array:
        """How fast the torque may change, (nv,) or a scalar, N·m/s: the tighter of the robot's and what is asked."""
        given = "torque_rate_limit" in self.metrics.model_fields_set
        return tighter_rate(self.robot_limits, self.metrics.torque_rate_limit, given)

    def metric_settings(self) -> MetricSettings:
        """What the metrics are told: ``[metrics]``, the plant's torque limits, and what stops the robot it names."""
        return MetricSettings(
            cutoff_hz=self.metrics.cutoff_hz,
            settling_band=np.asarray(self.metrics.settling_band),
            effort_limit=np.asarray(self.build_plant().effort_limit),
            torque_rate_limit=self.torque_rate_limit,
            trips=trip_limits(self.robot_limits, self.torque_rate_limit),
        )


def take_carried_arm(experiment: Experiment, carried: CarriedUrdf | None) -> None:
    """Have an experiment take its arm from the URDF that went along with a result, and run no xacro file."""
    experiment._carried = carried
