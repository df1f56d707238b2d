"""Whether gains lie in the region where the sampled loop is stable, as far as a quick search can tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.experiment import Experiment
from asmc_pin.plant import Plant
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.law_loops import law_loops
from asmc_pin.sampled.loop_analysis import spaces_of
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace
from asmc_pin.study.plant_sensor import sensor_of_plant

SAMPLES = 128
"""Configurations of the joint box at which a loop is looked at, before a local search from the worst of them."""

_FINEST = 0.01  # of a joint's range


class StableRegion:
    """The frozen loops of a law, over the joint boxes of several arms and about rest under gravity.

    Looked at are the loop of PPC that a law contains, the same inside its boundary layer, and the law's own inside a
    band where it is linear (docs/stability.md). A switching term is not linear and is left out. A law of another kind,
    without M̄, K_s and β, has no such loop, and nothing is asked of it.

    Args:
        trials: The experiment as it is in each training trial; trials with the same arm count once.
    """

    def __init__(self, trials: Sequence[Experiment]) -> None:
        self._plant = trials[0].build_plant()
        drive = self._plant.drive
        self._delay = drive.delay if drive is not None else 0.0
        self._sensor = sensor_of_plant(self._plant)
        arms: dict[str, Any] = {trial.arm.model_dump_json(): trial.build_arm() for trial in trials}
        viscous = _counted_on([trial.build_plant() for trial in trials])
        self._spaces = [
            space.thinned(SAMPLES, _FINEST)
            for arm in arms.values()
            for space in spaces_of(frozen_arms(arm, None), samples=SAMPLES, seed=0, viscous=viscous)
        ]

    def holds(self, law: Any) -> bool:
        """Whether every loop of the law has a spectral radius below 1 where it was searched."""
        loops: list[SampledLoop] = []
        for item in law_loops(self._plant.arm, {"law": law}, delay=self._delay, sensor=self._sensor):
            loops.append(item.loop)
            loops += [replace(item.loop, beta=item.loop.beta + slope) for slope in item.layers.values()]
            loops += list(item.bands.values())
        return all(self._stable(loop, space) for loop in loops for space in self._spaces)

    def _stable(self, loop: SampledLoop, space: Workspace) -> bool:
        if np.max(space.radii(loop)) >= 1.0:
            return False
        return bool(space.worst(loop)[0] < 1.0)


def _counted_on(plants: Sequence[Plant]) -> Array | None:
    """The least viscous friction that any of the plants has, its scatter included, (nv,), N·m·s/rad; None for none."""
    least = np.full(plants[0].nv, np.inf)
    for plant in plants:
        scattered = 1.0 if plant.spread is None else min(1.0, plant.spread.least_friction)
        least = np.minimum(least, scattered * np.asarray(plant.friction.viscous))
    return least if least.any() else None
