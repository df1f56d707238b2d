"""The plant's parameters: arms, friction, drives, and how they are integrated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.errors import ParameterError
from asmc_pin.plant.compiled_run.held_dynamics import held_bodies, no_recursion
from asmc_pin.plant.drive.drive_parameters import Drive
from asmc_pin.plant.friction.friction_parameters import Friction
from asmc_pin.plant.integrators import INTEGRATORS
from asmc_pin.plant.per_trial import per_trial, read_only
from asmc_pin.plant.sensor.sensor_parameters import Sensor
from asmc_pin.plant.world.end_stops import EndStops
from asmc_pin.plant.world.spread import Spread
from asmc_pin.plant.world.world_parameters import Disturbance, PayloadChange


@dataclass(frozen=True, eq=False, init=False)
class PlantParameters:
    """What a `Plant` is made of, checked; its attributes are explained there."""

    arms: tuple[Arm, ...]
    substeps: int
    friction: Friction
    effort_limit: Array
    start: Literal["holding", "relaxed"]
    integrator: str
    speed_bound: float
    error_bound: float
    threads: int
    drive: Drive | None
    sensor: Sensor | None
    end_stops: EndStops | None
    disturbances: tuple[Disturbance, ...]
    payload_changes: tuple[PayloadChange, ...]
    spread: Spread | None
    seed: int
    engine: Literal["compiled", "pinocchio"]
    first_trial: int

    def __init__(
        self,
        arm: Arm | Sequence[Arm],
        *,
        substeps: int = 2,
        friction: Friction | None = None,
        effort_limit: ArrayLike | None = None,
        start: Literal["holding", "relaxed"] = "holding",
        integrator: str = "semi_implicit",
        speed_bound: float = 1e3,
        error_bound: float = 1e2,
        threads: int = 1,
        drive: Drive | None = None,
        sensor: Sensor | None = None,
        end_stops: EndStops | None = None,
        disturbances: Sequence[Disturbance] = (),
        payload_changes: Sequence[PayloadChange] = (),
        spread: Spread | None = None,
        seed: int = 0,
        engine: Literal["compiled", "pinocchio"] = "compiled",
        first_trial: int = 0,
    ) -> None:
        """Check and freeze the parameters.

        Args:
            arm: One arm, or a sequence with one per trial.
            substeps: At least 1.
            friction: None for what the URDF declares.
            effort_limit: Positive; None for what the URDF declares.
            start: ``"holding"`` or ``"relaxed"``.
            integrator: A name in `asmc_pin.plant.INTEGRATORS`.
            speed_bound: Positive.
            error_bound: Positive.
            threads: At least 1. More than one pays from some 64 trials on, and only on processors that are otherwise
                idle: OpenMP's threads spin while they wait, so beside other work the run takes several times longer.
            drive: None for an ideal one.
            sensor: None for an ideal one.
            end_stops: None: a joint passes its limits, and the run says so.
            disturbances: Any number.
            payload_changes: Any number; they replace each other in order of time.
            spread: None for trials that are all alike.
            seed: Whole number, 0 or more.
            engine: ``"compiled"`` or ``"pinocchio"``.
            first_trial: Whole number, 0 or more.

        Raises:
            ParameterError: a parameter has a wrong size, sign or value; or the compiled dynamics of an arm are not
                Pinocchio's.
        """
        arms = (arm,) if isinstance(arm, Arm) else tuple(arm)
        _check_arms(arms)
        if isinstance(substeps, bool) or int(substeps) != substeps or substeps < 1:
            raise ParameterError("substeps", f"{substeps!r} given; expected a whole number of at least 1")
        if start not in ("holding", "relaxed"):
            raise ParameterError("start", f"{start!r} given; expected 'holding' or 'relaxed'")
        if engine not in ("compiled", "pinocchio"):
            raise ParameterError("engine", f"{engine!r} given; expected 'compiled' or 'pinocchio'")
        if integrator not in INTEGRATORS:
            raise ParameterError("integrator", f"{integrator!r} given; known are {', '.join(sorted(INTEGRATORS))}")
        for name, bound in (("speed_bound", speed_bound), ("error_bound", error_bound)):
            if not bound > 0.0:
                raise ParameterError(name, f"{bound} given; expected a positive number")
        if friction is None:
            friction = Friction(_stacked(arms, "friction"), _stacked(arms, "damping"))
        limit = read_only("effort_limit", _stacked(arms, "effort_limit") if effort_limit is None else effort_limit)
        if not np.all(limit > 0.0):
            raise ParameterError(
                "effort_limit", f"{limit.tolist()} given; expected positive torques, inf where there is no limit"
            )
        if threads < 1:
            raise ParameterError("threads", f"{threads} given; expected at least 1")
        values = {
            "arms": arms,
            "substeps": int(substeps),
            "friction": friction,
            "effort_limit": limit,
            "start": start,
            "integrator": integrator,
            "speed_bound": float(speed_bound),
            "error_bound": float(error_bound),
            "threads": threads,
            "drive": drive,
            "sensor": sensor,
            "end_stops": end_stops,
            "disturbances": tuple(disturbances),
            "payload_changes": tuple(sorted(payload_changes, key=lambda change: change.time)),
            "spread": spread,
            "engine": engine,
            "seed": _whole("seed", seed),
            "first_trial": _whole("first_trial", first_trial),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        self._check_options()
        if drive is not None and not drive.elastic and np.any(drive.reflected_inertia > 0.0):
            object.__setattr__(self, "arms", _shared(arms, lambda arm: _with_rotors(arm, drive)))
        if engine == "compiled":
            for each in dict.fromkeys(self.arms):
                if no_recursion(each) is None:
                    held_bodies(each)

    def _check_options(self) -> None:
        """Find what is for another number of joints; whether it suits the batch is seen when there is one."""
        limit = self.effort_limit
        self.friction.check(self.nv)
        per_trial("effort_limit", limit, len(limit) if limit.ndim == 2 else 1, self.nv)
        if self.friction.yields and self.integrator == "rk4":
            raise ParameterError(
                "integrator", "rk4 cannot carry presliding friction; take 'semi_implicit' or 'midpoint'"
            )
        if self.drive is not None:
            self.drive.check(self.nv, limit)
        if self.sensor is not None:
            self.sensor.check(self.arm.joint_kinds, self.arm.joint_names)
        if self.end_stops is not None:
            self.end_stops.check(self.nv)
        for disturbance in self.disturbances:
            disturbance.check(self.arm)
        for change in self.payload_changes:
            change.arms(self.arms[:1])

    @property
    def arm(self) -> Arm:
        """The arm; with one per trial, the first trial's."""
        return self.arms[0]

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.arms[0].nv)

    def torque_limits(self, batch: int) -> Array:
        """Torque limits of the drives, (batch, nv), N·m.

        Raises:
            ParameterError: they are for another number of trials.
        """
        return per_trial("effort_limit", self.effort_limit, batch, self.nv)

    def for_trials(self, trials: Sequence[int]) -> Self:
        """The plant of these trials, with the scatter of each drawn; the plant itself if nothing scatters.

        Args:
            trials: Numbers of the trials in the study, which seed what is random in them.

        Raises:
            ParameterError: the plant's arms are for another number of trials.
        """
        if len(self.arms) not in (1, len(trials)):
            raise ParameterError(
                "arm", f"{len(self.arms)} arms given for a batch of {len(trials)}; give one, or one per trial"
            )
        if self.spread is None:
            return self
        made = copy(self)
        numbers = self.numbered(trials)
        object.__setattr__(made, "arms", self.spread.arms(self.arms, self.seed, numbers))
        friction = self.spread.of_friction(self.friction, self.nv, self.seed, numbers)
        object.__setattr__(made, "friction", friction)
        object.__setattr__(made, "spread", None)
        return made

    def numbered(self, trials: Sequence[int]) -> list[int]:
        """Numbers that trials have in the study, and by which what is random in them is drawn."""
        return [self.first_trial + trial for trial in trials]

    def arms_at(self, time: float, period: float) -> tuple[Arm, ...]:
        """The arms with what they carry over the period that begins at a control tick, s."""
        arms = self.arms
        for change in self.payload_changes:
            if round(change.time / period) <= round(time / period):
                arms = change.arms(arms)
        return arms


