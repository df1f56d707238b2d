"""Joint friction: what it is made of, per joint and, where wanted, per trial."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.plant.per_trial import per_trial, read_only


@dataclass(frozen=True, eq=False, init=False)
class Friction:
    r"""Coulomb, viscous and Stribeck friction of the joints, with presliding where asked for.

    A joint that slides feels −level(v)·sgn(v) − viscous·v, where the level falls from breakaway to Coulomb:

        level(v) = coulomb + (breakaway − coulomb)·exp(−(v/stribeck_velocity)²)

    A joint at rest stays at rest, exactly, while the load on it is within ±breakaway: friction is set-valued there, see
    `asmc_pin.plant.friction.compiled_friction`. With ``presliding`` it gives way like a spring before it breaks loose,
    see `asmc_pin.plant.friction.presliding`. Every value is a scalar, (nv,) or (batch, nv).

    Source: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation
    methods for the control of machines with friction", Automatica 30(7), 1994, with the Gaussian form.

    Attributes:
        coulomb: Coulomb level, N·m (N for prismatic joints).
        viscous: Viscous coefficient, N·m·s/rad (N·s/m).
        breakaway: Level at rest, not below `coulomb`, N·m; the Coulomb level when omitted.
        stribeck_velocity: Speed at which 1/e of the difference is left, rad/s (m/s).
        coulomb_backward: Coulomb level against motion backwards, N·m; `coulomb` when omitted.
        breakaway_backward: The same for breakaway; `breakaway` when omitted, but not below `coulomb_backward`.
        presliding: Stiffness before breaking loose, N·m/rad (N/m); None, or 0 in a joint, for none.
        presliding_damping: Damping of that spring, N·m·s/rad (N·s/m).

    Raises:
        ParameterError: a value is negative, not finite, or of another shape; breakaway is below Coulomb.
    """

    coulomb: Array
    viscous: Array
    breakaway: Array
    stribeck_velocity: Array
    coulomb_backward: Array
    breakaway_backward: Array
    presliding: Array
    presliding_damping: Array

    def __init__(
        self,
        coulomb: ArrayLike = 0.0,
        viscous: ArrayLike = 0.0,
        *,
        breakaway: ArrayLike | None = None,
        stribeck_velocity: ArrayLike = 0.01,
        coulomb_backward: ArrayLike | None = None,
        breakaway_backward: ArrayLike | None = None,
        presliding: ArrayLike | None = None,
        presliding_damping: ArrayLike = 0.0,
    ) -> None:
        given = {"coulomb": coulomb, "viscous": viscous, "stribeck_velocity": stribeck_velocity}
        given |= {"breakaway": coulomb if breakaway is None else breakaway}
        given |= {"coulomb_backward": coulomb if coulomb_backward is None else coulomb_backward}
        given |= {"presliding": 0.0 if presliding is None else presliding, "presliding_damping": presliding_damping}
        if breakaway_backward is None:
            if breakaway is None:
                breakaway_backward = given["coulomb_backward"]
            elif coulomb_backward is None:
                breakaway_backward = breakaway
            else:
                breakaway_backward = np.maximum(
                    read_only("friction.breakaway", breakaway), read_only("friction.coulomb_backward", coulomb_backward)
                )
        given |= {"breakaway_backward": breakaway_backward}
        for name in _names():
            value = read_only(f"friction.{name}", given[name])
            if not np.all(np.isfinite(value) & (value >= 0.0)):
                raise ParameterError(
                    f"friction.{name}", f"{value.tolist()} given; every value has to be finite and not negative"
                )
            object.__setattr__(self, name, value)
        self._check_levels()

    def _check_levels(self) -> None:
        if not np.all(self.stribeck_velocity > 0.0):
            raise ParameterError(
                "friction.stribeck_velocity", f"{self.stribeck_velocity.tolist()} given; expected positive speeds"
            )
        for end in ("", "_backward"):
            least, level = getattr(self, f"coulomb{end}"), getattr(self, f"breakaway{end}")
            try:
                below = level < least
            except ValueError:
                continue  # of different sizes; `spread` says for which joints
            if np.any(below):
                raise ParameterError(
                    f"friction.breakaway{end}",
                    f"{level.tolist()} given; it must not be below coulomb{end}, {least.tolist()}",
                )

    @property
    def constant(self) -> bool:
        """Whether the levels are those of Coulomb friction, the same in both directions."""
        return all(x is self.coulomb or np.array_equal(x, self.coulomb) for x in self._levels)

    @property
    def yields(self) -> bool:
        """Whether a joint gives way before it breaks loose."""
        return bool(np.any(self.presliding > 0.0))

    @property
    def _levels(self) -> tuple[Array, Array, Array]:
        return self.coulomb_backward, self.breakaway, self.breakaway_backward

    def spread(self, name: str, batch: int, nv: int) -> Array:
        """One of the attributes as a new array of shape (batch, nv).

        Raises:
            ParameterError: it is for another number of joints or trials.
        """
        return per_trial(f"friction.{name}", getattr(self, name), batch, nv)

    def check(self, nv: int) -> None:
        """Check that every attribute is for nv joints.

        Raises:
            ParameterError: one is not.
        """
        for name in _names():
            value = getattr(self, name)
            per_trial(f"friction.{name}", value, len(value) if value.ndim == 2 else 1, nv)

    def scaled(self, factor: Array) -> Friction:
        """Friction with every torque (levels and coefficients) multiplied by factors, (batch, nv)."""
        return Friction(
            **{name: getattr(self, name) * (1.0 if name == "stribeck_velocity" else factor) for name in _names()}
        )


def _names() -> tuple[str, ...]:
    """What a joint's friction is made of."""
    return tuple(item.name for item in fields(Friction))
