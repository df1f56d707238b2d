"""What acts on the arm from outside, and what changes while it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin.arms import Arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.arms.payload import Payload, as_payload
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import AsGiven, Choice, OptionalPerJoint, OptionalScalar, Scalar, Values
from asmc_pin.plant.per_trial import sized

_ZERO: Any = (0.0, 0.0, 0.0)
PROFILES = ("step", "pulse", "sine", "noise")


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbance:
    """An external torque at the joints, or a wrench at a link, and how it goes in time.

    The profile p(t) multiplies `torque`, `force` and `moment`; it is 0 before `start`. ``step``: 1 from then on.
    ``pulse``: 1 for `duration`. ``sine``: sin 2πf(t − start). ``noise``: Gaussian with standard deviation 1, coloured
    by a first-order low-pass at `frequency` (an Ornstein–Uhlenbeck process), independent in each component and trial,
    held over each control period. `duration` ends the last three; only a pulse needs it. Over an integration step the
    mean of the profile acts, so that its impulse is exact wherever it begins or ends.
    """

    profile: Choice = Choice("how it goes in time", PROFILES)
    torque: OptionalPerJoint = OptionalPerJoint("amplitude at the joints", "N·m (N)")
    link: AsGiven = AsGiven("link or frame that a wrench acts on", shape="text", default=None)
    force: Values = Values(
        "amplitude of a force at the link's origin", "N", axes=(1,), shape="3 numbers", default=_ZERO
    )
    moment: Values = Values("amplitude of a moment on the link", "N·m", axes=(1,), shape="3 numbers", default=_ZERO)
    axes: Choice = Choice("whose axes force and moment are along", ("base", "link"), default="base")
    start: Scalar = Scalar("when it begins", "s", at_least=0.0, default=0.0)
    duration: OptionalScalar = OptionalScalar("how long it lasts", "s", above=0.0)
    frequency: OptionalScalar = OptionalScalar("of the sine, or corner of the noise", "Hz", above=0.0)

    def __post_init__(self) -> None:
        """Check what depends on several parameters."""
        if (self.torque is None) == (self.link is None):
            raise ParameterError("torque", "give either torque, for the joints, or link with force and moment")
        if self.link is not None and not isinstance(self.link, str):
            raise ParameterError("link", f"{self.link!r} given; expected the name of a link")
        for name in ("force", "moment"):
            if getattr(self, name).shape != (3,):
                raise ParameterError(name, f"{getattr(self, name).tolist()} given; expected 3 numbers")
        if self.profile == "pulse" and self.duration is None:
            raise ParameterError("duration", "is missing; a pulse needs to know how long it lasts")
        if self.profile in ("sine", "noise") and self.frequency is None:
            raise ParameterError("frequency", f"is missing; a {self.profile} needs one, in Hz")
        if self.profile == "step" and self.duration is not None:
            raise ParameterError("duration", "given for a step, which goes on for ever; a pulse ends")

    def check(self, arm: Arm) -> None:
        """Check sizes and names against an arm; raises `ParameterError`."""
        sized("disturbances", self, arm.nv)
        if self.link is not None:
            FrameKinematics(arm, self.link, "disturbances.link")

    def mean(self, since: float, until: float) -> float:
        """Mean of a profile without chance over an interval, exact."""
        end = np.inf if self.duration is None else self.start + self.duration
        low, high = max(since, self.start), min(until, end)
        if high <= low:
            return 0.0
        if self.profile != "sine":
            return (high - low) / (until - since)
        assert self.frequency is not None
        rate = 2.0 * np.pi * self.frequency
        middle, half = rate * (0.5 * (low + high) - self.start), 0.5 * rate * (high - low)
        return float(2.0 * np.sin(middle) * np.sin(half) / (rate * (until - since)))


@dataclass(frozen=True, kw_only=True, eq=False)
class PayloadChange:
    """Something is picked up or put down while the arm moves.

    From the control tick nearest to `time` on, the arm carries `payload` in place of what it carried; None for nothing.
    Velocities are continuous: what is picked up moves with the gripper already.
    """

    time: Scalar = Scalar("when", "s", at_least=0.0)
    payload: AsGiven = AsGiven(
        "what is carried from then on, as in `[arm]`; nothing when omitted",
        "kg",
        shape="a mass or a table",
        default=None,
    )

    def __post_init__(self) -> None:
        """Read the payload."""
        value = self.payload
        object.__setattr__(self, "payload", value if isinstance(value, Payload) else as_payload(value))

    def arms(self, arms: Sequence[Arm]) -> tuple[Arm, ...]:
        """The arms, carrying it; the same arm stays one."""
        made = {id(arm): arm.replace(payload=self.payload) for arm in arms}
        return tuple(made[id(arm)] for arm in arms)
