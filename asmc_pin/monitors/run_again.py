"""The same trial again with another period or limit, to say where a claim that broke would hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import BPoly

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Plant

_SHORTER = (1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32)
_MOST_TICKS = 300_000  # of a run that is tried
_OTHERS = (0.25, 0.5, 2.0, 4.0)


@dataclass(frozen=True, eq=False)
class Recorded:
    """The reference of a run: between its ticks of fifth order, through position, velocity and acceleration at both.

    Attributes:
        curve: The polynomial pieces.
        duration: Their end, s.
        nv: Number of joints.
    """

    curve: Any
    duration: float
    nv: int

    def evaluate(self, t: Array) -> Setpoint:
        """At the times t, (T,), s."""
        at = np.clip(t, 0.0, self.duration)
        return Setpoint(*(self.curve.derivative(order)(at) if order else self.curve(at) for order in range(3)))


def recorded(run: Rollout) -> Recorded:
    """The reference that a run followed, also between its ticks."""
    ends = np.stack([run.q_ref, run.v_ref, run.a_ref], axis=1)
    return Recorded(BPoly.from_derivatives(run.time, ends), float(run.time[-1]), run.q_ref.shape[1])


def tried_again(
    run: Rollout,
    trial: int,
    number: int,
    plant: Plant,
    law: Any,
    levers: Sequence[str],
    kept: Callable[[Rollout, Any], bool],
) -> str:
    """In words, with which other values of the law's parameters the claim holds in the same trial.

    Args:
        run: The run.
        trial: Which of its trials.
        number: The trial's number in its study, which makes its noise and scatter.
        plant: On what.
        law: The law.
        levers: Names of the parameters to change; of the period shorter ones are tried, up to the first that holds.
        kept: Whether the claim holds in a run of one trial of a law.
    """
    reference, end = recorded(run), float(run.time[-1])
    start: dict[str, Any] = {"q0": run.q[trial, 0], "v0": run.v[trial, 0], "trials": [number]}
    said = []
    for name in levers:
        good: list[str] = []
        bad: list[str] = []
        for factor in _SHORTER if name == "period" else _OTHERS:
            value = factor * getattr(law, name)
            if name == "period" and end / value > _MOST_TICKS:
                break
            try:
                other = replace(law, **{name: value})
                again = rollout(plant, other, reference, end, **start)
            except ParameterError:
                continue  # the plant or the law does not take it
            holds = again.status == ("ok",) and kept(again, other)
            (good if holds else bad).append(f"{value:.3g}")
            if holds and name == "period":
                break
        said += [f"with {name} = {' or '.join(good)} it holds"] if good else []
        said += [f"with {name} = {', '.join(bad)} it does not"] if bad else []
    return f"run again: {'; '.join(said)}" if said else ""
