"""Metrics of how far a joint is from where it should be, e = q_d − q."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.metrics.metric_registry import BAEK, OURS, MetricSettings, metric, tracking_error

if TYPE_CHECKING:
    from asmc_pin.engine import Rollout


@metric("RMS tracking error", "position", "√( (1/T) Σ_k e_k² ), e = q_d − q", BAEK, best="smallest", main=True)
def rms_error(rollout: Rollout, settings: MetricSettings) -> Array:
    """Root of the mean squared tracking error over all T samples."""
    return np.asarray(np.sqrt(np.mean(tracking_error(rollout) ** 2, axis=1)))


@metric(
    "Maximum tracking error",
    "position",
    "max_k |e_k|",
    "Baek, Jin, Han 2016, Figs. 7, 8, 13 (|e|)",
    best="smallest",
    main=True,
)
def max_error(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest absolute tracking error."""
    return np.asarray(np.max(np.abs(tracking_error(rollout)), axis=1))


@metric("Final tracking error", "position", "|e_{T−1}|", OURS, best="smallest")
def final_error(rollout: Rollout, settings: MetricSettings) -> Array:
    """Absolute tracking error at the last sample."""
    return np.asarray(np.abs(tracking_error(rollout)[:, -1]))


@metric(
    "Settling time",
    "time",
    "min { t_k : |e_j| ≤ band for all j ≥ k }; not defined (NaN) if |e_{T−1}| > band",
    "step-response settling time, taken of the tracking error from t = 0 (Ogata, Modern Control Engineering, ch. 5)",
    best="smallest",
)
def settling_time(rollout: Rollout, settings: MetricSettings) -> Array:
    """Time after which the tracking error never leaves the band again; 0 if it never was outside."""
    outside = ~(np.abs(tracking_error(rollout)) <= settings.settling_band)
    samples = outside.shape[1]
    after = samples - np.argmax(outside[:, ::-1], axis=1)  # index that follows the last sample outside
    settled = np.where(np.any(outside, axis=1), after, 0)
    times = np.append(rollout.time - rollout.time[0], np.nan)
    return np.asarray(times[settled])


@metric(
    "Integral of absolute error (IAE)",
    "integral of position",
    "∫ |e| dt, by the trapezoidal rule over the samples",
    "Åström, Hägglund, Advanced PID Control, ch. 4",
    best="smallest",
)
def iae(rollout: Rollout, settings: MetricSettings) -> Array:
    """Area under the absolute error: every second of it counts alike."""
    return _integral(np.abs(tracking_error(rollout)), rollout.period)


@metric(
    "Integral of squared error (ISE)",
    "integral of squared position",
    "∫ e² dt, by the trapezoidal rule over the samples",
    "Åström, Hägglund, Advanced PID Control, ch. 4",
    best="smallest",
)
def ise(rollout: Rollout, settings: MetricSettings) -> Array:
    """Area under the squared error: large errors count most."""
    return _integral(tracking_error(rollout) ** 2, rollout.period)


@metric(
    "Integral of time times absolute error (ITAE)",
    "integral of position and time",
    "∫ t |e| dt from the start of the run, by the trapezoidal rule over the samples",
    "Graham, Lathrop 1953, The synthesis of optimum transient response, Trans. AIEE 72",
    best="smallest",
)
def itae(rollout: Rollout, settings: MetricSettings) -> Array:
    """Area under the absolute error times the time since the start: what does not die out counts most."""
    since = (rollout.time - rollout.time[0])[:, None]
    return _integral(since * np.abs(tracking_error(rollout)), rollout.period)


def _integral(values: Array, period: float) -> Array:
    return np.asarray(np.trapezoid(values, dx=period, axis=1))
