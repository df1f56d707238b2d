"""Several settings of one law in one rollout, one for each trial."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers import PerJoint, Sample, Scalar, ScalarOrWord, Setpoint, TdeLaw, parameters_of
from asmc_pin.controllers.one_trial.compiled_law import CompiledLaw
from asmc_pin.controllers.one_trial.trial_step import TrialStep
from asmc_pin.errors import ParameterError


class Stacked(CompiledLaw):
    """A law whose parameters have a row for each trial.

    The laws of `asmc_pin.controllers` compute element by element, so a (batch, nv) parameter serves where a (nv,) one
    does: trial i runs as ``laws[i]`` would alone, to the last bit, and a batch costs little more than one of them.

    Attributes:
        laws: The settings.
        period: Control period L that they share, s.
    """

    def __init__(self, laws: Sequence[TdeLaw], nv: int) -> None:
        """Stack them.

        Args:
            laws: Settings of one law, at least one; they share its class, period and estimate of q̈(t−L).
            nv: Number of joints.

        Raises:
            ParameterError: they are of several laws, or differ in what cannot be stacked.
        """
        self.laws = tuple(law.for_joints(nv) for law in laws)
        first = self.laws[0]
        self.period = first.period
        stacked = copy.copy(first)
        fields = parameters_of(type(first))
        # What a law has computed from its parameters is computed again, from the stacked ones.
        kept = {name: value for name, value in vars(stacked).items() if name in fields}
        for name, item in fields.items():
            values = [getattr(law, name) for law in self.laws if type(law) is type(first)]
            if len(values) < len(self.laws):
                raise ParameterError("laws", "are of several classes; stack settings of one law")
            if isinstance(item, PerJoint) and all(value is not None for value in values):
                kept[name] = np.array(values)
            elif name != "period" and (isinstance(item, Scalar) or _numbers(item, values)):
                kept[name] = np.array(values)[:, None]
            elif any(value is not values[0] and np.any(value != values[0]) for value in values):
                raise ParameterError(name, f"differs between the laws ({values}); only numbers can be stacked")
        vars(stacked).clear()
        vars(stacked).update(kept)
        self._stacked = stacked

    def init(self, sample: Sample) -> Any:
        """State before the first tick, each trial's made by its own setting."""
        rows = [slice(i, i + 1) for i in range(len(self.laws))]
        parts = [Sample(sample.q[row], sample.v[row], sample.torque[row]) for row in rows]
        return _joined([law.init(part) for law, part in zip(self.laws, parts, strict=True)])

    @property
    def trial_step(self) -> TrialStep | None:  # type: ignore[override]
        """That of the law; None if it has its step in numpy."""
        return self._stacked.trial_step

    def rows(self) -> tuple[ArrayLike, ...]:
        """The law's, with a row for each trial."""
        return self._stacked.rows()

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        """Torque to hold over the next period, (batch, nv), N·m, and the next state."""
        return self._stacked.step(state, sample, setpoint)


def _numbers(item: Any, values: list[Any]) -> bool:
    """Whether a parameter that may be a word is a number in every setting."""
    return isinstance(item, ScalarOrWord) and not any(isinstance(value, str) for value in values)


def _joined(states: list[Any]) -> Any:
    """States of single trials as one state: arrays row under row, what is no array shared."""
    first = states[0]
    if isinstance(first, tuple):
        return type(first)(*(_joined(list(field)) for field in zip(*states, strict=True)))
    return np.concatenate(states) if isinstance(first, np.ndarray) else first
