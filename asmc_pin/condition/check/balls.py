"""The condition itself in ball arithmetic, from the URDF's decimals on.

A third leg that shares nothing with the proof: no lift, no recursion, no losses, no floating point. Every number is a
ball that encloses the true one (Arb, in python-flint; F. Johansson, IEEE Trans. Comput. 66, 2017), the inertia matrix
is summed body by body from Jacobians in the base frame, and the condition is asked of M⁻¹M̄ as it is written.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from flint import arb, arb_mat

from asmc_pin.condition.check.ball_geometry import (
    about,
    column,
    cross,
    dot,
    normalised,
    rotation,
    symmetric,
    unit,
    zero,
)
from asmc_pin.condition.check.contents import Load, Statement
from asmc_pin.condition.check.urdf_text import Description

Verdict: TypeAlias = Literal["true", "false", "open"]
"""Whether it is so for all numbers in the balls, false for at least one, or neither by these balls."""

PRECISIONS = (128, 512)
"""Bits; the second where the first leaves a point open."""


@dataclass(frozen=True, eq=False)
class _Above:
    """A moving joint on the way to a body: its number, kind, and axis and place in the base frame."""

    number: int
    slides: bool
    axis: arb_mat
    place: arb_mat


class BallArm:
    """An arm whose inertia matrix is computed in balls.

    Args:
        robot: The robot.
        joints: Names of its moving joints.
        locked: The angles of the others, rad (m where prismatic), exact.
        payload: What is fastened to a link of it.
    """

    def __init__(
        self, robot: Description, joints: Sequence[str], locked: Mapping[str, float], payload: Load | None
    ) -> None:
        self._robot, self._locked, self._payload = robot, locked, payload
        self._index = {name: i for i, name in enumerate(joints)}

    def mass_matrix(self, q: Sequence[arb], armature: Sequence[arb]) -> arb_mat:
        """M(q) + diag(armature), an enclosure of it for every q and armature in the balls; (n, n)."""
        n = len(self._index)
        total = [[arb(0)] * n for _ in range(n)]
        for i in range(n):
            total[i][i] = armature[i]
        waiting: list[tuple[str, arb_mat, arb_mat, tuple[_Above, ...]]] = [(self._robot.root, unit(), zero(), ())]
        while waiting:
            name, turn, place, above = waiting.pop()
            body = self._robot.bodies[name]
            if above and body is not None:
                mass, tensor = arb(body.mass), symmetric([arb(x) for x in body.inertia])
                _add(total, mass, tensor, turn, place, rotation(body.pose), column(body.pose.xyz), above)
            if above and self._payload is not None and self._payload.link == name:
                load = self._payload
                tensor = symmetric([arb(x) for x in load.inertia])
                com = arb_mat(3, 1, [arb(x) for x in load.com])
                _add(total, arb(load.mass), tensor, turn, place, unit(), com, above)
            for joint in self._robot.children.get(name, ()):
                there, at = turn * rotation(joint.pose), place + turn * column(joint.pose.xyz)
                number = self._index.get(joint.name) if joint.kind != "fixed" else None
                if joint.kind == "fixed":
                    waiting.append((joint.child, there, at, above))
                    continue
                along, slides = normalised(joint.axis), joint.kind == "prismatic"
                by = arb(self._locked[joint.name]) if number is None else q[number]
                axis = there * along
                beyond = above if number is None else (*above, _Above(number, slides, axis, at))
                if slides:
                    waiting.append((joint.child, there, at + axis * by, beyond))
                else:
                    waiting.append((joint.child, there * about(along, by), at, beyond))
        return arb_mat(total)


def _add(
    total: list[list[arb]],
    mass: arb,
    tensor: arb_mat,
    turn: arb_mat,
    place: arb_mat,
    pose: arb_mat,
    com: arb_mat,
    above: tuple[_Above, ...],
) -> None:
    """Add m Jᵀ J of a body's centre and Jᵀ I J of its turning to the inertia matrix."""
    at, turned = place + turn * com, turn * pose
    inertia = turned * tensor * turned.transpose()
    columns = []
    for joint in above:
        linear = joint.axis if joint.slides else cross(joint.axis, at - joint.place)
        angular = zero() if joint.slides else joint.axis
        columns.append((joint.number, linear, angular, inertia * angular))
    for i, linear, angular, _ in columns:
        for j, other, _, moment in columns:
            if j <= i:
                value = mass * dot(linear, other) + dot(angular, moment)
                total[i][j] = total[i][j] + value
                total[j][i] = total[i][j]


