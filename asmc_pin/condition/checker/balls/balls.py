"""The condition itself in ball arithmetic, from the URDF's decimals on.

A third leg that shares nothing with the proof: no lift, no recursion, no losses, no floating point. Every number is a
ball that encloses the true one (Arb, in python-flint; F. Johansson, IEEE Trans. Comput. 66, 2017), the inertia matrix
is summed body by body from Jacobians in the base frame, and the condition is asked of M⁻¹M̄ as it is written.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from flint import arb, arb_mat, ctx

from asmc_pin.condition.checker.balls.ball_geometry import (
    about,
    column,
    cross,
    dot,
    normalised,
    rotation,
    still,
    symmetric,
    unit,
    zero,
)
from asmc_pin.condition.checker.reading.coupled_joints import following
from asmc_pin.condition.checker.reading.header_parts import Load, WrittenStatement
from asmc_pin.condition.checker.reading.urdf_text import Description

Verdict: TypeAlias = Literal["true", "false", "open"]
"""Whether it is so for all numbers in the balls, false for at least one, or neither by these balls."""

PRECISIONS = (128, 512)
"""Bits; the second where the first leaves a point open."""


@dataclass(frozen=True, eq=False)
class Body:
    """All that moves with one joint, and how the joint hangs on the body before it; all constant.

    Attributes:
        parent: Number of the joint before it; −1 for the base.
        turn: Rotation of the joint's frame in its parent's at zero, 3 × 3.
        place: Its origin there, 3 × 1.
        axis: Unit axis in the joint's frame, 3 × 1.
        slides: Prismatic.
        mass: Of the body.
        moment: Mass times centre, in the joint's frame, 3 × 1.
        tensor: Inertia about the joint's origin, in its frame, 3 × 3.
    """

    parent: int
    turn: arb_mat
    place: arb_mat
    axis: arb_mat
    slides: bool
    mass: arb
    moment: arb_mat
    tensor: arb_mat


class BallArm:
    """An arm whose inertia matrix is computed in balls.

    Args:
        robot: The robot.
        joints: Names of its joints with a coordinate.
        locked: The angles of the others, rad (m where prismatic), exact.
        payload: What is fastened to a link of it.
        moving: Names of all its joints that move, each after the one before it, where some follow others.

    Attributes:
        bodies: What moves with each of its joints.
        follow: How its joints follow its coordinates.
    """

    def __init__(
        self,
        robot: Description,
        joints: Sequence[str],
        locked: Mapping[str, float],
        payload: Load | None,
        moving: Sequence[str] = (),
    ) -> None:
        self.follow = following(robot, joints, moving)
        index = {name: i for i, name in enumerate(self.follow.moving)}
        heads: dict[int, tuple[int, arb_mat, arb_mat, arb_mat, bool]] = {}
        loads = [(arb(0), zero(), arb_mat(3, 3)) for _ in index]
        with ctx.workprec(PRECISIONS[-1]):
            waiting = [(robot.root, -1, *still())]
            while waiting:
                name, body, turn, place = waiting.pop()
                if body >= 0:
                    for part in _parts(robot, name, payload):
                        loads[body] = _joined(loads[body], part, turn, place)
                for joint in robot.children.get(name, ()):
                    at, turned = place + turn * column(joint.pose.xyz), turn * rotation(joint.pose)
                    if joint.kind == "fixed":
                        waiting.append((joint.child, body, turned, at))
                        continue
                    axis, slides = normalised(joint.axis), joint.kind == "prismatic"
                    if joint.name in index:
                        heads[index[joint.name]] = (body, turned, at, axis, slides)
                        waiting.append((joint.child, index[joint.name], *still()))
                        continue
                    angle = arb(locked[joint.name])
                    moved = (turned, at + turned * axis * angle) if slides else (turned * about(axis, angle), at)
                    waiting.append((joint.child, body, *moved))
        self.bodies = [Body(*heads[i], *loads[i]) for i in range(len(index))]

    def mass_matrix(self, q: Sequence[arb], armature: Sequence[arb]) -> arb_mat:
        """M(q) + diag(armature), an enclosure of it for every q and armature in the balls; (nv, nv).

        Of joints that follow others it is Sᵀ M S with the S of their ratios.
        """
        follow = self.follow
        if not follow.follows:
            return self._of_joints(q, armature)
        rows = zip(follow.coordinate, follow.ratio, follow.offset, strict=True)
        tree = self._of_joints([ratio * q[c] + offset for c, ratio, offset in rows], [arb(0)] * len(self.bodies))
        nv = len(follow.joints)
        total = [[armature[a] if a == b else arb(0) for b in range(nv)] for a in range(nv)]
        for i, a in enumerate(follow.coordinate):
            for j, b in enumerate(follow.coordinate):
                total[a][b] += follow.ratio[i] * tree[i, j] * follow.ratio[j]
        return arb_mat(total)

    def _of_joints(self, q: Sequence[arb], armature: Sequence[arb]) -> arb_mat:
        """The same of joints that move freely, (n, n).

        With a body's origin at velocity v and its turning ω, 2 T = m v·v + 2 v·(ω × m c) + ω·(I ω).
        """
        n = len(self.bodies)
        total = [[armature[i] if i == j else arb(0) for j in range(n)] for i in range(n)]
        turns: list[arb_mat] = []
        places: list[arb_mat] = []
        axes: list[arb_mat] = []
        for i, body in enumerate(self.bodies):
            turn, place = still() if body.parent < 0 else (turns[body.parent], places[body.parent])
            place, turn = place + turn * body.place, turn * body.turn
            axes.append(turn * body.axis)
            places.append(place + axes[i] * q[i] if body.slides else place)
            turns.append(turn if body.slides else turn * about(body.axis, q[i]))
            self._add(total, i, turns[i], places, axes)
        return arb_mat(total)

    def _add(
        self, total: list[list[arb]], i: int, turn: arb_mat, places: Sequence[arb_mat], axes: Sequence[arb_mat]
    ) -> None:
        """Add one body's share to the inertia matrix: of every two joints on the way to it."""
        body = self.bodies[i]
        moment, tensor = turn * body.moment, turn * body.tensor * turn.transpose()
        columns = []
        k = i
        while k >= 0:
            slides = self.bodies[k].slides
            linear = axes[k] if slides else cross(axes[k], places[i] - places[k])
            angular = zero() if slides else axes[k]
            columns.append((k, linear, angular, cross(angular, moment), tensor * angular))
            k = self.bodies[k].parent
        for a, linear, angular, swing, _ in columns:
            for b, other, _, others_swing, others_turning in columns:
                if b <= a:
                    value = body.mass * dot(linear, other) + dot(linear, others_swing) + dot(other, swing)
                    total[a][b] += value + dot(angular, others_turning)
                    total[b][a] = total[a][b]


