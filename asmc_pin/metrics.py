"""What a comparison measures: each metric once, with its formula, unit and source.

Metrics are computed from a rollout, that is from what the plant did, never from what a controller says of itself. A
metric is a function of a `Rollout` and the `MetricSettings`; it returns one number per trial and joint. Add one by
writing the function below with ``@_metric(...)``: tables, results and `docs/metrics.md` pick it up from `METRICS`.

Conventions: e = q_d − q (as in Baek 2016); T samples at t_k = k·L, k = 0 … T−1; torque τ_k is held over [t_k, t_{k+1}),
so the run holds τ_0 … τ_{T−2}, and those are what the torque metrics see. A trial that diverged has no metric: every
figure of it is NaN (null in JSON, a dash in tables) and its status says when it happened, because a number over the
part that ran would depend on how early the trial broke down, and would flatter the law that broke down first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.engine import Rollout

# Of a revolute and of a prismatic joint, SI.
QUANTITIES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "position": ("rad", "m"),
        "torque": ("N·m", "N"),
        "torque rate": ("N·m/s", "N/s"),
        "gain": ("rad/s²", "m/s²"),
        "rate": ("1/s", "1/s"),
        "time": ("s", "s"),
        "share": ("1", "1"),
    }
)


MOVED = "moved_"
"""How the columns of a summary begin that say how half the step moves a metric, relative to the finer figure."""


@dataclass(frozen=True, slots=True)
class MetricSettings:
    """What the metrics need in addition to the run.

    Attributes:
        cutoff_hz: Frequency above which torque power counts as high, Hz.
        settling_band: Band of |e| in which a joint counts as settled, a scalar or nv values, rad (m if prismatic).
        effort_limit: Torque limits, a scalar or nv values, N·m; infinite where there is none.
    """

    cutoff_hz: float = 50.0
    settling_band: float | Array = 0.002
    effort_limit: float | Array = field(default=np.inf)

    def __post_init__(self) -> None:
        for name in ("cutoff_hz", "settling_band", "effort_limit"):
            if not np.all(np.asarray(getattr(self, name)) > 0.0):
                raise ParameterError(name, f"must be positive, got {getattr(self, name)}")


_Function = Callable[["Rollout", MetricSettings], Array]

Best = Literal["smallest", "largest"] | None
"""Which figure of several is the best; None where neither is, as of a torque or a gain."""


@dataclass(frozen=True)
class Metric:
    """One number per trial and joint that says how well a controller did.

    Attributes:
        name: Key in results and in ``compare --json``.
        title: What a table calls it.
        quantity: Key of `QUANTITIES`, which gives the unit.
        formula: The definition, in plain text.
        source: Where the definition comes from.
        best: Which figure of several is the best; tables mark it.
        main: Whether a person reads it first; the other metrics follow.
        function: Computes it for every trial as if none had diverged, shape (batch, nv).
    """

    name: str
    title: str
    quantity: str
    formula: str
    source: str
    best: Best
    main: bool
    function: _Function

    @property
    def unit(self) -> str:
        """SI unit, that of a prismatic joint after it where it differs; ``"1"`` for a pure number."""
        revolute, prismatic = QUANTITIES[self.quantity]
        return revolute if revolute == prismatic else f"{revolute} or {prismatic}"

    def __call__(self, rollout: Rollout, settings: MetricSettings | None = None) -> Array:
        """Evaluate on a rollout.

        Args:
            rollout: What the plant did.
            settings: Cut-off, settling band and torque limits; the defaults where omitted.

        Returns:
            Shape (batch, nv), SI; NaN for a trial that diverged or where the metric is not defined.
        """
        with np.errstate(invalid="ignore"):  # NaN after a divergence is expected, and masked below.
            values = np.array(self.function(rollout, settings or MetricSettings()), dtype=np.float64)
        values[np.asarray(rollout.status) != "ok"] = np.nan
        return values


_REGISTRY: dict[str, Metric] = {}
METRICS: Mapping[str, Metric] = MappingProxyType(_REGISTRY)


def _metric(
    title: str, quantity: str, formula: str, source: str, *, best: Best = None, main: bool = False
) -> Callable[[_Function], _Function]:
    def register(function: _Function) -> _Function:
        name = function.__name__
        _REGISTRY[name] = Metric(name, title, quantity, formula, source, best, main, function)
        return function

    return register


def evaluate(rollout: Rollout, settings: MetricSettings | None = None) -> dict[str, Array]:
    """All metrics of a rollout: name -> array of shape (batch, nv), in SI units."""
    return {name: metric(rollout, settings) for name, metric in METRICS.items()}


def _error(rollout: Rollout) -> Array:
    return rollout.q_ref - rollout.q


def _held(rollout: Rollout) -> Array:
    return rollout.torque[:, :-1]


def _duration(rollout: Rollout) -> float:
    return float(rollout.time[-1] - rollout.time[0])


_OURS = "this toolkit"
_BAEK = "Baek, Jin, Han 2016, Tables I to III"


@_metric("RMS tracking error", "position", "√( (1/T) Σ_k e_k² ), e = q_d − q", _BAEK, best="smallest", main=True)
def rms_error(rollout: Rollout, settings: MetricSettings) -> Array:
    """Root of the mean squared tracking error over all T samples."""
    return np.asarray(np.sqrt(np.mean(_error(rollout) ** 2, axis=1)))


@_metric(
    "Maximum tracking error",
    "position",
    "max_k |e_k|",
    "Baek, Jin, Han 2016, Figs. 7, 8, 13 (|e|)",
    best="smallest",
    main=True,
)
def max_error(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest absolute tracking error."""
    return np.asarray(np.max(np.abs(_error(rollout)), axis=1))


