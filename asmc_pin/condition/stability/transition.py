"""One control period of an arm with constant inertia under held torque: exact, or as the plant's substeps do it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from asmc_pin._typing import Array


@dataclass(frozen=True)
class Transition:
    """(q, v) one period on: state·(q, v) + recent·u_recent + older·u_older − load·h.

    Attributes:
        state: Shape (..., 2nv, 2nv).
        recent: Response to the command (u = M̄⁻¹τ, rad/s²) that acts at the end of the period, shape (..., 2nv, nv).
        older: Response to the command that still acts at its beginning; zero unless the delay has a fraction.
        load: Response to a load torque h held over the period, shape (..., 2nv, nv).
    """

    state: Array
    recent: Array
    older: Array
    load: Array


def transition(
    mass: Array,
    mbar: Array,
    period: float,
    *,
    fraction: float = 0.0,
    viscous: ArrayLike | None = None,
    stiffness: Array | None = None,
    substeps: int | None = None,
) -> Transition:
    """Solve M q̈ = M̄u − D q̇ − G q − h over one period.

    Args:
        mass: M, shape (..., nv, nv), kg·m².
        mbar: Diagonal of M̄, shape (nv,), kg·m².
        period: L, s.
        fraction: Share of the period, in [0, 1), during which the older command still acts.
        viscous: D's diagonal, N·m·s/rad.
        stiffness: G, shape (..., nv, nv), N·m/rad.
        substeps: None for the exact solution; else the number of semi-implicit Euler steps. A change of command within
            one is averaged over it.
    """
    n = mbar.size
    inverse = np.asarray(np.linalg.inv(mass), dtype=np.float64)
    generator = np.zeros((*np.shape(mass)[:-2], 2 * n, 2 * n))
    generator[..., :n, n:] = np.eye(n)
    if viscous is not None:
        generator[..., n:, n:] = -inverse * np.broadcast_to(np.asarray(viscous, dtype=np.float64), (n,))
    if stiffness is not None:
        generator[..., n:, :n] = -inverse @ stiffness
    free = viscous is None and stiffness is None
    if substeps is not None:
        state, recent, older, load = _semi_implicit(generator, inverse, period, fraction, substeps)
    else:
        state, load = _exact(generator, inverse, period, free=free)
        if fraction:
            rest, recent = _exact(generator, inverse, (1.0 - fraction) * period, free=free)
            older = rest @ _exact(generator, inverse, fraction * period, free=free)[1]
        else:
            recent, older = load, np.zeros_like(load)
    return Transition(state, recent * mbar, older * mbar, load)


def _exact(generator: Array, inverse: Array, span: float, *, free: bool) -> tuple[Array, Array]:
    """State and torque response over a span of constant torque."""
    n = inverse.shape[-1]
    if free:
        state = np.eye(2 * n) + span * generator
        return state, np.concatenate([0.5 * span**2 * inverse, span * inverse], axis=-2)
    block = np.zeros((*inverse.shape[:-2], 3 * n, 3 * n))
    block[..., : 2 * n, : 2 * n] = generator
    block[..., n : 2 * n, 2 * n :] = inverse
    exponential = np.asarray(expm(span * block), dtype=np.float64)
    return exponential[..., : 2 * n, : 2 * n], exponential[..., : 2 * n, 2 * n :]


def _semi_implicit(
    generator: Array, inverse: Array, period: float, fraction: float, substeps: int
) -> tuple[Array, Array, Array, Array]:
    """As `_exact`, by steps v⁺ = v + h q̈(q, v), q⁺ = q + h v⁺."""
    n, h = inverse.shape[-1], period / substeps
    kick = np.zeros_like(generator)
    kick[..., :, :] = np.eye(2 * n)
    kick[..., n:, :] += h * generator[..., n:, :]
    drift = np.eye(2 * n)
    drift[:n, n:] = h * np.eye(n)
    push = np.zeros((*inverse.shape[:-2], 2 * n, n))
    push[..., n:, :] = h * inverse
    one, push = drift @ kick, drift @ push
    state = np.broadcast_to(np.eye(2 * n), generator.shape)
    recent, older = np.zeros_like(push), np.zeros_like(push)
    for i in range(substeps):
        old_share = min(max(fraction * substeps - i, 0.0), 1.0)
        state = one @ state
        recent = one @ recent + (1.0 - old_share) * push
        older = one @ older + old_share * push
    return state, recent, older, recent + older
