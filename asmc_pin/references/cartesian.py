"""Motions of the tool along straight lines, turned into joint motions by inverse kinematics with a stated residual."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import Rotation

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import AsGiven, Choice, Scalar, Values
from asmc_pin.references.reference import as_times, held_outside, quintic_blend, reference_kind

_KNOT = 0.004  # s, at most, between configurations that are solved for; a quintic spline joins them
_SOLVED = 1e-11  # m and rad
_ITERATIONS = 60
_STEP = 0.3  # rad (m), the furthest that one iteration moves a joint


@reference_kind("cartesian")
@dataclass(frozen=True, kw_only=True, eq=False)
class CartesianPath:
    """The origin of a link along straight lines from point to point, at rest in each (10x³ − 15x⁴ + 6x⁵ in between).

    It starts where `start` puts the link; orientation, unless free, turns about a fixed axis at the same pace. `on`
    solves the inverse kinematics for an arm and gives the reference to follow.

    Attributes:
        link: Name of the link (or frame of the URDF) that is moved.
        start: Angles at t = 0, nv values, rad; which branch of the inverse kinematics is followed is decided here.
        points: Where each line ends, shape (lines, 3), m in the base frame; 3 values if there is only one.
        move: Time of each line, s; a number or one per line.
        orientation: ``"keep"`` that of the start, ``"free"``, or ``"given"`` by `rpy`.
        rpy: Roll, pitch, yaw at each point, as in a URDF, shape (lines, 3), rad.
        tolerance: The largest deviation from the path that is allowed between the solved configurations, m and rad.
    """

    motion: ClassVar[str] = "a link along straight lines from point to point, at rest in each"

    start: Values = Values("angles at t = 0", "rad", axes=(1,), shape="a list of one per joint")
    points: Values = Values("where each line ends, in the base frame", "m", axes=(1, 2), shape="a list of points")
    move: Values = Values("time of each line", "s", axes=(0, 1), shape="a number or a list of one per line", above=0.0)
    link: AsGiven = AsGiven("link or frame that is moved", shape="text")
    orientation: Choice = Choice("of the link on its way", ("keep", "free", "given"), default="keep")
    rpy: AsGiven = AsGiven(
        'roll, pitch, yaw at each point, with orientation = "given"', "rad", shape="a list of points", default=None
    )
    tolerance: Scalar = Scalar("largest deviation from the path", "m and rad", above=0.0, default=1e-6)

    def __post_init__(self) -> None:
        """Check what depends on several parameters."""
        points = np.atleast_2d(self.points)
        if points.shape[1] != 3:
            raise ParameterError("points", f"a point has {points.shape[1]} values; expected x, y, z in m")
        if self.move.ndim == 1 and self.move.size != len(points):
            raise ParameterError("move", f"has {self.move.size} values for {len(points)} points; give one for each")
        if not isinstance(self.link, str):
            raise ParameterError("link", f"{self.link!r} given; expected the name of a link")
        if (self.orientation == "given") != (self.rpy is not None):
            raise ParameterError("rpy", "goes with orientation = 'given': roll, pitch, yaw at each point, in rad")
        if self.rpy is not None:
            try:
                angles = np.array(np.atleast_2d(self.rpy), dtype=np.float64)
            except (TypeError, ValueError):
                angles = np.empty((0, 0))
            if angles.shape != points.shape or not np.isfinite(angles).all():
                count = len(points)
                raise ParameterError("rpy", f"got {self.rpy!r}; expected roll, pitch, yaw for each of {count} points")
            angles.setflags(write=False)
            object.__setattr__(self, "rpy", angles)

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.start.size)

    @property
    def duration(self) -> float:
        """When the last point is reached, s."""
        return float(np.sum(np.broadcast_to(self.move, (len(np.atleast_2d(self.points)),))))

    def evaluate(self, t: Array) -> Setpoint:
        """Not before an arm is known: raises a `ParameterError` that says so."""
        raise ParameterError("reference", "a Cartesian path is followed by an arm; take reference.on(arm)")

    def poses(self, t: Array, first: Array) -> tuple[Array, Array]:
        """Positions (T, 3), m, and rotation matrices (T, 3, 3) of the path, from the pose (4, 4) at the start."""
        points = np.vstack([first[:3, 3], np.atleast_2d(self.points)])
        turns = Rotation.from_matrix(np.repeat(first[None, :3, :3], len(points), axis=0))
        if self.orientation == "given":
            turns = Rotation.concatenate([turns[:1], Rotation.from_euler("xyz", self.rpy)])
        ends = np.cumsum(np.broadcast_to(self.move, (len(points) - 1,)))
        line = np.minimum(np.searchsorted(ends, t, side="right"), len(ends) - 1)
        begin = np.concatenate([[0.0], ends[:-1]])
        share = quintic_blend((t - begin[line]) / (ends - begin)[line])[0][:, None]
        position = points[line] + share * (points[line + 1] - points[line])
        way = (turns[:-1].inv() * turns[1:]).as_rotvec()
        return position, (turns[line] * Rotation.from_rotvec(share * way[line])).as_matrix()

    def on(self, arm: Arm) -> SolvedPath:
        """The joint motion that moves an arm along the path.

        Raises:
            ParameterError: no such link, another number of joints, or a point that the arm does not reach without
                a jump or from this start.
        """
        if self.nv != arm.nv:
            text = f"has {self.nv} values but {arm.name} has {arm.nv} joints; give one per joint"
            raise ParameterError("start", text)
        frame = FrameKinematics(arm, self.link, "link")
        ends = np.concatenate([[0.0], np.cumsum(np.broadcast_to(self.move, (len(np.atleast_2d(self.points)),)))])
        pieces = [np.linspace(a, b, 2 + math.ceil((b - a) / _KNOT), endpoint=False) for a, b in pairwise(ends)]
        times = np.append(np.concatenate(pieces), ends[-1])
        first = frame.poses(self.start)
        q = np.empty((len(times), self.nv))
        q[0] = self.start
        for k, (point, turn) in enumerate(zip(*self.poses(times, first), strict=True)):
            guess = q[0] if k == 0 else 2.0 * q[k - 1] - q[k - 2] if k > 1 else q[k - 1]
            q[k] = self._solve(frame, point, turn, guess, times[k])
        still = np.zeros(self.nv)
        rest: Any = ([(1, still), (2, still)],) * 2
        curve = make_interp_spline(times, q, k=5, bc_type=rest)
        between = 0.5 * (times[1:] + times[:-1])
        found = frame.poses(np.asarray(curve(between)))
        deviation = self._deviation(found, *self.poses(between, first))
        worst = int(np.argmax(np.abs(deviation).max(axis=1)))
        largest = np.abs(deviation[worst]).max()
        if not largest <= self.tolerance:
            raise ParameterError(
                "points",
                f"the joints leave the path by {largest:.2g} m or rad at t = {between[worst]:.4g} s: "
                "the path passes near a singularity there, or is too fast; move it, or give it more time",
            )
        sizes = np.linalg.norm(deviation.reshape(len(between), -1, 3), axis=2).max(axis=0)
        return SolvedPath(self, curve, float(sizes[0]), float(sizes[1]) if sizes.size > 1 else math.nan)

    def _deviation(self, found: Array, position: Array, rotation: Array) -> Array:
        """What is missing from poses (..., 4, 4), along the base's axes, (..., 3) or (..., 6), m and rad."""
        apart = position - found[..., :3, 3]
        if self.orientation == "free":
            return apart
        turn = Rotation.from_matrix(rotation) * Rotation.from_matrix(found[..., :3, :3]).inv()
        return np.concatenate([apart, turn.as_rotvec()], axis=-1)

    def _solve(self, frame: FrameKinematics, position: Array, rotation: Array, guess: Array, time: float) -> Array:
        """Gauss–Newton with the shortest step of the joints, so that a redundant arm moves no more than it must."""
        q = np.array(guess)
        for _ in range(_ITERATIONS):
            apart = self._deviation(frame.poses(q), position, rotation)
            if np.abs(apart).max() < _SOLVED:
                return q
            step = np.linalg.lstsq(frame.jacobians(q)[: apart.size], apart, rcond=1e-9)[0]
            q = q + step * min(1.0, _STEP / max(np.abs(step).max(), 1e-300))
        raise ParameterError(
            "points",
            f"link '{self.link}' does not get to {np.round(position, 4).tolist()} m at t = {time:.4g} s "
            f"(left over: {np.abs(apart).max():.2g} m or rad); it is out of reach or beyond a singularity",
        )


@dataclass(frozen=True, eq=False)
class SolvedPath:
    """A Cartesian path as a motion of the joints.

    Attributes:
        path: What was asked for.
        curve: Quintic spline through the solved configurations.
        residual_position: Largest distance from the path midway between them, m.
        residual_rotation: Largest angle, rad; NaN where orientation is free.
    """

    path: CartesianPath
    curve: BSpline
    residual_position: float
    residual_rotation: float

    @property
    def nv(self) -> int:
        """Number of joints."""
        return self.path.nv

    @property
    def duration(self) -> float:
        """When the last point is reached, s."""
        return self.path.duration

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv)."""
        t = as_times(t)
        inside = (t >= 0.0) & (t <= self.duration)
        q, v, a = (np.asarray(self.curve(np.clip(t, 0.0, self.duration), nu)) for nu in range(3))
        return held_outside(inside, q, v, a)

    def __str__(self) -> str:
        turn = "" if math.isnan(self.residual_rotation) else f" and {self.residual_rotation:.2g} rad"
        return (
            f"Cartesian path of {self.path.link}: inverse kinematics to {self.residual_position:.2g} m{turn}, "
            "checked midway between its knots"
        )
