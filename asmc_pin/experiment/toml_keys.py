"""The keys of an experiment file whose names do not depend on a law or a kind of reference.

Keys of ``[reference]``, ``[defaults]`` and ``[controllers.*]`` come from the constructors themselves (`parameters`), so
a new parameter of a law or of a reference needs no second list here. A new key of the plant is a field of `PlantTable`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo, WithJsonSchema, field_validator

from asmc_pin.errors import ParameterError
from asmc_pin.experiment.arm_keys import ArmTable, arm_table
from asmc_pin.experiment.named_robot import RobotName
from asmc_pin.experiment.toml_values import (
    LimitPerJoint,
    PerJoint,
    PositivePerJoint,
    TomlTable,
)
from asmc_pin.experiment.tune_table import TuneTable
from asmc_pin.words.units import LONGEST_PERIOD, check_period

MOST_CONTROLLERS = 100

MOST_TRIALS = 10_000

MOST_TICKS = 10_000_000
"""Longest run in control ticks: almost three hours at 1 ms, some gigabytes of trajectories for each controller."""

_LONGEST_LABEL = 200


class PlantTable(TomlTable):
    """The simulated world. What is omitted is the plant's own default."""

    substeps: int = Field(default=2, ge=1, description="integration steps in each control period")
    start: Literal["holding", "relaxed"] = Field(
        default="holding", description="torque before t = 0: balances gravity at q(0), or is zero"
    )
    engine: Literal["compiled", "pinocchio"] = Field(
        default="compiled", description="what computes the dynamics: compiled code held against Pinocchio, or Pinocchio"
    )
    integrator: Literal["semi_implicit", "midpoint", "rk4"] = Field(
        default="semi_implicit", description="scheme between the control ticks"
    )
    friction: dict[str, Any] | None = Field(default=None, description="joint friction; the URDF's when omitted")
    effort_limit: LimitPerJoint | None = Field(
        default=None, description="torque limits, N·m (N), inf for none; the URDF's when omitted"
    )
    limits: RobotName = Field(
        default=None,
        description="robot whose published limits of torque, torque rate and velocity the run is held against, and an "
        "export kept within; none when omitted",
    )
    q0: PerJoint | None = Field(default=None, description="q(0), rad (m); the reference's when omitted")
    v0: PerJoint | None = Field(default=None, description="v(0), rad/s (m/s); the reference's when omitted")
    drive: dict[str, Any] | None = Field(default=None, description="between command and joint torque; ideal if omitted")
    sensor: dict[str, Any] | None = Field(default=None, description="what the law is told; the truth when omitted")
    end_stops: dict[str, Any] | None = Field(default=None, description="stiff stops at the limits; none when omitted")
    disturbances: list[Any] = Field(default=[], description="external torques and wrenches")
    payload_changes: list[Any] = Field(default=[], description="what is picked up or put down in mid-run")
    spread: dict[str, Any] | None = Field(default=None, description="scatter of the parameters from trial to trial")


class MetricsTable(TomlTable):
    """What the metrics of docs/metrics.md need to be told."""

    cutoff_hz: float = Field(default=50.0, gt=0.0, description="torque power above it counts as high-frequency, Hz")
    settling_band: PositivePerJoint = Field(
        default=0.002, description="band of |e| in which a joint counts as settled, rad (m)"
    )
    torque_rate_limit: LimitPerJoint = Field(
        default=1000.0,
        description="how fast a robot lets its torque change, N·m/s (N/s), inf for no limit; ticks beyond are counted",
    )
    tool: str | None = Field(
        default=None, description="link or frame whose error is given in mm and rad; none if omitted"
    )


class EnsembleTable(TomlTable):
    """How sure a figure is: trials that differ by less than anyone could set or measure."""

    trials: int = Field(
        default=16, ge=1, le=MOST_TRIALS, description="trials of each controller, run in lockstep; 1 for a single run"
    )
    q0_deviation: float = Field(
        default=1e-6, ge=0.0, description="standard deviation of q(0) in all trials but the first, rad (m)"
    )


_NUMBER = {"type": "number"}
_CENTRE_AND_WIDTH = {"anyOf": [_NUMBER, {"type": "array", "items": _NUMBER, "minItems": 1, "maxItems": 2}]}
_TWO = {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}
_BOUNDS = {"at_least": _NUMBER, "at_most": _NUMBER, "each": {"type": "boolean"}}


