"""Estimates as a user reads them: breakaway, centre of mass and delay with intervals, from what was fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.identification.possible_body import LastBody
from asmc_pin.identification.torque_model import LEAST
from asmc_pin.identification.weighted_fit import Fit

WIDTH = 2.0
"""Standard deviations on each side, for 95 %: Student's t of some sixty independent pieces of a log."""

_UNITS = {
    "coulomb": "N·m",
    "viscous": "N·m·s/rad",
    "breakaway": "N·m",
    "stribeck_velocity": "rad/s",
    "armature": "kg·m²",
    "torque_constant": "",
    "torque_offset": "N·m",
    "payload.mass": "kg",
    "payload.com.x": "m",
    "payload.com.y": "m",
    "payload.com.z": "m",
    "delay": "s",
}


@dataclass(frozen=True)
class Estimate:
    """A value with its interval of 95 %."""

    low: float
    value: float
    high: float

    def as_dict(self) -> dict[str, float]:
        """The three figures by name."""
        return {"low": self.low, "value": self.value, "high": self.high}


def unit_of(name: str) -> str:
    """Unit of an estimate; of joints that slide N, N·s/m, m/s and kg."""
    return _UNITS.get(name) or _UNITS.get(name.split(".")[0], "")


def estimates(fit: Fit) -> dict[str, Estimate]:
    """All that was estimated, by ``kind.joint``, ``payload.mass``, ``payload.com.x`` … and ``delay``."""
    found: dict[str, Estimate] = {}
    model, free, values, covariance = fit.model, fit.free, fit.values, fit.covariance
    for i in np.flatnonzero(free):
        kind, _, joint = model.names[i].partition(":")
        if kind == "weakening":
            j = model.arm.joint_names.index(joint)
            first = model.index("coulomb", j)
            spread = covariance[i, i] + covariance[first, first] + 2.0 * covariance[i, first]
            found[f"breakaway.{joint}"] = around(values[i] + values[first], spread, 0.0)
        elif kind.startswith("payload.moment"):
            continue
        else:
            found[f"{kind}.{joint}" if joint else kind] = around(values[i], covariance[i, i], _least(fit, kind))
    mass = model.index("payload.mass")
    if free[mass] and abs(values[mass]) > 1e-6:
        for axis in "xyz":
            place = model.index(f"payload.moment.{axis}")
            if not free[place]:
                continue
            centre = values[place] / values[mass]
            slope = np.array([1.0, -centre]) / values[mass]
            both = covariance[np.ix_([place, mass], [place, mass])]
            found[f"payload.com.{axis}"] = around(centre, float(slope @ both @ slope))
    return found


def _least(fit: Fit, kind: str) -> float | None:
    """What cannot be less, by physics: no more can be missing than the last body weighs."""
    if kind == "payload.mass":
        return -LastBody.of(fit.model.arm).mass
    return LEAST.get(kind, 0.0 if kind == "stribeck_velocity" else None)


def around(value: float, variance: float, least: float | None = None) -> Estimate:
    """A value with its interval of 95 % by its variance, which ends at the least that there can be."""
    half = WIDTH * float(np.sqrt(max(variance, 0.0)))
    low = value - half
    return Estimate(float(low if least is None else max(low, least)), float(value), float(value + half))


def correlation_time(residual: Array, rows: BoolArray) -> Array:
    """How many rows of each joint's residual are worth one, (nv,): 1 for white noise; rows in a row only."""
    found = []
    for j in range(residual.shape[1]):
        inside = np.where(rows[:, j], residual[:, j], 0.0)
        counts = rows[:, j].astype(np.float64)
        power = float(np.sum(inside**2) / max(counts.sum(), 1.0))
        total = 1.0
        for lag in range(1, len(inside) // 4):
            pairs = float(np.sum(counts[lag:] * counts[:-lag]))
            rho = float(np.sum(inside[lag:] * inside[:-lag])) / max(pairs, 1.0) / max(power, 1e-300)
            if rho < 0.05:
                break
            total += 2.0 * rho
        found.append(total)
    return np.array(found)
