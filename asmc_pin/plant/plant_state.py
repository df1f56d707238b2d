"""A batch of trials under way: the mutable side of a plant, one control tick after the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.protocol import Sample
from asmc_pin.errors import ParameterError
from asmc_pin.plant.compiled_ticks import limit_torque, stop_diverged
from asmc_pin.plant.drive.drive_state import Actuator
from asmc_pin.plant.drive.elastic_state import ElasticMechanics
from asmc_pin.plant.free_dynamics import FreeDynamics
from asmc_pin.plant.integrators import INTEGRATORS
from asmc_pin.plant.mechanics import JointFriction, JointMechanics
from asmc_pin.plant.plant_parameters import PlantParameters
from asmc_pin.plant.sensor.sensor_state import Sensing
from asmc_pin.plant.world.end_stops import StopForces
from asmc_pin.plant.world.loads_state import Loads

# A spring that turns further than this in a step, in radians of its own oscillation, is not resolved: the schemes blow
# up at 2 (semi_implicit, midpoint) and 2.8 (rk4).
SPRING_ANGLE = 1.0


class Motion:
    """A run while it goes on: the trials of one plant, all at the same tick. `Plant.begin` makes it.

    A tick is `stop_diverged`, `sample`, `apply`, `advance`. Arrays that are handed out are never written to afterwards.

    Attributes:
        q: Angles, shape (batch, nv), rad.
        v: Velocities, shape (batch, nv), rad/s.
        torque: Torque of the drives at the joints, after their limits, (batch, nv), N·m: its mean over the last period
            once `advance` has gone over it. With rigid gears that is what the joints feel.
        external: Mean torque of the disturbances over the last period, (batch, nv), N·m; None without any.
        plant: What moves.
        period: L, s.
        changes: Ticks at which something is picked up or put down.
        limit: Torque limits of the drives, (batch, nv), N·m.
        friction, stops, loads, actuator, sensing: What acts in between; None where it is absent or ideal.
        active: Trials that are still integrated, shape (batch,). A stopped trial is parked at zero: Pinocchio still
            runs over the whole batch and the law is still asked, so what they read has to be finite.
    """

    def __init__(self, plant: PlantParameters, period: float, q: Array, v: Array, trials: Sequence[int]) -> None:
        batch, nv = q.shape
        trials = plant.numbered(trials)
        self.active: BoolArray = np.ones(batch, dtype=np.bool_)
        self._all_active = True
        self.plant, self.period, self._nv = plant, period, nv
        self._step = period / plant.substeps
        self._integrate = INTEGRATORS[plant.integrator]
        self._ticks = 0
        self.changes = [round(change.time / period) for change in plant.payload_changes]
        free = self._free_dynamics(0.0, batch)
        self.limit = plant.torque_limits(batch)
        self.loads = (
            Loads(plant.disturbances, plant.arm, period, batch, plant.seed, trials) if plant.disturbances else None
        )
        self.external = None if self.loads is None else np.zeros((batch, nv))
        self.friction = friction = JointFriction(plant.friction, batch, nv, self.active)
        self.stops = stops = (
            None if plant.end_stops is None else StopForces(plant.end_stops, plant.arm.lower, plant.arm.upper)
        )
        self._links = JointMechanics(free, friction, stops, self.loads)
        if plant.start == "holding":
            self.torque = np.clip(free.gravity(q), -self.limit, self.limit)
        else:
            self.torque = np.zeros((batch, nv))
        self._mechanics: JointMechanics | ElasticMechanics = self._links
        self._x, self._w = q, v
        drive = plant.drive
        if drive is not None and drive.elastic:
            at_motor = drive.friction == "motor"
            friction = friction.extended(nv if at_motor else 0, 0 if at_motor else nv)
            self._mechanics = ElasticMechanics(self._links, drive, friction)
            self._x = np.hstack([q, self._mechanics.deflected(q, self.torque)])
            self._w = np.hstack([v, v])
        self._check_springs(q)
        self.actuator = (
            Actuator(drive, self.limit, self.torque, period, plant.substeps, self.active)
            if drive is not None and drive.shapes_torque
            else None
        )
        self._motor_side = plant.sensor is not None and plant.sensor.side == "motor"
        self.sensing = (
            None
            if plant.sensor is None
            else Sensing(
                plant.sensor,
                np.ones(()) if drive is None else drive.gear,
                *self._sensed(),
                period=period,
                seed=plant.seed,
                trials=trials,
            )
        )
        self._sample: Sample | None = None

    @property
    def q(self) -> Array:
        """Joint angles, (batch, nv), rad."""
        return self._x if self._x.shape[1] == self._nv else self._x[:, : self._nv]

    @property
    def v(self) -> Array:
        """Joint velocities, (batch, nv), rad/s."""
        return self._w if self._w.shape[1] == self._nv else self._w[:, : self._nv]

    @property
    def ideal_sensor(self) -> bool:
        """Whether the law is told the truth."""
        return self.sensing is None

    def stop_diverged(self, q_ref: Array) -> bool:
        """Stop the trials that are too fast or too far from q_ref, (nv,), for the plant's bounds; True if any is."""
        plant = self.plant
        return self._note(stop_diverged(self.q, self.v, q_ref, plant.speed_bound, plant.error_bound, self.active))

    def sample(self) -> Sample:
        """What the drives report now; read-only. Asked again in the same tick it is the same."""
        if self._sample is None:
            if self.sensing is None:
                self._sample = Sample(_view(self.q), _view(self.v), _view(self.torque))
            else:
                read = self.sensing.read(*self._sensed(), self.torque)
                self._sample = Sample(_view(read.q), _view(read.v), _view(read.torque))
        return self._sample

    def apply(self, command: Array) -> bool:
        """Hold the command, (batch, nv), within the drives' limits; True if a trial's is not finite, which stops it."""
        self.torque = np.empty_like(command)
        stopped = self._note(limit_torque(command, self.limit, self.active, self.torque))
        if self.actuator is not None:
            self.actuator.command(self.torque)
        return stopped

    def advance(self) -> Array:
        """Carry the trials over one control period.

        Returns:
            Torque of friction on the joints, its mean over the period, (batch, nv), N·m: against the motion where a
            joint slides, against the load where it sticks.
        """
        if self._ticks in self.changes:
            self._links.free = self._free_dynamics(self._ticks * self.period, len(self._x))
        if self.loads is not None:
            self.loads.tick()
            self.external = np.zeros_like(self.torque)
        impulse = np.zeros_like(self._x)
        x, w = self._x, self._w
        for index in range(self.plant.substeps):
            x, w = self._integrate(self._mechanics, x, w, self._step_torque(index, x, w), self._step, impulse)
        if not self._all_active:
            x = np.where(self.active[:, None], x, self._x)
            w = np.where(self.active[:, None], w, self._w)
        self._x, self._w = x, w
        self._ticks += 1
        self._sample = None
        if self.actuator is not None:
            self.torque = self.actuator.mean()
        nv = self._nv
        return (impulse if impulse.shape[1] == nv else impulse[:, :nv] + impulse[:, nv:]) / self.period

    def _free_dynamics(self, time: float, batch: int) -> FreeDynamics:
        plant = self.plant
        arms = plant.arms_at(time, self.period)
        return FreeDynamics(arms, batch, plant.threads, own_mass=plant.engine != "pinocchio")

    def _step_torque(self, index: int, x: Array, w: Array) -> Array:
        """Mean torque of the drives over an integration step; sets what else acts then."""
        nv = self._nv
        torque = self.torque if self.actuator is None else self.actuator.torque(index, w[:, -nv:])
        if self.loads is not None:
            since = self._ticks * self.period + index * self._step
            self.loads.hold(since, since + self._step)
            assert self.external is not None
            self.external += self.loads.torque(np.ascontiguousarray(x[:, :nv])) / self.plant.substeps
        return torque if x.shape[1] == nv else np.hstack([np.zeros_like(torque), torque])

    def _sensed(self) -> tuple[Array, Array]:
        """What the encoders are fixed to: links, or rotors where they have coordinates of their own."""
        return (self._x[:, -self._nv :], self._w[:, -self._nv :]) if self._motor_side else (self.q, self.v)

    def _note(self, stopped: int) -> bool:
        if stopped:
            self._all_active = False
            self._x = np.where(self.active[:, None], self._x, 0.0)
            self._w = np.where(self.active[:, None], self._w, 0.0)
            if self.sensing is None:
                self._sample = None
        return bool(stopped)

    def _check_springs(self, q: Array) -> None:
        """Refuse springs that the step does not resolve."""
        found = []
        if isinstance(self._mechanics, ElasticMechanics):
            found.append(("drive.stiffness", "gear", self._mechanics.fastest(q)))
        if self._links.stops is not None:
            diagonal = np.diagonal(np.linalg.inv(self._links.mass_matrix(q)), axis1=1, axis2=2)
            found.append(
                ("end_stops.stiffness", "stops", float(np.sqrt((diagonal * self._links.stops.stiffness).max())))
            )
        for name, what, rate in found:
            if rate * self._step > SPRING_ANGLE:
                least = int(np.ceil(rate * self.period / SPRING_ANGLE))
                raise ParameterError(
                    name,
                    f"the {what} swing at {rate:.4g} rad/s at q(0), too fast for steps of {self._step:.3g} s; take at "
                    f"least {least} substeps, or soften them",
                )


def _view(array: Array) -> Array:
    view = array.view()
    view.setflags(write=False)
    return view
