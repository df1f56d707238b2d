"""What a log can tell at all: the condition of its regressor, and parameters that it cannot tell apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.identification.torque_model import TorqueModel

WORST_CONDITION = 300.0
"""Of the columns at unit length; beyond it the least told parameter is left where it was."""

# Which of those that cannot be told apart is given up first.
_GIVEN_UP = (
    "torque_constant",
    "armature",
    "torque_offset",
    "viscous",
    "payload.moment.z",
    "payload.moment.y",
    "payload.moment.x",
    "payload.mass",
    "delay",
    "coulomb",
)


@dataclass(frozen=True)
class Confusion:
    """A parameter that was given up, and what it cannot be told from; nothing where the log does not feel it."""

    name: str
    others: tuple[str, ...]


def judged(
    model: TorqueModel, values: Array, sigma: Array, rows: BoolArray, free: BoolArray
) -> tuple[BoolArray, float, list[Confusion]]:
    """Give up parameters until those left can be told apart.

    Args:
        model: The model.
        values: Where it is looked at.
        sigma: Weight of each joint, shape (nv,), N·m.
        rows: Rows that count, shape (R, nv).
        free: What is to be estimated, shape (P,).

    Returns:
        What can be, the condition number of that, and what was given up.
    """
    _, jacobian = model.residual(values)
    free = free.copy()
    confusions: list[Confusion] = []
    scaled = np.where(rows[..., None], jacobian / sigma[:, None], 0.0).reshape(-1, jacobian.shape[2])
    length = np.linalg.norm(scaled, axis=0)
    unfelt = free & (length <= 1e-9 * max(float(length.max()), 1e-300))
    confusions += [Confusion(model.names[place], ()) for place in np.flatnonzero(unfelt)]
    free &= ~unfelt
    while True:
        places = np.flatnonzero(free)
        columns = scaled[:, places] / length[places]
        eigen, directions = np.linalg.eigh(columns.T @ columns)
        condition = float(np.sqrt(eigen[-1] / max(eigen[0], 1e-300)))
        if condition <= WORST_CONDITION or len(places) < 2:
            return free, condition, confusions
        weights = np.abs(directions[:, 0])
        involved = [int(places[k]) for k in np.argsort(-weights) if weights[k] > 0.2 * weights.max()]
        out = min(involved, key=lambda i: (_rank(model.names[i]), involved.index(i)))
        free[out] = False
        confusions.append(Confusion(model.names[out], tuple(model.names[i] for i in involved if i != out)[:4]))


def _rank(name: str) -> int:
    kind = name.split(":")[0]
    return _GIVEN_UP.index(kind) if kind in _GIVEN_UP else len(_GIVEN_UP)
