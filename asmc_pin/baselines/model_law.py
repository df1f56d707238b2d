"""What laws that know the model have in common: a model of the arm, exact or with a stated error."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import Any, ClassVar, Self

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import Choice, Scalar, match_joints
from asmc_pin.registering import registering


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelLaw(ABC):
    """A law that computes with a model of the arm, M̂ and ĥ = Ĉ q̇ + ĝ; the laws derive from it.

    The model is the arm itself unless an error is stated: `mass_scale` c multiplies the mass and the rotational inertia
    of every link, the payload's among them, and leaves centres of mass and armature as they are, so that
    M̂ = c (M − diag(armature)) + diag(armature) and ĥ = c h; ``payload="unknown"`` takes the payload away. What the
    plant does beyond the arm (friction, drives, a payload picked up during a run) is not in the model.

    Attributes:
        period: Control period L, above 0, s.
        mass_scale: c, above 0; 1 for an exact model.
        payload: ``"known"`` or ``"unknown"``.
        arm: The arm that the model is of; an experiment gives its own (`with_arm`).

    Raises:
        ParameterError: a parameter has a wrong type, size or sign, or is not finite.
    """

    knows_model: ClassVar[bool] = True
    title: ClassVar[str] = ""
    equation: ClassVar[str] = ""
    reference: ClassVar[str] = ""
    oracle: ClassVar[str] = ""
    """What it does exactly, or in which order."""
    claim: ClassVar[str] = ""
    """What its source claims."""
    fails: ClassVar[str] = ""
    """When that does not hold."""
    typical: ClassVar[Mapping[str, float]] = {}
    """Values of its own parameters to begin with: they hold two_link, ur5 and panda at 1 kHz."""

    period: Scalar = Scalar("control period L", "s", above=0.0)
    mass_scale: Scalar = Scalar("masses and inertias of the model over the arm's", above=0.0, default=1.0)
    payload: Choice = Choice("whether the model has the payload", ("known", "unknown"), default="known")
    arm: Arm | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if self.arm is not None and not isinstance(self.arm, Arm):
            raise ParameterError("arm", f"{self.arm!r} given; expected an Arm, see asmc_pin.load_arm")
        nv = match_joints(self)
        if self.arm is not None and nv not in (None, self.arm.nv):
            raise ParameterError("arm", f"{self.arm.name} has {self.arm.nv} joints, the law's parameters are for {nv}")

    def with_arm(self, arm: Arm) -> Self:
        """The same law with a model of this arm.

        Raises:
            ParameterError: the law's parameters are for another number of joints.
        """
        return replace(self, arm=arm)

    @cached_property
    def model(self) -> Arm:
        """The arm of the model, before `mass_scale`.

        Raises:
            ParameterError: the law has no arm.
        """
        if self.arm is None:
            raise ParameterError(
                "arm",
                f"{type(self).__name__} computes with a model and has none; give arm=load_arm(…), or law.with_arm(…)",
            )
        return self.arm if self.payload == "known" or self.arm.payload is None else self.arm.replace(payload=None)

    def init(self, sample: Sample) -> Any:
        """There is no state unless a law has one; checks that the sample fits the arm.

        Raises:
            ParameterError: the law has no arm, or the sample's fields are not all (batch, nv).
        """
        shape = sample.q.shape
        if len(shape) != 2 or shape[1] != self.model.nv or sample.v.shape != shape:
            raise ParameterError(
                "sample",
                f"q and v have the shapes {shape} and {sample.v.shape}; expected (batch, {self.model.nv}) for both",
            )

    @abstractmethod
    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state, None where there is none."""

    def inertial_torque(self, q: Array, acceleration: Array) -> Array:
        """M̂(q) a, for arrays of shape (batch, nv)."""
        rotors = self.model.armature * acceleration
        # Every row by itself, so that a trial's torque does not depend on the batch it runs in.
        whole: Array = np.matmul(self.model.mass_matrix(q), acceleration[..., None])[..., 0]
        return self.mass_scale * (whole - rotors) + rotors

    def bias(self, q: Array, v: Array) -> Array:
        """ĥ(q, q̇) = Ĉ q̇ + ĝ, for arrays of shape (batch, nv)."""
        return self.mass_scale * self.model.bias(q, v)

    def gravity(self, q: Array) -> Array:
        """ĝ(q), for an array of shape (batch, nv)."""
        return self.mass_scale * self.model.gravity(q)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, so that a copy in another process is as read-only as this one.
        return partial(type(self), **{f.name: getattr(self, f.name) for f in fields(self)}), ()


BASELINES: dict[str, type[ModelLaw]] = {}
"""The laws by the names that experiments use; complete in `asmc_pin.baselines`, which imports their files."""

model_law = registering(BASELINES)
