"""Metrics of the torque that was applied: how large it is, how it chatters, what it costs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.metrics.metric_registry import (
    OURS,
    ROUNDING,
    MetricSettings,
    held_torque,
    metric,
    run_length,
    torque_steps,
)

if TYPE_CHECKING:
    from asmc_pin.engine import Rollout


@metric("Torque RMS", "torque", "√( (1/(T−1)) Σ_{k<T−1} τ_k² ), the exact RMS of a held torque", OURS, main=True)
def torque_rms(rollout: Rollout, settings: MetricSettings) -> Array:
    """Root mean square of the torque that was applied, after the drive's limits."""
    return np.asarray(np.sqrt(np.mean(held_torque(rollout) ** 2, axis=1)))


@metric("Maximum torque", "torque", "max_{k<T−1} |τ_k|", "Baek, Jin, Han 2016, Figs. 6, 12")
def torque_max(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest absolute torque that was applied."""
    return np.asarray(np.max(np.abs(held_torque(rollout)), axis=1))


@metric(
    "Torque variation (chatter)",
    "torque rate",
    "Σ_{0<k<T−1} |τ_k − τ_{k−1}| / (t_{T−1} − t_0)",
    "total variation of the input (Skogestad, Postlethwaite, Multivariable Feedback Control, sec. 2.4), per second",
    best="smallest",
    main=True,
)
def torque_variation(rollout: Rollout, settings: MetricSettings) -> Array:
    """How much the torque goes up and down in a second; what is heard as chatter, and what wears gears."""
    return np.asarray(np.sum(np.abs(np.diff(held_torque(rollout), axis=1)), axis=1) / run_length(rollout))


@metric(
    "High-frequency torque share",
    "share",
    "Σ_{f>f_c} |X(f)|² / Σ_{f>0} |X(f)|², X = DFT of Hann-windowed τ − mean(τ); 0 if τ is constant; "
    "not defined if f_c ≥ 1/(2L)",
    "periodogram with a Hann window (Oppenheim, Schafer, Discrete-Time Signal Processing, ch. 10)",
)
def torque_high_frequency_share(rollout: Rollout, settings: MetricSettings) -> Array:
    """Share of the torque's power, its mean aside, above the cut-off frequency f_c."""
    torque = held_torque(rollout)
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


@metric(
    "Torque noise",
    "torque",
    "√( 2 Σ_{f>f_c} |X(f)|² / (n Σ w²) ), X as above, w the window, n = T−1: RMS of the torque above f_c; not defined "
    "if f_c ≥ 1/(2L)",
    "windowed periodogram, scaled by the window's power (Welch 1967, IEEE Trans. Audio Electroacoustics 15(2))",
    best="smallest",
)
def torque_noise(rollout: Rollout, settings: MetricSettings) -> Array:
    """RMS of the torque above the cut-off frequency f_c: what chatter and the sensors' noise make of it together."""
    torque = held_torque(rollout)
    count = torque.shape[1]
    frequency = np.fft.rfftfreq(count, rollout.period)
    if settings.cutoff_hz >= 0.5 / rollout.period:
        return np.full((torque.shape[0], torque.shape[2]), np.nan)
    window = np.hanning(count + 1)[:-1, None]
    power = np.abs(np.fft.rfft(window * (torque - np.mean(torque, axis=1, keepdims=True)), axis=1)) ** 2
    high = np.sum(power[:, frequency > settings.cutoff_hz], axis=1)
    return np.asarray(np.sqrt(2.0 * high / (count * np.sum(window**2))))


@metric("Saturation share", "share", "#{ k < T−1 : |τ_k| ≥ τ_max (1 − 1e-9) } / (T−1)", OURS)
def saturation_share(rollout: Rollout, settings: MetricSettings) -> Array:
    """Share of the run in which the torque stood at its limit; 0 where there is no limit."""
    return np.asarray(np.mean(np.abs(held_torque(rollout)) >= np.asarray(settings.effort_limit) * (1.0 - 1e-9), axis=1))


@metric(
    "Largest torque step",
    "torque",
    "max_{0<k<T−1} |τ_k − τ_{k−1}|, from one control tick to the next",
    OURS,
    best="smallest",
)
def torque_step(rollout: Rollout, settings: MetricSettings) -> Array:
    """Largest change of the torque from a tick to the next; 0 in a run of a single period."""
    return np.asarray(np.max(torque_steps(rollout), axis=1, initial=0.0))


@metric(
    "Ticks over the torque-rate limit",
    "count",
    "#{ 0 < k < T−1 : |τ_k − τ_{k−1}| / L > limit (1 + 1e-9) }",
    "limit of 1000 N·m/s: Franka Emika, FCI documentation, robot and interface specifications",
    best="smallest",
)
def torque_rate_ticks(rollout: Rollout, settings: MetricSettings) -> Array:
    """Ticks at which a robot that limits the rate of its torque would have stopped; 0: it would have run there."""
    most = np.asarray(settings.torque_rate_limit) * rollout.period * (1.0 + ROUNDING)
    return np.asarray(np.sum(torque_steps(rollout) > most, axis=1), dtype=np.float64)


@metric(
    "Mechanical energy",
    "energy",
    "∫ |τ q̇| dt = Σ_{k<T−1} |τ_k (q_{k+1} − q_k)|, exact where no joint turns round within a period",
    "absolute mechanical work: what is braked is not recovered",
    best="smallest",
)
def energy(rollout: Rollout, settings: MetricSettings) -> Array:
    """Work done by the drive and on it, both counted: what a drive without recovery of energy spends at least."""
    return np.asarray(np.sum(np.abs(held_torque(rollout) * np.diff(rollout.q, axis=1)), axis=1))


@metric(
    "Copper-loss proxy",
    "integral of squared torque",
    "∫ τ² dt = L Σ_{k<T−1} τ_k²; times R/(k_t N)² of a motor with winding R, torque constant k_t and gear N it is its "
    "Joule loss",
    "Joule's law with the current that the torque needs; no motor's data are known here, so laws compare, watts do not",
    best="smallest",
)
def copper_loss_proxy(rollout: Rollout, settings: MetricSettings) -> Array:
    """What the heat in a motor's winding is proportional to."""
    return np.asarray(np.sum(held_torque(rollout) ** 2, axis=1) * rollout.period)
