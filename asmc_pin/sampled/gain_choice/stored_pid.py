"""A PID that keeps its integral, as robots' software runs it, and its loop."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.linear.pid import Pid
from asmc_pin.controllers.one_trial.trial_step import TrialStep
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.sampled.sampled_loop import SampledLoop


class StoredPidState(NamedTuple):
    """What the PID remembers; each (batch, nv).

    Attributes:
        ticks: Number of ticks taken.
        error: e at the last tick, rad.
        integral: k_i L Σe up to there, N·m.
    """

    ticks: int
    error: Array
    integral: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredPid(Pid):
    """u_k = k_p e_k + k_i L Σ_{j ≤ k} e_j + k_d (e_k − e_{k−1})/L: what `pid` sums up to, with a memory of its own.

    It never asks what torque the drives applied. So while nothing saturates and nothing is late it equals `pid` by
    position, and with a delay of the torque it is another loop.
    """

    label: ClassVar[str] = "a PID that keeps its integral"
    separates: ClassVar[bool] = True
    trial_step: ClassVar[TrialStep | None] = None

    def init(self, sample: Sample) -> Any:
        """State before the first tick: no error, no integral."""
        self.start(sample)
        return StoredPidState(0, np.zeros_like(sample.q), np.zeros_like(sample.q))

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[Array, Any]:
        """The torque of a tick, and what is remembered."""
        kp, ki, kd = self.gains
        error = setpoint.q - sample.q
        integral = state.integral + ki * self.period * error
        torque = kp * error + integral + kd * (error - state.error) / self.period
        return np.asarray(torque), StoredPidState(state.ticks + 1, error, np.asarray(integral))


def pid_loop(loop: SampledLoop) -> SampledLoop:
    """The loop of the PID whose gains a loop's are, by that PID's own map.

    Args:
        loop: With v by difference, the last torque and no filter; one β for all joints.
    """
    law = StoredPid(mbar=loop.mbar, ks=loop.ks, beta=float(loop.beta[0]), period=loop.period)
    return replace(loop, law=law)
