"""What the arms would do without friction, by Pinocchio, for a batch of trials in lockstep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array, IntArray
from asmc_pin.arms import Arm
from asmc_pin.plant.coupled_dynamics import coupled_acceleration
from asmc_pin.rigid_body.recursion import Links, crba, links_of

# With fewer trials a thread costs more to wake than it saves (UR5: 16 trials take 34 µs alone, 19 µs on two threads).
TRIALS_PER_THREAD = 8


_mass_matrices: Callable[..., Array] = crba


@dataclass(frozen=True, eq=False)
class _Group:
    """Trials with the same arm: Pinocchio's pool holds one model, and so does a pass of the mass kernel."""

    arm: Arm
    links: Links
    armature: Array
    rows: slice | IntArray
    pool: pin.ModelPool
    threads: int


class FreeDynamics:
    """Forward dynamics and inertia of a batch of trials, each with its own arm or all with one.

    A trial's result does not depend on its neighbours, nor on the number of threads, to the last bit.

    Attributes:
        nv: Number of joints.

    Args:
        arms: One arm for all trials, or one per trial.
        batch: Number of trials.
        threads: Threads for Pinocchio.
        own_mass: Whether M comes from the compiled recursion, and not from Pinocchio.
    """

    def __init__(self, arms: Sequence[Arm], batch: int, threads: int, own_mass: bool = True) -> None:
        self.nv = int(arms[0].nv)
        self._own_mass = own_mass
        members: dict[int, list[int]] = {}
        for trial in range(batch):
            members.setdefault(id(arms[trial % len(arms)]), []).append(trial)
        self._groups: list[_Group] = []
        for rows in members.values():
            contiguous = rows[-1] - rows[0] + 1 == len(rows)
            count = max(1, min(threads, len(rows) // TRIALS_PER_THREAD))
            arm = arms[rows[0] % len(arms)]
            where = slice(rows[0], rows[-1] + 1) if contiguous else np.array(rows)
            self._groups.append(
                _Group(arm, links_of(arm.tree), np.array(arm.armature), where, pin.ModelPool(arm.model, count), count)
            )

    def acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """Joint accelerations without friction, M⁻¹(τ − C v − g).

        Args:
            q: Shape (batch, nv), rad; C-ordered like the rest, so that Pinocchio reads it in place.
            v: Shape (batch, nv), rad/s.
            torque: Shape (batch, nv), N·m.

        Returns:
            Shape (batch, nv), rad/s².
        """
        out = np.empty_like(q)
        for group in self._groups:
            rows = group.rows
            if group.arm.mimics:
                mass = _mass_matrices(group.links, group.armature, np.ascontiguousarray(q[rows]))
                parts = q[rows], v[rows], torque[rows]
                out[rows] = coupled_acceleration(group.arm.tree.coupling, group.pool, group.threads, mass, *parts)
            elif isinstance(rows, slice):
                pin.abaInParallel(group.threads, group.pool, q[rows].T, v[rows].T, torque[rows].T, out[rows].T)
            else:
                part = np.empty((len(rows), q.shape[1]))
                pin.abaInParallel(group.threads, group.pool, q[rows].T, v[rows].T, torque[rows].T, part.T)
                out[rows] = part
        return out

    def mass_matrix(self, q: Array) -> Array:
        """M(q) of every trial, armature included. Shape (batch, nv, nv), kg·m²."""
        if self._own_mass and len(self._groups) == 1:
            return _mass_matrices(self._groups[0].links, self._groups[0].armature, q)
        out = np.empty((*q.shape, q.shape[1]))
        for group in self._groups:
            part = q[group.rows]
            own = self._own_mass
            out[group.rows] = _mass_matrices(group.links, group.armature, part) if own else group.arm.mass_matrix(part)
        return out

    def gravity(self, q: Array) -> Array:
        """Torque that balances gravity. Shape (batch, nv), N·m."""
        out = np.empty_like(q)
        for group in self._groups:
            out[group.rows] = group.arm.gravity(q[group.rows])
        return out
