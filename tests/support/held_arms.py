"""The nonlinear sampled arm held at rest: many configurations, each on its own arm, in one run of the plant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms import Arm
from asmc_pin.controllers import CONTROLLERS, Sample, Setpoint
from asmc_pin.engine import rollout
from asmc_pin.plant import Drive, Friction, Plant
from asmc_pin.sampled import SampledLoop
from asmc_pin.sampled.frozen_arms import FrozenArms


@dataclass(frozen=True)
class Held:
    """PPC about a set-point of each trial's own, on drives that give `factor` times the torque they report."""

    law: Any
    q: Array
    factor: float

    @property
    def period(self) -> float:
        return self.law.period

    def init(self, sample: Sample) -> Any:
        return self.law.init(self._seen(sample))

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        torque, state = self.law.step(state, self._seen(sample), setpoint)
        return self.factor * torque, state

    def _seen(self, sample: Sample) -> Sample:
        return Sample(sample.q - self.q, sample.v, sample.torque / self.factor)


@dataclass(frozen=True)
class Zero:
    """No motion."""

    nv: int
    duration: float = math.inf

    def evaluate(self, t: Array) -> Setpoint:
        zero = np.zeros((t.size, self.nv))
        return Setpoint(zero, zero, zero)


def held_arms(arms: FrozenArms, points: Array) -> list[Arm]:
    """The arm of each point; without gravity where only the inertia is looked at."""
    made: dict[bytes, Arm] = {}
    found = []
    for point in points:
        what = np.delete(point, slice(1, 1 + arms.nv))  # all but q
        key = what.tobytes()
        if key not in made:
            arm = arms.arm_of(point)
            made[key] = arm if point[-1] > 0.0 else arm.replace(gravity=(0.0, 0.0, 0.0))
        found.append(made[key])
    return found


def grow(
    arms: Sequence[Arm], q: Array, loop: SampledLoop, seconds: float, *, factor: float = 1.0, delay: float = 0.0
) -> BoolArray:
    """Which of the trials that start some 1e-7 rad off their set-points are further away later on than earlier.

    Args:
        arms: The arm of each trial.
        q: Its set-point, shape (batch, nv), rad.
        loop: Gains and timing.
        seconds: How long.
        factor: True over reported torque.
        delay: Delay that comes on top, periods.
    """
    law = CONTROLLERS["ppc"](
        mbar=loop.mbar, ks=loop.ks, beta=float(loop.beta[0]), period=loop.period,
        acceleration=loop.acceleration, filter_hz=loop.filter_hz,
    )  # fmt: skip
    nv = q.shape[1]
    plant = Plant(
        arms if len(set(map(id, arms))) > 1 else arms[0],
        friction=Friction(0.0, 0.0),
        effort_limit=np.full(nv, np.inf),
        drive=Drive(delay=loop.delay + delay),
    )
    # Off in all directions, so that every mode is struck.
    off = 1e-7 * np.random.default_rng(5).choice([-1.0, 1.0], q.shape)
    run = rollout(plant, Held(law, q, factor), Zero(nv), seconds, batch=len(q), q0=q + off, v0=np.zeros(q.shape))
    angle, velocity = run.q - q[:, None], run.v
    found = []
    for i, status in enumerate(run.status):
        e, v = angle[i], velocity[i]
        size = np.sum(e**2 / np.mean(e**2) + v**2 / np.mean(v**2), axis=1)
        half = len(size) // 2
        early, late = np.mean(size[half // 2 : half]), np.mean(size[half:])
        # Below 1e-8 of the start it is rounding that lives on.
        found.append(status == "diverged" or bool(late > early and late > 1e-8 * size.max()))
    return np.array(found)


def later(loop: SampledLoop, delay: float) -> SampledLoop:
    """The loop with delay on top."""
    return replace(loop, delay=loop.delay + delay)
