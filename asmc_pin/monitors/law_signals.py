r"""What a law with time-delay estimation asked for and what it got, tick by tick, from a rollout alone.

Discrete quantities; ā_k = (v_{k+1} − v_k)/L is the mean of q̈ over the period [t_k, t_{k+1}), τ_k that of the torque:

    Γ_k = ā_k − M̄⁻¹ τ_k                  (3), the mean of Γ(t) over the period
    Γ̂_k = q̈̂_k − M̄⁻¹ τ_{k−1}             (6), the law's own estimate of q̈(t−L), of the true motion; q̈̂_0 = 0; with
                                         (τ_{k−1} + τ_{k−2})/2 where the law averages two torques
    N_k = Γ_k − Γ̂_k                      the TDE error
    u_k = q̈_d + K_s ė + β s + w_k        the acceleration that the law wants; w its switching term
    r_k = M̄⁻¹ τ_k + Γ̂_k − u_k            how far the torque is from what gives u_k

The mean needs no model, and it is what the sampled loop feels: ā_k = u_k + r_k + N_k, exactly. With ideal sensors and a
drive that applies what it is told, r = 0. Else it is the sum of what the sensors make of u and Γ̂, of what the torque
limits take away, and of what the rest of the drive does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from asmc_pin._typing import Array
from asmc_pin.engine import Rollout
from asmc_pin.monitors.true_arm import Truth, World

SATURATION, NOISE, DRIVE = "saturation", "noise", "drive"


@dataclass(frozen=True, eq=False)
class Signals:
    """Arrays of shape (batch, T, nv); NaN at the last tick, whose period is beyond the run, and after a divergence.

    Attributes:
        s: Sliding variable (4) of the true motion, rad/s.
        gamma: Γ_k, rad/s².
        estimate: Γ̂_k, rad/s².
        error: N_k, rad/s².
        switching: w_k, rad/s²; None for a law that does not say.
        shortfall: r_k by what it comes from (`SATURATION`, `NOISE`, `DRIVE`), rad/s²; empty where it does not say w.
    """

    s: Array
    gamma: Array
    estimate: Array
    error: Array
    switching: Array | None
    shortfall: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class _View:
    """What a law makes of one account of the motion, the true one or the measured one."""

    s: Array
    estimate: Array
    switching: Array | None
    wanted: Array | None


def signals_of(rollout: Rollout, law: Any, mbar: Array, effort_limit: Array) -> Signals:
    """The quantities above.

    Args:
        rollout: What happened.
        law: The law, with ``ks`` and ``beta`` where it has them, and what it says of its estimate of q̈(t−L).
        mbar: Diagonal of M̄, shape (nv,), kg·m².
        effort_limit: Torque limits, shape (batch, nv), N·m; inf where there is none.
    """
    acceleration = np.full_like(rollout.v, np.nan)
    acceleration[:, :-1] = np.diff(rollout.v, axis=1) / rollout.period
    gamma = acceleration - rollout.torque / mbar
    before = np.concatenate([rollout.held_torque[:, None], rollout.torque[:, :-1]], axis=1)
    # Two torques are averaged where v is a difference of angles: of the true motion, it is that of the true angles.
    rate = rollout.v
    if getattr(law, "averages_torque", False):
        rate = _differences(rollout.q, rollout.v, rollout.period)
    true = _view(rollout, law, mbar, rollout.q, rollout.v, rate, before)
    shortfall: dict[str, Array] = {}
    if true.wanted is not None:
        told = true
        if not rollout.ideal_sensor:
            seen = rollout.v_measured
            told = _view(rollout, law, mbar, rollout.q_measured, seen, seen, rollout.torque_measured)
        assert told.wanted is not None
        command = mbar * (told.wanted - told.estimate)
        limited = np.clip(command, -effort_limit[:, None], effort_limit[:, None])
        shortfall = {
            SATURATION: (limited - command) / mbar,
            NOISE: (told.wanted - true.wanted) - (told.estimate - true.estimate),
            DRIVE: (rollout.torque - limited) / mbar,
        }
    return Signals(true.s, gamma, true.estimate, gamma - true.estimate, true.switching, shortfall)


def _view(rollout: Rollout, law: Any, mbar: Array, q: Array, v: Array, slope: Array, before: Array) -> _View:
    """One account of the motion; `slope` is the velocity of which the estimate of q̈(t−L) is a difference."""
    rate = rollout.v_ref - v
    s = rate + getattr(law, "ks", np.nan) * (rollout.q_ref - q)
    if getattr(law, "averages_torque", False):
        before = 0.5 * (before + np.concatenate([before[:, :1], before[:, :-1]], axis=1))
    estimate = _low_passed(estimated_acceleration(q, slope, rollout.period, law) - before / mbar, law)
    switching = switching_term(law, s, rollout.gain)
    wanted = None if switching is None else rollout.a_ref + law.ks * rate + law.beta * s + switching
    return _View(s, estimate, switching, wanted)


def estimated_acceleration(q: Array, v: Array, period: float, law: Any) -> Array:
    """The law's estimate of q̈(t−L) at each tick; see `asmc_pin.controllers.TdeLaw`.

    Args:
        q: Shape (batch, T, nv), rad.
        v: Shape (batch, T, nv), rad/s.
        period: L, s.
        law: ``acceleration`` and ``filter_weight`` are read where it has them.

    Returns:
        Shape (batch, T, nv), rad/s²; 0 at the first tick.
    """
    rate = v
    if getattr(law, "acceleration", "velocity") == "position":
        rate = _differences(q, v, period)
    estimate = np.zeros_like(v)
    estimate[:, 1:] = np.diff(rate, axis=1) / period
    weight = getattr(law, "filter_weight", 1.0)
    if weight == 1.0:
        return estimate
    filtered: Array = lfilter([weight], [1.0, weight - 1.0], estimate, axis=1)
    return filtered


def _low_passed(estimate: Array, law: Any) -> Array:
    """Γ̂ through the law's low-pass on the whole of it, which starts from the first one."""
    weight = getattr(law, "estimate_weight", 1.0)
    if weight == 1.0:
        return estimate
    first = (1.0 - weight) * estimate[:, :1]
    filtered: Array = lfilter([weight], [1.0, weight - 1.0], estimate, axis=1, zi=first)[0]
    return filtered


