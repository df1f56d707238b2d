"""An ensemble of one controller: trials in lockstep whose starts differ by less than anyone could set or measure.

It tells how far the figures of this plant and these gains are a matter of chance in the numbers: of rounding, of the
last digit of a start. All trials have the arm, scatter and noise of trial 0; plants that differ are a sweep's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from asmc_pin._typing import Array
from asmc_pin.engine import Rollout
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.toml_keys import MOST_TICKS
from asmc_pin.metrics import Trip
from asmc_pin.plant.sensor.trial_noise import START, generator
from asmc_pin.statistics.order_statistics import HIGH, LOW, quantile
from asmc_pin.tool_error import ToolError

BANDS = ("error", "error_size", "torque", "s", "gain")
"""Signals of which the bands are kept: what the figures show."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What is kept of a controller's trials.

    Attributes:
        rows: One for each trial and joint, see `asmc_pin.study.comparison.summary_rows`.
        first: Trial 0.
        bands: See `bands`.
        seconds: That all of it took.
        warnings: Of all trials.
        tool: Error of the tool in trial 0, if the experiment names one.
        trip: The first limit of the named robot that any trial was beyond, if it names one and any was.
    """

    rows: pd.DataFrame
    first: Rollout
    bands: Mapping[str, Array]
    seconds: float
    warnings: tuple[str, ...]
    tool: ToolError | None = None
    trip: Trip | None = None


def starts(experiment: Experiment) -> Array:
    """q(0) of every trial, shape (trials, nv), rad (m).

    Trial 0 starts where the experiment says, so that it is the run that the experiment describes; the others are off
    by normal draws. A trial's draw depends on the seed and its number alone: all controllers meet the same starts
    (common random numbers), and more trials add starts and change none.

    Args:
        experiment: As to be run.
    """
    nv, table = experiment.build_arm().nv, experiment.ensemble
    given = experiment.plant.q0
    start = experiment.build_reference().evaluate(np.zeros(1)).q[0] if given is None else np.asarray(given)
    z = [generator(experiment.seed, trial, START).standard_normal(nv) for trial in range(1, table.trials)]
    return np.broadcast_to(start, (nv,)) + table.q0_deviation * np.vstack([np.zeros((1, nv)), *z])


def check_size(experiment: Experiment) -> None:
    """Whether the trials of one controller fit into memory together, asked before anything is run.

    Raises:
        ExperimentError: they do not.
    """
    trials, ticks = experiment.ensemble.trials, round(experiment.duration / experiment.period)
    if trials > 1 and trials * ticks > MOST_TICKS:
        raise ExperimentError(
            "ensemble.trials",
            f"{trials} trials of {ticks} control periods are kept in memory together, at most {MOST_TICKS:g} periods "
            "in all; take fewer trials (1 for a single run), or shorten the duration",
        )


def first_trial(run: Rollout) -> Rollout:
    """Trial 0 of a run as a run of its own, equal to the last bit to one that is run alone."""
    if len(run.status) == 1:
        return run
    told = {"q_measured", "v_measured"} if run.ideal_sensor else set()
    changed: dict[str, Any] = dict.fromkeys(told)
    for item in fields(run):
        value = getattr(run, item.name)
        if item.name not in told and isinstance(value, np.ndarray) and item.name not in _SHARED:
            changed[item.name] = value[:1].copy()
            changed[item.name].setflags(write=False)
    own = tuple(violation for violation in run.limit_violations if violation.trial == 0)
    return replace(run, **changed, status=run.status[:1], limit_violations=own)


_SHARED = {"time", "q_ref", "v_ref", "a_ref"}


def bands(run: Rollout) -> dict[str, Array]:
    """5 % and 95 % of each signal over the trials, tick by tick: name -> (2, T, nv); none of a single trial.

    To three digits, since they are looked at and not computed with. NaN where trials that diverged would be part of
    it: a curve that ends there says so.
    """
    if len(run.status) == 1:
        return {}
    error = run.q_ref - run.q
    signals = {"error": error, "error_size": np.abs(error), "torque": run.torque, "s": run.s, "gain": run.gain}
    return {name: _band(values) for name, values in signals.items()}


def _band(values: Array) -> Any:
    gone = np.isnan(values)
    if gone.all():
        return np.full((2, *values.shape[1:]), np.nan, dtype=np.float32)
    filled = np.where(gone, np.inf, values)
    ends = np.stack([quantile(filled, LOW), quantile(filled, HIGH)])
    shown = np.where(np.isfinite(ends), ends, np.nan).astype(np.float32)
    # Three digits are more than a picture shows, and what follows them would be most of a result's size.
    return (shown.view(np.uint32) & np.uint32(0xFFFFF000)).view(np.float32)


def add_bands(dataset: xr.Dataset, found: Mapping[str, Mapping[str, Array]]) -> None:
    """Put the bands beside the trajectories of the first trial, dimensions (controller, time, joint).

    Args:
        dataset: Of the first trials, controllers in the order of `found`; written.
        found: By controller, see `bands`.
    """
    parts: Sequence[Mapping[str, Array]] = list(found.values())
    for name in BANDS if parts and parts[0] else ():
        like = {"error": "q", "error_size": "q"}.get(name, name)
        for end, words in enumerate(("5 %", "95 %")):
            key = f"{name}_{('low', 'high')[end]}"
            dataset[key] = (("controller", "time", "joint"), np.stack([part[name][end] for part in parts]))
            signal = {"error": "q_ref - q", "error_size": "|q_ref - q|"}.get(name, name)
            dataset[key].attrs = {
                "long_name": f"{words} of {signal} over the trials",
                "units": dataset[like].attrs["units"],
            }
