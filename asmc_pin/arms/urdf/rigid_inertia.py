"""What a rigid body's mass and inertia must satisfy, and the nearest inertia that does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.magnitudes import INERTIA, MASS

ENTRIES = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
"""Where each attribute of ``<inertia>`` stands in the tensor."""

# Relative to the largest principal moment: exporters print some ten digits.
_TOLERANCE = 1e-9

# m²: within this radius of gyration, squared, a body is a point.
_POINT = 1e-12

# Principal moments are sums of two of the three second moments: λ = B σ.
_SUMS = np.ones((3, 3)) - np.eye(3)


@dataclass(frozen=True, eq=False)
class LinkInertia:
    """``<inertial>`` of a link.

    Attributes:
        mass: kg.
        com: Centre of mass in the link's frame, shape (3,), m.
        turn: Rotation from the axes that the tensor is written in to the link's, shape (3, 3).
        written: The tensor about the centre as it is written, shape (3, 3), kg·m².
        where: The link and its place in the file, for messages.
    """

    mass: float
    com: Array
    turn: Array
    written: Array
    where: str

    @property
    def inertia(self) -> Array:
        """The tensor about the centre in the link's axes, shape (3, 3), kg·m²."""
        return np.asarray(self.turn @ self.written @ self.turn.T)


def mass_problem(mass: float) -> str:
    """Say what is wrong with a mass, kg, or nothing."""
    if mass < 0.0:
        return f"its mass is {mass:g} kg; a mass is positive, correct the sign"
    if not mass <= MASS:
        return f"its mass is {mass:g} kg, and at most {MASS:g} kg are taken; correct the number, or its unit"
    return ""


def size_problem(inertia: Array) -> str:
    """Say of a tensor, shape (3, 3), kg·m², that its numbers are too large to be computed with, or nothing."""
    largest = float(np.max(np.abs(inertia)))
    if not largest <= INERTIA:
        return f"its inertia has an entry of {largest:g} kg·m², and at most {INERTIA:g} are taken; correct the number"
    return ""


def tensor_problem(mass: float, inertia: Array) -> str:
    """Say what is wrong with a tensor about a centre of mass, or nothing.

    A body's principal moments about its centre are sums of m y² + m z² and the like, so none is negative and none
    exceeds the sum of the other two (triangle inequality). Both are judged to 1e-9 of the largest moment, or to what
    the mass has within a micrometre of its centre: exporters write 1e-20 for a zero, of either sign.

    Args:
        mass: kg.
        inertia: Shape (3, 3), kg·m².

    Returns:
        A clause for a message, empty where such a body is possible.
    """
    moments = np.linalg.eigvalsh(inertia)
    slack = max(_TOLERANCE * float(np.max(np.abs(moments))), _POINT * mass)
    listed = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] < -slack:
        return f"its inertia is not positive semidefinite (principal moments {listed} kg·m²)"
    if moments[2] > moments[0] + moments[1] + slack:
        return (
            f"its inertia breaks the triangle inequality: of its principal moments {listed} kg·m² the largest exceeds "
            "the sum of the other two, which no rigid body has"
        )
    return ""


TENSOR_REMEDY = "check its signs and its unit, or recompute it about the centre of mass, all six entries"
"""What to look at where `tensor_problem` found something."""


def inertia_problem(mass: float, inertia: Array) -> str:
    """Say what is wrong with a rigid body, or nothing.

    Args:
        mass: kg.
        inertia: About the centre of mass, shape (3, 3), kg·m².

    Returns:
        A clause for a message, empty where the body is possible.
    """
    found = mass_problem(mass) or size_problem(inertia)
    if found:
        return found
    found = tensor_problem(mass, inertia)
    return f"{found}; {TENSOR_REMEDY}" if found else ""


def nearest_inertia(inertia: Array) -> Array:
    """The tensor of a possible body that is nearest to a given one, with the same mass and centre.

    A body is possible exactly where its pseudo-inertia is positive semidefinite (Wensing, Kim, Slotine (2018), IEEE
    Robotics and Automation Letters 3(1)): with a positive mass, where the second moments Σ = ½ tr(I) 1 − I about the
    centre are. Distances are of Frobenius. The nearest tensor has the same axes, as the distance does not change under
    rotations (Hoffman and Wielandt), so three numbers are left: nonnegative least squares.

    Args:
        inertia: About the centre of mass, shape (3, 3), kg·m².

    Returns:
        Shape (3, 3), kg·m²; on the border of what is possible, unless the given one is possible itself.
    """
    moments, axes = np.linalg.eigh(inertia)
    size = float(np.max(np.abs(moments)))
    if size == 0.0:
        return np.zeros((3, 3))
    second, _ = nnls(_SUMS, moments / size)
    nearest: Array = (axes * (_SUMS @ second * size)) @ axes.T
    return 0.5 * (nearest + nearest.T)
