"""How the joints of a tree follow the coordinates of an arm: a mimicking joint has none of its own.

Every joint is q_i = ratio_i · q[coordinate_i] + offset_i, so q_tree = S q + offset with a constant S. Hence
q̇_tree = S q̇, τ = Sᵀ τ_tree and M = Sᵀ M_tree S; no force comes of S itself, because it does not change.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, IntArray


@dataclass(frozen=True, eq=False)
class Coupling:
    """The map S from the nv coordinates of an arm to the n joints of its tree; arrays read-only.

    Attributes:
        coordinate: Which coordinate each joint follows, shape (n,).
        ratio: By how much, shape (n,); 1 for a joint that is followed itself.
        offset: And from where, shape (n,), rad (m).
        leader: The joint that has each coordinate for its own, shape (nv,).
    """

    coordinate: IntArray
    ratio: Array
    offset: Array
    leader: IntArray

    def __post_init__(self) -> None:
        """Nobody changes it afterwards."""
        for array in (self.coordinate, self.ratio, self.offset, self.leader):
            array.setflags(write=False)

    @property
    def nv(self) -> int:
        """Number of coordinates."""
        return int(self.leader.size)

    @property
    def follows(self) -> bool:
        """Whether any joint follows another."""
        return self.coordinate.size > self.leader.size

    @property
    def matrix(self) -> Array:
        """S, shape (n, nv)."""
        found = np.zeros((self.coordinate.size, self.nv))
        found[np.arange(self.coordinate.size), self.coordinate] = self.ratio
        return found

    def joints(self, q: Array) -> Array:
        """Joint values (..., n) at the coordinates q, (..., nv)."""
        return np.asarray(q[..., self.coordinate] * self.ratio + self.offset) if self.follows else q

    def rates(self, v: Array) -> Array:
        """Joint velocities (..., n) at the coordinates' velocities v, (..., nv)."""
        return np.asarray(v[..., self.coordinate] * self.ratio) if self.follows else v

    def forces(self, torque: Array) -> Array:
        """Sᵀ τ: what torques at the joints, (..., n), are at the coordinates, (..., nv).

        Joint by joint: a matrix product rounds a row in one way alone and in another among others.
        """
        if not self.follows:
            return torque
        found = np.zeros((*torque.shape[:-1], self.nv))
        for joint, (coordinate, ratio) in enumerate(zip(self.coordinate, self.ratio, strict=True)):
            found[..., coordinate] += ratio * torque[..., joint]
        return found

    def form(self, matrix: Array) -> Array:
        """Sᵀ X S of a form in the joints' velocities, (..., n, n); shape (..., nv, nv)."""
        return np.asarray(self.matrix.T @ matrix @ self.matrix) if self.follows else matrix


def uncoupled(nv: int) -> Coupling:
    """Every joint has a coordinate of its own."""
    return Coupling(np.arange(nv), np.ones(nv), np.zeros(nv), np.arange(nv))
