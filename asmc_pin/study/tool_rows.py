"""The tool's error as results show it: in mm and rad."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from asmc_pin.results.ensemble_summary import figures_by_trial
from asmc_pin.statistics.order_statistics import spread_of
from asmc_pin.tool_error import ToolError
from asmc_pin.tool_path import ToolPath

_COLUMNS = ("rms_position", "max_position", "rms_rotation", "max_rotation", "path_accuracy", "path_repeatability")


def tool_figures(rows: pd.DataFrame) -> dict[str, str | float | None]:
    """Figures of one controller for ``compare --json``: mm and rad, median, 5 % and 95 %; null where not defined."""
    figures: dict[str, str | float | None] = {"frame": str(rows.tool.iloc[0])}
    for name in _COLUMNS:
        spread = spread_of(figures_by_trial(rows, f"tool_{name}")[0, :, 0])
        factor = 1.0 if name.endswith("rotation") else 1e3
        key = f"{name}_{'rad' if name.endswith('rotation') else 'mm'}"
        ends = {"": spread.median}
        if not name.startswith("path"):  # which is a figure of all trials together
            ends |= {"_low": spread.low, "_high": spread.high}
        figures |= {key + end: factor * float(x) if np.isfinite(x) else None for end, x in ends.items()}
    return figures


def add_tool_columns(rows: pd.DataFrame, error: ToolError, path: ToolPath) -> None:
    """Put the figures into a controller's summary: the same for every joint of a trial, in m and rad.

    Args:
        rows: See `asmc_pin.study.comparison.summary_rows`; written.
        error: Of every trial.
        path: Over all trials as passes, so the same in each of them.
    """
    rows["tool"] = error.frame
    for name, values in error.figures().items():
        rows[f"tool_{name}"] = values[rows.trial.to_numpy()]
    for name in ("accuracy", "repeatability"):
        value = float(getattr(path, name))
        rows[f"tool_path_{name}"] = value if np.isfinite(value) else np.nan


def add_tool_error(dataset: xr.Dataset, errors: Sequence[ToolError]) -> None:
    """Put the error over time beside the trajectories, dimensions (controller, trial, time)."""
    if not errors:
        return
    for name, unit, meaning in (("position", "m", "distance"), ("rotation", "rad", "angle of the turn")):
        values = np.stack([getattr(error, name) for error in errors])
        dataset[f"tool_error_{name}"] = (("controller", "trial", "time"), values)
        text = f"{meaning} between frame {errors[0].frame} and its reference"
        dataset[f"tool_error_{name}"].attrs = {"long_name": text, "units": unit}