def _differences(q: Array, v: Array, period: float) -> Array:
    """Velocities as the backward differences of the angles, v(0) at the first tick."""
    return np.concatenate([v[:, :1], np.diff(q, axis=1) / period], axis=1)


def switching_term(law: Any, s: Array, gain: Array) -> Array | None:
    """w, what the law adds to PPC; None for a law that does not say. See `asmc_pin.controllers.TdeLaw`."""
    said: Array | None = law.switching_term(s, gain) if hasattr(law, "switching_term") else None
    return said


def gamma_at_ticks(rollout: Rollout, arm: World, law: Any) -> Array:
    """Γ(t_k) as (1) and (3) have it, right after the tick: M⁻¹(τ_k + f_k − C q̇ − g) − M̄⁻¹ τ_k at q_k and v_k.

    For comparison with the mean Γ_k: they differ by what q̈ does within the period, of order L where nothing switches.
    Friction f_k and the disturbances' torque are the logged means over the period: at rest friction has no value of its
    own.

    Args:
        rollout: What happened.
        arm: The arm that it happened to, or the plant.
        law: Has ``mbar``.

    Returns:
        Shape (batch, T, nv), rad/s².
    """
    truth = Truth(rollout, arm)
    whole = np.empty_like(rollout.q)
    torque = rollout.torque + rollout.friction_torque + rollout.external_torque
    for trial in range(len(whole)):
        for span, body in truth.arms_of(trial):
            state = rollout.q[trial, span], rollout.v[trial, span], torque[trial, span]
            whole[trial, span] = body.forward_dynamics(*state)
    return np.asarray(whole - rollout.torque / law.mbar)
