"""Weighted least squares of the torque model, within what physics allows, and how sure the estimates are.

Residuals of a log are correlated in time, through the filter and through all that the model leaves out, so the plain
covariance of least squares is far too small. Here it is the sandwich A⁻¹ B A⁻¹ with B summed over lags (Newey, West
(1987), Econometrica 55(3)), its bandwidth from the residuals' own correlation (Andrews (1991), Econometrica 59(3)).
Joints at one instant count as one observation, whatever they share.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.identification.possible_body import LastBody, payload_entries
from asmc_pin.identification.torque_model import LEAST, PAYLOAD, TorqueModel

_STEPS = 40


@dataclass(frozen=True, eq=False)
class Fit:
    """Estimates.

    Attributes:
        model: What was fitted.
        values: All parameters, estimated or not, shape (P,).
        free: Which were estimated, shape (P,).
        covariance: Of the values, shape (P, P); 0 where not estimated.
        sigma: RMS of each joint's residual over the rows that were fitted, shape (nv,), N·m.
        rows: Rows that were fitted, shape (R, nv).
        lags: Bandwidth of the covariance, rows.
        impossible: What the fit would be if the last body needed not be possible; None where it is so anyway.
    """

    model: TorqueModel
    values: Array
    free: BoolArray
    covariance: Array
    sigma: Array
    rows: BoolArray
    lags: float
    impossible: Array | None = None

    @property
    def deviation(self) -> Array:
        """Standard deviations, shape (P,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def residual(self) -> Array:
        """Logged − model torque at all rows, shape (R, nv), N·m."""
        return self.model.residual(self.values)[0]


def fit(model: TorqueModel, rows: BoolArray, free: BoolArray, start: Array | None = None) -> Fit:
    """Estimate the free parameters from some rows, within what physics allows.

    Where the payload that explains the log best takes more from the last body than there is, everything is estimated
    again under the condition that this body is possible; the covariance then is that of the same parameters at the
    estimate on the bound, so that no interval is the narrower for it.

    Args:
        model: The model.
        rows: Which count, shape (R, nv).
        free: Which parameters are estimated, shape (P,).
        start: Where to begin, and the values of all others; those of the URDF when omitted.
    """
    found, body = _fitted(model, rows, free, start, None), LastBody.of(model.arm)
    if body.is_possible(model, found.values):
        return found
    begin = found.values.copy()
    begin[[model.index(name) for name in PAYLOAD]] = 0.0
    return replace(_fitted(model, rows, free, begin, body), impossible=found.values)


def _fitted(model: TorqueModel, rows: BoolArray, free: BoolArray, start: Array | None, body: LastBody | None) -> Fit:
    values = model.start() if start is None else start.copy()
    places = np.flatnonzero(free).astype(np.int64)
    lower, upper = allowed_values(model, places)
    values[places] = np.clip(values[places], lower, upper)
    within = None if body is None else (body, payload_entries(model, places))
    residual, jacobian = model.residual(values)
    sigma = _spread(residual - _means(residual, rows), rows)
    for _ in range(_STEPS):
        step = _bounded_step(jacobian[:, :, places], residual, sigma, rows, (lower, upper), values[places], within)
        before, cost = values[places].copy(), _cost(residual, sigma, rows)
        for share in (1.0, 0.5, 0.25, 0.1, 0.02):
            values[places] = np.clip(before + share * step, lower, upper)
            residual, jacobian = model.residual(values)
            if _cost(residual, sigma, rows) <= cost * (1.0 + 1e-9):
                break
        new = _spread(residual, rows)
        still = bool(np.all(np.abs(new - sigma) < 1e-4 * sigma))
        sigma = new
        if still and np.all(np.abs(values[places] - before) < 1e-5 * (1.0 + np.abs(before))):
            break
    covariance, lags = sandwich(jacobian[:, :, places], residual, sigma, rows)
    whole = np.zeros((len(values), len(values)))
    whole[np.ix_(places, places)] = covariance
    return Fit(model, values, free, whole, sigma, rows, lags)


def _bounded_step(
    jacobian: Array,
    residual: Array,
    sigma: Array,
    rows: BoolArray,
    ends: tuple[Array, Array],
    at: Array,
    within: tuple[LastBody, list[int | None]] | None,
) -> Array:
    """Gauss and Newton's step, within the bounds and where asked for to a possible body, on the normal equations."""
    scaled = np.where(rows[..., None], jacobian / sigma[:, None], 0.0).reshape(-1, jacobian.shape[2])
    left = np.where(rows, residual / sigma, 0.0).reshape(-1)
    normal, right = scaled.T @ scaled, -scaled.T @ left
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    # A trace of Levenberg's damping: what the log does not tell stays where it is.
    normal = normal / np.outer(size, size) + 1e-9 * np.eye(len(size))
    factor = np.linalg.cholesky(normal).T
    target = np.asarray(np.linalg.solve(factor.T, right / size), dtype=np.float64)
    limits = (ends[0] - at) * size - 1e-12, (ends[1] - at) * size + 1e-12
    if within is not None:
        body, payload = within
        return body.step(factor, target, limits, size, payload, at) / size
    found = lsq_linear(factor, target, limits, method="bvls", max_iter=200)
    return np.asarray(found.x / size)


def _cost(residual: Array, sigma: Array, rows: BoolArray) -> float:
    return float(np.sum(((residual / sigma)[rows]) ** 2))


def allowed_values(model: TorqueModel, places: IntArray) -> tuple[Array, Array]:
    """Least and greatest values that parameters may have."""
    kinds = [model.names[i].split(":")[0] for i in places]
    lower = np.array([LEAST.get(kind, -np.inf) for kind in kinds])
    upper = np.full(len(kinds), np.inf)
    for k, kind in enumerate(kinds):
        if kind == "stribeck_velocity":
            lower[k], upper[k] = 0.005, 1.0
        if kind == "delay":
            lower[k], upper[k] = -0.1, 0.1
    return lower, upper


def sandwich(jacobian: Array, residual: Array, sigma: Array, rows: BoolArray) -> tuple[Array, float]:
    """Covariance of weighted least squares with residuals that are correlated in time.

    Args:
        jacobian: Of the residual, shape (R, nv, p).
        residual: Shape (R, nv).
        sigma: Shape (nv,).
        rows: Shape (R, nv).

    Returns:
        The covariance, shape (p, p), and the bandwidth in rows.
    """
    count = jacobian.shape[2]
    scaled = np.where(rows[..., None], jacobian / sigma[:, None], 0.0)
    length = np.sqrt(np.einsum("tjp,tjp->p", scaled, scaled))
    told = length > 1e-9 * length.max(initial=1e-300)  # a parameter without any effect has no interval
    scaled = scaled[..., told]
    left = np.where(rows, residual / sigma, 0.0)
    bread = np.einsum("tjp,tjq->pq", scaled, scaled)
    size = np.sqrt(np.maximum(np.diag(bread), 1e-300))
    inverse = np.linalg.pinv(bread / np.outer(size, size), rcond=1e-12, hermitian=True)
    scores = np.einsum("tjp,tj->tp", scaled, left) / size
    lags = _bandwidth(scores)
    middle = _long_run(scores, lags)
    # As many observations are lost as parameters were fitted; correlated rows are worth fewer.
    worth = np.maximum(rows.any(axis=1).sum() / max(lags, 1.0), 2.0)
    lost = told.sum() / residual.shape[1]
    inner = inverse @ middle @ inverse / np.outer(size, size) * worth / max(worth - lost, 1.0)
    whole = np.zeros((count, count))
    whole[np.ix_(told, told)] = inner
    return whole, lags


def _long_run(scores: Array, lags: float) -> Array:
    """Σ_l w(l) Γ_l, with Parzen's weights: positive semidefinite."""
    total = scores.T @ scores
    for lag in range(1, min(int(lags) + 1, len(scores) - 1)):
        x = lag / (lags + 1.0)
        weight = 1.0 - 6.0 * x**2 + 6.0 * x**3 if x <= 0.5 else 2.0 * (1.0 - x) ** 3
        cross = scores[lag:].T @ scores[:-lag]
        total += weight * (cross + cross.T)
    return np.asarray(total)


def _bandwidth(scores: Array) -> float:
    """Andrews' plug-in for Parzen's kernel, from first-order autoregressions of the scores."""
    one, other = scores[:-1], scores[1:]
    rho = np.sum(one * other, axis=0) / np.maximum(np.sum(one**2, axis=0), 1e-300)
    rho = np.clip(rho, 0.0, 0.97)
    power = np.sum((other - rho * one) ** 2, axis=0) ** 2
    top = np.sum(4.0 * rho**2 * power / (1.0 - rho) ** 8)
    alpha = top / np.maximum(np.sum(power / (1.0 - rho) ** 4), 1e-300)
    return float(np.clip(2.6614 * (alpha * len(scores)) ** 0.2, 4.0, len(scores) / 8.0))


def _spread(residual: Array, rows: BoolArray) -> Array:
    masked = np.where(rows, residual, np.nan)
    return np.asarray(np.maximum(np.sqrt(np.nanmean(masked**2, axis=0)), 1e-9))


def _means(residual: Array, rows: BoolArray) -> Array:
    return np.asarray(np.nanmean(np.where(rows, residual, np.nan), axis=0))
