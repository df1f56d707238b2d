"""The form of a law's step for one trial, and how it is compiled.

A step is one function ``step(tick, law, memory, work, command)`` under the decorator `trial_step`:

- tick: what the law sees, a `Tick`;
- law: its parameters, a row each, (rows, nv); a scalar stands in every column;
- memory: what it remembers from tick to tick, a row for each array of its state, (rows, nv); read and written;
- work: `WORK_ROWS` rows, (WORK_ROWS, nv), to compute in; they mean nothing between two ticks;
- command: torque to hold over the next period, (nv,), N·m; every entry is to be written.

It is plain Python that numba compiles when it is first run, for every law with the same signature. So the engine is
compiled once for all laws, and a law by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import errors
from numba.extending import intrinsic

from asmc_pin._typing import Array
from asmc_pin.numerics.short_loops import ALLOCATING, OPTIONS, with_room

WORK_ROWS = 8


class Tick(NamedTuple):
    """What a law sees of one trial at a tick; arrays of shape (nv,), not to be written to.

    Attributes:
        ticks: Number of ticks taken before; 0 at t = 0.
        q: Reported angles, rad.
        v: Reported velocities, rad/s.
        torque: Reported torque of the last period, N·m.
        q_ref: Reference, rad.
        v_ref: Its velocity, rad/s.
        a_ref: Its acceleration, rad/s².
    """

    ticks: int
    q: Array
    v: Array
    torque: Array
    q_ref: Array
    v_ref: Array
    a_ref: Array


Function = Callable[[Tick, Array, Array, Array, Array], None]

_types: Any = types  # numba has no types
_errors: Any = errors
_ir: Any = ir
_intrinsic: Any = intrinsic
_ROW, _ROWS = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
SIGNATURE = types.void(_types.NamedTuple([types.int64, *6 * [_ROW]], Tick), _ROWS, _ROWS, _ROWS, _ROW)
"""That of every step, for numba."""


def _run_at(
    typing: Any, address: Any, tick: Any, law: Any, memory: Any, work: Any, command: Any
) -> tuple[Any, Callable[..., Any]]:
    """Types and code of `run_at`, for numba."""

    def call(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        function = _ir.FunctionType(context.get_value_type(types.none), kinds)
        builder.call(builder.inttoptr(values[0], function.as_pointer()), values[1:])
        return context.get_dummy_value()

    return types.void(address, *SIGNATURE.args), call


run_at: Any = _intrinsic(_run_at)
"""Of compiled code: ``run_at(address, tick, law, memory, work, command)`` runs a step, see `TrialStep.address`."""


class TrialStep:
    """A law's step for one trial.

    Attributes:
        function: As it is written, in Python.
    """

    def __init__(self, function: Function) -> None:
        self.function = function

    @cached_property
    def address(self) -> int:
        """Where it is in this process, compiled, or found in numba's cache, which lies beside the law's file.

        An address has the same type for every law, so that what calls it is compiled once.
        """
        try:
            self._compiled: Any = numba.njit(SIGNATURE, **OPTIONS)(self.function)
        except _errors.NumbaError:  # it makes arrays; or it is wrong, and then that is said now
            self._compiled = numba.njit(SIGNATURE, **ALLOCATING)(self.function)
        (found,) = self._compiled.overloads.values()
        address: int = found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name)
        return address


def trial_step(function: Function) -> TrialStep:
    """Decorator of a law's step for one trial; see the top of this module."""
    return TrialStep(function)


@with_room
def over_trials(step: int, ticks: int, law: Array, seen: Array, memory: Array, command: Array) -> None:
    """Run a step for every trial of a batch.

    Args:
        step: Address of a `TrialStep`.
        ticks: Number of ticks taken before.
        law: Parameters, (1 or batch, rows, nv).
        seen: The fields of a `Tick` but the first, (6, batch, nv).
        memory: (batch, rows, nv); written.
        command: Written, (batch, nv), N·m.
    """
    batch, nv = command.shape
    work = np.empty((WORK_ROWS, nv))
    for trial in range(batch):
        tick = Tick(
            ticks, seen[0, trial], seen[1, trial], seen[2, trial], seen[3, trial], seen[4, trial], seen[5, trial]
        )
        run_at(step, tick, law[trial if len(law) > 1 else 0], memory[trial], work, command[trial])
