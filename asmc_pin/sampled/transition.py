"""One control period of an arm with constant inertia under held torque: exact, or as the plant's substeps do it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

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
        substeps: None for the exact solution; else the number of steps of the plant's "semi_implicit" scheme. A change
            of command within one is averaged over it.
    """
    n = mbar.size
    inverse = np.asarray(np.linalg.inv(mass), dtype=np.float64)
    generator = np.zeros((*np.shape(mass)[:-2], 2 * n, 2 * n))
    generator[..., :n, n:] = np.eye(n)
    if viscous is not None:
        generator[..., n:, n:] = -inverse * np.broadcast_to(np.asarray(viscous, dtype=np.float64), (n,))
    if stiffness is not None:
        generator[..., n:, :n] = -inverse @ stiffness
    if substeps is not None:
        state, recent, older, load = _midpoint_steps(generator, inverse, period, fraction, substeps)
    else:
        state, load = _exact(generator, inverse, period)
        recent, older = load, np.zeros_like(load)
        if fraction:
            rest, recent = _exact(generator, inverse, (1.0 - fraction) * period)
            older = rest @ _exact(generator, inverse, fraction * period)[1]
    return Transition(state, recent * mbar, older * mbar, load)


def _exact(generator: Array, inverse: Array, span: float) -> tuple[Array, Array]:
    """State and torque response over a span of constant torque: exp(Gh) and ∫₀ʰ exp(Gs) ds · [0; M⁻¹].

    A Taylor series of the integral on a span halved until it converges fast, then doubled back: batched, where
    scipy's expm goes matrix by matrix. Without friction and stiffness G² = 0 and two terms are exact.
    """
    n = inverse.shape[-1]
    size = float(np.abs(generator).sum(axis=-1).max()) * span
    halvings = max(0, math.ceil(math.log2(size / 0.25))) if size > 0.25 else 0
    h = span / 2**halvings
    term = h * np.broadcast_to(np.eye(2 * n), generator.shape)
    integral = term
    for k in range(2, 14):  # 0.25¹³/13! is 2e-18
        term = (h / k) * (generator @ term)
        if not term.any():
            break
        integral = integral + term
    state = np.eye(2 * n) + generator @ integral
    for _ in range(halvings):
        integral = integral + state @ integral
        state = state @ state
    return state, integral[..., :, n:] @ inverse


def _midpoint_steps(
    generator: Array, inverse: Array, period: float, fraction: float, substeps: int
) -> tuple[Array, Array, Array, Array]:
    """As the plant's "semi_implicit" scheme: half a drift, a kick with friction at its end, half a drift."""
    n, h = inverse.shape[-1], period / substeps
    identity = np.broadcast_to(np.eye(2 * n), generator.shape)
    half_drift = np.eye(2 * n)
    half_drift[:n, n:] = 0.5 * h * np.eye(n)
    # v⁺ = (I + h M⁻¹D)⁻¹ (v + h M⁻¹(τ − G q))
    implicit, explicit = np.array(identity), np.array(identity)
    implicit[..., n:, n:] -= h * generator[..., n:, n:]
    explicit[..., n:, :n] += h * generator[..., n:, :n]
    push = np.zeros((*inverse.shape[:-2], 2 * n, n))
    push[..., n:, :] = h * inverse
    one = half_drift @ np.linalg.solve(implicit, explicit @ half_drift)
    push = half_drift @ np.linalg.solve(implicit, push)
    state, recent, older = identity, np.zeros_like(push), np.zeros_like(push)
    for i in range(substeps):
        old_share = min(max(fraction * substeps - i, 0.0), 1.0)
        state = one @ state
        recent = one @ recent + (1.0 - old_share) * push
        older = one @ older + old_share * push
    return state, recent, older, recent + older
