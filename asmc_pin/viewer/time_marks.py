"""What happens while a result's arms move: pushes, loads, and the times that are worth a look."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin.results.kept_ticks import of_kept_ticks

if TYPE_CHECKING:
    import xarray as xr

    from asmc_pin.results.result_folder import Result


@dataclass(frozen=True)
class TimeMark:
    """Something at a time.

    Attributes:
        start: When, s.
        end: Until when, s; None for an instant.
        kind: ``push`` and ``load`` stand on the time line; a ``place`` is a time to go to.
        words: What, for a person.
    """

    start: float
    end: float | None
    kind: Literal["push", "load", "place"]
    words: str


def time_marks(result: Result, trial: int) -> list[TimeMark]:
    """What happens in one trial of a result, in the order of time."""
    duration = float(result.dataset.time[-1])
    kept = of_kept_ticks(result.experiment.log_every)
    errors = _largest_errors(result.dataset.isel(trial=trial), kept)
    marks = [*_acting(result, duration), *_worst(result, trial, kept), *errors]
    return sorted((mark for mark in marks if mark.start <= duration), key=lambda mark: mark.start)


def _acting(result: Result, duration: float) -> Iterator[TimeMark]:
    plant = result.experiment.build_plant()
    for push in plant.disturbances:
        end = duration if push.duration is None else min(push.start + push.duration, duration)
        what = f"torques of up to {np.abs(push.torque).max():g}" if push.link is None else f"a wrench at {push.link}"
        span = f"{push.start:g} s to {end:g} s"
        yield TimeMark(push.start, end, "push", f"Push ({push.profile}), {what}: {span}")
    for change in plant.payload_changes:
        load = change.payload
        what = "Nothing is carried" if load is None or load.mass == 0.0 else f"Load of {load.mass:g} kg"
        yield TimeMark(change.time, None, "load", f"{what} from {change.time:g} s on")


def _worst(result: Result, trial: int, kept: str) -> Iterator[TimeMark]:
    """The configuration in which Lemma 1's norm is largest, of all controllers that have one."""
    if result.monitors is None or "lemma1_norm" not in result.monitors:
        return
    norms = result.monitors.lemma1_norm.isel(trial=trial).transpose("controller", "time").to_numpy()
    if not np.isfinite(norms).any():
        return
    k, tick = np.unravel_index(np.nanargmax(norms), norms.shape)
    time, label = float(result.monitors.time[tick]), str(result.monitors.controller.to_numpy()[k])
    words = f"Worst configuration, Lemma 1's norm {norms[k, tick]:.4g} ({label}{kept}): {time:.3g} s"
    yield TimeMark(time, None, "place", words)


def _largest_errors(run: xr.Dataset, kept: str) -> Iterator[TimeMark]:
    """Of each controller, when the error of a joint is largest; of a mixed arm, of the joints that turn."""
    kinds = run.joint_kind.to_numpy()
    alike = kinds == "revolute" if (kinds == "revolute").any() else kinds == kinds[0]
    error = np.abs(run.q_ref.transpose("time", "joint") - run.q).transpose("controller", "time", "joint").to_numpy()
    for label, each in zip(run.controller.to_numpy(), error[:, :, alike], strict=True):
        if np.isfinite(each).any():
            time = float(run.time[np.nanargmax(np.nan_to_num(each, nan=-1.0).max(axis=1))])
            yield TimeMark(time, None, "place", f"Largest joint error of {label}{kept}: {time:.3g} s")
