"""Ticks that travel with the exported code: what goes in, and what Python says comes out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.codegen.guarded_law import GuardedLaw
from asmc_pin.codegen.translation.c_words import LARGEST
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.words.choices import RealType

_ROUGH_TICKS, _QUIET_TICKS = 300, 12
_FIELDS = ("q", "v", "tau", "q_ref", "v_ref", "a_ref", "tau_out")


@dataclass
class Vectors:
    """Recorded ticks.

    Attributes:
        law: What computes them; its state runs along.
        rows: One a tick: whether it is an init, dt, status, then q, v, τ, q_d, q̇_d, q̈_d and the torque.
    """

    law: GuardedLaw
    rows: list[list[float]] = field(default_factory=list)

    def init(self, told: Array) -> None:
        """Begin anew with q, v and τ of `told`, (6, nv)."""
        self._keep(1.0, 0.0, self.law.init(*told[:3]), told)

    def step(self, told: Array, dt: float) -> None:
        """A tick with sample and set point `told`, (6, nv)."""
        self._keep(0.0, dt, self.law.step(Sample(*told[:3]), Setpoint(*told[3:]), dt), told)

    def csv(self, names: list[str]) -> str:
        """All ticks as CSV; `names` are those of the joints. A number is written so that it is read back as itself."""
        safe = [name.replace(",", "_").replace("\n", "_") for name in names]
        header = ["init", "dt", "status", *(f"{kind} {name}" for kind in _FIELDS for name in safe)]
        return "\n".join([",".join(header), *(",".join(map(_shown, row)) for row in self.rows), ""])

    @property
    def came_to(self) -> Array:
        """The status of every tick, (ticks,)."""
        return np.array([row[2] for row in self.rows])

    @property
    def torques(self) -> Array:
        """The torque of every tick, (ticks, nv), N·m."""
        return np.array([row[-len(self.law.command) :] for row in self.rows])

    def _keep(self, begins: float, dt: float, status: int, told: Array) -> None:
        self.rows.append([begins, dt, float(status), *told.reshape(-1).tolist(), *map(float, self.law.command)])


def number_of(real: RealType) -> Any:
    """Numpy's type of that name."""
    return np.float32 if real == "float" else np.float64


def record_motion(law: GuardedLaw, motion: Array, period: float, real: RealType) -> Vectors:
    """The motion alone, from its first tick on; see `record`."""
    number = number_of(real)
    vectors = Vectors(law)
    vectors.init(motion[0].astype(number).astype(np.float64))
    for told in motion.astype(number).astype(np.float64):
        vectors.step(told, float(number(period)))
    return vectors


def record(law: GuardedLaw, motion: Array, period: float, ticks_of_fault: int, real: RealType) -> Vectors:
    """A motion; rough ticks that saturate; ticks out of order, with two faults.

    Args:
        law: What computes them.
        motion: Samples and set points of a run, (ticks, 6, nv).
        period: L, s.
        ticks_of_fault: From the first tick out of order to the end of the ramp.
        real: Type of the numbers: the ticks are rounded to it, so that C reads what Python had.
    """
    number, dt = number_of(real), float(number_of(real)(period))
    motion = motion.astype(number).astype(np.float64)
    vectors = record_motion(law, motion, period, real)
    rough = _rough(motion, law.command)
    vectors.init(rough[0])
    for told in rough:
        vectors.step(told.astype(number).astype(np.float64), dt)
    _out_of_order(vectors, motion, dt, ticks_of_fault, real)
    return vectors


def _rough(motion: Array, like: Array) -> Array:
    """Samples far from the reference and torques beyond any limit, drawn once for ever."""
    draws = np.random.default_rng(20161130)
    shape = (_ROUGH_TICKS, *like.shape)
    spread = 10.0 ** draws.uniform(-4.0, 0.5, (_ROUGH_TICKS, 1))
    rough = motion[np.arange(_ROUGH_TICKS) % len(motion)].copy()
    for row, size in enumerate((0.3, 1.0, 100.0)):
        rough[:, row] += spread * size * draws.standard_normal(shape)
    return rough


def _out_of_order(vectors: Vectors, motion: Array, dt: float, ticks_of_fault: int, real: RealType) -> None:
    told = _around(motion)
    nan, inf = float("nan"), float("inf")
    vectors.init(next(told))
    # One at a time, with ticks in order between; uneven periods that are still in order among them.
    for wrong in (dt, 0.5 * dt, 1.5 * dt, 1.2 * dt, 0.0, -dt, 2.0 * dt, nan, inf, 0.49 * dt, dt):
        vectors.step(next(told), float(np.float32(wrong)) if real == "float" else wrong)
        vectors.step(next(told), dt)
    for row in range(6):
        for bad in (nan, inf, -inf):
            broken = next(told).copy()
            broken[row, row % broken.shape[1]] = bad
            vectors.step(broken, dt)
            vectors.step(next(told), dt)
    if real == "double":  # in double an overflow is one; single precision overflows elsewhere
        huge = next(told).copy()
        huge[3:] = 0.9 * LARGEST[real]
        huge[0] = -huge[3]
        vectors.step(huge, dt)
        vectors.step(next(told), dt)
    for _ in range(ticks_of_fault + _QUIET_TICKS):
        vectors.step(next(told), nan)
    for _ in range(_QUIET_TICKS):  # a fault stays
        vectors.step(next(told), dt)
    vectors.init(next(told))
    for _ in range(_QUIET_TICKS):
        vectors.step(next(told), dt)
    broken = next(told).copy()
    broken[0] = nan
    vectors.init(broken)
    vectors.step(next(told), dt)
    vectors.init(next(told))
    vectors.step(next(told), dt)


def _around(motion: Array) -> Iterator[Array]:
    """Ticks of the motion from its middle on, again and again."""
    at = len(motion) // 2
    while True:
        yield motion[at % len(motion)]
        at += 1


def _shown(value: float) -> str:
    return repr(value).removesuffix(".0")
