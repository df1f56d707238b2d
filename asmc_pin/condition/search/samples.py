"""What a search varies, low-discrepancy samples of it, and the condition's figures at many configurations."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import qmc

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import Box, BoxLike, resolve_box
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.errors import NotPositiveDefinite
from asmc_pin.rigid_body.recursion import Links, links_of

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

NORM = {"lemma1": compiled_norms.LEMMA1, "weighted": compiled_norms.WEIGHTED}
SCALE = {"lemma1": compiled_norms.LEMMA1_SCALE, "weighted": compiled_norms.WEIGHTED_SCALE}

_CHUNK = 4096


@dataclass(frozen=True, eq=False)
class Domain:
    """All that a search varies on one arm: the joint box, and the armature within a range.

    Attributes:
        arm: The arm; its own armature is replaced by the range.
        box: The joint box.
        armature_lower: Shape (nv,), kg·m².
        armature_upper: Shape (nv,), kg·m².
    """

    arm: Arm
    box: Box
    armature_lower: Array
    armature_upper: Array

    @property
    def links(self) -> Links:
        """The compiled form of the arm."""
        return links_of(self.arm.tree)


def domain_of(arm: Arm, box: BoxLike = None) -> Domain:
    """The domain of one arm as it is, without ranges of armature."""
    return Domain(arm, resolve_box(arm, box), arm.armature, arm.armature)


def sample_box(box: Box, count: int, seed: int) -> Array:
    """Scrambled Sobol points of a box; joints that do not matter stay at its centre.

    Args:
        box: The box.
        count: How many points.
        seed: Of the scrambling; the same seed gives the same points.

    Returns:
        Shape (count, nv).
    """
    q = np.tile(box.centre, (count, 1))
    free = np.flatnonzero(box.free)
    if free.size:
        q[:, free] = box.lower[free] + _sobol(free.size, count, seed) * (box.upper - box.lower)[free]
    return q


def _sobol(dimension: int, count: int, seed: int) -> Array:
    exponent = max(count - 1, 1).bit_length()
    points: Array = qmc.Sobol(dimension, seed=seed).random_base2(exponent)[:count]
    return points


def evaluate(kind: int, arm: Arm, q: Array, mbar: Array, armature: Array | None = None, threads: int = 1) -> Array:
    """A figure of the condition at many configurations, by the compiled kernel.

    Args:
        kind: `compiled_norms.LEMMA1` and its fellows.
        arm: The arm.
        q: Shape (count, nv).
        mbar: Diagonal of M̄, shape (nv,).
        armature: In place of the arm's own, shape (nv,) or (count, nv).
        threads: Worker threads; the kernels release the interpreter's lock.

    Returns:
        Shape (count,).

    Raises:
        NotPositiveDefinite: M(q) is not positive definite at one of them.
    """
    links = links_of(arm.tree)
    q = np.ascontiguousarray(q)
    # Copies, because a read-only array is another type to the compiler and would compile everything again.
    added = np.array(np.atleast_2d(arm.armature if armature is None else armature), order="C")
    mbar = np.array(mbar)
    out = np.empty(len(q))

    def run(start: int) -> None:
        part = slice(start, start + _CHUNK)
        compiled_norms.figures(kind, links, added if len(added) == 1 else added[part], q[part], mbar, out[part])

    if threads == 1 or len(q) <= _CHUNK:
        for start in range(0, len(q), _CHUNK):
            run(start)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(run, range(0, len(q), _CHUNK)))
    bad = np.flatnonzero(np.isnan(out))
    if bad.size:
        mass = arm.mass_matrix(q[bad[0]])
        raise NotPositiveDefinite((int(bad[0]),), float(np.linalg.eigvalsh(mass)[0]))
    return out
