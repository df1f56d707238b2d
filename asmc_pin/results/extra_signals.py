"""Signals of a comparison besides those that every result has: what was measured, what pushed, and the energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from asmc_pin.engine import Rollout
from asmc_pin.plant import Plant
from asmc_pin.plant.energy import stored_energy

# Name: meaning, and the variable whose unit it has.
_MEASURED = {
    "q_measured": ("joint position as the law was told", "q"),
    "v_measured": ("joint velocity as the law was told", "v"),
    "torque_measured": ("torque of the last period as the law was told", "torque"),
}
_EXTERNAL = {"external_torque": ("torque of the disturbances over the period that begins here", "torque")}


def add_signals(dataset: xr.Dataset, plant: Plant, runs: Sequence[Rollout]) -> None:
    """Put the mechanical energy beside the trajectories, and measured and external signals where there are such.

    Args:
        dataset: Of the runs, in their order; written.
        plant: What they ran on.
        runs: One for each controller.
    """
    found = dict(_MEASURED) if plant.sensor is not None else {}
    found |= _EXTERNAL if plant.disturbances else {}
    for name, (meaning, like) in found.items():
        values = np.stack([getattr(run, name) for run in runs])
        dataset[name] = (("controller", "trial", "time", "joint"), values)
        dataset[name].attrs = {"long_name": meaning, "units": dataset[like].attrs["units"]}
    energy = np.stack([stored_energy(plant, run) for run in runs])
    dataset["energy"] = (("controller", "trial", "time"), energy)
    dataset["energy"].attrs = {"long_name": "kinetic and potential energy of the arm", "units": "J"}
