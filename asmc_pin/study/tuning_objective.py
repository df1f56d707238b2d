"""What tuning makes small: the tracking error, within a limit of chatter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.engine import Rollout
from asmc_pin.errors import ParameterError
from asmc_pin.metrics import METRICS
from asmc_pin.statistics.joint_mean import joint_mean

_DIVERGED = 1e6


@dataclass(frozen=True)
class Objective:
    """Geometric mean of the joints' RMS tracking errors, times the square of what the chatter is above its limit.

    The mean is `joint_mean`. Without a limit of chatter the most accurate law is the one that shakes the arm most, so a
    comparison of tuned laws needs one.

    Attributes:
        chatter_limit: Largest torque variation of each joint, N·m/s (N/s); None for no limit.
    """

    chatter_limit: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.chatter_limit is not None and not all(x > 0.0 for x in self.chatter_limit):
            raise ParameterError("chatter_limit", f"{self.chatter_limit} given; expected positive numbers, N·m/s")

    @property
    def text(self) -> str:
        """The definition in words."""
        mean = "geometric mean over the joints of the RMS tracking error"
        if self.chatter_limit is None:
            return mean
        limits = ", ".join(f"{x:.4g}" for x in self.chatter_limit)
        return f"{mean}, times max(1, torque variation / limit)², the worst joint's; limits {limits} N·m/s"

    def __call__(self, run: Rollout) -> Array:
        """Its value for each trial, shape (batch,), rad (m); for one that diverged above 1e6, less the later it did."""
        metric = METRICS["rms_error"]
        value = joint_mean(metric(run), metric.least)
        if self.chatter_limit is not None:
            excess = METRICS["torque_variation"](run) / np.asarray(self.chatter_limit)
            value = value * np.maximum(1.0, np.max(excess, axis=-1)) ** 2
        late = run.end_time / run.time[-1]
        values: Array = np.where(np.asarray(run.status) == "ok", value, _DIVERGED * (2.0 - late))
        return values
