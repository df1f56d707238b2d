"""What a search sees of the condition number of M and of the velocity forces; it refutes and never proves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.search.samples import sample_box

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition.domain.arm_ranges import Case
    from asmc_pin.condition.domain.joint_box import Box

Figure = Callable[[Array], Array]
"""Configurations (count, nv) -> what is to be made as large as possible, (count,)."""

_SAMPLES = 2048
_STARTS = 6
_FINEST = 1e-3  # of a joint's range
_TURNS = 40
_DIRECTIONS = 6


@dataclass(frozen=True, eq=False)
class SeenLargest:
    """The largest value seen, and where: a configuration of shape (nv,)."""

    value: float
    q: Array


def largest_condition_number(cases: Sequence[Case], scaling: Array, also: Array, seed: int) -> SeenLargest:
    """The largest λ_max/λ_min of S M S seen.

    Args:
        cases: The arms; of a range of the armature both ends are looked at.
        scaling: Diagonal of S, shape (nv,).
        also: Configurations to look at besides, shape (count, nv).
        seed: Of the samples.
    """
    found = []
    for case in cases:
        domain = case.domain
        # The same rows once only.
        ends = np.unique(np.stack((domain.armature_lower, domain.armature_upper)), axis=0)
        for end in ends:

            def number(q: Array, arm: Arm = domain.arm, end: Array = end) -> Array:
                mass = arm.mass_matrix(q) + np.diag(end - arm.armature)
                values = np.linalg.eigvalsh(mass * scaling * scaling[:, None])
                return np.asarray(values[:, -1] / values[:, 0])

            found.append(_climbed(domain.box, number, also, seed))
    return max(found, key=lambda item: item.value)


def largest_velocity_forces(cases: Sequence[Case], scaling: Array, seed: int) -> SeenLargest:
    """The largest ‖S C(q, Sx) Sx‖ over ‖x‖ = 1 seen.

    Args:
        cases: The arms; the armature does not matter.
        scaling: Diagonal of S, shape (nv,).
        seed: Of the samples and the directions.
    """
    found = []
    for case in cases:

        def forces(q: Array, arm: Arm = case.domain.arm) -> Array:
            return _largest_of_directions(christoffel(arm, q, scaling), seed)

        found.append(_climbed(case.domain.box, forces, np.empty((0, scaling.size)), seed))
    return max(found, key=lambda item: item.value)


def christoffel(arm: Arm, q: Array, scaling: Array) -> Array:
    """Christoffel symbols of S M S: Γ[i, j, k] with Σ Γ[i, j, k] x_j x_k = (S C(q, Sx) Sx)_i, (count, nv, nv, nv)."""
    parts = [arm.coriolis(q, np.broadcast_to(unit, q.shape)) for unit in np.diag(scaling)]
    return np.stack(parts, axis=-1) * scaling[:, None, None] * scaling[:, None]


def _largest_of_directions(symbols: Array, seed: int) -> Array:
    """Largest ‖Γ x x‖ over unit x that steps along the gradient find from a few directions, (count,)."""
    count, n = symbols.shape[:2]
    symmetric = 0.5 * (symbols + np.swapaxes(symbols, 2, 3))
    rng = np.random.default_rng(seed)
    best = np.zeros(count)
    for _ in range(_DIRECTIONS):
        x = np.broadcast_to(rng.normal(size=n), (count, n)) / np.sqrt(n)
        for _ in range(_TURNS):
            along = np.einsum("bijk,bj->bik", symmetric, x)
            force = np.einsum("bik,bk->bi", along, x)
            # The gradient of ‖force‖², with a little of x itself so that a zero does not end it.
            x = np.einsum("bik,bi->bk", along, force) + 1e-3 * np.linalg.norm(force, axis=1)[:, None] ** 2 * x
            x = x / np.maximum(np.linalg.norm(x, axis=1), 1e-300)[:, None]
        force = np.einsum("bijk,bj,bk->bi", symmetric, x, x)
        size = np.einsum("bk,bk->b", x, x)
        best = np.maximum(best, np.where(size > 0.5, np.linalg.norm(force, axis=1) / np.maximum(size, 0.5), 0.0))
    return best


def _climbed(box: Box, figure: Figure, also: Array, seed: int) -> SeenLargest:
    """The largest value at samples, and a compass search from the best of them."""
    q = np.concatenate((sample_box(box, _SAMPLES, seed), also))
    values = figure(q)
    chosen = np.argsort(-values, kind="stable")[:_STARTS]
    q, best = q[chosen], values[chosen]
    width = box.upper - box.lower
    free = np.flatnonzero(box.free)
    moves = np.concatenate((np.eye(len(width))[free], -np.eye(len(width))[free])) * width
    step = np.full(len(q), 0.05)
    while free.size and step.max() > _FINEST:
        trial = box.wrap(q[:, None, :] + step[:, None, None] * moves)
        found = figure(trial.reshape(-1, q.shape[1])).reshape(trial.shape[:2])
        to = found.argmax(axis=1)
        rows = np.arange(len(q))
        better = found[rows, to] > best
        q[better], best[better] = trial[rows, to][better], found[rows, to][better]
        step *= np.where(better, 0.95, 0.5)
    first = int(best.argmax())
    return SeenLargest(float(best[first]), box.wrap(q[first]))
