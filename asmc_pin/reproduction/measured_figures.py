"""The figures of an ensemble that the paper's tables, figures and claims speak of."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.engine import Rollout, rollout
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.metrics.metric_registry import LEAST
from asmc_pin.monitors import monitor
from asmc_pin.statistics.joint_mean import joint_mean
from asmc_pin.statistics.order_statistics import spread_of, with_failures
from asmc_pin.statistics.paired_ratio import ratio_interval


def measure(run: Rollout, law: str, window: float | None) -> dict[str, Any]:
    """Of one controller, over its trials; valid JSON, null where most trials diverged, or a law has no gain.

    Args:
        run: All trials.
        law: Name of the law.
        window: RMS errors are over the first so many seconds; None for the whole run.

    Returns:
        ``rms_deg, max_error_deg, torque_max, torque_variation, max_s, peak_gain, peak_gain_before,
        peak_gain_last_quarter`` by joint, in deg, N·m, N·m/s, rad/s and rad/s²; ``gain_times``: time in which the gain
        of joint 1 rises from 10 to 90 % of its peak, and from the peak falls to half of it, s; ``mean_rms_deg``: one
        number, the geometric mean of a trial's RMS errors over the joints. Each a median, with
        ``…_low`` and ``…_high`` for 5 % and 95 %. ``trials``, ``failed``; ``status`` and ``end_time`` of the first that
        diverged, if one did.
    """
    late = 3 * run.time.size // 4
    failed = np.array(run.status) != "ok"
    told: dict[str, Any] = {
        "law": law,
        "status": "diverged" if failed.any() else "ok",
        "trials": len(run.status),
        "failed": int(failed.sum()),
        "end_time": float(run.end_time.min()),
    }
    figures = {
        "rms_deg": rms_by_trial(run, window),
        "mean_rms_deg": joint_mean(rms_by_trial(run, window), np.degrees(LEAST))[:, None],
        "max_error_deg": np.degrees(METRICS["max_error"](run)),
        **{name: METRICS[name](run) for name in ("torque_max", "torque_variation")},
        "max_s": np.max(np.abs(run.s), axis=1),
        "peak_gain": METRICS["peak_gain"](run),
        "peak_gain_before": METRICS["peak_gain"](_part(run, None, late)),
        "peak_gain_last_quarter": METRICS["peak_gain"](_part(run, late, None)),
        "gain_times": np.array([_gain_times(run.time, gain[:, 0]) for gain in run.gain]),
    }
    for name, values in figures.items():
        spread = spread_of(_with_failures(values, failed))
        ends = (("", spread.median), ("_low", spread.low), ("_high", spread.high))
        told |= {name + end: _listed(found) for end, found in ends}
    return told


def _with_failures(values: Array, failed: BoolArray) -> Array:
    """A trial that diverged counts as failed where its figure is lost, not where its part of the run went well."""
    return with_failures(values, failed & np.isnan(values).all(axis=1))


def rms_by_trial(run: Rollout, window: float | None) -> Array:
    """RMS error of every trial as a table has it, shape (trials, nv), deg; NaN where it diverged.

    Table II has it over its window only, so that a law that diverges later still has one.
    """
    inside = None if window is None else int(np.searchsorted(run.time, window + 1e-9, side="right"))
    return np.asarray(np.degrees(METRICS["rms_error"](_part(run, None, inside))))


def certainly_above(rms: Mapping[str, Array]) -> dict[str, list[list[str]]]:
    """For each controller and joint those whose RMS error is larger with certainty; see `ratio_interval`.

    Args:
        rms: By label, shape (trials, nv), NaN where a trial diverged; the trials are paired.
    """
    figures = {label: np.where(np.isnan(values), np.inf, values) for label, values in rms.items()}

    def above(own: Array, other: Array) -> bool:
        found = ratio_interval(own, other)
        return found.excludes_one and found.high < 1.0

    return {
        label: [
            [other for other in figures if other != label and above(own[:, joint], figures[other][:, joint])]
            for joint in range(own.shape[1])
        ]
        for label, own in figures.items()
    }


def theorems(experiment: Experiment, label: str) -> dict[str, dict[str, str]]:
    """What the theorem monitors say of one controller: by claim its title, the verdict and the reason."""
    plant, law = experiment.build_plant(), experiment.build_controllers()[label]
    run = rollout(plant, law, experiment.build_reference(), experiment.duration)
    found = monitor(run, experiment.build_arm(), law, effort_limit=plant.effort_limit)
    return {
        item.key: {"title": item.statement.title, "verdict": item.short, "reason": item.reason} for item in found.claims
    }


def _part(run: Rollout, start: int | None, stop: int | None) -> Rollout:
    """A part of a run in time, in which a trial that diverged after it counts as ``"ok"``."""
    time = run.time[start:stop]
    over = run.end_time <= time[-1]
    own = ("q", "v", "torque", "friction_torque", "s", "gain")
    changed: dict[str, Any] = {name: getattr(run, name)[:, start:stop] for name in own}
    changed |= {name: getattr(run, name)[start:stop] for name in ("q_ref", "v_ref", "a_ref")}
    changed |= dict.fromkeys(("q_measured", "v_measured", "torque_measured", "external_torque"))
    status = tuple(status if gone else "ok" for status, gone in zip(run.status, over, strict=True))
    return dataclasses.replace(run, time=time, **changed, status=status, end_time=np.minimum(run.end_time, time[-1]))


def _gain_times(time: Array, gain: Array) -> tuple[float, float]:
    """Time of the rise to the peak, from the last tick at 10 % of it to the first at 90 %; and of the fall to half.

    NaN of a law without a gain, and of a trial that diverged; +∞ of a fall that never comes.
    """
    if not np.isfinite(gain).all():
        return math.nan, math.nan
    peak = int(np.argmax(gain))
    if not gain[peak] > 0.0:
        return math.nan, math.nan
    low = np.flatnonzero(gain[: peak + 1] <= 0.1 * gain[peak])
    start = int(low[-1]) if low.size else 0
    high = start + int(np.argmax(gain[start : peak + 1] >= 0.9 * gain[peak]))
    below = np.flatnonzero(gain[peak:] <= 0.5 * gain[peak])
    fall = float(time[peak + below[0]] - time[peak]) if below.size else math.inf
    return float(time[high] - time[start]), fall


def _listed(values: Array) -> list[float | None]:
    return [float(x) if math.isfinite(x) else None for x in values]