def _whole(name: str, value: int) -> int:
    if isinstance(value, bool) or int(value) != value or value < 0:
        raise ParameterError(name, f"{value!r} given; expected a whole number, 0 or more")
    return int(value)


def _shared(arms: tuple[Arm, ...], change: Callable[[Arm], Arm]) -> tuple[Arm, ...]:
    """Every arm changed; trials that shared one still do."""
    made = {id(arm): change(arm) for arm in arms}
    return tuple(made[id(arm)] for arm in arms)


def _with_rotors(arm: Arm, drive: Drive) -> Arm:
    return arm.replace(armature=arm.armature + drive.reflected_inertia)


def _check_arms(arms: tuple[Arm, ...]) -> None:
    if not arms or not all(isinstance(arm, Arm) for arm in arms):
        raise ParameterError("arm", "expected an Arm (see asmc_pin.load_arm), or a sequence with one per trial")
    for trial, arm in enumerate(arms):
        if arm.joint_names != arms[0].joint_names:
            raise ParameterError(
                "arm",
                f"trial {trial} has the joints {', '.join(arm.joint_names)}, "
                f"trial 0 has {', '.join(arms[0].joint_names)}; "
                "arms of one batch differ in payload, armature or gravity, but not in their joints",
            )


def _stacked(arms: tuple[Arm, ...], name: str) -> Array:
    """The arms' values: (nv,) for one arm, (batch, nv) for one per trial."""
    values: Array = getattr(arms[0], name) if len(arms) == 1 else np.array([getattr(arm, name) for arm in arms])
    return values
