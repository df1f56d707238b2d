"""Metrics of what a law does inside: its sliding variable and its gain, as far as it has such."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.metrics.metric_registry import MetricSettings, metric, run_length

if TYPE_CHECKING:
    from asmc_pin.engine import Rollout


@metric(
    "Sign changes of s",
    "rate",
    "#{ k > 0 : sgn(s_k) ≠ sgn(s_{k−1}) } / (t_{T−1} − t_0), sgn(0) = +1",
    "Baek, Jin, Han 2016, eqs. (4), (10)",
)
def s_sign_changes(rollout: Rollout, settings: MetricSettings) -> Array:
    """How often per second the sliding variable s = ė + K_s e crosses zero."""
    positive = rollout.s >= 0.0
    rate = np.sum(positive[:, 1:] != positive[:, :-1], axis=1) / run_length(rollout)
    return np.asarray(np.where(np.all(np.isfinite(rollout.s), axis=1), rate, np.nan))


@metric("Peak gain", "gain", "max_k k̂_k", "Baek, Jin, Han 2016, Figs. 5, 11 and Lemma 2")
def peak_gain(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest switching gain; not defined for a law without one."""
    return np.asarray(np.max(rollout.gain, axis=1))


@metric("Final gain", "gain", "k̂_{T−1}", "Baek, Jin, Han 2016, Figs. 5, 11")
def final_gain(rollout: Rollout, settings: MetricSettings) -> Array:
    """Switching gain at the last sample; not defined for a law without one."""
    return np.asarray(rollout.gain[:, -1])
