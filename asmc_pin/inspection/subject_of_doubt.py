"""What doubts are about: a robot's moving bodies with their sizes, and what a doubt is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.assembling import Unjudged
from asmc_pin.arms.bodies.moving_bodies import MovingBody
from asmc_pin.words.text import quoted


@dataclass(frozen=True)
class Doubt:
    """Something that is possible, and probably not meant.

    Attributes:
        kind: Which doubt it is, one word or two, the same in every release.
        about: Names of the joints or links.
        text: What was found, and what it looks like.
        serious: Whether M(q) is probably wrong by it, so that every command that loads the arm says it.
    """

    kind: str
    about: tuple[str, ...]
    text: str
    serious: bool = True


@dataclass(frozen=True, eq=False)
class Sized:
    """A moving body and how large it is.

    Attributes:
        body: The body.
        extent: m; how far the next joints, or twice its centre, are from its joint, at least a share of the reach.
        radii: Radii of gyration about the centre, ascending, shape (3,), m; zero where a moment is negative.
    """

    body: MovingBody
    extent: float
    radii: Array


@dataclass(frozen=True, eq=False)
class SubjectOfDoubt:
    """A robot as doubts look at it.

    Attributes:
        parts: What was read.
        bodies: Its moving bodies with their sizes.
        reach: m; the longest way from the base along the joints' origins.
        armature: Reflected inertia per joint that will be there, shape (nv,), kg·m².
    """

    parts: Unjudged
    bodies: Sequence[Sized]
    reach: float
    armature: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def mass(self) -> float:
        """All that moves, kg."""
        return sum(sized.body.mass for sized in self.bodies)


def subject_of(parts: Unjudged, armature: Array | None = None) -> SubjectOfDoubt:
    """Measure a robot.

    Args:
        parts: What was read.
        armature: Shape (nv,), kg·m²; none where omitted.
    """
    model, bodies = parts.model, parts.bodies
    steps = [float(np.linalg.norm(placement.translation)) for placement in model.jointPlacements]
    far, beyond, depth = [0.0] * model.njoints, [0.0] * model.njoints, [0] * model.njoints
    for index in range(1, model.njoints):
        parent = model.parents[index]
        far[index] = far[parent] + steps[index]
        beyond[parent] = max(beyond[parent], steps[index])
        depth[index] = depth[parent] + 1
    # Without a mass there is no centre.
    away = [2.0 * float(np.linalg.norm(body.com)) if body.mass > 0.0 else 0.0 for body in bodies]
    tips = [far[i + 1] + away[i] for i in range(len(bodies))]
    reach = max(tips, default=0.0)
    least = reach / max(depth)
    sized = [Sized(body, max(beyond[i + 1], away[i], least), radii_of(body)) for i, body in enumerate(bodies)]
    return SubjectOfDoubt(parts, sized, reach, np.zeros(model.nv) if armature is None else armature)


def radii_of(body: MovingBody) -> Array:
    """Radii of gyration about the centre, ascending, shape (3,), m."""
    if not body.mass > 0.0 or not np.all(np.isfinite(body.inertia)):
        return np.zeros(3)
    return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(body.inertia), 0.0) / body.mass))


def some(names: Sequence[str]) -> str:
    """Names, as many of them as one reads."""
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(map(quoted, names[:4])) + more
