"""What the rows of a summary say of each controller over its trials, with failures as they count."""

from __future__ import annotations

import numpy as np
import pandas as pd

from asmc_pin._typing import Array, BoolArray
from asmc_pin.metrics import METRICS
from asmc_pin.statistics.joint_mean import joint_mean
from asmc_pin.statistics.order_statistics import spread_of, with_failures
from asmc_pin.statistics.pairwise import PairedComparison, pairwise


def labels_of(summary: pd.DataFrame) -> list[str]:
    """The controllers in their order."""
    return list(map(str, dict.fromkeys(summary.controller)))


def figures_by_trial(summary: pd.DataFrame, name: str) -> Array:
    """One column of the summary for every trial, shape (controllers, trials, nv), SI.

    +∞ where a trial failed, see `asmc_pin.statistics.order_statistics.with_failures`; NaN where the figure is not
    defined for that controller and joint.

    Args:
        summary: Rows in the order of controllers, trials and joints.
        name: A metric, or a figure of the tool.
    """
    values = _cube(summary, name).astype(np.float64)
    return np.stack([with_failures(*pair) for pair in zip(values, failures(summary), strict=True)])


def failures(summary: pd.DataFrame) -> BoolArray:
    """Whether a trial failed, shape (controllers, trials)."""
    return np.asarray(_cube(summary, "status")[:, :, 0] != "ok")


def ends(summary: pd.DataFrame) -> Array:
    """When each trial ended, shape (controllers, trials), s."""
    return np.asarray(_cube(summary, "end_time")[:, :, 0], dtype=np.float64)


def failed_words(failed: BoolArray, ended: Array) -> str:
    """How the trials of one controller ended: "ok", or how many diverged and when the first did.

    Args:
        failed: Shape (trials,).
        ended: Shape (trials,), s.
    """
    if not failed.any():
        return "ok"
    first = f"{ended[failed].min():.3g} s"
    if len(failed) == 1:
        return f"diverged at {first}"
    return f"{int(failed.sum())} of {len(failed)} diverged, the first at {first}"


def _cube(summary: pd.DataFrame, name: str) -> Array:
    shape = (len(dict.fromkeys(summary.controller)), summary.trial.nunique(), summary.joint.nunique())
    return np.asarray(summary[name].to_numpy().reshape(shape))


UNSEEN = 1e-5
"""Deviation of the starts up to which nobody could tell them apart, rad (m): a fifth of a count of 17 bits."""


def starts_words(deviation: float) -> str:
    """How the starts of trials differ, to follow "trials from".

    Args:
        deviation: Standard deviation of q(0), rad (m).
    """
    if deviation <= UNSEEN:
        return "starts that nobody could tell apart"
    return f"starts with a standard deviation of {deviation:g} rad (m)"


def alike(summary: pd.DataFrame) -> bool:
    """Whether all trials of each controller are the same to the last bit: as many runs as one, and no sample.

    So it is where starts do not deviate and nothing of the plant is random.

    Args:
        summary: Rows of a comparison.
    """
    if failures(summary).all():  # there is no figure to tell trials apart by
        return bool(summary.trial.nunique() == 1)
    for name in summary.columns.intersection(["status", "end_time", *METRICS]):
        values = pd.DataFrame(_cube(summary, name).swapaxes(0, 1).reshape(summary.trial.nunique(), -1))
        if not values.equals(pd.DataFrame(np.broadcast_to(values.to_numpy()[:1], values.shape))):
            return False
    return True


def paired(summary: pd.DataFrame) -> list[PairedComparison]:
    """Every pair of controllers by the metrics that a person reads first; nothing of trials all alike.

    By the `joint_mean`.

    Args:
        summary: Rows of a comparison.
    """
    if alike(summary):
        return []
    labels, family = labels_of(summary), {}
    for name, metric in METRICS.items():
        if metric.main and metric.best == "smallest":
            mean = joint_mean(figures_by_trial(summary, name), metric.least)
            family[name] = {label: row for label, row in zip(labels, mean, strict=True) if not np.isnan(row).any()}
    return pairwise(family)


def sensitivity(summary: pd.DataFrame, name: str) -> Array:
    """By what part of itself a metric moves from its 5 % to its 95 % quantile, shape (controllers, nv).

    +∞ where failures reach the 95 % quantile, NaN where the metric is not defined.
    """
    spread = spread_of(np.moveaxis(figures_by_trial(summary, name), 1, 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(spread.high == spread.low, 0.0 * spread.median, spread.high / spread.low - 1.0))
