"""How slow a loop may run: stability, error and noise as its period, its filter or its delay changes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.sampled.error_prediction import drift_error
from asmc_pin.sampled.linear_map import spectral_radius
from asmc_pin.sampled.noise.noise_response import noise_rms
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace

_POINTS = 17
_SAMPLES = 12
_SPAN = 32.0  # times the period, both ways
_LOWEST_HZ, _NYQUIST = 1.0, 0.5
_LONGEST_DELAY = 8.0  # periods


@dataclass(frozen=True, eq=False)
class LoopCurve:
    """A loop along one of its parameters, the worst of some configurations at each value.

    Attributes:
        name: What varies: "period" (s), "filter_hz" (Hz) or "delay" (periods).
        values: Shape (count,), ascending.
        here: The loop's own value; None for a filter that is absent.
        radius: Spectral radius, shape (count,).
        drift_error: |e| while the load drifts at `drift`, shape (count, nv), rad; NaN where the loop is unstable.
        torque_rms: Torque noise, shape (count, nv), N·m; NaN where the loop is unstable, None without noise.
    """

    name: str
    values: Array
    here: float | None
    radius: Array
    drift_error: Array
    torque_rms: Array | None

    @property
    def stable(self) -> BoolArray:
        """Where no configuration that was looked at is unstable, shape (count,), of bool."""
        return np.asarray(self.radius < 1.0)


@dataclass(frozen=True, eq=False)
class LoopCurves:
    """The three curves of a loop.

    Attributes:
        loop: Gains and timing.
        drift: Rate at which the load drifts, shape (nv,), N·m/s.
        curves: By what varies.
        configurations: How many were looked at, with gravity's stiffness and without.
    """

    loop: SampledLoop
    drift: Array
    curves: tuple[LoopCurve, ...]
    configurations: int


def loop_curves(
    workspaces: list[Workspace], loop: SampledLoop, drift: Array, sensor: LoopSensor | None, worst_q: list[Array]
) -> LoopCurves:
    """Curves over period, filter and delay.

    Args:
        workspaces: The inertia alone, and about rest under gravity where that acts.
        loop: Gains and timing.
        drift: Rate at which the load on each joint drifts, shape (nv,), N·m/s.
        sensor: For the noise; None, or one that is perfect, for none.
        worst_q: Configurations to look at besides samples, each (nv,).
    """
    looked_at = []
    for space in workspaces:
        mass, stiffness = space.frozen(np.concatenate([space.at(np.array(worst_q)), space.points[:_SAMPLES]]))
        looked_at.append((mass, stiffness, space.viscous))

    def along(name: str, values: Array, member: Callable[[float], SampledLoop], here: float | None) -> LoopCurve:
        radius, error, noise = [], [], []
        for value in map(float, values):
            other = member(value)
            radius.append(
                max(
                    float(spectral_radius(mass, other, viscous=viscous, stiffness=stiffness).max())
                    for mass, stiffness, viscous in looked_at
                )
            )
            bad = radius[-1] >= 1.0
            error.append(np.full(loop.nv, np.nan) if bad else np.abs(drift_error(other, drift)))
            if sensor is not None and sensor.noisy:
                mass, stiffness, viscous = looked_at[-1]
                rms, _ = noise_rms(mass, other, sensor, viscous=viscous, stiffness=stiffness)
                noise.append(np.full(loop.nv, np.nan) if bad else rms.max(axis=0))
        return LoopCurve(name, values, here, np.array(radius), np.array(error), np.array(noise) if noise else None)

    periods = loop.period * np.geomspace(1.0 / _SPAN, _SPAN, 2 * _POINTS - 1)
    corners = np.geomspace(_LOWEST_HZ, _NYQUIST / loop.period, _POINTS)
    delays = np.linspace(0.0, max(_LONGEST_DELAY, 2.0 * loop.delay), _POINTS)
    return LoopCurves(
        loop=loop,
        drift=np.asarray(drift),
        curves=(
            along("period", periods, lambda x: replace(loop, period=x), loop.period),
            along("filter_hz", corners, lambda x: replace(loop, filter_hz=x), loop.filter_hz),
            along("delay", delays, lambda x: replace(loop, delay=x), loop.delay),
        ),
        configurations=len(looked_at[0][0]),
    )
