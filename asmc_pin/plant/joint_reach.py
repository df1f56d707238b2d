"""How far the joints of a run come, noted at every tick, so that it is known whatever is logged of the run."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.numerics.short_loops import inlined, short_loops
from asmc_pin.plant.plant_parameters import PlantParameters
from asmc_pin.plant.run_record import LimitViolation

LIMIT_SLACK = 1e-9
"""Beyond a joint limit by less than this, rad (m), is round-off of a trajectory that touches it."""

# Rows of a trial's reach: the joints' position limits, the lowest and the highest angle of all ticks so far, and the
# tick at which a joint was first outside; −1 for never.
LOWER, UPPER, LOWEST, HIGHEST, LEFT_AT = range(5)


def no_reach(plant: PlantParameters, batch: int) -> Array:
    """The reach of trials that have not begun, (batch, 5, nv)."""
    reach = np.empty((batch, 5, plant.arm.nv))
    for row, side in ((LOWER, "lower"), (UPPER, "upper")):
        reach[:, row] = np.array([getattr(arm, side) for arm in plant.arms])
    reach[:, LOWEST], reach[:, HIGHEST], reach[:, LEFT_AT] = np.inf, -np.inf, -1.0
    return reach


@inlined
def reached(reach: Array, q: Array, k: int) -> None:
    """Take in where one trial, (5, nv), is at a tick."""
    for i in range(q.size):
        outside = False  # for the first time only where it is as far as never before
        if q[i] < reach[LOWEST, i]:
            reach[LOWEST, i] = q[i]
            outside = reach[LOWER, i] - q[i] > LIMIT_SLACK
        if q[i] > reach[HIGHEST, i]:
            reach[HIGHEST, i] = q[i]
            outside = outside or q[i] - reach[UPPER, i] > LIMIT_SLACK
        if outside and reach[LEFT_AT, i] < 0.0:
            reach[LEFT_AT, i] = k


@short_loops
def all_reached(reach: Array, q: Array, k: int, active: BoolArray) -> None:
    """Take in where the trials that run are at a tick, (batch, nv)."""
    for trial in range(q.shape[0]):
        if active[trial]:
            reached(reach[trial], q[trial], k)


def outside_limits(joint_names: tuple[str, ...], period: float, reach: Array) -> tuple[LimitViolation, ...]:
    """Every joint that left its limits, joint by joint, then trial by trial.

    Args:
        joint_names: Names of the joints.
        period: Control period, s.
        reach: Of all trials, (batch, 5, nv).
    """
    found = []
    for joint, name in enumerate(joint_names):
        for trial in np.flatnonzero(reach[:, LEFT_AT, joint] >= 0.0).tolist():
            one = reach[trial, :, joint]
            above, below = one[HIGHEST] - one[UPPER], one[LOWER] - one[LOWEST]
            excess = above if above >= below else -below
            found.append(LimitViolation(trial, name, float(one[LEFT_AT] * period), float(excess)))
    return tuple(found)
