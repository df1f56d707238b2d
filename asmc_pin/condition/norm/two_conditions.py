"""The two conditions on given inertia matrices: Lemma 1 of Baek (2016), and the weaker weighted one.

They are different conditions and have different numbers; nothing in the package presents one as the other.
"""

from __future__ import annotations

from typing import get_args

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.errors import NotPositiveDefinite, ParameterError
from asmc_pin.numerics.float_range import LARGEST, SMALLEST
from asmc_pin.words.choices import Condition as Condition

CONDITIONS: tuple[Condition, ...] = get_args(Condition)


def lemma1_norm(mass: Array, mbar: Array) -> Array:
    r"""Contraction factor of the time-delay estimation error, ‖I − M(q)⁻¹ M̄‖₂.

    Below 1 at every configuration of a motion, the estimation error stays bounded (Baek 2016, Lemma 1). The 2-norm
    mixes joint units: on an arm with both revolute and prismatic joints, scale the coordinates first.

    Args:
        mass: Joint-space inertia M(q), symmetric positive definite, armature included. Shape (..., nv, nv), kg·m².
        mbar: Diagonal of M̄. Shape (nv,) or (..., nv), kg·m², every entry positive.

    Returns:
        The norm, shape (...), dimensionless.

    Raises:
        NotPositiveDefinite: carries the index of the first such matrix and its smallest eigenvalue.
        ParameterError: A shape does not fit, an entry is not finite, M is not symmetric or M̄ not positive.
    """
    return _figure(compiled_norms.LEMMA1, mass, mbar)


def weighted_norm(mass: Array, mbar: Array) -> Array:
    r"""Contraction factor of the same error in the constant weighting M̄^½: max|1 − λ(M(q)⁻¹ M̄)|.

    Below 1 exactly when M̄ ≺ 2M. A common weighting makes every step a contraction, so the error stays bounded here
    too, although ‖I − M⁻¹M̄‖₂ may exceed 1: this is weaker than Lemma 1, which implies it. It does not depend on the
    units of the joints.

    Args:
        mass: As for `lemma1_norm`.
        mbar: As for `lemma1_norm`.

    Returns:
        The norm, shape (...), dimensionless, never above `lemma1_norm` of the same matrices.

    Raises:
        NotPositiveDefinite: carries the index of the first such matrix and its smallest eigenvalue.
        ParameterError: As for `lemma1_norm`.
    """
    return _figure(compiled_norms.WEIGHTED, mass, mbar)


def _figure(kind: int, mass: Array, mbar: Array) -> Array:
    mass = np.asarray(mass, dtype=np.float64)
    if mass.ndim < 2 or mass.shape[-1] != mass.shape[-2] or mass.shape[-1] == 0:
        raise ParameterError("mass", f"shape {mass.shape} given, (..., nv, nv) expected")
    nv = mass.shape[-1]
    mbar = np.asarray(mbar, dtype=np.float64)
    if mbar.ndim == 0 or mbar.shape[-1] != nv:
        raise ParameterError("mbar", f"shape {mbar.shape} given, (..., {nv}) expected: one value per joint of M")
    _positive(mbar)
    if not np.all(np.isfinite(mass)):
        raise ParameterError("mass", "it has an entry that is not finite")
    scale = np.abs(mass).max(axis=(-2, -1), keepdims=True, initial=0.0)
    if np.any(np.abs(mass - np.swapaxes(mass, -2, -1)) > 1e-8 * scale):
        raise ParameterError("mass", "it is not symmetric; give the joint-space inertia M(q)")
    try:
        lead = np.broadcast_shapes(mass.shape[:-2], mbar.shape[:-1])
    except ValueError:
        raise ParameterError("mbar", f"shape {mbar.shape} does not go with masses of shape {mass.shape}") from None
    flat = np.ascontiguousarray(np.broadcast_to(mass, (*lead, nv, nv)).reshape(-1, nv, nv))
    out = np.empty(len(flat))
    compiled_norms.figures_of_masses(
        kind, flat, np.ascontiguousarray(np.broadcast_to(mbar, (*lead, nv)).reshape(-1, nv)), out
    )
    bad = np.flatnonzero(np.isnan(out))
    if bad.size:
        index = tuple(int(i) for i in np.unravel_index(bad[0], lead)) if lead else ()
        raise NotPositiveDefinite(index, float(np.linalg.eigvalsh(flat[bad[0]])[0]))
    return out.reshape(lead)


def _positive(mbar: Array) -> None:
    for fits, expected in (
        (np.isfinite(mbar) & (mbar > 0.0), "positive and finite"),
        ((mbar >= SMALLEST) & (mbar <= LARGEST), f"between {SMALLEST:g} and {LARGEST:g} kg·m²"),
    ):
        bad = np.argwhere(~fits)
        if bad.size:
            index = tuple(int(i) for i in bad[0])
            raise ParameterError("mbar", f"{mbar[index]:g} at index {index[-1]}: every entry must be {expected}")


def check_mbar(mbar: object, nv: int) -> Array:
    """M̄ of an arm as nv positive values; one value counts for all joints.

    Args:
        mbar: A number, or nv of them, kg·m².
        nv: Number of joints.

    Returns:
        Read-only, shape (nv,).

    Raises:
        ParameterError: Wrong number of values, or one that is not a positive finite number.
    """
    try:
        values = np.array(mbar, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("mbar", f"{mbar!r} given, one number or {nv} numbers expected") from None
    if values.ndim == 0:
        values = np.full(nv, values)
    if values.shape != (nv,):
        given = f"{values.size} values" if values.ndim == 1 else f"shape {values.shape}"
        raise ParameterError("mbar", f"{given} given, {nv} expected: one per joint, base to tip")
    _positive(values)
    values.setflags(write=False)
    return values


def check_condition(condition: str) -> Condition:
    """The condition's name, checked."""
    for known in CONDITIONS:
        if condition == known:
            return known
    raise ParameterError("condition", f"'{condition}' given, one of {', '.join(CONDITIONS)} expected")
