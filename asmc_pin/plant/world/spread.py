"""Arms and friction that differ from trial to trial as real ones do, every one of them possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.pinocchio_model import carry
from asmc_pin.arms.pinocchio_tree import tree_of
from asmc_pin.parameters import Scalar
from asmc_pin.plant.friction.friction_parameters import Friction
from asmc_pin.plant.sensor.trial_noise import SPREAD, generator

END = 2.0
"""Standard deviations to what counts as an end of the scatter; a normal number lies further out in 5 % of the draws."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spread:
    """How far parameters scatter about the arm's own, one standard deviation.

    Each link is stretched along the three axes of its frame by exp(inertia·z), then shifted by com·z, and its mass is
    multiplied by exp(mass·z), all z standard normal: what comes out is the mass distribution of a body again, so mass
    is positive, inertia positive definite and the triangle inequality holds, however far out z is. Where in the body
    the mass lies changes by the stretch too. Payload and armature stay as they are. Friction of a joint, levels and
    coefficients together, is multiplied by exp(friction·z).

    Numbers are drawn per trial from the experiment's seed and the trial's number.
    """

    mass: Scalar = Scalar("scatter of each link's mass, relative", "", at_least=0.0, at_most=2.0, default=0.0)
    com: Scalar = Scalar(
        "scatter of each link's centre of mass, along each axis", "m", at_least=0.0, at_most=10.0, default=0.0
    )
    inertia: Scalar = Scalar(
        "stretch of each link along each axis, relative", "", at_least=0.0, at_most=2.0, default=0.0
    )
    friction: Scalar = Scalar("scatter of each joint's friction, relative", "", at_least=0.0, at_most=2.0, default=0.0)

    @property
    def moves_links(self) -> bool:
        """Whether any link differs from the URDF's."""
        return bool(self.mass or self.com or self.inertia)

    def ends(self, arm: Arm) -> tuple[Arm, Arm]:
        """The lightest and the heaviest arm that are looked at: all links `END` standard deviations off together.

        The light one has lighter links, shrunk along all axes, their centres drawn towards the frames' origins, at most
        into them; the heavy one the opposite. Links that are drawn one by one may lie beyond these two in part.
        """
        model = (arm.replace(payload=None) if arm.payload is not None else arm).model
        centre = np.array([model.inertias[i + 1].lever for i in range(arm.tree.joints)])
        far = np.linalg.norm(centre, axis=1, keepdims=True)
        outward = np.divide(centre, far, out=np.zeros_like(centre), where=far > 0.0)
        made = []
        for sign in (-1.0, 1.0):
            size = np.exp(sign * END * self.inertia)
            shift = np.maximum(sign * END * self.com, -size * far) * outward
            mass = np.full(arm.tree.joints, np.exp(sign * END * self.mass))
            made.append(vary_links(arm, mass, shift, np.full((arm.tree.joints, 3), size)))
        return made[0], made[1]

    def arms(self, arms: Sequence[Arm], seed: int, trials: Sequence[int]) -> tuple[Arm, ...]:
        """One arm per trial, made from one arm or one per trial."""
        if not self.moves_links:
            return tuple(arms)
        made = []
        for k, trial in enumerate(trials):
            z = generator(seed, trial, SPREAD, 0).standard_normal((arms[0].tree.joints, 7))
            arm = arms[k % len(arms)]
            made.append(
                vary_links(arm, np.exp(self.mass * z[:, 0]), self.com * z[:, 1:4], np.exp(self.inertia * z[:, 4:]))
            )
        return tuple(made)

    @property
    def least_friction(self) -> float:
        """Factor on a joint's friction at the low end of the scatter."""
        return float(np.exp(-END * self.friction))

    def of_friction(self, friction: Friction, nv: int, seed: int, trials: Sequence[int]) -> Friction:
        """Friction with one row per trial."""
        if not self.friction:
            return friction
        z = [generator(seed, trial, SPREAD, 1).standard_normal(nv) for trial in trials]
        return friction.scaled(np.exp(self.friction * np.array(z)))


@dataclass(frozen=True, eq=False, repr=False)
class VariedArm(Arm):
    """An arm whose links differ from its URDF's; see `vary_links`.

    Attributes:
        nominal: The arm as its URDF has it.
        factors: Mass factors (n,), shifts (n, 3) and stretches (n, 3) of its links, one per joint that moves.
    """

    nominal: Arm | None = None
    factors: tuple[Array, Array, Array] | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return vary_links, (self.nominal, *(self.factors or ()))

    def replace(self, **options: Any) -> Arm:
        """The same links with other options; see `Arm.replace`."""
        assert self.nominal is not None
        assert self.factors is not None
        return vary_links(self.nominal.replace(**options), *self.factors)


def vary_links(arm: Arm, mass: Array, shift: Array, stretch: Array) -> VariedArm:
    """The arm with other links: each body's mass distribution stretched, shifted and made denser.

    With S = diag(stretch), second moment Σ = ½ tr(I)·1 − I about the frame's origin, mass m and centre c:
    m' = mass·m, c' = S c + shift, Σ' about the centre = mass·S Σ S. A payload is added afterwards, as it is.

    Args:
        arm: The arm.
        mass: Factors, (n,), positive, for the body behind each of the n joints that move, mimicking ones included.
        shift: Of the centres, along the joints' axes at their frames, (n, 3), m.
        stretch: Factors, (n, 3), positive.
    """
    if isinstance(arm, VariedArm):
        raise TypeError("the links of a varied arm are not varied again; vary its nominal arm")
    bare = arm.replace(payload=None) if arm.payload is not None else arm
    model = bare.model.copy()
    for i in range(arm.tree.joints):
        model.inertias[i + 1] = _varied(bare.model.inertias[i + 1], mass[i], shift[i], np.diag(stretch[i]))
    if arm.payload is not None:
        carry(arm.made_of.robot, model, arm.payload)
    values = {item.name: getattr(arm, item.name) for item in fields(Arm) if item.init and item.name != "_local"}
    values |= {"model": model, "tree": tree_of(model, arm.tree.coupling)}
    return VariedArm(**values, nominal=arm, factors=(mass, shift, stretch))


def _varied(link: pin.Inertia, mass: float, shift: Array, stretch: Array) -> pin.Inertia:
    spread = 0.5 * np.trace(link.inertia) * np.eye(3) - link.inertia
    spread = mass * stretch @ spread @ stretch
    return pin.Inertia(mass * link.mass, stretch @ link.lever + shift, np.trace(spread) * np.eye(3) - spread)
