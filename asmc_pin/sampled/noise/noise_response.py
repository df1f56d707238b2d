"""How torque and error of a sampled loop answer to noise and to rounding of its readings, by its linear map."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.sampled.linear_map import ClosedLoop, closed_loop
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.sampled_loop import SampledLoop

_DOUBLINGS = 26  # 2**26 ticks: loops that take longer to forget count as unstable


_BLOCK = 64  # ticks


_BLOCKS = 4096


def noise_rms(
    mass: Array,
    loop: SampledLoop,
    sensor: LoopSensor,
    *,
    viscous: Array | None = None,
    stiffness: Array | None = None,
) -> tuple[Array, Array]:
    """RMS of torque and error under the sensors' noise, rounding taken as noise of variance Δ²/12.

    Args:
        mass: M, shape (..., nv, nv), kg·m².
        loop: Gains and timing.
        sensor: The sensors.
        viscous: Viscous friction, shape (nv,), N·m·s/rad.
        stiffness: ∂g/∂q, shape (..., nv, nv), N·m/rad.

    Returns:
        RMS of the commanded torque, N·m, and of the error, rad, each of shape (..., nv); inf for an unstable loop.
    """
    system = closed_loop(mass, loop, viscous=viscous, stiffness=stiffness, sensed=True)
    variance = {
        "angle": sensor.angle_noise**2 + sensor.count**2 / 12.0,
        "rate": sensor.rate_noise**2,
        "report": (sensor.torque_noise / loop.mbar) ** 2,
    }
    entered = np.concatenate([system.sensed[name] * np.sqrt(size) for name, size in variance.items()], axis=-1)
    covariance, settled = stationary_covariance(system.matrix, entered @ np.swapaxes(entered, -1, -2))
    torque = np.einsum("...ij,...jk,...ik->...i", system.drive, covariance, system.drive)
    error = np.diagonal(covariance, axis1=-2, axis2=-1)[..., system.blocks["q"]]
    torque_rms, error_rms = loop.mbar * np.sqrt(np.maximum(torque, 0.0)), np.sqrt(np.maximum(error, 0.0))
    known = settled[..., None]
    return np.where(known, torque_rms, np.inf), np.where(known, error_rms, np.inf)


def stationary_covariance(matrix: Array, entered: Array) -> tuple[Array, BoolArray]:
    """X = F X Fᵀ + W by doubling: X ← X + F X Fᵀ, then F ← F².

    A sum of terms that are not negative, so it keeps its digits where poles are near 1 and the state mixes rad with
    rad/s²; scipy's ``solve_discrete_lyapunov`` loses 4 % on a UR5 at 4 kHz there, and goes matrix by matrix.

    Args:
        matrix: F, shape (..., N, N).
        entered: W, symmetric and not negative, shape (..., N, N).

    Returns:
        X, shape (..., N, N), and whether it settled, shape (...); it does not for a spectral radius of 1 or more.
    """
    power, total = matrix, entered
    settled = np.zeros(matrix.shape[:-2], dtype=np.bool_)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(_DOUBLINGS):
            more = power @ total @ np.swapaxes(power, -1, -2)
            total = total + more
            size = np.abs(np.diagonal(total, axis1=-2, axis2=-1))
            new = np.abs(np.diagonal(more, axis1=-2, axis2=-1))
            settled = np.asarray((new <= 1e-12 * size).all(axis=-1) & np.isfinite(size).all(axis=-1))
            if (settled | ~np.isfinite(size).all(axis=-1)).all():
                break
            power = power @ power
    return total, settled


def rounding_bound(
    mass: Array,
    loop: SampledLoop,
    count: Array,
    *,
    viscous: Array | None = None,
    stiffness: Array | None = None,
) -> tuple[Array, Array]:
    """Largest torque and error that rounding can cause: half a count times Σ|impulse response|, over all joints.

    Args:
        mass: M, shape (..., nv, nv), kg·m².
        loop: Gains and timing.
        count: Δq at the joint, shape (nv,), rad (m).
        viscous: As of `noise_rms`.
        stiffness: As of `noise_rms`.

    Returns:
        Torque, N·m, and error, rad, each of shape (..., nv); inf for a loop that does not forget within 262144 ticks.
    """
    system = closed_loop(mass, loop, viscous=viscous, stiffness=stiffness, sensed=True)
    seen, leap = _outputs_over_a_block(system, loop)
    state = system.sensed["angle"] * (0.5 * count)
    total = np.zeros((*seen.shape[:-2], 2 * loop.nv))
    for _ in range(_BLOCKS):
        response = np.abs(seen @ state).sum(axis=-1)
        added = response.reshape(*response.shape[:-1], _BLOCK, 2 * loop.nv).sum(axis=-2)
        total += added
        if (added <= 1e-9 * total).all() or not np.isfinite(total).all():
            break
        state = leap @ state
    total = np.where(added <= 1e-6 * total, total, np.inf)
    return total[..., : loop.nv], total[..., loop.nv :]


def _outputs_over_a_block(system: ClosedLoop, loop: SampledLoop) -> tuple[Array, Array]:
    """Rows that give torque and error at each tick of a block from the state at its beginning, and F over a block."""
    size = system.matrix.shape[-1]
    error = np.broadcast_to(np.eye(size)[system.blocks["q"]], system.drive.shape)
    rows = np.concatenate([loop.mbar[:, None] * system.drive, error], axis=-2)
    stacked = []
    for _ in range(_BLOCK):
        stacked.append(rows)
        rows = rows @ system.matrix
    return np.concatenate(stacked, axis=-2), np.linalg.matrix_power(system.matrix, _BLOCK)
