"""What a search varies, low-discrepancy samples of it, and the condition's figures at many configurations."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import qmc

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.domain.base_branches import branch_of, branches
from asmc_pin.condition.domain.joint_box import Box, BoxLike, resolve_box
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.errors import NotPositiveDefinite, ParameterError
from asmc_pin.rigid_body.mass_matrix import mass_matrices
from asmc_pin.rigid_body.recursion import Links, links_of
from asmc_pin.rigid_body.tree import Tree

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

NORM = {"lemma1": compiled_norms.LEMMA1, "weighted": compiled_norms.WEIGHTED}
SCALE = {"lemma1": compiled_norms.LEMMA1_SCALE, "weighted": compiled_norms.WEIGHTED_SCALE}

_CHUNK = 4096

MOST_SAMPLES = 2**24
"""Of a box; more take more memory than they add to what a search finds, which a proof should rather settle."""


@dataclass(frozen=True, eq=False)
class Domain:
    """All that a search varies on one arm, or on one branch of it: the joint box, and the armature within a range.

    Attributes:
        arm: The arm; its own armature is replaced by the range.
        box: The joint box of the joints it is about.
        armature_lower: Shape (joints,), kg·m².
        armature_upper: Shape (joints,), kg·m².
        branch: Numbers of the joints in the arm where it is about one branch on the base; None for the whole arm.
    """

    arm: Arm
    box: Box
    armature_lower: Array
    armature_upper: Array
    branch: IntArray | None = None

    @cached_property
    def joints(self) -> IntArray:
        """Numbers, in the arm, of the joints it is about."""
        return np.arange(self.arm.nv) if self.branch is None else self.branch

    @cached_property
    def tree(self) -> Tree:
        """The tree of these joints alone."""
        return branch_of(self.arm.tree, self.joints)

    @property
    def links(self) -> Links:
        """The compiled form of the same."""
        return links_of(self.tree)

    def masses(self, q: Array, armature: Array) -> Array:
        """M(q) with an armature in place of the arm's own: (count, joints) of both -> (count, joints, joints)."""
        extra = armature - self.tree.armature
        masses: Array = mass_matrices(self.tree, q) + np.einsum("bi,ij->bij", extra, np.eye(self.tree.nv))
        return masses

    def by_branch(self) -> list[Domain]:
        """A domain for each branch on the base: M(q) is block diagonal, and these are its blocks."""
        parts = branches(self.tree)
        if len(parts) == 1:
            return [self]
        return [
            Domain(self.arm, self.box.of(part), self.armature_lower[part], self.armature_upper[part], self.joints[part])
            for part in parts
        ]


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

    Raises:
        ParameterError: No such number of points is taken.
    """
    if not isinstance(count, int | np.integer) or not 1 <= count <= MOST_SAMPLES:
        raise ParameterError("samples", f"{count!r} given, a whole number from 1 to {MOST_SAMPLES} expected")
    check_seed(seed)
    q = np.tile(box.centre, (count, 1))
    free = np.flatnonzero(box.free)
    if free.size:
        q[:, free] = box.lower[free] + _sobol(free.size, count, seed) * (box.upper - box.lower)[free]
    return q


def check_seed(seed: int | None) -> None:
    """None, which draws anew each time, or what a generator takes.

    Raises:
        ParameterError: It is neither.
    """
    if seed is not None and not (isinstance(seed, int | np.integer) and seed >= 0):
        raise ParameterError("seed", f"{seed!r} given, a whole number of 0 or more expected")


def _sobol(dimension: int, count: int, seed: int) -> Array:
    exponent = max(count - 1, 1).bit_length()
    points: Array = qmc.Sobol(dimension, seed=seed).random_base2(exponent)[:count]
    return points


def figures_at(kind: int, tree: Tree, q: Array, mbar: Array, armature: Array | None = None, threads: int = 1) -> Array:
    """A figure of the condition at many configurations, by the compiled kernel.

    Args:
        kind: `compiled_norms.LEMMA1` and its fellows.
        tree: The arm's tree, or a branch's.
        q: Shape (count, nv).
        mbar: Diagonal of M̄, shape (nv,).
        armature: In place of the tree's own, shape (nv,) or (count, nv).
        threads: Worker threads; the kernels release the interpreter's lock.

    Returns:
        Shape (count,).

    Raises:
        NotPositiveDefinite: M(q) is not positive definite at one of them.
    """
    links = links_of(tree)
    q = np.ascontiguousarray(q)
    # Copies, because a read-only array is another type to the compiler and would compile everything again.
    added = np.array(np.atleast_2d(tree.armature if armature is None else armature), order="C")
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
        mass = mass_matrices(tree, q[bad[0]])
        raise NotPositiveDefinite((int(bad[0]),), float(np.linalg.eigvalsh(mass)[0]))
    return out
