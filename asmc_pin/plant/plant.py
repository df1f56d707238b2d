"""The plant's parameters: arms, friction, drives, and how they are integrated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.errors import ParameterError
from asmc_pin.plant.friction import Friction
from asmc_pin.plant.integrators import INTEGRATORS
from asmc_pin.plant.motion import Motion
from asmc_pin.plant.parameters import per_trial, read_only


@dataclass(frozen=True, eq=False, init=False)
class Plant:
    """Ground truth: arms with friction and drives, for one trial or a batch; parameters only, `begin` starts it.

    Attributes:
        arms: The arm of all trials, or one per trial (payload, armature and the like may differ, the joints may not).
        substeps: Integration steps per control period; the torque is held over all of them.
        friction: Joint friction; its arrays may be per trial.
        effort_limit: Torque limits of the drives, (nv,) or (batch, nv), N·m (N); inf for none.
        start: ``"holding"``: before t = 0 the drives balance gravity at q(0), as far as their limits go, as when a
            brake opens; ``"relaxed"``: they apply nothing.
        integrator: Name of the scheme in `asmc_pin.plant.INTEGRATORS`.
        speed_bound: A trial has diverged when a joint is faster, rad/s (m/s).
        error_bound: A trial has diverged when a joint is further from its reference, rad (m).
        threads: Threads for Pinocchio; the result does not depend on them.
    """

    arms: tuple[Arm, ...]
    substeps: int
    friction: Friction
    effort_limit: Array
    start: Literal["holding", "relaxed"]
    integrator: str
    speed_bound: float
    error_bound: float
    threads: int

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
                idle:
            OpenMP's threads spin while they wait, so beside other work the run takes several times longer.

        Raises:
            ParameterError: a parameter has a wrong size, sign or value.
        """
        arms = (arm,) if isinstance(arm, Arm) else tuple(arm)
        _check_arms(arms)
        if isinstance(substeps, bool) or int(substeps) != substeps or substeps < 1:
            raise ParameterError("substeps", f"{substeps!r} given; expected a whole number of at least 1")
        if start not in ("holding", "relaxed"):
            raise ParameterError("start", f"{start!r} given; expected 'holding' or 'relaxed'")
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
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        # What is for another number of joints is found here; whether it suits the batch, when there is one.
        for name, array in (
            ("friction.coulomb", friction.coulomb),
            ("friction.viscous", friction.viscous),
            ("effort_limit", limit),
        ):
            per_trial(name, array, len(array) if array.ndim == 2 else 1, self.nv)

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

    def begin(self, q: Array, v: Array, period: float) -> Motion:
        """Trials at rest in time, ready for their first control tick.

        Args:
            q: q(0), shape (batch, nv), rad.
            v: v(0), shape (batch, nv), rad/s.
            period: Control period, s.

        Raises:
            ParameterError: the plant's arms, friction or limits are for another number of trials.
        """
        if len(self.arms) not in (1, len(q)):
            raise ParameterError(
                "arm", f"{len(self.arms)} arms given for a batch of {len(q)}; give one, or one per trial"
            )
        return Motion(self, period, q, v)


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
