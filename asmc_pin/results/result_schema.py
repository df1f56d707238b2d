"""What the files of a result must hold to be shown: names, axes, sizes and kinds, and that they speak of one run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from asmc_pin.errors import ResultError
from asmc_pin.experiment.toml_keys import MOST_TRIALS
from asmc_pin.metrics import METRICS, MOVED
from asmc_pin.monitors import BAEK, CAUSES, STATEMENTS, STATUSES
from asmc_pin.results.kept_ticks import LOG_EVERY, RANGE
from asmc_pin.results.result_files import Columns, check_columns
from asmc_pin.words.text import printable

if TYPE_CHECKING:
    from asmc_pin.experiment import Experiment

_AXES = ("controller", "trial", "time", "joint")
_RUN, _TRIAL, _SHARED = _AXES, _AXES[:2], _AXES[2:]
_TEXT = {"controller": ("controller",), "law": ("controller",), "joint": ("joint",), "joint_kind": ("joint",)}
_NUMBERS = {
    **dict.fromkeys(("q", "v", "torque", "s", "gain", "friction_torque"), _RUN),
    **dict.fromkeys(("q_ref", "v_ref", "a_ref"), _SHARED),
    "end_time": _TRIAL,
    "trial": ("trial",),
    "time": ("time",),
}
_FURTHEST = 1e9
"""rad (m): a run ends as diverged long before it, and a picture of it would be nothing but overflow."""

_KINDS = ("revolute", "prismatic")

_SUMMARY: Columns = {
    **dict.fromkeys(("experiment", "arm", "controller", "law", "joint", "joint_kind", "status"), "text"),
    "knows_model": "flag",
    "trial": "count",
    "end_time": "number",
    **dict.fromkeys(METRICS, "number"),
}
_TOOL: Columns = {
    "tool": "text",
    **{f"tool_{name}": "number" for name in ("rms_position", "max_position", "rms_rotation", "max_rotation")},
    **{f"tool_path_{name}": "number" for name in ("accuracy", "repeatability")},
}
_MOVED: Columns = {f"{MOVED}{name}": "number" for name in METRICS}
"""How half the step moves each metric, where that was asked for."""
_CLAIMS: Columns = {
    **dict.fromkeys(("controller", "claim", "title", "statement", "status", "unit", "reason"), "text"),
    **dict.fromkeys(("trial", "checked", "broken", *CAUSES), "count"),
    **dict.fromkeys(("first_time", "worst_time", "amount", "until"), "number"),
}


def check_trajectories(path: Path, dataset: xr.Dataset, experiment: Experiment) -> None:
    """Whether these are the trajectories of an experiment.

    Args:
        path: Their file, for messages.
        dataset: As read.
        experiment: As run.

    Raises:
        ResultError: A variable is missing, or is not of its axes, kind or size.
    """
    for names, kind, what in ((_TEXT | {"status": _TRIAL}, "UO", "text"), (_NUMBERS, "iuf", "numbers")):
        for name, axes in names.items():
            found = dataset.variables.get(name)
            if found is None:
                raise ResultError(path, f"{path}: has no variable '{name}'")
            if found.dims != axes:
                given = printable(", ".join(map(str, found.dims)))
                raise ResultError(path, f"{path}: '{name}' has the axes ({given}), ({', '.join(axes)}) expected")
            if found.dtype.kind not in kind:
                raise ResultError(path, f"{path}: '{name}' does not hold {what}")
    sizes = dataset.sizes
    ticks = len(experiment.time[:: experiment.log_every])
    for axis, expected in (("controller", len(experiment.controllers)), ("time", ticks)):
        if sizes[axis] != expected:
            raise ResultError(path, f"{path}: has {sizes[axis]} along '{axis}', its experiment has {expected}")
    if not np.array_equal(dataset.attrs.get(LOG_EVERY, 1), experiment.log_every):
        raise ResultError(path, f"{path}: says of '{LOG_EVERY}' something else than its experiment")
    if not 1 <= sizes["trial"] <= MOST_TRIALS or sizes["joint"] < 1:
        raise ResultError(path, f"{path}: has {sizes['trial']} trials of {sizes['joint']} joints")
    _check_names(path, dataset, experiment)
    _check_times(path, dataset)
    for name in ("q", "q_ref"):
        if bool((np.abs(dataset[name].to_numpy()) > _FURTHEST).any()):
            raise ResultError(path, f"{path}: '{name}' has positions beyond {_FURTHEST:g} rad (m)")
    if not np.isfinite(dataset.q_ref.to_numpy()).all():
        raise ResultError(path, f"{path}: 'q_ref' has a position that is no number")
    for name in RANGE:
        found = dataset.get(name, dataset.q_ref[0])
        if found.dims != ("joint",) or found.dtype.kind not in "iuf" or not np.isfinite(found.to_numpy()).all():
            raise ResultError(path, f"{path}: '{name}' does not hold a number for each joint")
    for name in ("warnings", "notes"):
        if not isinstance(dataset.attrs.get(name, ""), str):
            raise ResultError(path, f"{path}: its attribute '{name}' is no text")


def _check_names(path: Path, dataset: xr.Dataset, experiment: Experiment) -> None:
    for name in _TEXT:
        for text in dataset[name].to_numpy():
            if not isinstance(text, str) or printable(text) != text:
                raise ResultError(
                    path, f"{path}: '{name}' has the name '{printable(str(text))}', which is not plain text"
                )
    labels = dataset.controller.to_numpy().tolist()
    # A label as shown may carry a mark.
    same = all(
        shown == label or shown.startswith(f"{label} (") for shown, label in _pairs(labels, experiment.controllers)
    )
    if not same or len(set(labels)) != len(labels):
        raise ResultError(path, f"{path}: its controllers are {_listed(labels)}, not those of its experiment")
    if len(set(dataset.joint.to_numpy().tolist())) != dataset.sizes["joint"]:
        raise ResultError(path, f"{path}: two of its joints have the same name")
    if not set(dataset.joint_kind.to_numpy().tolist()) <= set(_KINDS):
        raise ResultError(path, f"{path}: 'joint_kind' has others than {' and '.join(_KINDS)}")
    states = {str(state) for state in dataset.status.to_numpy().ravel()}
    if not states <= {"ok", "diverged"}:
        raise ResultError(path, f"{path}: a status is {_listed(sorted(states))}, 'ok' or 'diverged' expected")


def _check_times(path: Path, dataset: xr.Dataset) -> None:
    time = dataset.time.to_numpy()
    if not (np.isfinite(time).all() and time[0] == 0.0 and (np.diff(time) > 0.0).all() and time[-1] < 1e12):
        raise ResultError(path, f"{path}: its times are not finite and increasing from 0")
    if dataset.trial.to_numpy().tolist() != list(range(dataset.sizes["trial"])):
        raise ResultError(path, f"{path}: its trials are not numbered from 0")
    if not np.isfinite(dataset.end_time.to_numpy()).all():
        raise ResultError(path, f"{path}: 'end_time' has one that is no number")


def check_summary(path: Path, rows: pd.DataFrame, dataset: xr.Dataset) -> None:
    """Whether the rows are those of checked trajectories: one for each controller, trial and joint, in that order.

    There may be more trials than those whose trajectories are kept.

    Raises:
        ResultError: A column or a row is missing, or speaks of something else.
    """
    check_columns(path, rows, _SUMMARY)
    if "tool" in rows:
        check_columns(path, rows, _TOOL)
    if any(str(name).startswith(MOVED) for name in rows):
        check_columns(path, rows, _MOVED)
    labels, joints = dataset.controller.to_numpy().tolist(), dataset.joint.to_numpy().tolist()
    kinds, trials = dataset.joint_kind.to_numpy().tolist(), len(rows) // (len(labels) * len(joints))
    if trials < dataset.sizes["trial"]:
        raise ResultError(path, f"{path}: has rows of {trials} trials, trajectories.nc has {dataset.sizes['trial']}")
    keys = ["controller", "trial", "joint", "joint_kind"]
    expected = [
        (label, trial, joint, kind)
        for label in labels
        for trial in range(trials)
        for joint, kind in zip(joints, kinds, strict=True)
    ]
    if list(rows[keys].itertuples(index=False, name=None)) != expected:
        raise ResultError(
            path, f"{path}: its rows are not those of the controllers, trials and joints of trajectories.nc"
        )
    if not set(rows.status) <= {"ok", "diverged"} or not np.isfinite(rows.end_time).all():
        raise ResultError(path, f"{path}: a row has a status or an end that no run has")


def check_claims(path: Path, rows: pd.DataFrame, dataset: xr.Dataset) -> None:
    """Whether the claims are some of the monitors', on controllers and trials of checked trajectories.

    Raises:
        ResultError: They are not.
    """
    check_columns(path, rows, _CLAIMS)
    known = {
        "controller": dataset.controller.to_numpy().tolist(),
        "claim": list(STATEMENTS),
        "status": list(STATUSES),
        "trial": range(dataset.sizes["trial"]),
    }
    for name, values in known.items():
        if not set(rows[name]) <= set(values):
            raise ResultError(path, f"{path}: column '{name}' has one that this result does not know")
    if rows.duplicated(["controller", "trial", "claim"]).any():
        raise ResultError(path, f"{path}: a claim stands there twice")
    # Results of an earlier version lack claims that came later; they lack them everywhere.
    whole = len(dataset.controller) * dataset.sizes["trial"] * max(rows.claim.nunique(), len(BAEK))
    if len(rows) != whole:
        raise ResultError(path, f"{path}: has {len(rows)} claims, {whole} expected")


def check_monitors(path: Path, monitors: xr.Dataset, dataset: xr.Dataset) -> None:
    """Whether the monitors' arrays are numbers on the axes of checked trajectories.

    Raises:
        ResultError: They are not.
    """
    for axis in _AXES:
        if axis not in monitors.coords or not np.array_equal(monitors[axis].to_numpy(), dataset[axis].to_numpy()):
            raise ResultError(path, f"{path}: its axis '{axis}' is not that of trajectories.nc")
    for name, values in monitors.data_vars.items():
        if not set(values.dims) <= set(_AXES) or values.dtype.kind not in "iuf":
            raise ResultError(path, f"{path}: '{printable(str(name))}' is no array of numbers on the run's axes")


def check_provenance(path: Path, provenance: Mapping[str, Any]) -> None:
    """Whether what is shown of the provenance is there in its form, as far as it is there.

    Raises:
        ResultError: It is something else.
    """
    arm = provenance.get("arm", {})
    if not isinstance(arm, dict) or not isinstance(arm.get("sha256", ""), str):
        raise ResultError(path, f"{path}: 'arm' is no object with the hash of a URDF")
    provisos = arm.get("provisos", [])
    if not isinstance(provisos, list) or not all(
        isinstance(each, dict) and all(isinstance(each.get(key), str) for key in ("kind", "text")) for each in provisos
    ):
        raise ResultError(path, f"{path}: 'arm.provisos' is no list of objects with 'kind' and 'text'")


def _pairs(labels: list[str], controllers: Mapping[str, Any]) -> list[tuple[str, str]]:
    return list(zip(labels, controllers, strict=True))


def _listed(names: list[Any]) -> str:
    return printable(", ".join(f"'{name}'" for name in names))
