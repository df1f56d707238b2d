"""The tool's error as results show it: in mm and rad."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from asmc_pin.tool_error import ToolError

_COLUMNS = ("rms_position", "max_position", "rms_rotation", "max_rotation")


def tool_figures(error: ToolError) -> dict[str, str | float | None]:
    """Figures of the first trial for ``compare --json``: mm and rad; null where not defined."""
    found = {name: float(value[0]) for name, value in error.figures().items()}
    units = {"position": ("mm", 1e3), "rotation": ("rad", 1.0)}
    figures: dict[str, str | float | None] = {"frame": error.frame}
    for name in _COLUMNS:
        unit, scale = units[name.split("_")[1]]
        figures[f"{name}_{unit}"] = scale * found[name] if math.isfinite(found[name]) else None
    return figures


def add_tool_columns(rows: pd.DataFrame, errors: Mapping[str, ToolError]) -> None:
    """Put the figures into the summary: the same for every joint of a trial, in m and rad.

    Args:
        rows: See `asmc_pin.study.comparison.summary_rows`; written.
        errors: By label as the summary has it; nothing is done if there are none.
    """
    for label, error in errors.items():
        here = rows.controller == label
        rows.loc[here, "tool"] = error.frame
        for name, values in error.figures().items():
            rows.loc[here, f"tool_{name}"] = values[rows.trial[here].to_numpy()]


def add_tool_error(dataset: xr.Dataset, errors: Sequence[ToolError]) -> None:
    """Put the error over time beside the trajectories, dimensions (controller, trial, time)."""
    if not errors:
        return
    for name, unit, meaning in (("position", "m", "distance"), ("rotation", "rad", "angle of the turn")):
        values = np.stack([getattr(error, name) for error in errors])
        dataset[f"tool_error_{name}"] = (("controller", "trial", "time"), values)
        text = f"{meaning} between frame {errors[0].frame} and its reference"
        dataset[f"tool_error_{name}"].attrs = {"long_name": text, "units": unit}
