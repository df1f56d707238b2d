"""Drives under way: the commands on their way to the joints, and the current loops."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.plant.drive.compiled_drive import drive_torque
from asmc_pin.plant.drive.drive_parameters import FOLDBACK, Drive
from asmc_pin.plant.per_trial import row


class Actuator:
    """The drives of a batch; `command` once per control tick, then `torque` once per integration step.

    Args:
        drive: The parameters.
        limit: Torque limits, (batch, nv), N·m.
        held: Torque that the drives hold before t = 0, (batch, nv), N·m.
        period: Control period, s.
        substeps: Integration steps per period.
        active: Trials that run, (batch,); read at every step.
    """

    def __init__(
        self, drive: Drive, limit: Array, held: Array, period: float, substeps: int, active: BoolArray
    ) -> None:
        nv = held.shape[1]
        whole = math.floor(drive.delay)
        fraction = drive.delay - whole
        # Oldest first. The last but one is acting while the newest is not there yet: it counts with a fraction only.
        self._commands = deque([held] * (whole + 2), maxlen=whole + 2)
        self.older_share = [min(max(fraction * substeps - i, 0.0), 1.0) for i in range(substeps)]
        steps = row(drive.current_hz, nv, np.inf) * (2.0 * np.pi * period / substeps)  # h/T of each current loop
        self.remaining = np.exp(-steps)
        self.mean_remaining = -np.expm1(-steps) / steps
        self._current = held.copy()
        self._limit, self._active = limit, active
        self.bounds = drive.speed_bounds(nv)
        self._total = np.zeros_like(held)
        self._substeps = substeps

    def command(self, command: Array) -> None:
        """Take the command of a tick, (batch, nv), N·m, within its limits; it is kept, not copied."""
        self._commands.append(command)
        self._total = np.zeros_like(command)

    def torque(self, index: int, velocity: Array) -> Array:
        """Mean torque over integration step `index` of the period, (batch, nv), N·m, at this velocity of the motors."""
        torque = np.empty_like(self._current)
        drive_torque(
            self._commands[1],
            self._commands[0],
            self.older_share[index],
            self._current,
            self.remaining,
            self.mean_remaining,
            self._limit,
            velocity,
            *self.bounds,
            FOLDBACK,
            self._active,
            torque,
            self._total,
        )
        return torque

    def mean(self) -> Array:
        """Time average of the torque over the period, (batch, nv), N·m, once all its steps are taken."""
        return self._total / self._substeps
