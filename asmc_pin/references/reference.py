"""What a reference offers, and what the kinds share."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.registering import registering

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


class Reference(Protocol):
    """A desired motion with its exact velocity and acceleration; for a prismatic joint read m for rad."""

    @property
    def nv(self) -> int:
        """Number of joints."""
        ...

    @property
    def duration(self) -> float:
        """Time at which the motion is over and is held from then on, s; infinity if it goes on for ever."""
        ...

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv) in rad, rad/s, rad/s².

        Outside the time for which it is defined it holds the nearest end, with velocity and acceleration 0.
        """
        ...


@runtime_checkable
class OnAnArm(Protocol):
    """A kind that only an arm can follow, as motions of its tool; `Reference` is what `on` makes of it."""

    start: Array

    def on(self, arm: Arm) -> Reference:
        """The motion of the joints of this arm."""
        ...


class Kind(Protocol):
    """A kind of reference, as it is registered: a dataclass of parameters that says what it is.

    Attributes:
        motion: What it does, in one line for the tables.
    """

    motion: ClassVar[str]

    @property
    def nv(self) -> int:
        """Number of joints."""
        ...


def reference_words(reference: Reference) -> tuple[str, ...]:
    """What was done to a file before it became this motion, a sentence each; nothing for other motions."""
    return tuple(getattr(reference, "told", ()))


REFERENCES: dict[str, type[Kind]] = {}
"""The kinds of reference by the names that experiments use; complete in `asmc_pin.references`, which imports them."""

reference_kind = registering(REFERENCES)


def as_times(t: Array) -> Array:
    """The times as a float64 array of shape (T,); a `ParameterError` for anything else, or for NaN and infinity."""
    times = np.asarray(t, dtype=np.float64)
    if times.ndim != 1 or not np.isfinite(times).all():
        raise ParameterError("t", f"got times of shape {times.shape}; expected finite ones of shape (T,), in s")
    return times


def held_outside(inside: BoolArray, q: Array, v: Array, a: Array) -> Setpoint:
    """The motion (q, v, a), each (T, nv), at rest wherever inside, (T,), is false."""
    at_rest = ~inside[:, None]
    return Setpoint(q, np.where(at_rest, 0.0, v), np.where(at_rest, 0.0, a))


def quintic_blend(x: Array) -> tuple[Array, Array, Array]:
    """10x³ − 15x⁴ + 6x⁵ on 0…1, and its first two derivatives by x; 0 before, 1 after. It starts and ends at rest."""
    x = np.clip(x, 0.0, 1.0)
    rest = 1.0 - x
    return x**3 * (10.0 + x * (6.0 * x - 15.0)), 30.0 * (x * rest) ** 2, 60.0 * x * rest * (1.0 - 2.0 * x)


def cosine_blend(x: Array) -> tuple[Array, Array, Array]:
    """(1 − cos πx)/2 on 0…1, and its first two derivatives by x; 0 before, 1 after.

    The second derivative jumps at both ends; there the later value is taken.
    """
    moving = (x >= 0.0) & (x < 1.0)
    angle = np.pi * np.clip(x, 0.0, 1.0)
    return (
        0.5 * (1.0 - np.cos(angle)),
        np.where(moving, 0.5 * np.pi * np.sin(angle), 0.0),
        np.where(moving, 0.5 * np.pi**2 * np.cos(angle), 0.0),
    )
