r"""The TDE error from tick to tick, and what Lemma 1 says of it.

With E_k = I − M(q_k)⁻¹M̄, h = C q̇ + g − f and the input ũ = u + r that was applied (signals.py), (1) and (7) give

    N_k = E_k N_{k−1} + E_k (ũ_{k−1} − ũ_k) + M_k⁻¹ ((M_{k−1} − M_k) ā_{k−1} + h_{k−1} − h_k).

Lemma 1 asks for ‖E_k‖₂ < 1: what was there shrinks. What comes in each period is of order L where input and load are
smooth, so that N goes to 0 with L. It is not where something jumps, whatever L is: K̂ sgn(s) in ũ by 2k̂ at a change of
sign, Coulomb friction in h where a joint turns round, sticks or breaks away.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm.two_conditions import lemma1_norm
from asmc_pin.engine import Rollout
from asmc_pin.monitors.law_signals import Signals
from asmc_pin.monitors.true_arm import Truth

SWITCHING, FRICTION = "sgn(s) or sat(s)", "friction"


@dataclass(frozen=True, eq=False)
class Contraction:
    """One trial; shapes (T,), NaN where not defined.

    Attributes:
        norm: ‖E_k‖₂.
        size: ‖N_k‖₂, rad/s².
        growth: ‖N_k‖₂ − ‖N_{k−1}‖₂, rad/s².
        carried: ‖E_k N_{k−1}‖₂ / ‖N_{k−1}‖₂: by how much the old error alone shrinks.
        without: The growth if something had not changed in the period, by its name: E_k(x_{k−1} − x_k) taken off N_k,
            for the switching term and each part of r, and M_k⁻¹(f_k − f_{k−1}) for friction.
    """

    norm: Array
    size: Array
    growth: Array
    carried: Array
    without: Mapping[str, Array]


def contraction_of(
    signals: Signals, rollout: Rollout, truth: Truth, mbar: Array, trial: int, weight: float = 1.0
) -> Contraction:
    """Follow N of one trial from tick to tick; M̄'s diagonal has shape (nv,).

    With a low-pass of weight c on the whole estimate the old error is carried by I − cM⁻¹M̄, and the condition is on
    cM̄; what comes in does so through I − M⁻¹M̄ as ever.
    """
    q, friction, error = rollout.q[trial], rollout.friction_torque[trial], signals.error[trial]
    alive = np.isfinite(q).all(axis=1)
    mass = truth.mass(trial, q)
    norm = np.full(len(q), np.nan)
    norm[alive] = lemma1_norm(mass[alive], weight * mbar)

    def accelerated(torque: Array) -> Array:
        """M_k⁻¹ x_k."""
        return np.asarray(np.linalg.solve(mass, torque[..., None])[..., 0])

    def pushed(vector: Array) -> Array:
        """E_k x_k."""
        return vector - accelerated(mbar * vector)

    old = _size(_previous(error))
    size = _size(error)
    terms = {name: part[trial] for name, part in signals.shortfall.items()}
    if signals.switching is not None:
        terms[SWITCHING] = signals.switching[trial]
    without = {name: _size(error - pushed(_previous(x) - x)) - old for name, x in terms.items()}
    without[FRICTION] = _size(error - accelerated(friction - _previous(friction))) - old
    carried = np.full(len(q), np.nan)
    kept = _previous(error)
    np.divide(_size(kept - accelerated(weight * mbar * kept)), old, out=carried, where=old > 0.0)
    return Contraction(norm, size, size - old, carried, without)


def _previous(values: Array) -> Array:
    """x_{k−1} at k; NaN at the first tick."""
    shifted = np.full_like(values, np.nan)
    shifted[1:] = values[:-1]
    return shifted


def _size(vectors: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(vectors**2, axis=-1)))
