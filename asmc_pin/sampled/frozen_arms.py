"""The arms that a loop is frozen on: every configuration of a box, every payload and armature of a range.

A point is one row: which choice of locked joints, q, where in the payload's range, the armature, and the share of
gravity's stiffness that acts, 1 at rest and 0 for the inertia alone. M and ∂g/∂q are affine in a payload's mass, M in
the armature, so a point between two ends costs no arm of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.payload import Payload
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, Case, LockChoices, PayloadRange, cases
from asmc_pin.condition.domain.joint_box import Box, BoxLike
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.condition.premises import ends_of, premises_of, worst_keys
from asmc_pin.condition.search.samples import check_seed, sample_box
from asmc_pin.words.text import printable

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_STIFFNESS_STEP = 1e-5


@dataclass(frozen=True, eq=False)
class FrozenArms:
    """Arms and configurations over which a loop is looked at.

    Attributes:
        pairs: The arm with the lightest and with the heaviest payload, per choice of locked joints and place of it.
        box: The joint box.
        armature_lower: Shape (nv,), kg·m².
        armature_upper: Shape (nv,), kg·m².
    """

    pairs: tuple[tuple[Arm, Arm], ...]
    box: Box
    armature_lower: Array
    armature_upper: Array

    @property
    def arm(self) -> Arm:
        """The first of them."""
        return self.pairs[0][0]

    @property
    def nv(self) -> int:
        """Number of joints."""
        return self.arm.nv

    @property
    def heavy(self) -> bool:
        """Whether gravity acts."""
        return bool(np.any(self.arm.gravity_vector))

    @cached_property
    def about(self) -> Premises:
        """What a verdict over all of them supposes."""
        arms = [arm for pair in self.pairs for arm in dict.fromkeys(pair)]
        return premises_of(arms, [ends_of(self.box)], (self.armature_lower, self.armature_upper))

    @cached_property
    def moves(self) -> Array:
        """Steps of a compass search in a point, one range long, both ways, shape (moves, 2nv + 3)."""
        width = np.concatenate(
            [
                [0.0],
                self.box.upper - self.box.lower,
                [float(any(light is not laden for light, laden in self.pairs))],
                self.armature_upper - self.armature_lower,
                [0.0],
            ]
        )
        ways = np.eye(width.size)[width > 0.0] * width
        return np.concatenate([ways, -ways])

    def wrap(self, points: Array) -> Array:
        """The points of the ranges that these are up to whole turns; others are clipped."""
        n = self.nv
        inside = np.array(points)
        inside[..., 1 : 1 + n] = self.box.wrap(points[..., 1 : 1 + n])
        inside[..., 1 + n] = np.clip(points[..., 1 + n], 0.0, 1.0)
        inside[..., 2 + n : -1] = np.clip(points[..., 2 + n : -1], self.armature_lower, self.armature_upper)
        return inside

    def sample(self, count: int, seed: int, gravity: bool) -> Array:
        """Low-discrepancy configurations, each on an arm at the ends of the ranges, shape (count, 2nv + 3)."""
        # M does not depend on a joint that carries the whole arm; gravity does.
        box = replace(self.box, idle=np.zeros_like(self.box.idle)) if gravity else self.box
        check_seed(seed)
        which = np.random.default_rng(seed)
        # As often all joints at one end of the armature as each at its own.
        ends = which.integers(0, 2, (count, self.nv))
        ends[::2] = ends[::2, :1]
        return np.column_stack(
            [
                which.integers(0, len(self.pairs), count),
                sample_box(box, count, seed),
                which.integers(0, 2, count),
                np.where(ends == 0, self.armature_lower, self.armature_upper),
                np.full(count, float(gravity)),
            ]
        )

    def q(self, points: Array) -> Array:
        """The configurations of points, shape (..., nv)."""
        return np.asarray(points[..., 1 : 1 + self.nv])

    def armature(self, points: Array) -> Array:
        """The armature of points, shape (..., nv), kg·m²."""
        return np.asarray(points[..., 2 + self.nv : -1])

    def arm_of(self, point: Array) -> Arm:
        """The arm of one point, its payload and armature with it."""
        light, laden = self.pairs[int(point[0])]
        share = float(point[1 + self.nv])
        arm = light if share == 0.0 else laden if share == 1.0 else light.replace(payload=_between(light, laden, share))
        own = self.armature(point)
        return arm if np.array_equal(own, arm.armature) else arm.replace(armature=own.tolist())

    def place(self, point: Array) -> tuple[dict[str, Any], str]:
        """What of the ranges a point has: by the names of `worst_keys`, and in words, empty without ranges."""
        about, own = self.about, self.armature(point)
        where = worst_keys(about, self.arm_of(point), own)
        said = []
        if about.payload is not None and isinstance(about.payload.mass, tuple):
            said.append(f"payload {where['worst_payload']['mass']:.3g} kg")
        if any(isinstance(value, tuple) for value in about.armature):
            said.append(f"armature ({', '.join(f'{value:.3g}' for value in own)}) kg·m²")
        if "worst_locked" in where:
            said.append(", ".join(f"{printable(name)} at {angle:g}" for name, angle in where["worst_locked"].items()))
        return where, ", ".join(said)

    def mass(self, points: Array) -> Array:
        """M at points, shape (count, nv, nv), kg·m²."""
        mass = self._along_payload(points, lambda arm, q: arm.mass_matrix(q))
        own = np.array([light.armature for light, _ in self.pairs])[points[:, 0].astype(np.int64)]
        mass[:, np.arange(self.nv), np.arange(self.nv)] += self.armature(points) - own
        return mass

    def stiffness(self, points: Array) -> Array:
        """The share of ∂g/∂q that acts at points, shape (count, nv, nv), N·m/rad."""
        stiffness = np.zeros((len(points), self.nv, self.nv))
        acts = points[:, -1] > 0.0
        if acts.any():
            stiffness[acts] = self._along_payload(points[acts], gravity_stiffness) * points[acts, -1, None, None]
        return stiffness

    def _along_payload(self, points: Array, figure: Callable[[Arm, Array], Array]) -> Array:
        """A matrix of the arm at q that is affine in the payload's mass."""
        values = np.zeros((len(points), self.nv, self.nv))
        for i, (light, laden) in enumerate(self.pairs):
            mine = points[:, 0] == i
            share = points[:, 1 + self.nv] if laden is not light else np.zeros(len(points))
            for arm, part in ((light, 1.0 - share), (laden, share)):
                some = mine & (part > 0.0)
                if some.any():
                    values[some] += part[some, None, None] * figure(arm, self.q(points[some]))
        return values


