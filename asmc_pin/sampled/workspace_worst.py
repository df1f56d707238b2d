"""Where the sampled loop is worst, over configurations and ranges: low-discrepancy samples, then a local search.

The search returns a radius that some configuration really has. It refutes stability; it does not prove it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.frozen_arms import FrozenArms, frozen_arms
from asmc_pin.sampled.linear_map import inertia_ratios, spectral_radius
from asmc_pin.sampled.sampled_loop import SampledLoop

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

Figure = Callable[[Array], Array]
"""Points (count, …) -> what is to be made as large as possible, (count,)."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """What a loop is looked at on, and samples of it.

    Attributes:
        arms: The arms and the joint box.
        points: Samples, shape (samples, 2nv + 3); see `asmc_pin.sampled.frozen_arms`.
        viscous: Viscous friction that is counted on, shape (nv,), N·m·s/rad; None for none.
        starts: Number of local searches, from the best samples.
        finest: Where they end, as a share of a range; near a maximum the figures are flat to second order.
    """

    arms: FrozenArms
    points: Array
    viscous: Array | None = None
    starts: int = 4
    finest: float = 1e-4

    @cached_property
    def mass(self) -> Array:
        """M at the samples, shape (samples, nv, nv)."""
        return self.arms.mass(self.points)

    @cached_property
    def stiffness(self) -> Array | None:
        """∂g/∂q as far as it acts at the samples, shape (samples, nv, nv); None where it acts at none."""
        return self.stiffness_of(self.points)

    def stiffness_of(self, points: Array) -> Array | None:
        """The same at other points."""
        return self.arms.stiffness(points) if (points[:, -1] > 0.0).any() else None

    def at(self, q: Array) -> Array:
        """Configurations (count, nv) on the arms at the ends of the ranges, the armature of all joints at one end."""
        arms, found = self.arms, []
        for lock in range(len(arms.pairs)):
            for share in (0.0, 1.0):
                for armature in (arms.armature_lower, arms.armature_upper):
                    points = np.empty((len(q), self.points.shape[1]))
                    points[:, 0], points[:, 1 : 1 + arms.nv], points[:, 1 + arms.nv] = lock, q, share
                    points[:, 2 + arms.nv : -1], points[:, -1] = armature, self.points[0, -1]
                    found.append(points)
        return np.concatenate(found)

    def frozen(self, points: Array) -> tuple[Array, Array | None]:
        """M, (count, nv, nv), and as much of ∂g/∂q as acts, at points."""
        return self.arms.mass(points), self.stiffness_of(points)

    def radii(self, loop: SampledLoop, points: Array | None = None) -> Array:
        """Spectral radius of the loop frozen at points, or at the samples; shape (count,)."""
        if points is None:
            return spectral_radius(self.mass, loop, viscous=self.viscous, stiffness=self.stiffness)
        mass, stiffness = self.frozen(points)
        return spectral_radius(mass, loop, viscous=self.viscous, stiffness=stiffness)

    def worst(self, loop: SampledLoop) -> tuple[float, Array, int]:
        """Largest radius found, its point, and the number of points tried."""
        return self.maximise(lambda points: self.radii(loop, points), self.radii(loop))

    def thinned(self, count: int, finest: float = 2e-3) -> Workspace:
        """The same with the first `count` samples and a coarser search, for searches that are repeated."""
        return replace(self, points=self.points[:count], starts=2, finest=finest)

    def ratio_range(self, mbar: Array) -> tuple[tuple[float, Array], tuple[float, Array]]:
        """Smallest and largest eigenvalue of M⁻¹M̄ found, each with its point."""
        at_samples = inertia_ratios(self.mass, mbar)

        def ratios(points: Array) -> Array:
            return inertia_ratios(self.arms.mass(points), mbar)

        low, at_low, _ = self.maximise(lambda points: -ratios(points)[:, 0], -at_samples[:, 0])
        high, at_high, _ = self.maximise(lambda points: ratios(points)[:, -1], at_samples[:, -1])
        return (-low, at_low), (high, at_high)

    def maximise(self, figure: Figure, at_samples: Array) -> tuple[float, Array, int]:
        """Climb from the best samples by a compass search, all climbs in one batch.

        The figures are maxima over eigenvalues, so they have kinks; a compass search needs no gradient.

        Args:
            figure: What is maximised.
            at_samples: The figure at `points`, shape (samples,).

        Returns:
            The largest value, its point, and the number of points tried.
        """
        chosen = np.argsort(-at_samples, kind="stable")[: self.starts]
        points, best = self.points[chosen].copy(), at_samples[chosen].copy()
        tried = len(at_samples)
        moves = self.arms.moves
        step = np.full(len(points), 0.05)
        while len(moves) and step.max() > self.finest:
            trial = self.arms.wrap(points[:, None, :] + step[:, None, None] * moves)
            values = figure(trial.reshape(-1, points.shape[1])).reshape(trial.shape[:2])
            tried += values.size
            to = values.argmax(axis=1)
            reached = values[np.arange(len(points)), to]
            better = reached > best
            points[better], best[better] = trial[better, to[better]], reached[better]
            # Shrinking after a success too bounds the number of rounds, along a ridge as well.
            step *= np.where(better, 0.95, 0.5)
        first = int(best.argmax())
        return float(best[first]), self.arms.wrap(points[first]), tried


def workspace_of(
    arm: Arm | FrozenArms,
    box: BoxLike = None,
    *,
    samples: int = 2048,
    seed: int = 0,
    gravity: bool = False,
    viscous: Array | None = None,
) -> Workspace:
    """Sample what a loop is looked at on.

    Args:
        arm: The arm; or arms over ranges, which have their joint box.
        box: Joint box; see `asmc_pin.condition.domain.joint_box.BoxLike`. The arm's own by default.
        samples: Number of points.
        seed: Of the samples.
        gravity: Whether maps are those about rest under gravity: ∂g/∂q acts as a spring.
        viscous: See `Workspace`.

    Raises:
        ParameterError: the box or the number of samples cannot be used.
    """
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 1:
        raise ParameterError("samples", f"got {samples!r}; expected a whole number of at least 1")
    arms = arm if isinstance(arm, FrozenArms) else frozen_arms(arm, box)
    return Workspace(arms, arms.sample(int(samples), seed, gravity), viscous)
