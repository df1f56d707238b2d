"""Forward dynamics of arms with joints that mimic others, which Pinocchio's aba does not know.

q_tree = S q + offset with a constant S (`asmc_pin.rigid_body.coupling`), so (Sᵀ M_tree S) q̈ = τ − Sᵀ (C v + g)_tree:
the forces by Pinocchio's rnea over the whole tree, M by the compiled kernel, and a Cholesky factor per trial.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.numerics.cholesky import cholesky, solve_lower, solve_upper
from asmc_pin.rigid_body.coupling import Coupling


@numba.njit(cache=True, nogil=True, error_model="numpy")
def _solve_each(mass: Array, right: Array) -> None:
    """Overwrite right (batch, nv) with M⁻¹ right, NaN where M (batch, nv, nv) is not positive definite."""
    batch, nv = right.shape
    column = np.empty((nv, 1))
    for b in range(batch):
        if not cholesky(mass[b], mass[b]):
            right[b, :] = np.nan
            continue
        for i in range(nv):
            column[i, 0] = right[b, i]
        solve_lower(mass[b], column)
        solve_upper(mass[b], column)
        for i in range(nv):
            right[b, i] = column[i, 0]


_solved: Callable[[Array, Array], None] = _solve_each


def coupled_acceleration(
    coupling: Coupling, pool: pin.ModelPool, threads: int, mass: Array, q: Array, v: Array, torque: Array
) -> Array:
    """Accelerations of trials of one arm.

    Args:
        coupling: How its joints follow its coordinates.
        pool: Pinocchio's, of the whole tree.
        threads: How many to use.
        mass: M(q), armature included, shape (batch, nv, nv); overwritten.
        q: Shape (batch, nv), rad.
        v: Shape (batch, nv), rad/s.
        torque: Shape (batch, nv), N·m.

    Returns:
        Shape (batch, nv), rad/s².
    """
    joints, rates = (np.ascontiguousarray(x) for x in (coupling.joints(q), coupling.rates(v)))
    forces, still = np.empty_like(joints), np.zeros_like(joints)
    pin.rneaInParallel(threads, pool, joints.T, rates.T, still.T, forces.T)
    right: Array = torque - coupling.forces(forces)
    _solved(mass, right)
    return right
