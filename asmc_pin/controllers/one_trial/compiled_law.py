"""A law whose step is compiled: what `step`, the engine and a batch of settings ask of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.one_trial.state_rows import as_rows, from_rows
from asmc_pin.controllers.one_trial.trial_step import TrialStep, over_trials
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.errors import ParameterError


class CompiledLaw:
    """What a law with a `trial_step` derives from; `asmc_pin.controllers.TdeLaw` does.

    A law in plain numpy overrides `step` instead, and is asked tick by tick.
    """

    trial_step: ClassVar[TrialStep | None] = None
    """The step for one trial; None for a law that has its step in numpy. It may be a property."""
    row_meanings: ClassVar[Mapping[str, str]] = {}
    """What rows of its parameters are, with their units, by the small letters of the constants that the step reads them
    by; those of the classes that it derives from count too. Exported code has them as comments."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """A class that says itself what a step is does not have the compiled step of the law that it derives from."""
        super().__init_subclass__(**kwargs)
        if "step" in vars(cls) and "trial_step" not in vars(cls):
            cls.trial_step = None

    def rows(self) -> tuple[ArrayLike, ...]:
        """The parameters that `trial_step` computes with, a scalar or (nv,) each, in the order of its rows."""
        return ()

    def law_rows(self, nv: int) -> Array:
        """The same as an array, (1, rows, nv), or (batch, rows, nv) where a parameter has a row for each trial."""
        if nv not in self._packed:
            self._packed[nv] = packed(self.rows(), nv)
        return self._packed[nv]

    @cached_property
    def _packed(self) -> dict[int, Array]:
        return {}

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        ticks, memory = as_rows(state, sample.q.shape)
        if self.trial_step is None:
            raise NotImplementedError(f"{type(self).__name__} has neither a trial_step nor a step of its own")
        command = run_step(self.trial_step, ticks, self.law_rows(sample.q.shape[1]), memory, sample, setpoint)
        return command, from_rows(state, ticks + 1, memory)


def packed(rows: Sequence[ArrayLike], nv: int) -> Array:
    """Parameters as `over_trials` takes them: each of `rows` a scalar, (nv,), or with a row for each trial."""
    arrays = [np.asarray(row, dtype=np.float64) for row in rows]
    trials = max((len(array) for array in arrays if array.ndim == 2), default=1)
    out = np.empty((trials, len(arrays), nv))
    for row, array in enumerate(arrays):
        out[:, row] = array
    return out


def check_trials(law: Array, batch: int) -> None:
    """Refuse parameters, (1 or batch, rows, nv), that are for another number of trials."""
    if len(law) not in (1, batch):
        raise ParameterError("sample", f"has {batch} trials, but the law's parameters are for {len(law)}; give as many")


def run_step(step: TrialStep, ticks: int, law: Array, memory: Array, sample: Sample, setpoint: Setpoint) -> Array:
    """The command of a step, (batch, nv), N·m, for a batch of trials; see `over_trials`.

    Args:
        step: The step.
        ticks: Number of ticks taken before.
        law: Parameters, (1 or batch, rows, nv).
        memory: (batch, rows, nv); brought up to date.
        sample: What the drives report, fields of shape (batch, nv).
        setpoint: The reference there; fields that broadcast to that.
    """
    seen = np.empty((6, *sample.q.shape))
    fields = (sample.q, sample.v, sample.torque, setpoint.q, setpoint.v, setpoint.a)
    for copied, field in zip(seen, fields, strict=True):
        copied[:] = field
    check_trials(law, seen.shape[1])
    command = np.empty(seen.shape[1:])
    over_trials(step.address, ticks, law, seen, memory, command)
    return command
