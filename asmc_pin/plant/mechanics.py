"""Arms, friction, end stops and loads of a batch, as the schemes of `asmc_pin.plant.integrators` see them."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.errors import ParameterError
from asmc_pin.plant.free_dynamics import FreeDynamics
from asmc_pin.plant.friction.compiled_friction import slide_or_stick, stribeck_levels
from asmc_pin.plant.friction.friction_parameters import Friction
from asmc_pin.plant.friction.presliding import slide_or_bend
from asmc_pin.plant.world.end_stops import StopForces
from asmc_pin.plant.world.loads_state import Loads


class JointFriction:
    """Friction under way: its levels, and how far presliding joints have given way.

    Attributes:
        none: Whether no trial has any friction.

    Args:
        friction: The parameters.
        batch: Number of trials.
        nv: Number of joints.
        active: Trials that run, (batch,).
    """

    def __init__(self, friction: Friction, batch: int, nv: int, active: BoolArray) -> None:
        def spread(name: str) -> Array:
            return friction.spread(name, batch, nv)

        self.coulomb, self.viscous = spread("coulomb"), spread("viscous")
        self._active = active
        self._constant = friction.constant
        self._coulomb_back = spread("coulomb_backward")
        self._breakaway, self._breakaway_back = spread("breakaway"), spread("breakaway_backward")
        self._scale = spread("stribeck_velocity")
        self._terms = [(item.level, spread(name)) for name, item in friction.terms.items()]
        self._kinked = (self._breakaway > 0.0) | (self._breakaway_back > 0.0)
        for _, coefficient in self._terms:
            self._kinked |= coefficient > 0.0
        self.none = not (self._kinked.any() or self.viscous.any())
        self._yields = friction.yields
        if self._yields:
            self.stiffness = np.where(self._kinked, spread("presliding"), 0.0)
            if np.any(self._kinked & (self.stiffness == 0.0)):
                raise ParameterError(
                    "friction.presliding",
                    "is 0 in a joint with Coulomb friction, but not in all; give every such joint a stiffness, or none",
                )
            self._damping = spread("presliding_damping")
            self._bend = np.zeros((batch, nv))

    def extended(self, front: int, back: int) -> JointFriction:
        """The same for `front` more coordinates before and `back` after the joints', without friction."""
        around = ((0, 0), (front, back))
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray) and value.ndim == 2:
                setattr(self, name, np.pad(value, around, constant_values=1.0 if name == "_scale" else 0))
        self._terms = [(level, np.pad(coefficient, around)) for level, coefficient in self._terms]
        return self

    def levels(self, v: Array) -> tuple[Array, Array]:
        """Levels against motion forwards and backwards at a velocity, each (batch, nv), N·m."""
        if self._constant:
            return self.coulomb, self.coulomb
        ahead, back = np.empty_like(v), np.empty_like(v)
        stribeck_levels(v, self.coulomb, self._breakaway, self._scale, ahead)
        stribeck_levels(v, self._coulomb_back, self._breakaway_back, self._scale, back)
        for level, coefficient in self._terms:
            added = level(coefficient, v)
            ahead, back = ahead + added, back + added
        return ahead, back

    def step(
        self,
        mass: Array,
        v: Array,
        acceleration: Array,
        step: float,
        impulse: Array,
        sliding_at: Array,
        implicit: float,
        trial_run: bool,
    ) -> Array:
        """Velocity after a step; see `asmc_pin.plant.integrators.Mechanics.after_friction`."""
        next_v = v.copy()  # what stopped trials keep
        ahead, back = self.levels(sliding_at)
        if not self._yields:
            slide_or_stick(
                mass, v, acceleration, ahead, back, self.viscous, step, self._active, next_v, impulse, implicit
            )
            return next_v
        bend = self._bend.copy()
        slide_or_bend(
            mass,
            v,
            acceleration,
            ahead,
            back,
            self.viscous,
            self.stiffness,
            self._damping,
            self._bend,
            step,
            self._active,
            next_v,
            impulse,
            bend,
        )
        if not trial_run:
            self._bend = bend
        return next_v

    def sliding(self, v: Array) -> Array:
        """Torque on joints that slide at v, (batch, nv), N·m."""
        ahead, back = self.levels(v)
        return np.asarray(np.where(v > 0.0, -ahead, np.where(v < 0.0, back, 0.0)) - self.viscous * v)

    def slides(self, *velocities: Array) -> BoolArray:
        """Trials, (batch,), in which every joint that has Coulomb friction moves the same way at all velocities."""
        lowest, highest = np.minimum.reduce(velocities), np.maximum.reduce(velocities)
        moves = (lowest > 0.0) | (highest < 0.0) | ~self._kinked
        return np.asarray(moves.all(axis=1))


class JointMechanics:
    """Rigid joints: one coordinate each.

    Attributes:
        free: The arms without friction.
        friction: Its state.
        stops: End stops, or None.
        loads: What acts on the arms from outside, or None.
        frictionless: Whether no trial has any friction.
    """

    def __init__(
        self, free: FreeDynamics, friction: JointFriction, stops: StopForces | None, loads: Loads | None
    ) -> None:
        self.free, self.friction, self.stops, self.loads = free, friction, stops, loads
        self.frictionless = friction.none
        self._mass_of: tuple[Array, Array] | None = None

    def acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """Joint acceleration without friction, (batch, nv), rad/s²."""
        if self.stops is not None:
            torque = torque + self.stops.torque(q, v)
        if self.loads is not None:
            torque = torque + self.loads.torque(q)
        return self.free.acceleration(q, v, torque)

    def mass_matrix(self, q: Array) -> Array:
        """M(q), (batch, nv, nv), kg·m²; asked twice for the same array it is not computed again."""
        if self._mass_of is None or self._mass_of[0] is not q:
            self._mass_of = q, self.free.mass_matrix(q)
        return self._mass_of[1]

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
        """Velocity after the step, rad/s, exactly 0.0 where a joint sticks; adds friction's `impulse`, N·m·s."""
        if self.frictionless:
            return v + step * acceleration
        at = v if sliding_at is None else sliding_at
        return self.friction.step(self.mass_matrix(q), v, acceleration, step, impulse, at, implicit, trial_run)

    def sliding_friction(self, v: Array) -> Array:
        """Torque of friction on sliding joints, (batch, nv), N·m."""
        return self.friction.sliding(v)

    def slides(self, *velocities: Array) -> BoolArray:
        """Trials in which every joint slides on, (batch,)."""
        return self.friction.slides(*velocities)
