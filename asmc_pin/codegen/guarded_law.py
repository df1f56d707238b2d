"""What the exported code does around a law, in Python: limits, ticks that are not in order, faults.

Written apart from the C and held against it tick by tick; the law itself is the compiled step that comparisons run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.codegen.first_state import FirstRow
from asmc_pin.codegen.python_precision import in_python
from asmc_pin.controllers.one_trial.compiled_law import CompiledLaw, run_step
from asmc_pin.controllers.one_trial.trial_step import WORK_ROWS, Tick
from asmc_pin.controllers.protocol import Sample, Setpoint

OK, LIMITED, BAD_TIME, BAD_INPUT, BAD_RESULT, FAULT = range(6)
"""What a tick comes to; the numbers of the exported status."""


@dataclass(frozen=True)
class Guard:
    """What stands around a law; arrays (nv,), N·m.

    Attributes:
        period: L, s.
        torque_limit: Largest size of the torque, finite.
        torque_step: Largest change from tick to tick, finite.
        safe_torque: Where a fault leads to.
        fault_ticks: Ticks in a row that are not in order and make a fault.
        ramp_ticks: Ticks from a fault to the safe torque.
    """

    period: float
    torque_limit: Array
    torque_step: Array
    safe_torque: Array
    fault_ticks: int
    ramp_ticks: int

    @property
    def longest_ramp(self) -> int:
        """Ticks from a fault to the safe torque at most, from a limit and with no step above the largest."""
        steps = np.ceil((self.torque_limit + np.abs(self.safe_torque)) / self.torque_step)
        return int(max(self.ramp_ticks, steps.max()))


class GuardedLaw:
    """A law within its guard, for one arm.

    Args:
        law: The law.
        guard: What stands around it.
        first: Its memory before the first tick.
        period_row: Row of its parameters that is the period, for which the time since the last tick stands.
        number: Type of the numbers: numba's compiled step computes in float64, float32 is computed by Python.
    """

    def __init__(
        self,
        law: CompiledLaw,
        guard: Guard,
        first: Sequence[FirstRow],
        period_row: int | None,
        number: Any = np.float64,
    ) -> None:
        nv = len(guard.torque_limit)
        self._law, self._first, self._period_row, self._number = law, first, period_row, number
        self._rows = law.law_rows(nv)[0].astype(number)
        self._limit, self._step, self._safe = (
            x.astype(number) for x in (guard.torque_limit, guard.torque_step, guard.safe_torque)
        )
        self._period, self._shortest, self._longest = (number(part * guard.period) for part in (1.0, 0.5, 1.5))
        self._guard = guard
        self._written: Callable[..., None] | None = None
        if number is not np.float64 and law.trial_step is not None:
            self._written = in_python(law.trial_step.function)
        self.memory = np.zeros((len(first), nv), dtype=number)
        self.command = self._safe.copy()
        self._ticks = self._bad = 0
        self._missed, self._ramp_left, self._fault = number(0.0), 1, True

    def init(self, q: Array, v: Array, tau: Array) -> int:
        """The state before the first tick; BAD_INPUT leaves it faulted at the safe torque."""
        finite = bool(np.isfinite([q, v, tau]).all())
        q, v, tau = (np.asarray(x, dtype=self._number) for x in (q, v, tau))
        if finite:
            with np.errstate(all="ignore"):
                self.memory = np.array([row.value(q, v, tau) for row in self._first], dtype=self._number)
            self.command = _cut(tau, -self._limit, self._limit)
        else:
            self.memory = np.zeros_like(self.memory)
            self.command = self._safe.copy()
        self._ticks = self._bad = 0
        self._missed, self._ramp_left, self._fault = self._number(0.0), 1, not finite
        return OK if finite else BAD_INPUT

    def step(self, sample: Sample, setpoint: Setpoint, dt: float) -> int:
        """A tick; `command` is what is to be held until the next. Arrays of shape (nv,)."""
        told = (sample.q, sample.v, sample.torque, setpoint.q, setpoint.v, setpoint.a)
        fields = np.array(told, dtype=self._number)
        elapsed = self._number(dt)
        timely = bool(self._shortest <= elapsed <= self._longest)
        status, memory, asked = OK, self.memory, self.command
        if self._fault:
            status = FAULT
        elif not timely:
            status = BAD_TIME
        elif not np.isfinite(fields).all():
            status = BAD_INPUT
        else:
            memory, asked = self._law_step(fields, self._missed + elapsed)
            if not (np.isfinite(asked).all() and np.isfinite(memory).all()):
                status = BAD_RESULT
        if status == OK:
            slowed = _cut(asked, self.command - self._step, self.command + self._step)
            given = _cut(slowed, -self._limit, self._limit)
            status = OK if (given == asked).all() else LIMITED
            self.command, self.memory = given, memory
            self._missed, self._bad, self._ticks = self._number(0.0), 0, self._ticks + 1
            return status
        if status != FAULT:
            self._missed += elapsed if timely else self._period
            self._bad += 1
            if self._bad < self._guard.fault_ticks:
                return status
            self._fault, self._ramp_left = True, self._guard.ramp_ticks
        self._ramp()
        return FAULT

    def _ramp(self) -> None:
        way = self._safe - self.command
        arrived = (self._ramp_left <= 1) & (np.abs(way) <= self._step)
        share = _cut(way / self._number(max(self._ramp_left, 1)), -self._step, self._step)
        self.command = np.where(arrived, self._safe, self.command + share)
        self._ramp_left = max(self._ramp_left - 1, 1)

    def _law_step(self, fields: Array, elapsed: Any) -> tuple[Array, Array]:
        """Memory and command of the law after a tick that comes `elapsed` s after the last."""
        rows, memory = self._rows.copy(), self.memory.copy()
        if self._period_row is not None:
            rows[self._period_row] = elapsed
        with np.errstate(all="ignore"):
            if self._written is None:
                seen = [field[None] for field in fields]
                step = self._law.trial_step
                assert step is not None
                asked = run_step(step, self._ticks, rows[None], memory[None], Sample(*seen[:3]), Setpoint(*seen[3:]))
                return memory, asked[0]
            command = np.zeros_like(fields[0])
            work = np.zeros((WORK_ROWS, len(command)), dtype=self._number)
            self._written(Tick(self._ticks, *fields), rows, memory, work, command)
            return memory, command


def _cut(value: Array, low: Array, high: Array) -> Array:
    """A value between two, itself where it lies there: also −0, of which numpy's clip may make +0."""
    return np.where(value < low, low, np.where(value > high, high, value))
