"""Joint friction: what it is made of, per joint and, where wanted, per trial."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import PerTrial, parameters_of
from asmc_pin.plant.per_trial import per_trial


class VelocityTerm(PerTrial):
    """A field of `Friction`: the coefficient of a term that is added to the level of friction while a joint moves.

    Attributes:
        level: (coefficient, velocity), both (batch, nv), to what it adds, (batch, nv), N·m (N); not negative, and 0 at
            velocity 0, so that what a joint needs to break loose stays what `breakaway` says.
    """

    def __init__(self, meaning: str, unit: str, *, level: Callable[[Array, Array], Array]) -> None:
        super().__init__(meaning, unit, at_least=0.0, default=0.0)
        self.level = level


@dataclass(frozen=True, eq=False)
class Friction:
    r"""Coulomb, viscous and Stribeck friction of the joints, with presliding where asked for.

    A joint that slides feels −level(v)·sgn(v) − viscous·v, where the level falls from breakaway to Coulomb:

        level(v) = coulomb + (breakaway − coulomb)·exp(−(v/stribeck_velocity)²)

    A joint at rest stays at rest, exactly, while the load on it is within ±breakaway: friction is set-valued there, see
    `asmc_pin.plant.friction.compiled_friction`. With ``presliding`` it gives way like a spring before it breaks loose,
    see `asmc_pin.plant.friction.presliding`. A `VelocityTerm` adds to the level while a joint moves. Every value is a
    scalar, (nv,) or (batch, nv).

    Source: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation
    methods for the control of machines with friction", Automatica 30(7), 1994, with the Gaussian form.

    What is omitted: `breakaway` and `coulomb_backward` are `coulomb`; `breakaway_backward` is `breakaway`, but not
    below `coulomb_backward`; `presliding` None, or 0 in a joint, is none.

    Raises:
        ParameterError: a value is negative, not finite, or of another shape; breakaway is below Coulomb.
    """

    coulomb: PerTrial = PerTrial("Coulomb friction", "N·m (N)", at_least=0.0, default=0.0)
    viscous: PerTrial = PerTrial("viscous friction", "N·m·s/rad (N·s/m)", at_least=0.0, default=0.0)
    _: KW_ONLY
    breakaway: PerTrial = PerTrial(
        "level at rest; the Coulomb level when omitted", "N·m (N)", at_least=0.0, default=None
    )
    stribeck_velocity: PerTrial = PerTrial(
        "speed over which it falls to the Coulomb level", "rad/s (m/s)", above=0.0, default=0.01
    )
    coulomb_backward: PerTrial = PerTrial(
        "Coulomb friction against motion backwards; the same when omitted", "N·m (N)", at_least=0.0, default=None
    )
    breakaway_backward: PerTrial = PerTrial(
        "level at rest against motion backwards; the same when omitted", "N·m (N)", at_least=0.0, default=None
    )
    presliding: PerTrial = PerTrial(
        "stiffness before breaking loose; rigid when omitted", "N·m/rad (N/m)", at_least=0.0, default=None
    )
    presliding_damping: PerTrial = PerTrial("damping of that stiffness", "N·m·s/rad (N·s/m)", at_least=0.0, default=0.0)

    def __post_init__(self) -> None:
        """Fill in what was omitted, and check what depends on several parameters."""
        coulomb, breakaway = self.coulomb, self.breakaway
        one_way = self.coulomb_backward is None
        filled = {
            "breakaway": coulomb,
            "coulomb_backward": coulomb,
            "breakaway_backward": (coulomb if one_way else self.coulomb_backward)
            if breakaway is None
            else breakaway
            if one_way
            else np.maximum(breakaway, self.coulomb_backward),
            "presliding": 0.0,
        }
        for name, value in filled.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        for end in ("", "_backward"):
            least, level = getattr(self, f"coulomb{end}"), getattr(self, f"breakaway{end}")
            try:
                below = level < least
            except ValueError:
                continue  # of different sizes; `spread` says for which joints
            if np.any(below):
                raise ParameterError(
                    f"breakaway{end}", f"{level.tolist()} given; it must not be below coulomb{end}, {least.tolist()}"
                )

    @property
    def constant(self) -> bool:
        """Whether the levels are those of Coulomb friction, the same in both directions."""
        return not self.terms and all(np.array_equal(x, self.coulomb) for x in self._levels)

    @property
    def yields(self) -> bool:
        """Whether a joint gives way before it breaks loose."""
        return bool(np.any(self.presliding > 0.0))

    @property
    def terms(self) -> dict[str, VelocityTerm]:
        """The terms of the level that are there beyond Coulomb and Stribeck, by the names of their fields."""
        own = parameters_of(type(self)).items()
        return {k: item for k, item in own if isinstance(item, VelocityTerm) and np.any(getattr(self, k) > 0.0)}

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
        for name in parameters_of(type(self)):
            value = getattr(self, name)
            per_trial(f"friction.{name}", value, len(value) if value.ndim == 2 else 1, nv)

    def scaled(self, factor: Array) -> Friction:
        """Friction with every torque (levels and coefficients) multiplied by factors, (batch, nv)."""
        kept = ("stribeck_velocity",)
        own = {name: getattr(self, name) for name in parameters_of(type(self))}
        return replace(self, **{name: value * factor for name, value in own.items() if name not in kept})
