"""What stands between a control law's command and the joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import Choice, OptionalPerJoint, PerJoint, Scalar
from asmc_pin.plant.per_trial import row, sized

# A speed limit takes the torque away over this part of the speed below it: a step there would chatter.
FOLDBACK = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Drive:
    """Motor, gear and current loop of each joint; everything as seen at the joint, after the gear.

    A command passes, in this order: the torque limit (`Plant.effort_limit`), the transport delay, the current loop, and
    the bounds that depend on speed. The delay is the one that docs/stability.md defines: a command of t_k acts from
    t_k + delay·L on, and `Sample.torque` is the time average over a period of what reached the joint.

    Speed bounds take torque away in the direction of motion only; braking is never weakened. Between `corner_speed`
    and `no_load_speed` the available torque falls linearly from the limit to nothing, as a motor on a constant voltage.
    `velocity_limit` folds the torque back to nothing over the last 5 % below it, as a drive's own speed limiter.

    Without elasticity the rotor adds gear²·rotor_inertia to the arm's armature. With `stiffness` the joint becomes two
    masses, the rotor and the link, joined by a spring; `backlash` is play in that joint. See
    `asmc_pin.plant.drive.elastic_state`.
    """

    delay: Scalar = Scalar("transport delay of the torque", "periods", at_least=0.0, default=0.0)
    current_hz: OptionalPerJoint = OptionalPerJoint("bandwidth of the current loop, first order", "Hz", above=0.0)
    corner_speed: OptionalPerJoint = OptionalPerJoint("speed up to which the full torque is there", "rad/s (m/s)")
    no_load_speed: OptionalPerJoint = OptionalPerJoint("speed at which no torque is left", "rad/s (m/s)", above=0.0)
    velocity_limit: OptionalPerJoint = OptionalPerJoint(
        "speed that the drive does not exceed", "rad/s (m/s)", above=0.0
    )
    gear: PerJoint = PerJoint("turns of the motor per turn of the joint (rad per m)", above=0.0, default=1.0)
    rotor_inertia: PerJoint = PerJoint("inertia of the rotor, at the motor", "kg·m²", at_least=0.0, default=0.0)
    stiffness: OptionalPerJoint = OptionalPerJoint("stiffness of the gear at the joint", "N·m/rad (N/m)", above=0.0)
    damping: PerJoint = PerJoint("damping of the gear's spring", "N·m·s/rad (N·s/m)", at_least=0.0, default=0.0)
    friction: Choice = Choice(
        "which of the two masses of an elastic joint has the joint's friction", ("joint", "motor"), default="joint"
    )
    backlash: PerJoint = PerJoint("play of the gear at the joint, end to end", "rad (m)", at_least=0.0, default=0.0)

    def __post_init__(self) -> None:
        """Check what depends on several parameters."""
        if (self.corner_speed is None) != (self.no_load_speed is None):
            missing = "corner_speed" if self.corner_speed is None else "no_load_speed"
            raise ParameterError(missing, "is missing; a torque–speed curve needs corner_speed and no_load_speed")
        if self.corner_speed is not None and not np.all(self.no_load_speed > self.corner_speed):
            raise ParameterError(
                "no_load_speed",
                f"{self.no_load_speed.tolist()} given; it must be above corner_speed, {self.corner_speed.tolist()}",
            )
        if self.stiffness is None:
            for name in ("backlash", "damping"):
                if np.any(getattr(self, name) > 0.0):
                    raise ParameterError(name, "given without stiffness; the gear is rigid then, give its stiffness")
        elif not np.all(self.rotor_inertia > 0.0):
            raise ParameterError("rotor_inertia", "is 0; behind an elastic gear the rotor needs an inertia of its own")

    @property
    def elastic(self) -> bool:
        """Whether the joints are two masses each."""
        return self.stiffness is not None

    @property
    def reflected_inertia(self) -> Array:
        """gear²·rotor_inertia, shape () or (nv,), kg·m² (kg)."""
        return np.asarray(self.gear**2 * self.rotor_inertia)

    @property
    def shapes_torque(self) -> bool:
        """Whether the torque can differ from the command after its limit."""
        return bool(
            self.delay > 0.0
            or self.current_hz is not None
            or self.no_load_speed is not None
            or self.velocity_limit is not None
        )

    def check(self, nv: int, effort_limit: Array) -> None:
        """Check the parameters against the arm and its torque limits, (nv,) or (batch, nv) N·m.

        Raises:
            ParameterError: wrong sizes, or a torque–speed curve without torque limits.
        """
        sized("drive", self, nv)
        if self.no_load_speed is not None and not np.all(np.isfinite(effort_limit)):
            raise ParameterError(
                "drive.no_load_speed", "given, but a joint has no torque limit to fall from; give effort_limit"
            )

    def speed_bounds(self, nv: int) -> tuple[Array, Array, Array]:
        """Corner speed, no-load speed and speed limit, each (nv,), inf where there is none."""
        return (
            row(self.corner_speed, nv, np.inf),
            row(self.no_load_speed, nv, np.inf),
            row(self.velocity_limit, nv, np.inf),
        )
