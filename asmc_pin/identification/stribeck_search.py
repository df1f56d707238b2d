"""Whether a joint's friction falls with speed, and over which: a search joint by joint before everything is fitted."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.identification.torque_model import TorqueModel

SPEEDS = (0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3)
"""Stribeck velocities that are tried, rad/s."""

_EVIDENCE = 1.02  # by how much the residual has to be larger without it, as a ratio of RMS


def stribeck_speeds(model: TorqueModel, rows: BoolArray, values: Array) -> tuple[Array, Array]:
    """The Stribeck velocity of each joint that explains its torque best, the other parameters about where they are.

    Args:
        model: The model.
        rows: Rows that count, shape (R, nv).
        values: Estimates without it.

    Returns:
        Velocities, shape (nv,), rad/s, NaN where none is worth having; and the weakening there, N·m.
    """
    nv = model.arm.nv
    residual, jacobian = model.residual(values)
    found, weakening = np.full(nv, np.nan), np.zeros(nv)
    best = np.full(nv, np.inf)
    own = [[model.index(kind, j) for kind in ("coulomb", "viscous", "torque_offset", "armature")] for j in range(nv)]
    plain = np.array([_left(jacobian[rows[:, j], j][:, own[j]], residual[rows[:, j], j])[0] for j in range(nv)])
    for speed in SPEEDS:
        share, _ = model.weakening(np.full(nv, speed))
        for j in range(nv):
            columns = np.column_stack([jacobian[rows[:, j], j][:, own[j]], -share[rows[:, j], j]])
            left, step = _left(columns, residual[rows[:, j], j])
            if left < best[j]:
                best[j], found[j], weakening[j] = left, speed, step[-1]
    worth = (plain / best > _EVIDENCE**2) & (weakening > 0.0)
    return np.where(worth, found, np.nan), np.where(worth, weakening, 0.0)


def _left(columns: Array, residual: Array) -> tuple[float, Array]:
    """Mean square that the columns leave of a residual, and the step along them."""
    step = np.linalg.lstsq(columns, -residual, rcond=None)[0]
    return float(np.mean((residual + columns @ step) ** 2)), np.asarray(step)