def holds(statement: Statement, mass: arb_mat, mbar: Sequence[float]) -> Verdict:
    """A statement at the inertia matrices that a ball matrix encloses, asked of f M⁻¹M̄ itself.

    With S = M̄^½ M⁻¹ M̄^½ and A = f M⁻¹M̄: ``weighted`` says f λ(S) < 1 + γ, ``bounded`` says f λ(S) > 1 − γ, ``lemma1``
    and ``level`` say ‖I − A‖₂ < γ.
    """
    n = len(mbar)
    f, gamma = arb(statement.scale), arb(statement.level)
    try:
        inverse = mass.inv()
    except ZeroDivisionError:
        return "open"
    if statement.kind in ("weighted", "bounded"):
        root = [arb(m).sqrt() for m in mbar]
        sign, limit = (1, 1 + gamma) if statement.kind == "weighted" else (-1, gamma - 1)
        return positive(n, lambda i, j: (limit if i == j else arb(0)) - sign * f * root[i] * inverse[i, j] * root[j])
    error = _error(inverse, f, mbar)
    square = error.transpose() * error
    return positive(n, lambda i, j: (gamma * gamma if i == j else arb(0)) - square[i, j])


def _error(inverse: arb_mat, f: arb, mbar: Sequence[float]) -> arb_mat:
    """I − f M⁻¹M̄."""
    n = len(mbar)
    return arb_mat([[arb(int(i == j)) - f * inverse[i, j] * arb(mbar[j]) for j in range(n)] for i in range(n)])


def positive(n: int, entry: Callable[[int, int], arb]) -> Verdict:
    """Whether a symmetric matrix is positive definite, by L D Lᵀ: every pivot above zero for sure."""
    rows = [[entry(max(i, j), min(i, j)) for j in range(n)] for i in range(n)]
    for k in range(n):
        pivot = rows[k][k]
        if not pivot > 0:
            return "false" if pivot <= 0 else "open"
        for i in range(k + 1, n):
            factor = rows[i][k] / pivot
            for j in range(k + 1, i + 1):
                rows[i][j] = rows[i][j] - factor * rows[j][k]
    return "true"


def norm_bound(
    condition: str, scale: float, mass: arb_mat, mbar: Sequence[float], direction: Sequence[float]
) -> arb | None:
    """An enclosure of a number that the condition's norm at scale · M̄ is not below; None where the balls say nothing.

    ``lemma1``: ‖(I − A) u‖/‖u‖. ``weighted``: |uᵀ(I − f S)u| / uᵀu. Any direction u makes it true, a good one close.
    """
    n = len(mbar)
    f = arb(scale)
    try:
        inverse = mass.inv()
    except ZeroDivisionError:
        return None
    u = arb_mat(n, 1, [arb(x) for x in direction])
    if not dot(u, u) > 0:
        return None
    if condition == "weighted":
        root = [arb(m).sqrt() for m in mbar]
        scaled = arb_mat(
            [[arb(int(i == j)) - f * root[i] * inverse[i, j] * root[j] for j in range(n)] for i in range(n)]
        )
        return abs(dot(u, scaled * u)) / dot(u, u)
    image = _error(inverse, f, mbar) * u
    return (dot(image, image) / dot(u, u)).sqrt()


def no_multiple(mass: arb_mat, mbar: Sequence[float], direction: Sequence[float]) -> bool:
    """Whether uᵀ M⁻¹M̄ u ≤ 0 for sure: then ‖I − f M⁻¹M̄‖₂ ≥ 1 for every f > 0."""
    n = len(mbar)
    try:
        inverse = mass.inv()
    except ZeroDivisionError:
        return False
    u = arb_mat(n, 1, [arb(x) for x in direction])
    image = inverse * arb_mat(n, 1, [arb(m) * arb(x) for m, x in zip(mbar, direction, strict=True)])
    return bool(dot(u, u) > 0) and bool(dot(u, image) <= 0)


def downward(number: arb) -> float:
    """A float that is not above any number of a ball."""
    lower = number.lower()
    if not lower.is_finite():
        return -math.inf
    value = float(lower.mid())
    return value if lower >= value else math.nextafter(value, -math.inf)
