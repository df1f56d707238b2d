"""Where in the workspace the sampled loop is worst: low-discrepancy samples, then a local search.

The search returns a radius that some configuration really has. It refutes stability; it does not prove it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import Box, BoxLike, resolve_box
from asmc_pin.condition.search.samples import sample_box
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.linear_map import inertia_ratios, spectral_radius
from asmc_pin.sampled.sampled_loop import SampledLoop

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

Figure = Callable[[Array], Array]
"""Configurations (count, nv) -> what is to be made as large as possible, (count,)."""

_STIFFNESS_STEP = 1e-5


@dataclass(frozen=True, eq=False)
class Workspace:
    """An arm, the joint box it works in, and samples of that box.

    Attributes:
        arm: The arm.
        box: The joint box.
        q: Samples, shape (samples, nv), rad.
        gravity: Whether maps are those about rest under gravity: ∂g/∂q acts as a spring.
        viscous: Viscous friction that is counted on, shape (nv,), N·m·s/rad; None for none.
        starts: Number of local searches, from the best samples.
        finest: Where they end, as a share of a joint's range; near a maximum the figures are flat to second order.
    """

    arm: Arm
    box: Box
    q: Array
    gravity: bool = False
    viscous: Array | None = None
    starts: int = 4
    finest: float = 1e-4

    @cached_property
    def mass(self) -> Array:
        """M at the samples, shape (samples, nv, nv)."""
        return self.arm.mass_matrix(self.q)

    @cached_property
    def stiffness(self) -> Array | None:
        """∂g/∂q at the samples, shape (samples, nv, nv); None where gravity is left out."""
        return gravity_stiffness(self.arm, self.q) if self.gravity else None

    def frozen(self, q: Array) -> tuple[Array, Array | None]:
        """M, (count, nv, nv), and ∂g/∂q where gravity counts, at configurations (count, nv)."""
        return self.arm.mass_matrix(q), gravity_stiffness(self.arm, q) if self.gravity else None

    def radii(self, loop: SampledLoop, q: Array | None = None) -> Array:
        """Spectral radius of the loop frozen at configurations (count, nv), or at the samples; shape (count,)."""
        if q is None:
            return spectral_radius(self.mass, loop, viscous=self.viscous, stiffness=self.stiffness)
        mass, stiffness = self.frozen(q)
        return spectral_radius(mass, loop, viscous=self.viscous, stiffness=stiffness)

    def worst(self, loop: SampledLoop) -> tuple[float, Array, int]:
        """Largest radius found, its configuration (nv,), and the number of configurations tried."""
        return self.maximise(lambda q: self.radii(loop, q), self.radii(loop))

    def thinned(self, count: int, finest: float = 2e-3) -> Workspace:
        """The same with the first `count` samples and a coarser search, for searches that are repeated."""
        return replace(self, q=self.q[:count], starts=2, finest=finest)

    def ratio_range(self, mbar: Array) -> tuple[tuple[float, Array], tuple[float, Array]]:
        """Smallest and largest eigenvalue of M⁻¹M̄ found, each with its configuration."""
        at_samples = inertia_ratios(self.mass, mbar)

        def ratios(q: Array) -> Array:
            return inertia_ratios(self.arm.mass_matrix(q), mbar)

        low, q_low, _ = self.maximise(lambda q: -ratios(q)[:, 0], -at_samples[:, 0])
        high, q_high, _ = self.maximise(lambda q: ratios(q)[:, -1], at_samples[:, -1])
        return (-low, q_low), (high, q_high)

    def maximise(self, figure: Figure, at_samples: Array) -> tuple[float, Array, int]:
        """Climb from the best samples by a compass search, all climbs in one batch.

        The figures are maxima over eigenvalues, so they have kinks; a compass search needs no gradient.

        Args:
            figure: What is maximised.
            at_samples: The figure at `q`, shape (samples,).

        Returns:
            The largest value, its configuration (nv,), and the number of configurations tried.
        """
        chosen = np.argsort(-at_samples, kind="stable")[: self.starts]
        q, best = self.q[chosen].copy(), at_samples[chosen].copy()
        tried = len(at_samples)
        width = self.box.upper - self.box.lower
        free = np.flatnonzero((width > 0.0) & (self.gravity | ~self.box.idle))
        moves = np.concatenate([np.eye(len(width))[free], -np.eye(len(width))[free]]) * width
        step = np.full(len(q), 0.05)
        while free.size and step.max() > self.finest:
            trial = self.box.wrap(q[:, None, :] + step[:, None, None] * moves)
            values = figure(trial.reshape(-1, q.shape[1])).reshape(trial.shape[:2])
            tried += values.size
            to = values.argmax(axis=1)
            reached = values[np.arange(len(q)), to]
            better = reached > best
            q[better], best[better] = trial[better, to[better]], reached[better]
            # Shrinking after a success too bounds the number of rounds, along a ridge as well.
            step *= np.where(better, 0.95, 0.5)
        first = int(best.argmax())
        return float(best[first]), self.box.wrap(q[first]), tried


def workspace_of(
    arm: Arm,
    box: BoxLike = None,
    *,
    samples: int = 2048,
    seed: int = 0,
    gravity: bool = False,
    viscous: Array | None = None,
) -> Workspace:
    """Sample an arm's workspace.

    Args:
        arm: The arm.
        box: Joint box; see `asmc_pin.condition.domain.joint_box.BoxLike`. The arm's own by default.
        samples: Number of configurations.
        seed: Of the samples.
        gravity: See `Workspace`.
        viscous: See `Workspace`.

    Raises:
        ParameterError: the box or the number of samples cannot be used.
    """
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 1:
        raise ParameterError("samples", f"got {samples!r}; expected a whole number of at least 1")
    resolved = resolve_box(arm, box)
    # M does not depend on a joint that carries the whole arm; gravity does.
    sampled = replace(resolved, idle=np.zeros_like(resolved.idle)) if gravity else resolved
    return Workspace(arm, resolved, sample_box(sampled, int(samples), seed), gravity, viscous)


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