def _varies(way: str, told: dict[str, Any], beside: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": {way: told, **beside}, "required": [way], "additionalProperties": False}


_WAYS: list[dict[str, Any]] = [
    _varies("uniform", _TWO, _BOUNDS),
    _varies("normal", _CENTRE_AND_WIDTH, _BOUNDS),
    _varies("lognormal", _CENTRE_AND_WIDTH, _BOUNDS),
    _varies("values", {"type": "array", "minItems": 1}, {"with": {"type": "string"}}),
    _varies("scan", _TWO, {"until": {"type": "object", "additionalProperties": _NUMBER}}),
]
SWEEP_SCHEMA = {
    "type": "object",
    "additionalProperties": {"anyOf": [*_WAYS, _varies("factor", {"anyOf": _WAYS}, {})]},
}


def _printable(value: dict[str, Any]) -> dict[str, Any]:
    if len(value) > MOST_CONTROLLERS:
        raise ValueError(f"are {len(value)}; one comparison has at most {MOST_CONTROLLERS} controllers")
    for label in value:
        if len(label) > _LONGEST_LABEL:
            raise ValueError(f"the label {label!r} has {len(label)} characters; at most {_LONGEST_LABEL} fit a table")
        if not label.strip() or not label.isprintable():
            raise ValueError(f"the label {label!r} must be printable text, as it is shown in tables and figures")
    return value


def _in_seconds(period: float) -> float:
    try:
        check_period(period)
    except ParameterError as error:
        raise ValueError(error.said) from None
    return period


class ExperimentTables(TomlTable):
    """All keys at the top of an experiment file."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$",
        max_length=100,
        description="results go to results/NAME; letters, digits, '.', '_' and '-'",
    )
    arm: Annotated[ArmTable, BeforeValidator(arm_table)] = Field(description="name, URDF path, or a table")
    period: Annotated[float, AfterValidator(_in_seconds)] = Field(
        gt=0.0,
        description="control period L of every controller, s",
        json_schema_extra={"exclusiveMaximum": LONGEST_PERIOD},
    )
    duration: float = Field(gt=0.0, description="length of the run, s")
    log_every: int = Field(
        default=1,
        ge=1,
        description="one control tick in how many is kept in a result's trajectories; figures and verdicts are of all "
        "ticks",
    )
    seed: int = Field(
        default=0,
        ge=0,
        description="seed of everything random: noise and scatter of a trial follow from it and the trial's number",
    )
    trial: int = Field(
        default=0, ge=0, description="number of the trial that is run: with the seed it decides noise and scatter"
    )
    plant: PlantTable = Field(default_factory=PlantTable, description="the simulated world")
    ensemble: EnsembleTable = Field(default_factory=EnsembleTable, description="how sure a figure is")
    metrics: MetricsTable = Field(default_factory=MetricsTable, description="settings of the metrics")
    reference: dict[str, Any] = Field(description="the motion to follow: kind, and the parameters of that kind")
    tune: TuneTable = Field(default_factory=TuneTable, description="how `tune` searches gains: see docs/tuning.md")
    sweep: Annotated[dict[str, Any], WithJsonSchema(SWEEP_SCHEMA)] = Field(
        default={}, description="what varies from trial to trial in a sweep, by the path of its key: see docs/sweeps.md"
    )
    defaults: dict[str, Any] = Field(default={}, description="parameters shared by the controllers")
    controllers: Annotated[dict[str, dict[str, Any]], AfterValidator(_printable)] = Field(
        min_length=1, description="[controllers.LABEL]: law, and its parameters"
    )

    @field_validator("duration")
    @classmethod
    def _fits_period_and_memory(cls, duration: float, info: ValidationInfo) -> float:
        period = info.data.get("period")
        if period is not None and round(duration / period) < 1:
            raise ValueError(f"{duration:g} s is less than one control period of {period:g} s; make it longer")
        if period is not None and duration > MOST_TICKS * period:
            raise ValueError(
                f"{duration:g} s are {duration / period:.3g} control periods of {period:g} s, and a run keeps all of "
                f"them in memory: at most {MOST_TICKS:g}; shorten the duration, or lengthen the period"
            )
        return duration

    @field_validator("log_every")
    @classmethod
    def _keeps_more_than_the_start(cls, log_every: int, info: ValidationInfo) -> int:
        period, duration = info.data.get("period"), info.data.get("duration")
        if period is not None and duration is not None and log_every > (most := round(duration / period)):
            raise ValueError(
                f"{log_every} would keep the start alone of a run of {most} control periods; at most {most}"
            )
        return log_every
