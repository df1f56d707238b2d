"""What a controller sees and what it must offer.

Controllers import numpy only and never see the plant: no mass matrix, no gravity, no friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from asmc_pin._typing import Array


@dataclass(frozen=True, slots=True)
class Sample:
    """What a drive reports at one control tick.

    Attributes:
        q: Joint angles (m for prismatic joints), shape (batch, nv), rad.
        v: Joint velocities, shape (batch, nv), rad/s.
        torque: Torque really applied over the last period, after the drive's limits; at t = 0 the torque it holds.
            Shape (batch, nv), N·m.
    """

    q: Array
    v: Array
    torque: Array


@dataclass(frozen=True, slots=True)
class Setpoint:
    """The set point: what the reference asks for at one control tick; each field of shape (batch, nv).

    Attributes:
        q: Desired angle, rad.
        v: Desired velocity, rad/s.
        a: Desired acceleration, rad/s².
    """

    q: Array
    v: Array
    a: Array


class Controller(Protocol):
    """A law with its parameters, as a run uses it, for a batch of trials.

    The parameters are fixed. What changes from tick to tick is the state, which `step` takes and returns.

    Two attributes are optional and only serve the log: ``ks``, with which the sliding variable s is computed, and
    ``gain`` of the state, (batch, nv), rad/s², where a law has an adaptive gain.
    """

    @property
    def period(self) -> float:
        """Control period L, s."""
        ...

    def init(self, sample: Sample) -> Any:
        """State before the first tick, made from the sample of t = 0."""
        ...

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        """Torque to hold over the next period, shape (batch, nv), and the next state. First called at t = 0."""
        ...