_Load = tuple[arb, arb_mat, arb_mat]
"""Mass, centre of mass or moment, and a tensor."""


def _parts(robot: Description, link: str, payload: Load | None) -> Iterator[_Load]:
    """Mass, centre and inertia about the centre of what a link has and carries, in the link's frame."""
    body = robot.bodies[link]
    if body is not None:
        turn = rotation(body.pose)
        tensor = turn * symmetric([arb(x) for x in body.inertia]) * turn.transpose()
        yield arb(body.mass), column(body.pose.xyz), tensor
    if payload is not None and payload.link == link:
        com = arb_mat(3, 1, [arb(x) for x in payload.com])
        yield arb(payload.mass), com, symmetric([arb(x) for x in payload.inertia])


def _joined(whole: _Load, part: _Load, turn: arb_mat, place: arb_mat) -> _Load:
    """A body with a part fastened to it: masses, moments and inertias about the body's origin add up (Steiner)."""
    mass, centre, tensor = part
    at = place + turn * centre
    spread = unit() * dot(at, at) - at * at.transpose()
    own = turn * tensor * turn.transpose()
    return whole[0] + mass, whole[1] + at * mass, whole[2] + own + spread * mass


def holds(statement: WrittenStatement, mass: arb_mat, mbar: Sequence[float]) -> Verdict:
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


def upward(number: arb) -> float:
    """A float that is not below any number of a ball."""
    return -downward(-number)
