"""The compiled dynamics of an arm, held against Pinocchio's before they are used."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.errors import ParameterError
from asmc_pin.rigid_body.dynamics import Bodies, bodies_of, dynamics

TOLERANCE = 1e-12
"""How far M, C v + g and forward dynamics may be from Pinocchio's, relative to the terms that they are made of."""
STATES = 4

_held: WeakKeyDictionary[Arm, Bodies] = WeakKeyDictionary()


def no_recursion(arm: Arm) -> str | None:
    """Why the compiled recursion does not have an arm, in words; None if it does."""
    return "joints that mimic others" if arm.mimics else None


def held_bodies(arm: Arm) -> Bodies:
    """The arm as compiled code takes it, held against Pinocchio's crba, nonLinearEffects and aba when first asked for.

    Raises:
        ParameterError: they differ by more than `TOLERANCE`.
    """
    if arm not in _held:
        bodies = bodies_of(arm.tree)
        worst = difference_from_pinocchio(arm, bodies)
        if not worst <= TOLERANCE:
            raise ParameterError(
                "engine",
                f"'compiled' computes the dynamics of {arm.name} {worst:.2g} away from Pinocchio's, relative to their "
                f"size, where {TOLERANCE:g} is allowed; take 'pinocchio'",
            )
        _held[arm] = bodies
    return _held[arm]


def difference_from_pinocchio(arm: Arm, bodies: Bodies) -> float:
    """The largest difference of M, C v + g and forward dynamics at seeded states, relative to the terms in them."""
    q, v, torque = np.random.default_rng(0).uniform(-2.0, 2.0, (3, STATES, arm.nv))
    mass, bias = dynamics(bodies, q, v)
    expected_mass, expected_bias = arm.mass_matrix(q), arm.bias(q, v)
    root = np.sqrt(np.diagonal(expected_mass, axis1=1, axis2=2))
    found = np.abs(mass - expected_mass) / (root[:, :, None] * root[:, None, :])
    # By what the sums are made of, not by what they come to: a joint that nothing loads has a bias of rounding alone.
    weight = np.sqrt(arm.tree.mass.sum()) * np.linalg.norm(arm.model.gravity.linear)
    turning = np.sum(root * np.abs(v), axis=1) * np.sum(np.abs(v), axis=1)
    worst = max(float(found.max()), _relative(bias - expected_bias, root * (weight + turning)[:, None]))
    data = arm.model.createData()
    for k in range(STATES):
        acceleration = np.array(pin.aba(arm.model, data, q[k], v[k], torque[k]))
        terms = np.abs(mass[k]) @ np.abs(acceleration) + np.abs(bias[k]) + np.abs(torque[k])
        worst = max(worst, _relative(mass[k] @ acceleration + bias[k] - torque[k], terms))
    return worst


def _relative(difference: Array, terms: Array) -> float:
    size = np.max(terms, axis=-1, keepdims=True)
    return float(np.max(np.abs(difference) / np.maximum(size, np.finfo(np.float64).tiny)))
