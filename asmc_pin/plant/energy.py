"""Where the energy of a run went."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.plant.plant import Plant
from asmc_pin.plant.run_record import Rollout
from asmc_pin.plant.world.end_stops import StopForces
from asmc_pin.rigid_body.mass_matrix import mass_matrices


def mechanical_energy(arm: Arm, q: Array, v: Array) -> Array:
    """Kinetic and potential energy, the potential being that of the heights above the base.

    Args:
        arm: The arm.
        q: Shape (..., nv), rad.
        v: Shape (..., nv), rad/s.

    Returns:
        Shape (...), J; NaN where the state is.
    """
    q, v = np.broadcast_arrays(np.asarray(q, dtype=np.float64), np.asarray(v, dtype=np.float64))
    # Not Pinocchio's kinetic energy: whether it counts the armature depends on the model.
    kinetic = 0.5 * np.einsum("...i,...ij,...j->...", v, mass_matrices(arm.tree, q), v)
    data, joints = arm.model.createData(), arm.tree.coupling.joints(q)
    potential = np.full(kinetic.shape, np.nan)
    for index in np.ndindex(kinetic.shape):
        if np.isfinite(q[index]).all():
            potential[index] = pin.computePotentialEnergy(arm.model, data, np.array(joints[index]))
    return np.asarray(kinetic + potential)


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Energy since t = 0, each of shape (batch, T), J; `stored` + `dissipated` = `supplied` up to `residual`.

    Attributes:
        stored: Mechanical energy of the arm and its end stops, less that at t = 0.
        supplied: Work of the drives.
        external: Work of the disturbances.
        dissipated: Heat of joint friction, positive.
        added: Energy that came and went with the payload.
        residual: supplied + external + added − stored − dissipated: the error of the integration, the loss in end stops
            with damping, and what a mean over a period says wrongly about torques that change within it.
    """

    stored: Array
    supplied: Array
    external: Array
    dissipated: Array
    added: Array

    @property
    def residual(self) -> Array:
        """What is unaccounted for, J."""
        return np.asarray(self.supplied + self.external + self.added - self.stored - self.dissipated)

    @property
    def turnover(self) -> Array:
        """All energy that has changed hands up to each tick, to judge the residual by, (batch, T), J."""
        flows = (self.supplied, self.external, self.dissipated, self.stored)
        changes = sum(np.abs(np.diff(flow, axis=1, prepend=0.0)) for flow in flows)
        return np.asarray(np.cumsum(changes, axis=1))


def energy_balance(plant: Plant, run: Rollout, trials: tuple[int, ...] | None = None) -> EnergyBalance:
    """Account for the energy of a run from its record.

    Args:
        plant: The plant that it ran on, with rigid gears: an elastic one stores energy that the record does not show.
        run: What happened.
        trials: Numbers of its trials, if they were not 0, 1, …; they matter where parameters scatter.

    Raises:
        ParameterError: not every tick of the run is logged.
    """
    run.need_every_tick("its energy is")
    plant = plant.for_trials(range(len(run.status)) if trials is None else trials)
    batch = len(run.status)
    moved = np.diff(run.q, axis=1)

    def work(torque: Array) -> Array:
        done = np.sum(torque[:, :-1] * moved, axis=2)
        return np.concatenate([np.zeros((batch, 1)), np.cumsum(done, axis=1)], axis=1)

    energy, added = _stored(plant, run)
    return EnergyBalance(
        stored=energy - energy[:, :1],
        supplied=work(run.torque),
        external=work(run.external_torque),
        dissipated=-work(run.friction_torque),
        added=added,
    )


def stored_energy(plant: Plant, run: Rollout, trials: tuple[int, ...] | None = None) -> Array:
    """Kinetic and potential energy of a run, with what the arm carries at the time, and of its end stops.

    Args:
        plant: The plant that it ran on.
        run: What happened.
        trials: Numbers of its trials, if they were not 0, 1, ….

    Returns:
        Shape (batch, T), J; NaN after a divergence.

    Raises:
        ParameterError: not every tick of the run is logged.
    """
    run.need_every_tick("its energy is")
    return _stored(plant.for_trials(range(len(run.status)) if trials is None else trials), run)[0]


def _stored(plant: Plant, run: Rollout) -> tuple[Array, Array]:
    """Stored energy, and what came with payloads since t = 0, each (batch, T), J."""
    batch, ticks, _ = run.q.shape
    energy, added = np.empty((batch, ticks)), np.zeros((batch, ticks))
    changes = sorted({round(change.time / run.period) for change in plant.payload_changes} - {0})
    begins = [0, *(k for k in changes if k < ticks)]
    for begin, end in zip(begins, [*begins[1:], ticks - 1], strict=True):
        arms = plant.arms_at(begin * run.period, run.period)
        for trial in range(batch):
            arm, span = arms[trial % len(arms)], slice(begin, end + 1)
            part = mechanical_energy(arm, run.q[trial, span], run.v[trial, span])
            if begin:
                added[trial, begin:] += part[0] - energy[trial, begin]
            energy[trial, span] = part
    if plant.end_stops is not None:
        energy = energy + StopForces(plant.end_stops, plant.arm.lower, plant.arm.upper).energy(run.q)
    return energy, added