@_metric("Final tracking error", "position", "|e_{T−1}|", _OURS, best="smallest")
def final_error(rollout: Rollout, settings: MetricSettings) -> Array:
    """Absolute tracking error at the last sample."""
    return np.asarray(np.abs(_error(rollout)[:, -1]))


@_metric(
    "Settling time",
    "time",
    "min { t_k : |e_j| ≤ band for all j ≥ k }; not defined (NaN) if |e_{T−1}| > band",
    "step-response settling time, taken of the tracking error from t = 0 (Ogata, Modern Control Engineering, ch. 5)",
    best="smallest",
)
def settling_time(rollout: Rollout, settings: MetricSettings) -> Array:
    """Time after which the tracking error never leaves the band again; 0 if it never was outside."""
    outside = ~(np.abs(_error(rollout)) <= settings.settling_band)
    samples = outside.shape[1]
    after = samples - np.argmax(outside[:, ::-1], axis=1)  # index that follows the last sample outside
    settled = np.where(np.any(outside, axis=1), after, 0)
    times = np.append(rollout.time - rollout.time[0], np.nan)
    return np.asarray(times[settled])


@_metric("Torque RMS", "torque", "√( (1/(T−1)) Σ_{k<T−1} τ_k² ), the exact RMS of a held torque", _OURS, main=True)
def torque_rms(rollout: Rollout, settings: MetricSettings) -> Array:
    """Root mean square of the torque that was applied, after the drive's limits."""
    return np.asarray(np.sqrt(np.mean(_held(rollout) ** 2, axis=1)))


@_metric("Maximum torque", "torque", "max_{k<T−1} |τ_k|", "Baek, Jin, Han 2016, Figs. 6, 12")
def torque_max(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest absolute torque that was applied."""
    return np.asarray(np.max(np.abs(_held(rollout)), axis=1))


@_metric(
    "Torque variation (chatter)",
    "torque rate",
    "Σ_{0<k<T−1} |τ_k − τ_{k−1}| / (t_{T−1} − t_0)",
    "total variation of the input (Skogestad, Postlethwaite, Multivariable Feedback Control, sec. 2.4), per second",
    best="smallest",
    main=True,
)
def torque_variation(rollout: Rollout, settings: MetricSettings) -> Array:
    """How much the torque goes up and down in a second; what is heard as chatter, and what wears gears."""
    return np.asarray(np.sum(np.abs(np.diff(_held(rollout), axis=1)), axis=1) / _duration(rollout))


@_metric(
    "High-frequency torque share",
    "share",
    "Σ_{f>f_c} |X(f)|² / Σ_{f>0} |X(f)|², X = DFT of Hann-windowed τ − mean(τ); 0 if τ is constant; "
    "not defined if f_c ≥ 1/(2L)",
    "periodogram with a Hann window (Oppenheim, Schafer, Discrete-Time Signal Processing, ch. 10)",
)
def torque_high_frequency_share(rollout: Rollout, settings: MetricSettings) -> Array:
    """Share of the torque's power, its mean aside, above the cut-off frequency f_c."""
    torque = _held(rollout)
    frequency = np.fft.rfftfreq(torque.shape[1], rollout.period)
    if settings.cutoff_hz >= 0.5 / rollout.period:
        return np.full((torque.shape[0], torque.shape[2]), np.nan)
    offset = torque - np.mean(torque, axis=1, keepdims=True)
    # Rounding of the mean leaves some 1e-16 of it: that is a constant torque, not power.
    quiet = np.max(np.abs(offset), axis=1) <= 1e-12 * np.max(np.abs(torque), axis=1)
    window = np.hanning(torque.shape[1] + 1)[:-1, None]
    power = np.abs(np.fft.rfft(window * offset, axis=1)[:, 1:]) ** 2
    total = np.sum(power, axis=1)
    high = np.sum(power[:, frequency[1:] > settings.cutoff_hz], axis=1)
    return np.asarray(np.where(quiet, 0.0, high / np.where(quiet, 1.0, total)))


@_metric(
    "Sign changes of s",
    "rate",
    "#{ k > 0 : sgn(s_k) ≠ sgn(s_{k−1}) } / (t_{T−1} − t_0), sgn(0) = +1",
    "Baek, Jin, Han 2016, eqs. (4), (10)",
)
def s_sign_changes(rollout: Rollout, settings: MetricSettings) -> Array:
    """How often per second the sliding variable s = ė + K_s e crosses zero."""
    positive = rollout.s >= 0.0
    rate = np.sum(positive[:, 1:] != positive[:, :-1], axis=1) / _duration(rollout)
    return np.asarray(np.where(np.all(np.isfinite(rollout.s), axis=1), rate, np.nan))


@_metric("Saturation share", "share", "#{ k < T−1 : |τ_k| ≥ τ_max (1 − 1e-9) } / (T−1)", _OURS)
def saturation_share(rollout: Rollout, settings: MetricSettings) -> Array:
    """Share of the run in which the torque stood at its limit; 0 where there is no limit."""
    return np.asarray(np.mean(np.abs(_held(rollout)) >= np.asarray(settings.effort_limit) * (1.0 - 1e-9), axis=1))


@_metric("Peak gain", "gain", "max_k k̂_k", "Baek, Jin, Han 2016, Figs. 5, 11 and Lemma 2")
def peak_gain(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest switching gain; not defined for a law without one."""
    return np.asarray(np.max(rollout.gain, axis=1))


@_metric("Final gain", "gain", "k̂_{T−1}", "Baek, Jin, Han 2016, Figs. 5, 11")
def final_gain(rollout: Rollout, settings: MetricSettings) -> Array:
    """Switching gain at the last sample; not defined for a law without one."""
    return np.asarray(rollout.gain[:, -1])
