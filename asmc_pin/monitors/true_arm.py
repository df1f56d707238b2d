"""Which arm moved in which trial and when: what was picked up or scattered is the plant's to know."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.engine import Rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Plant
from asmc_pin.rigid_body.mass_matrix import mass_matrices

World = Plant | Arm | Sequence[Arm]
"""The plant that a rollout ran on; or its arm, or one per trial, where nothing was picked up or scattered."""


class Truth:
    """Arms and torque limits of a run's trials.

    Args:
        rollout: What happened.
        world: On what.
        trials: Numbers of the trials in the study that they belong to; 0, 1, … when None.
        effort_limit: Torque limits, (nv,) or (batch, nv), N·m; the plant's or the arms' own when None.

    Attributes:
        effort_limit: Shape (batch, nv), N·m.

    Raises:
        ParameterError: the arms are for another number of joints or trials.
    """

    def __init__(
        self,
        rollout: Rollout,
        world: World,
        trials: Sequence[int] | None = None,
        effort_limit: ArrayLike | None = None,
    ) -> None:
        batch, ticks, nv = rollout.q.shape
        self._ticks = ticks
        starts = [0]
        if isinstance(world, Plant):
            plant = world.for_trials(range(batch) if trials is None else trials)
            starts += [round(change.time / rollout.period) for change in plant.payload_changes]
            self._arms = [plant.arms_at(start * rollout.period, rollout.period) for start in starts]
            limit = plant.effort_limit
        else:
            self._arms = [(world,) if isinstance(world, Arm) else tuple(world)]
            limit = np.array([arm.effort_limit for arm in self._arms[0]])
        self._edges = [min(start, ticks) for start in (*starts, ticks)]
        arms = self._arms[0]
        if len(arms) not in (1, batch) or any(arm.nv != nv for arm in arms):
            raise ParameterError("arm", f"expected one arm of {nv} joints, or one for each of {batch} trials")
        given = limit if effort_limit is None else np.asarray(effort_limit, dtype=np.float64)
        self.effort_limit: Array = np.broadcast_to(given, (batch, nv))

    def arms_of(self, trial: int) -> Iterator[tuple[slice, Arm]]:
        """The trial's arms, each with the ticks in which it was the one."""
        for (start, end), arms in zip(pairwise(self._edges), self._arms, strict=True):
            if end > start:
                yield slice(start, end), arms[trial % len(arms)]

    def mass(self, trial: int, q: Array) -> Array:
        """M(q_k), shape (T, nv, nv), kg·m², for q of shape (T, nv); the unit matrix where q is not finite."""
        ticks, nv = q.shape
        alive = np.asarray(np.isfinite(q).all(axis=1))
        mass = np.broadcast_to(np.eye(nv), (ticks, nv, nv)).copy()
        for span, arm in self.arms_of(trial):
            rows = np.flatnonzero(alive[span]) + span.start
            mass[rows] = mass_matrices(arm.tree, np.ascontiguousarray(q[rows]))
        return mass
