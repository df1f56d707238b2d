"""A run out of the trajectories of a comparison, to ask of it what is asked of a run."""

from __future__ import annotations

import xarray as xr

from asmc_pin import Rollout
from asmc_pin.results.kept_ticks import LOG_EVERY
from asmc_pin.results.result_writing import VARIABLES


def recorded_run(dataset: xr.Dataset, label: str) -> Rollout:
    """The first trial of a controller as the plant had it; a result with `log_every` has not every tick of it."""
    run = dataset.sel(controller=label).isel(trial=[0])
    shared = ("q_ref", "v_ref", "a_ref")
    return Rollout(
        time=dataset.time.to_numpy(),
        **{name: run[name].to_numpy() for name in VARIABLES if name not in shared},
        **{name: dataset[name].to_numpy() for name in shared},
        status=(str(run.status.item()),),
        end_time=run.end_time.to_numpy(),
        joint_names=tuple(map(str, dataset.joint.to_numpy())),
        period=float(dataset.attrs["period"]),
        limit_violations=(),
        log_every=int(dataset.attrs.get(LOG_EVERY, 1)),
    )
