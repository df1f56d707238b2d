"""When a real robot would have stopped: at the first torque, change of torque or speed beyond what it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.metrics.metric_registry import ROUNDING, MetricSettings, TripLimits, held_torque, metric, torque_steps

if TYPE_CHECKING:
    from asmc_pin.engine import Rollout


@dataclass(frozen=True, slots=True)
class Trip:
    """A joint beyond a limit at which a robot stops.

    Attributes:
        trial: Index of the trial.
        joint: Index of the joint.
        quantity: Field of `TripLimits`.
        value: What was reached, N·m, N·m/s or rad/s.
        limit: What the robot takes.
        time: When, s.
    """

    trial: int
    joint: int
    quantity: str
    value: float
    limit: float
    time: float


@metric(
    "Would have tripped at",
    "time",
    "the first t_k with |τ_k| or |τ_k − τ_{k−1}| / L (k < T−1) or |q̇_k| beyond what `plant.limits` publishes, at the "
    "latest when the trial diverged; not defined (NaN) where it never was, or no robot is named",
    "published limits of robots: docs/plant.md",
    of_diverged=True,
)
def trip_time(rollout: Rollout, settings: MetricSettings) -> Array:
    """When a joint would first have stopped the robot that the experiment names; a trial that diverged did."""
    if not settings.trips.judged:
        return np.full((rollout.q.shape[0], rollout.q.shape[2]), np.nan)
    found = [_first_time(rollout, name, values, limit) for name, values, limit in _judged(rollout, settings.trips)]
    diverged = np.asarray(rollout.status) != "ok"
    found.append(np.where(diverged, rollout.end_time, np.inf)[:, None])
    first = np.minimum.reduce(np.broadcast_arrays(*found))
    return np.where(np.isfinite(first), first, np.nan)


def first_trip(rollout: Rollout, limits: TripLimits) -> Trip | None:
    """The first limit that any trial of a run is beyond, or None.

    Args:
        rollout: What the plant did.
        limits: What the robot takes.

    Raises:
        ParameterError: not every tick of the run is logged.
    """
    rollout.need_every_tick("trips are")
    found: list[tuple[float, float, Trip]] = []
    for name, values, limit in _judged(rollout, limits):
        times = _first_time(rollout, name, values, limit)
        at = np.array(times.argmin())
        trial, joint = (int(x) for x in np.unravel_index(at, times.shape))
        time = float(times[trial, joint])
        if np.isfinite(time):
            k = int(np.argmax(_beyond(values[trial, :, joint], limit[joint])))
            value, most = float(values[trial, k, joint]), float(limit[joint])
            found.append((time, -value / most, Trip(trial, joint, name, value, most, time)))
    return min(found, key=lambda item: item[:2])[2] if found else None


def _judged(rollout: Rollout, limits: TripLimits) -> list[tuple[str, Array, Array]]:
    """Quantities with a limit: name, sizes (batch, ticks, nv), and limits (nv,)."""
    nv = rollout.q.shape[2]
    sizes: dict[str, Callable[[], Array]] = {
        "torque": lambda: np.abs(held_torque(rollout)),
        "torque_rate": lambda: torque_steps(rollout) / rollout.period,
        "velocity": lambda: np.abs(rollout.v),
    }
    each = {name: np.broadcast_to(np.asarray(getattr(limits, name), dtype=np.float64), (nv,)) for name in sizes}
    return [(name, size(), each[name]) for name, size in sizes.items() if np.isfinite(each[name]).any()]


def _first_time(rollout: Rollout, name: str, values: Array, limit: Array) -> Array:
    """When each joint is first beyond, shape (batch, nv), s; +∞ for never."""
    beyond = _beyond(values, limit)
    tick = np.argmax(beyond, axis=1) if values.shape[1] else np.zeros((len(values), values.shape[2]), dtype=int)
    late = 1 if name == "torque_rate" else 0  # a change is there at its second tick
    return np.where(beyond.any(axis=1), rollout.time[np.minimum(tick + late, len(rollout.time) - 1)], np.inf)


def _beyond(values: Array, limit: Array) -> BoolArray:
    with np.errstate(invalid="ignore"):  # NaN after a divergence is beyond nothing
        return np.asarray(values > limit * (1.0 + ROUNDING))
