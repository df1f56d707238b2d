"""The few frozen arms that decide about a loop and its like, grown by exchange when a search finds a worse one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.linear_map import spectral_radius
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace

_THIN = 256
_FEW = 4
_LARGE = 120  # states; from here on a map's eigenvalues cost tens of milliseconds
_FACTORS = (0.1, 0.3, 1.0, 3.0, 10.0)  # on the gains: how slow and how fast a loop the points are to decide about


@dataclass
class Critical:
    """What decides: points at rest under gravity and points of the inertia alone, in one set.

    Attributes:
        spaces: Where they are from, and where a search looks for worse ones.
        points: Shape (count, 2nv + 3); what was found last stands in front.
        mass: M there, shape (count, nv, nv).
        stiffness: As much of ∂g/∂q as acts there, shape (count, nv, nv).
    """

    spaces: tuple[Workspace, ...]
    points: Array
    mass: Array = field(init=False, repr=False)
    stiffness: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Evaluate the arms there."""
        arms = self.spaces[0].arms
        self.mass, self.stiffness = arms.mass(self.points), arms.stiffness(self.points)

    def radius(self, loop: SampledLoop) -> float:
        """Largest spectral radius over the points; over the first few where a long delay makes the map large.

        Infinite where there is no such loop.
        """
        if not loop.possible:
            return math.inf
        return float(self.radii(loop).max())

    def radii(self, loop: SampledLoop) -> Array:
        """Spectral radius at each point, or at the first few where the map is large."""
        some = slice(_FEW) if _large(loop) else slice(None)
        viscous = self.spaces[0].viscous
        return spectral_radius(self.mass[some], loop, viscous=viscous, stiffness=self.stiffness[some])

    def radius_at_torques(self, loop: SampledLoop, factors: Array) -> float:
        """Largest radius over the points and over factors by which the true torque differs from the reported one.

        xM̄u on M and G is M̄u on M/x and G/x, so that one batch of eigenvalues answers all.
        """
        stacked = [np.concatenate([value / x for x in factors]) for value in (self.mass, self.stiffness)]
        return float(spectral_radius(stacked[0], loop, stiffness=stacked[1]).max())

    def worst(self, loop: SampledLoop) -> tuple[float, Array]:
        """The largest radius over the points, and at which."""
        radii = self.radii(loop)
        return float(radii.max()), self.points[int(radii.argmax())]

    def extend(self, loop: SampledLoop) -> bool:
        """Search where `loop` ought to be stable; take in, in front, what is not. False if all that was tried is."""
        found = []
        for space in self.spaces:
            if _large(loop):
                few = space.points[: 4 * _FEW]
                radii = space.radii(loop, few)
                radius, point = float(radii.max()), few[int(radii.argmax())]
            else:
                radius, point, _ = space.thinned(_THIN).worst(loop)
            if radius >= 1.0:
                found.append(point)
        if found:
            self.points = np.concatenate([found, self.points])
            self.__post_init__()
        return bool(found)


def critical_set(spaces: tuple[Workspace, ...], loop: SampledLoop, known: list[Array]) -> Critical:
    """What decides about a loop, and about slower and faster ones.

    Args:
        spaces: The inertia alone, and where gravity acts the arms at rest.
        loop: Gains and timing.
        known: The worst points found for it.
    """
    arms = spaces[0].arms
    (_, slow), (_, fast) = spaces[0].ratio_range(loop.mbar)
    points = [*known]
    for space in spaces:
        weight = space.points[0, -1]
        points += [np.append(point[:-1], weight) for point in (slow, fast)]
        some = space.thinned(2 * _THIN)
        points += [some.points[int(some.radii(loop.scaled(ks=x, beta=x)).argmax())] for x in _FACTORS]
    return Critical(spaces, arms.wrap(np.unique(np.array(points), axis=0)))


def _large(loop: SampledLoop) -> bool:
    return loop.nv * (3 + math.ceil(loop.delay)) > _LARGE
