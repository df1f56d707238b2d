"""One tick in so many: what of a comparison's arrays goes to disk where an experiment has `log_every`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin._typing import Array

if TYPE_CHECKING:
    import xarray as xr

LOG_EVERY = "log_every"
"""Attribute of arrays of which not every tick is kept."""
RANGE = "q_ref_low", "q_ref_high"
"""Their variables for the range of the reference at any tick."""


def kept_ticks(dataset: xr.Dataset, log_every: int) -> xr.Dataset:
    """Ticks 0, N, 2N and so on of arrays along time, each as it was; the range of the reference stays that of all.

    Args:
        dataset: Trajectories, or what monitors found, of every tick.
        log_every: N.

    Returns:
        The dataset itself where every tick is kept.
    """
    if log_every == 1:
        return dataset
    kept = dataset.isel(time=slice(None, None, log_every)).assign_attrs({LOG_EVERY: log_every})
    if "q_ref" in dataset:
        for name, end, word in zip(RANGE, ("min", "max"), ("lowest", "highest"), strict=True):
            kept[name] = getattr(dataset.q_ref, end)("time")
            kept[name].attrs = {
                "long_name": f"{word} desired position at any tick",
                "units": dataset.q_ref.attrs["units"],
            }
    return kept


def reference_range(dataset: xr.Dataset) -> Array:
    """The lowest and the highest desired position of each joint over all ticks of the run, (2, nv), rad (m)."""
    import numpy as np

    if all(name in dataset for name in RANGE):
        return np.stack([dataset[name].to_numpy() for name in RANGE])
    reference = dataset.q_ref.transpose("time", "joint").to_numpy()
    return np.stack([reference.min(axis=0), reference.max(axis=0)])


def keeps_the_end(ticks: int, log_every: int) -> bool:
    """Whether the last of so many ticks is kept, whose torque acts in a period that the run does not have any more."""
    return (ticks - 1) % log_every == 0


def of_kept_ticks(log_every: int) -> str:
    """What to add to words about a figure that is read off kept ticks; nothing where every tick is kept."""
    return "" if log_every == 1 else f", of one tick in {log_every}"
