"""The drive's torque over one integration step, compiled for a batch."""

from __future__ import annotations

from asmc_pin._typing import Array, BoolArray
from asmc_pin.numerics.short_loops import short_loops


@short_loops
def _available(speed: float, limit: float, corner: float, no_load: float) -> float:
    """Torque that is there to push at a speed in its own direction, N·m."""
    if speed <= corner:
        return limit
    if speed >= no_load:
        return 0.0
    return limit * (no_load - speed) / (no_load - corner)


@short_loops
def joint_torque(
    recent: float,
    older: float,
    older_share: float,
    current: float,
    remaining: float,
    mean_remaining: float,
    limit: float,
    velocity: float,
    corner: float,
    no_load: float,
    speed_limit: float,
    foldback: float,
) -> tuple[float, float]:
    """Mean torque of one joint's drive over a step, and what its current loop carries after it; see `drive_torque`."""
    asked = recent
    if older_share > 0.0:
        asked = (1.0 - older_share) * asked + older_share * older
    gap = current - asked
    given = asked + mean_remaining * gap
    speed = velocity if given >= 0.0 else -velocity
    if speed > corner:
        bound = _available(speed, limit, corner, no_load)
        given = min(max(given, -bound), bound)
    if speed > (1.0 - foldback) * speed_limit:
        given *= max(0.0, (speed_limit - speed) / (foldback * speed_limit))
    return given, asked + remaining * gap


@short_loops
def drive_torque(
    recent: Array,
    older: Array,
    older_share: float,
    current: Array,
    remaining: Array,
    mean_remaining: Array,
    limit: Array,
    velocity: Array,
    corner: Array,
    no_load: Array,
    speed_limit: Array,
    foldback: float,
    active: BoolArray,
    torque: Array,
    total: Array,
) -> None:
    """Mean torque that the drives apply over one step, and the state of their current loops after it.

    Args:
        recent: Command that acts at the end of the step, within its limit. Shape (batch, nv), N·m.
        older: Command that still acts at its beginning.
        older_share: Part of the step in which `older` acts, 0 to 1.
        current: What the current loops carry, as torque, (batch, nv), N·m; written: after the step.
        remaining: exp(−h/T) of each loop, shape (nv,); 0 for an ideal one.
        mean_remaining: Mean of exp(−t/T) over the step, shape (nv,).
        limit: Torque limits, (batch, nv), N·m.
        velocity: Of the motors, at the start of the step, as joint speeds, (batch, nv), rad/s.
        corner: Shape (nv,), rad/s.
        no_load: Shape (nv,), rad/s; inf without a torque–speed curve.
        speed_limit: Shape (nv,), rad/s; inf for none.
        foldback: Part of the speed limit over which it takes the torque away.
        active: Trials that run, (batch,); the others get 0.
        torque: Written, (batch, nv), N·m.
        total: Added to, (batch, nv), N·m.
    """
    for trial in range(recent.shape[0]):
        for i in range(recent.shape[1]):
            if not active[trial]:
                torque[trial, i] = 0.0
                continue
            given, current[trial, i] = joint_torque(
                recent[trial, i],
                older[trial, i],
                older_share,
                current[trial, i],
                remaining[i],
                mean_remaining[i],
                limit[trial, i],
                velocity[trial, i],
                corner[i],
                no_load[i],
                speed_limit[i],
                foldback,
            )
            torque[trial, i] = given
            total[trial, i] += given
