"""Motions from way-point to way-point: quick quintic moves with rests between them, and cosine ramps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import Values
from asmc_pin.references.reference import as_times, cosine_blend, quintic_blend, reference_kind

Blend = Callable[[Array], tuple[Array, Array, Array]]


@reference_kind("quintic")
@dataclass(frozen=True, kw_only=True, eq=False)
class Quintic:
    """Point-to-point moves that start and end with zero velocity and acceleration, and rest in between ("step-like").

    q = q_{j−1} + (q_j − q_{j−1}) (10x³ − 15x⁴ + 6x⁵), x = (t − t_j)/T_j. The largest speed of a move is 1.875 times its
    mean speed.

    Attributes:
        start: Angles before the first move, nv values, rad.
        targets: Where each move ends, shape (moves, nv), rad; nv values if there is only one.
        times: t_j, when each move starts, s, one per move; default 0, which fits a single move.
        move: T_j, how long each takes, above 0, s; a number or one per move.

    Raises:
        ParameterError: wrong sizes or signs, or a move that starts before the one before it has ended.
    """

    motion: ClassVar[str] = 'moves between targets along 10x³ − 15x⁴ + 6x⁵, at rest in between ("step-like")'

    start: Values = Values("angles before the first move", "rad", axes=(1,), shape="a list of one per joint")
    targets: Values = Values("where each move ends", "rad", axes=(1, 2), shape="a list of targets, one value per joint")
    times: Values = Values(
        "start of each move", "s", axes=(0, 1), shape="a list of one per move", at_least=0.0, default=0.0
    )
    move: Values = Values("time of each move", "s", axes=(0, 1), shape="a number or a list of one per move", above=0.0)

    def __post_init__(self) -> None:
        targets = np.atleast_2d(self.targets)
        moves = len(targets)
        if targets.shape[1] != self.start.size:
            raise ParameterError(
                "targets", f"a target has {targets.shape[1]} values but start has {self.start.size}; give one per joint"
            )
        for name, value in (("times", self.times), ("move", self.move)):
            if value.size != moves and not (name == "move" and value.ndim == 0):
                raise ParameterError(name, f"has {value.size} values for {moves} targets; give one for each")
        starts, ends = self._schedule()
        for j in range(1, moves):
            if starts[j] < ends[j - 1]:
                raise ParameterError(
                    "times",
                    f"move {j + 1} starts at {starts[j]:g} s but move {j} lasts until {ends[j - 1]:g} s; "
                    "start it later or shorten move",
                )

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.start.size)

    @property
    def duration(self) -> float:
        """End of the last move, s."""
        return float(self._schedule()[1][-1])

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv)."""
        points = np.vstack([self.start, np.atleast_2d(self.targets)])
        starts, ends = self._schedule()
        return _blended(as_times(t), points, starts, ends - starts, quintic_blend)

    def _schedule(self) -> tuple[Array, Array]:
        starts = np.atleast_1d(self.times)
        return starts, starts + self.move


@reference_kind("ramps")
@dataclass(frozen=True, kw_only=True, eq=False)
class Ramps:
    """Cosine ramps through way-points, at rest in each.

    q = q_j + (q_{j+1} − q_j)(1 − cos πx)/2, x = (t − t_j)/(t_{j+1} − t_j). The acceleration jumps
    at the way-points, by π²/2 times the step over the square of its time. Two equal way-points in a row make a rest.

    Attributes:
        points: Way-points, shape (points, nv), at least two, rad.
        times: When each is reached, one per way-point, increasing, s; before the first and after the last it rests.

    Raises:
        ParameterError: wrong sizes, or times that do not increase.
    """

    motion: ClassVar[str] = "cosine ramps through way-points, at rest in each"

    points: Values = Values("way-points", "rad", axes=(2,), shape="a list of way-points, one value per joint")
    times: Values = Values("when each is reached", "s", axes=(1,), shape="a list of one per way-point", at_least=0.0)

    def __post_init__(self) -> None:
        if len(self.points) < 2:
            raise ParameterError("points", f"has {len(self.points)} way-point; give at least two")
        if self.times.size != len(self.points):
            raise ParameterError(
                "times", f"has {self.times.size} values for {len(self.points)} way-points; give one for each"
            )
        late = np.flatnonzero(np.diff(self.times) <= 0.0)
        if late.size:
            j = int(late[0])
            raise ParameterError(
                "times", f"{self.times[j + 1]:g} s comes after {self.times[j]:g} s; they must increase"
            )

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.points.shape[1])

    @property
    def duration(self) -> float:
        """Time of the last way-point, s."""
        return float(self.times[-1])

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv)."""
        return _blended(as_times(t), self.points, self.times[:-1], np.diff(self.times), cosine_blend)


def _blended(t: Array, points: Array, starts: Array, lengths: Array, blend: Blend) -> Setpoint:
    """Move j goes from points[j] to points[j+1], from starts[j] on, in lengths[j]; between moves it rests."""
    j = np.maximum(np.searchsorted(starts, t, side="right") - 1, 0)
    step = np.diff(points, axis=0)[j]
    length = lengths[j][:, None]
    position, rate, bend = blend((t - starts[j])[:, None] / length)
    return Setpoint(points[j] + step * position, step * rate / length, step * bend / length**2)
