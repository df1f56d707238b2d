"""How much torque the sensors' noise may take, and the low-pass with which gains keep to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.noise.noise_response import noise_rms
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace

SLACK = 1.01
"""The search asks for this much less noise, so that what is found afterwards is what was asked for."""

_SAMPLES = 128
_FINEST = 0.02  # of a joint's range: a variance is flat about its maximum
_FIRST = 4
_CORNERS = (0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002)  # of the control rate


@dataclass
class NoiseBudget:
    """A limit on the RMS of each drive's torque that comes of the sensors' noise.

    Attributes:
        space: Where the arm works; about rest under gravity, if that acts.
        sensor: What the drives report.
        limit: RMS that may be, shape (nv,), N·m.
    """

    space: Workspace
    sensor: LoopSensor
    limit: Array

    def __post_init__(self) -> None:
        """Begin with a few samples."""
        self.points = self.space.points[:_FIRST]
        self._frozen = self.space.frozen(self.points)

    def share(self, loop: SampledLoop) -> float:
        """Largest part of its budget that a joint takes, at the points that decide; inf for an unstable loop."""
        mass, stiffness = self._frozen
        return float(self._shares(mass, stiffness, loop).max())

    def keeps(self, loop: SampledLoop) -> bool:
        """Whether a loop keeps to the budget at the points that decide."""
        return self.share(loop) <= 1.0 / SLACK

    def holds(self, loop: SampledLoop) -> bool:
        """The same, where a search of the workspace leads; its end is one of the points that decide from then on."""
        space = self.space.thinned(_SAMPLES, _FINEST)

        def shares(points: Array) -> Array:
            return self._shares(*space.frozen(points), loop)

        worst, point, _ = space.maximise(shares, shares(space.points))
        self.take_in(point[None])
        return worst <= 1.0

    def take_in(self, points: Array) -> None:
        """Let more points decide, shape (count, …)."""
        self.points = np.unique(np.concatenate([points, self.points]), axis=0)
        self._frozen = self.space.frozen(self.points)

    def _shares(self, mass: Array, stiffness: Array | None, loop: SampledLoop) -> Array:
        rms, _ = noise_rms(mass, loop, self.sensor, viscous=self.space.viscous, stiffness=stiffness)
        return np.asarray((rms / self.limit).max(axis=-1))


def budget_of(limit: ArrayLike | None, sensor: LoopSensor | None, space: Workspace) -> NoiseBudget | None:
    """A budget from what a caller gives; None for none.

    Args:
        limit: RMS of torque per joint, a scalar or nv values, N·m.
        sensor: What the drives report.
        space: Where the arm works.

    Raises:
        ParameterError: It is not positive or finite, has a wrong size, or no noise is named that it could be about.
    """
    if limit is None:
        return None
    nv = space.arms.nv
    try:
        values = np.array(np.broadcast_to(np.asarray(limit, dtype=np.float64), (nv,)))
    except (TypeError, ValueError):
        raise ParameterError("noise_budget", f"got {limit!r}; expected a number or {nv} of them, in N·m") from None
    if not (np.isfinite(values).all() and (values > 0.0).all()):
        raise ParameterError("noise_budget", f"got {values.tolist()}; every value must be finite and above 0, in N·m")
    if sensor is None or not sensor.noisy:
        raise ParameterError("noise_budget", "needs to know the noise: name encoder bits, velocity or torque noise")
    return NoiseBudget(space, sensor, values)


def filtered(unit: SampledLoop) -> list[SampledLoop]:
    """A loop without a low-pass on q̈, and with lower and lower ones; only itself where it has one already."""
    if unit.filter_hz is not None:
        return [unit]
    return [unit, *(replace(unit, filter_hz=float(f"{corner / unit.period:.2g}")) for corner in _CORNERS)]
