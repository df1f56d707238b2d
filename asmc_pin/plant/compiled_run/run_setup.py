"""The numbers of a plant that stay during a run in compiled code: its scalars, and rows of parameters of its trials."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.plant.compiled_run.run_rows import (
    BACKWARD,
    BREAK_BACKWARD,
    BREAK_FORWARD,
    BRISTLE,
    BRISTLE_DAMPING,
    CORNER,
    COUNT,
    FORWARD,
    LIMIT,
    MEAN_REMAINING,
    NO_LOAD,
    PLANT_ROWS,
    REMAINING,
    SCALE,
    SCHEMES,
    SPEED_LIMIT,
    STOP_DAMPING,
    STOP_LOWER,
    STOP_STIFFNESS,
    STOP_UPPER,
    VISCOUS,
    Setup,
)
from asmc_pin.plant.drive.drive_parameters import FOLDBACK
from asmc_pin.plant.plant_state import Motion

_FRICTION = {
    FORWARD: "coulomb",
    VISCOUS: "viscous",
    BACKWARD: "coulomb_backward",
    BREAK_FORWARD: "breakaway",
    BREAK_BACKWARD: "breakaway_backward",
    SCALE: "stribeck_velocity",
    BRISTLE_DAMPING: "presliding_damping",
}


def setup_of(motion: Motion, log_every: int) -> Setup:
    """The scalars of a run in which one tick in so many is logged."""
    plant, sensing = motion.plant, motion.sensing
    return Setup(
        period=motion.period,
        step=motion.period / plant.substeps,
        substeps=plant.substeps,
        scheme=SCHEMES[plant.integrator],
        friction=not motion.friction.none,
        constant=plant.friction.constant,
        yields=plant.friction.yields,
        stops=motion.stops is not None,
        shaped=motion.actuator is not None,
        foldback=FOLDBACK,
        senses=sensing is not None,
        exact_velocity=sensing is not None and sensing.exact_velocity,
        keep=1.0 if sensing is None else sensing.keep,
        delay_fraction=0.0 if sensing is None else sensing.fraction,
        speed_bound=plant.speed_bound,
        error_bound=plant.error_bound,
        log_every=log_every,
    )


def plant_rows(motion: Motion) -> Array:
    """The rows of the plant's parameters, (batch, PLANT_ROWS, nv)."""
    batch, nv = motion.q.shape
    rows = np.zeros((batch, PLANT_ROWS, nv))
    rows[:, LIMIT] = motion.limit
    friction = motion.plant.friction
    for row, name in _FRICTION.items():
        rows[:, row] = friction.spread(name, batch, nv)
    if friction.yields:
        rows[:, BRISTLE] = motion.friction.stiffness
    if motion.stops is not None:
        stops = motion.stops
        rows[:, STOP_LOWER], rows[:, STOP_UPPER] = stops.lower, stops.upper
        rows[:, STOP_STIFFNESS], rows[:, STOP_DAMPING] = stops.stiffness, stops.damping
    if motion.actuator is not None:
        actuator = motion.actuator
        rows[:, REMAINING], rows[:, MEAN_REMAINING] = actuator.remaining, actuator.mean_remaining
        rows[:, CORNER], rows[:, NO_LOAD], rows[:, SPEED_LIMIT] = actuator.bounds
    if motion.sensing is not None:
        rows[:, COUNT] = motion.sensing.count
    return rows
