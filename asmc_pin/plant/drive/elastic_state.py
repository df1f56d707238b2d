"""Two masses per joint: rotor and link, joined by the gear's spring, with play in it where asked for.

Coordinates x = (q, θ): the link's angle and the rotor's, both at the joint. With δ = θ − q and play b,

    M(q) q̈ + C q̇ + g = τ_gear + friction,    J θ̈ = τ_motor − τ_gear,    J = gear²·rotor_inertia,
    τ_gear = k·(δ − b/2) + d·δ̇ for δ > b/2, k·(δ + b/2) + d·δ̇ for δ < −b/2, else 0; never pulling where teeth part.

Any scheme carries the doubled state. Friction acts on the link, or on the rotor with ``friction = "motor"``. The
armature of the arm itself stays on the link's side: give the rotor to the drive, and take it out of the arm's armature.

Source: M. W. Spong, "Modeling and control of elastic joint robots", ASME J. Dynamic Systems, Measurement, and Control
109(4), 1987; dead zone as in M. Nordin, P.-O. Gutman, "Controlling mechanical systems with backlash — a survey",
Automatica 38(10), 2002.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.plant.drive.drive_parameters import Drive
from asmc_pin.plant.mechanics import JointFriction, JointMechanics
from asmc_pin.plant.per_trial import row


class ElasticMechanics:
    """Joints of two masses, for a scheme; arrays of shape (batch, 2nv), the links' coordinates first.

    Args:
        links: The arms as rigid joints would move them.
        drive: Has the gears.
        friction: Extended to 2nv coordinates.
    """

    def __init__(self, links: JointMechanics, drive: Drive, friction: JointFriction) -> None:
        nv = links.free.nv
        self.links, self._nv, self._friction = links, nv, friction
        self.frictionless = friction.none
        self._rotor = row(drive.reflected_inertia, nv, 0.0)
        self._stiffness, self._damping = row(drive.stiffness, nv, np.inf), row(drive.damping, nv, 0.0)
        self._half_play = 0.5 * row(drive.backlash, nv, 0.0)

    def deflected(self, q: Array, torque: Array) -> Array:
        """Rotor angles at which the gears at rest carry a torque, (batch, nv), rad; amid the play where it is 0."""
        return np.asarray(q + torque / self._stiffness + self._half_play * np.sign(torque))

    def gear_torque(self, x: Array, w: Array) -> Array:
        """What the gears carry to the links, (batch, nv), N·m."""
        nv = self._nv
        bend = x[:, nv:] - x[:, :nv]
        past = bend - np.clip(bend, -self._half_play, self._half_play)
        torque = self._stiffness * past + self._damping * (w[:, nv:] - w[:, :nv])
        if not self._half_play.any():
            return np.asarray(torque)
        return np.asarray(np.where(past > 0.0, np.maximum(torque, 0.0), np.where(past < 0.0, np.minimum(torque, 0), 0)))

    def fastest(self, q: Array) -> float:
        """The highest natural frequency of the links against their rotors at q, (batch, nv), rad/s."""
        inverse = np.linalg.inv(self.links.mass_matrix(q)) + np.diag(1.0 / self._rotor)
        root = np.sqrt(self._stiffness)
        return float(np.sqrt(np.linalg.eigvalsh(root[:, None] * inverse * root)[:, -1].max()))

    def acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """Accelerations of links and rotors without friction, rad/s²."""
        nv = self._nv
        carried = self.gear_torque(q, v)
        angles, speeds = np.ascontiguousarray(q[:, :nv]), np.ascontiguousarray(v[:, :nv])
        out = np.empty_like(q)
        out[:, :nv] = self.links.acceleration(angles, speeds, torque[:, :nv] + carried)
        out[:, nv:] = (torque[:, nv:] - carried) / self._rotor
        return out

    def after_friction(
        self,
        q: Array,
        v: Array,
        acceleration: Array,
        step: float,
        impulse: Array,
        *,
        sliding_at: Array | None = None,
        implicit: float = 1.0,
        trial_run: bool = False,
    ) -> Array:
        """Velocities after the step; see `asmc_pin.plant.integrators.Mechanics`."""
        if self.frictionless:
            return v + step * acceleration
        nv = self._nv
        mass = np.zeros((*v.shape, 2 * nv))
        mass[:, :nv, :nv] = self.links.mass_matrix(np.ascontiguousarray(q[:, :nv]))
        mass[:, range(nv, 2 * nv), range(nv, 2 * nv)] = self._rotor
        at = v if sliding_at is None else sliding_at
        return self._friction.step(mass, v, acceleration, step, impulse, at, implicit, trial_run)

    def sliding_friction(self, v: Array) -> Array:
        """Torque of friction on what slides, (batch, 2nv), N·m."""
        return self._friction.sliding(v)

    def slides(self, *velocities: Array) -> BoolArray:
        """Trials in which all that has friction slides on, (batch,)."""
        return self._friction.slides(*velocities)
