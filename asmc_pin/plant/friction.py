"""Joint friction: what it is made of, per joint and, where wanted, per trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.plant.parameters import per_trial, read_only


@dataclass(frozen=True, eq=False, init=False)
class Friction:
    """Coulomb and viscous friction of the joints.

    The torque of friction on a sliding joint is −coulomb·sgn(v) − viscous·v. A joint at rest stays at rest, exactly,
    while the load on it is within ±coulomb: friction is set-valued there, see `asmc_pin.plant.friction_kernels`.

    Attributes:
        coulomb: Coulomb level, which is the breakaway torque too. Scalar, (nv,) or (batch, nv), N·m (N for prismatic
            joints).
        viscous: Viscous coefficient. Scalar, (nv,) or (batch, nv), N·m·s/rad (N·s/m).

    Raises:
        ParameterError: a value is negative, not finite, or of another shape.
    """

    coulomb: Array
    viscous: Array

    def __init__(self, coulomb: ArrayLike = 0.0, viscous: ArrayLike = 0.0) -> None:
        for name, given in (("coulomb", coulomb), ("viscous", viscous)):
            value = read_only(f"friction.{name}", given)
            if not np.all(np.isfinite(value) & (value >= 0.0)):
                raise ParameterError(
                    f"friction.{name}", f"{value.tolist()} given; every value has to be finite and not negative"
                )
            object.__setattr__(self, name, value)

    def of_trials(self, batch: int, nv: int) -> tuple[Array, Array]:
        """Coulomb levels and viscous coefficients, each of shape (batch, nv).

        Raises:
            ParameterError: the parameters are for another number of joints or trials.
        """
        return per_trial("friction.coulomb", self.coulomb, batch, nv), per_trial(
            "friction.viscous", self.viscous, batch, nv
        )
