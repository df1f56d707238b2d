"""The figures of one run that the paper's tables, figures and claims speak of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from asmc_pin._typing import Array
from asmc_pin.engine import rollout
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.monitors import monitor
from asmc_pin.results.result_folder import recorded_run


def measure(dataset: xr.Dataset, label: str, window: float | None) -> dict[str, Any]:
    """Of one controller, the first trial; valid JSON, null where a law diverged or has no gain.

    Args:
        dataset: Trajectories of a comparison.
        label: Controller.
        window: RMS errors are over the first so many seconds; None for the whole run.

    Returns:
        ``rms_deg, max_error_deg, torque_max, torque_variation, max_s, peak_gain, peak_gain_before,
        peak_gain_last_quarter`` by joint, in deg, N·m, N·m/s, rad/s and rad/s²; ``gain_times``: time in which the gain
        of joint 1 rises from 10 to 90 % of its peak, and from the peak falls to half of it, s; ``status``,
        ``end_time``.
    """
    run = recorded_run(dataset, label)
    late = 3 * run.time.size // 4
    # RMS as Table II has it: over its window only, so a law that diverges later still has one.
    inside = None if window is None else int(np.searchsorted(run.time, window + 1e-9, side="right"))

    def of(name: str, start: int | None = None, stop: int | None = None) -> Array:
        part = recorded_run(dataset.isel(time=slice(start, stop)), label)
        values: Array = METRICS[name](part)[0]
        return values

    ok, adaptive = run.status[0] == "ok", bool(np.isfinite(run.gain).any())
    return {
        "law": str(dataset.law.sel(controller=label).item()),
        "status": run.status[0],
        "end_time": float(run.end_time[0]),
        "rms_deg": _listed(np.degrees(of("rms_error", stop=inside))),
        "max_error_deg": _listed(np.degrees(of("max_error"))),
        "torque_max": _listed(of("torque_max")),
        "torque_variation": _listed(of("torque_variation")),
        "max_s": _listed(np.max(np.abs(run.s[0]), axis=0)),
        "peak_gain": _listed(of("peak_gain")),
        "peak_gain_before": _listed(of("peak_gain", stop=late)),
        "peak_gain_last_quarter": _listed(of("peak_gain", start=late)),
        "gain_times": list(_gain_times(run.time, run.gain[0, :, 0])) if ok and adaptive else [None, None],
    }


def theorems(experiment: Experiment, label: str) -> dict[str, dict[str, str]]:
    """What the theorem monitors say of one controller: by claim its title, the verdict and the reason."""
    plant, law = experiment.build_plant(), experiment.build_controllers()[label]
    run = rollout(plant, law, experiment.build_reference(), experiment.duration)
    found = monitor(run, experiment.build_arm(), law, effort_limit=plant.effort_limit)
    return {
        item.key: {"title": item.statement.title, "verdict": item.short, "reason": item.reason} for item in found.claims
    }


def _gain_times(time: Array, gain: Array) -> tuple[float | None, float | None]:
    """Time of the rise to the peak, from the last tick at 10 % of it to the first at 90 %; and of the fall to half."""
    peak = int(np.argmax(gain))
    if not gain[peak] > 0.0:
        return None, None
    low = np.flatnonzero(gain[: peak + 1] <= 0.1 * gain[peak])
    start = int(low[-1]) if low.size else 0
    high = start + int(np.argmax(gain[start : peak + 1] >= 0.9 * gain[peak]))
    below = np.flatnonzero(gain[peak:] <= 0.5 * gain[peak])
    fall = float(time[peak + below[0]] - time[peak]) if below.size else None
    return float(time[high] - time[start]), fall


def _listed(values: Array) -> list[float | None]:
    return [float(x) if math.isfinite(x) else None for x in values]