def frozen_arms(
    arm: Arm,
    box: BoxLike = None,
    *,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
) -> FrozenArms:
    """All arms of a statement about the sampled loop; arguments as of `verify`.

    Raises:
        ParameterError: a malformed or empty range, an unknown joint, or a box that looks like degrees.
        ArmError: a prismatic joint has no range.
    """
    found = cases(arm, box, payload, armature, lock)
    domain = found[0].domain
    return FrozenArms(_pairs(found), domain.box, domain.armature_lower, domain.armature_upper)


def _pairs(found: Sequence[Case]) -> tuple[tuple[Arm, Arm], ...]:
    pairs = []
    for _, arms in groupby((case.domain.arm for case in found), key=lambda arm: dict(arm.locked)):
        some = list(arms)
        # Of a range of places each is a pair; what weighs nothing is nowhere.
        bare = some[0] if some[0].payload is None or some[0].payload.mass == 0.0 else None
        for _, here in groupby(some, key=_place):
            ends = list(here)
            if ends[0] is not bare or len(some) == 1:
                pairs.append((ends[0] if bare is None else bare, ends[-1]))
    return tuple(pairs)


def _place(arm: Arm) -> tuple[float, ...] | None:
    load = arm.payload
    return None if load is None or load.mass == 0.0 else load.com


def _between(light: Arm, laden: Arm, share: float) -> Payload:
    """The payload at a share of a range."""
    heavier = laden.payload
    assert heavier is not None
    lighter = light.payload or replace(heavier, mass=0.0, inertia=(0.0,) * 6)
    inertia = (1.0 - share) * np.array(lighter.inertia) + share * np.array(heavier.inertia)
    return replace(heavier, mass=(1.0 - share) * lighter.mass + share * heavier.mass, inertia=tuple(inertia.tolist()))


def gravity_stiffness(arm: Arm, q: Array) -> Array:
    """∂g/∂q, the stiffness that gravity gives the arm about rest, by central differences.

    Args:
        arm: The arm.
        q: Configurations, shape (..., nv), rad.

    Returns:
        Symmetric, shape (..., nv, nv), N·m/rad; negative where the arm would fall away.
    """
    moves = _STIFFNESS_STEP * np.eye(arm.nv)
    around = np.asarray(q)[..., None, :]
    slope = (arm.gravity(around + moves) - arm.gravity(around - moves)) / (2.0 * _STIFFNESS_STEP)
    return np.asarray(0.5 * (slope + np.swapaxes(slope, -1, -2)))
