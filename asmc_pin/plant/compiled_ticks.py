"""The passes over a batch that every control tick needs, compiled: numpy calls cost more on a single trial."""

from __future__ import annotations

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray


@njit(cache=True, nogil=True)
def stop_diverged(q: Array, v: Array, q_ref: Array, speed_bound: float, error_bound: float, active: BoolArray) -> int:
    """Clear `active` where a state is not finite, |v| exceeds its bound, or |q − q_ref| exceeds its own.

    Args:
        q: Shape (batch, nv), rad.
        v: Shape (batch, nv), rad/s.
        q_ref: Shape (nv,), rad.
        speed_bound: rad/s.
        error_bound: rad.
        active: Trials that are still integrated, shape (batch,); written.

    Returns:
        How many trials were stopped by this call.
    """
    stopped = 0
    for trial in range(q.shape[0]):
        if not active[trial]:
            continue
        for i in range(q.shape[1]):
            # Written so that NaN fails.
            if not (abs(v[trial, i]) <= speed_bound and abs(q[trial, i] - q_ref[i]) <= error_bound):
                active[trial] = False
                stopped += 1
                break
    return stopped


@njit(cache=True, nogil=True)
def limit_torque(command: Array, limit: Array, active: BoolArray, torque: Array) -> int:
    """Clip a command to the drives' limits, and stop the trials whose command is not finite.

    Args:
        command: What the controller asks for. Shape (batch, nv), N·m.
        limit: Not negative, inf for none. Shape (batch, nv), N·m.
        active: Trials that are still integrated, shape (batch,); written.
        torque: Written: the torque that the drives apply, 0 in stopped trials. Shape (batch, nv), N·m.

    Returns:
        How many trials were stopped by this call.
    """
    stopped = 0
    for trial in range(command.shape[0]):
        finite = True
        for i in range(command.shape[1]):
            finite = finite and np.isfinite(command[trial, i])
        if active[trial] and not finite:
            active[trial] = False
            stopped += 1
        for i in range(command.shape[1]):
            if active[trial]:
                torque[trial, i] = min(max(command[trial, i], -limit[trial, i]), limit[trial, i])
            else:
                torque[trial, i] = 0.0
    return stopped
