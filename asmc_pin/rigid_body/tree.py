"""An arm's kinematic tree as plain arrays, for compiled kernels that cannot call Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.rigid_body.coupling import Coupling


@dataclass(frozen=True, eq=False)
class Tree:
    """Kinematics and inertias, joint by joint, parents before children; all arrays read-only.

    Attributes:
        parent: Index of the parent joint, −1 for the base, shape (n,).
        rotation: Rotation of the joint's frame at q = 0, seen from its parent joint's frame, shape (n, 3, 3).
        translation: Origin of the same, shape (n, 3), m.
        axis: Unit axis in the joint's frame, shape (n, 3).
        prismatic: Whether the joint slides, shape (n,).
        mass: Mass that moves with the joint, up to the next one, shape (n,), kg.
        com: Its centre in the joint's frame, shape (n, 3), m.
        inertia: Its inertia about that centre, in the joint's axes, shape (n, 3, 3), kg·m².
        armature: Reflected rotor inertia, shape (nv,), kg·m² (kg where prismatic).
        gravity: Acceleration of gravity in the base frame, shape (3,), m/s².
        coupling: How the n joints follow the nv coordinates; n > nv where joints mimic others.
    """

    parent: IntArray
    rotation: Array
    translation: Array
    axis: Array
    prismatic: BoolArray
    mass: Array
    com: Array
    inertia: Array
    armature: Array
    gravity: Array
    coupling: Coupling

    @property
    def nv(self) -> int:
        """Number of coordinates, the size of M(q)."""
        return self.armature.size

    @property
    def joints(self) -> int:
        """Number of joints n, those that mimic others included."""
        return self.parent.size
