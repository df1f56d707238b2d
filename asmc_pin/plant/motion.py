"""A batch of trials under way: the mutable side of a plant, one control tick after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.base import Sample
from asmc_pin.plant.dynamics import FreeDynamics
from asmc_pin.plant.friction_kernels import slide_or_stick
from asmc_pin.plant.integrators import INTEGRATORS
from asmc_pin.plant.tick_kernels import limit_torque, stop_diverged

if TYPE_CHECKING:
    from asmc_pin.plant.plant import Plant


@dataclass(frozen=True, eq=False)
class JointMechanics:
    """Arms and friction of a batch, as a scheme of `asmc_pin.plant.integrators` sees them.

    Attributes:
        free: The arms without friction.
        coulomb: Shape (batch, nv), N·m.
        viscous: Shape (batch, nv), N·m·s/rad.
        active: Trials that are integrated, shape (batch,).
        frictionless: Whether no trial has any friction.
    """

    free: FreeDynamics
    coulomb: Array
    viscous: Array
    active: BoolArray
    frictionless: bool

    def acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """Joint acceleration without friction, (batch, nv), rad/s²."""
        return self.free.acceleration(q, v, torque)

    def after_friction(self, q: Array, v: Array, acceleration: Array, step: float, impulse: Array) -> Array:
        """Velocity after the step, rad/s, exactly 0.0 where a joint sticks; adds to friction's `impulse`, N·m·s."""
        if self.frictionless:
            return v + step * acceleration
        next_v = v.copy()  # what stopped trials keep
        slide_or_stick(
            self.free.mass_matrix(q),
            v,
            acceleration,
            self.coulomb,
            self.coulomb,
            self.viscous,
            step,
            self.active,
            next_v,
            impulse,
        )
        return next_v


class Motion:
    """Trials of one plant in lockstep; made by `Plant.begin`.

    A tick is `stop_diverged`, `sample`, `apply`, `advance`. Arrays that are handed out are never written to afterwards.

    Attributes:
        q: Angles, shape (batch, nv), rad.
        v: Velocities, shape (batch, nv), rad/s.
        torque: Torque that the drives apply since the last `apply`, after their limits, (batch, nv), N·m.
        active: Trials that are still integrated, shape (batch,). A stopped trial is parked at zero: Pinocchio still
            runs over the whole batch and the law is still asked, so what they read has to be finite.
    """

    def __init__(self, plant: Plant, period: float, q: Array, v: Array) -> None:
        batch, nv = q.shape
        self.q, self.v = q, v
        self.active: BoolArray = np.ones(batch, dtype=np.bool_)
        self._all_active = True
        self._plant = plant
        self._period = period
        self._step = period / plant.substeps
        self._integrate = INTEGRATORS[plant.integrator]
        coulomb, viscous = plant.friction.of_trials(batch, nv)
        free = FreeDynamics(plant.arms, batch, plant.threads)
        self._limit = plant.torque_limits(batch)
        self._mechanics = JointMechanics(
            free, coulomb, viscous, self.active, frictionless=not (coulomb.any() or viscous.any())
        )
        if plant.start == "holding":
            self.torque = np.clip(free.gravity(q), -self._limit, self._limit)
        else:
            self.torque = np.zeros((batch, nv))

    def stop_diverged(self, q_ref: Array) -> bool:
        """Stop the trials that are too fast or too far from q_ref, (nv,), for the plant's bounds; True if any is."""
        plant = self._plant
        return self._note(stop_diverged(self.q, self.v, q_ref, plant.speed_bound, plant.error_bound, self.active))

    def sample(self) -> Sample:
        """What the drives report now; read-only."""
        return Sample(_view(self.q), _view(self.v), _view(self.torque))

    def apply(self, command: Array) -> bool:
        """Hold the command, (batch, nv), within the drives' limits; True if a trial's is not finite, which stops it."""
        self.torque = np.empty_like(command)
        return self._note(limit_torque(command, self._limit, self.active, self.torque))

    def advance(self) -> Array:
        """Carry the trials over one control period.

        Returns:
            Torque of friction on the joints, its mean over the period, (batch, nv), N·m: against the motion where a
            joint slides, against the load where it sticks.
        """
        impulse = np.zeros_like(self.q)
        q, v = self.q, self.v
        for _ in range(self._plant.substeps):
            q, v = self._integrate(self._mechanics, q, v, self.torque, self._step, impulse)
        if not self._all_active:
            q = np.where(self.active[:, None], q, self.q)
            v = np.where(self.active[:, None], v, self.v)
        self.q, self.v = q, v
        return impulse / self._period

    def _note(self, stopped: int) -> bool:
        if stopped:
            self._all_active = False
            self.q = np.where(self.active[:, None], self.q, 0.0)
            self.v = np.where(self.active[:, None], self.v, 0.0)
        return bool(stopped)


def _view(array: Array) -> Array:
    view = array.view()
    view.setflags(write=False)
    return view
