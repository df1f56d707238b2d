"""What a rigid body's mass and inertia must satisfy."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.magnitudes import INERTIA, MASS

# Relative to the largest principal moment: exporters print some ten digits.
_TOLERANCE = 1e-9


def inertia_problem(mass: float, inertia: Array) -> str:
    """Say what is wrong with a rigid body, or nothing.

    A body's principal moments about its centre are sums of m y² + m z² and the like, so none is negative and none
    exceeds the sum of the other two (triangle inequality). Both are judged to 1e-9 of the largest moment.

    Args:
        mass: kg.
        inertia: About the centre of mass, shape (3, 3), kg·m².

    Returns:
        A clause for a message, empty where the body is possible.
    """
    if mass < 0.0:
        return f"its mass is {mass:g} kg; a mass is positive, correct the sign"
    if not mass <= MASS:
        return f"its mass is {mass:g} kg, and at most {MASS:g} kg are taken; correct the number, or its unit"
    largest = float(np.max(np.abs(inertia)))
    if not largest <= INERTIA:
        return f"its inertia has an entry of {largest:g} kg·m², and at most {INERTIA:g} are taken; correct the number"
    moments = np.linalg.eigvalsh(inertia)
    slack = _TOLERANCE * float(np.max(np.abs(moments)))
    listed = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] < -slack:
        return (
            f"its inertia is not positive semidefinite (principal moments {listed} kg·m²); check the signs, and that "
            "all six entries are about the centre of mass"
        )
    if moments[2] > moments[0] + moments[1] + slack:
        return (
            f"its inertia breaks the triangle inequality: of its principal moments {listed} kg·m² the largest exceeds "
            "the sum of the other two, which no rigid body has; recompute it about the centre of mass"
        )
    return ""
