"""Writing what a comparison leaves on disk: trajectories and summary, whole and bitwise repeatable."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.disk.files import whole_folder
from asmc_pin.disk.unfinished import remove_leftovers
from asmc_pin.errors import ResultError
from asmc_pin.results.result_folder import EXPERIMENT, PROVENANCE
from asmc_pin.words.interface import flag_words, option_words

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from asmc_pin.arms import Arm
    from asmc_pin.engine import Rollout

# Variable: meaning, unit on a revolute joint, unit on a prismatic one.
VARIABLES: Mapping[str, tuple[str, str, str]] = {
    "q": ("joint position", "rad", "m"),
    "v": ("joint velocity", "rad/s", "m/s"),
    "q_ref": ("desired position", "rad", "m"),
    "v_ref": ("desired velocity", "rad/s", "m/s"),
    "a_ref": ("desired acceleration", "rad/s2", "m/s2"),
    "torque": ("torque applied over the period that begins here, after the drive's limits", "N m", "N"),
    "s": ("sliding variable s = de/dt + Ks e", "rad/s", "m/s"),
    "gain": ("switching gain of the law, NaN where it has none", "rad/s2", "m/s2"),
    "friction_torque": ("torque of joint friction, positive along the joint's axis", "N m", "N"),
}


def trajectories(arm: Arm, rollouts: Mapping[str, Rollout], laws: Mapping[str, str]) -> xr.Dataset:
    """The rollouts of several controllers on the same reference, as one dataset.

    Args:
        arm: The arm.
        rollouts: By label.
        laws: Name of each label's law.
    """
    import numpy as np
    import xarray as xr

    runs = list(rollouts.values())
    shared = ("q_ref", "v_ref", "a_ref")
    values: dict[str, Any] = {name: (("time", "joint"), getattr(runs[0], name)) for name in shared}
    for name in VARIABLES:
        if name not in shared:
            dims = ("controller", "trial", "time", "joint")
            values[name] = (dims, np.stack([getattr(run, name) for run in runs]))
    values = {name: values[name] for name in VARIABLES}
    values["status"] = (("controller", "trial"), np.array([run.status for run in runs], dtype=object))
    values["end_time"] = (("controller", "trial"), np.stack([run.end_time for run in runs]))
    dataset = xr.Dataset(
        values,
        coords={
            "controller": np.array(list(rollouts), dtype=object),
            "trial": np.arange(len(runs[0].status)),
            "time": runs[0].time,
            "joint": np.array(arm.joint_names, dtype=object),
            "law": ("controller", np.array([laws[label] for label in rollouts], dtype=object)),
            "joint_kind": ("joint", np.array(arm.joint_kinds, dtype=object)),
        },
        attrs={"arm": arm.name, "period": runs[0].period, "conventions": "SI; joint axis last; e = q_ref - q"},
    )
    kinds = set(arm.joint_kinds)
    for name, (meaning, revolute, prismatic) in VARIABLES.items():
        both = f"{revolute} (revolute), {prismatic} (prismatic)"
        unit = both if len(kinds) == 2 else revolute if "revolute" in kinds else prismatic
        dataset[name].attrs = {"long_name": meaning, "units": unit}
    dataset["time"].attrs = {"long_name": "control tick", "units": "s"}
    dataset["end_time"].attrs = {"long_name": "end of the run, or time of divergence", "units": "s"}
    return dataset


def write_trajectories(dataset: xr.Dataset, path: Path) -> None:
    """Write NetCDF-4 that is bitwise the same for the same data.

    It is made in memory: where a disk is full HDF5 prints tracebacks of its own. h5netcdf puts the versions of the
    libraries (``_NCProperties``) into a file that it creates, but not into one that it finds; so it is given an empty
    one.
    """
    import h5py  # type: ignore[import-untyped]

    content = io.BytesIO()
    with h5py.File(content, "w", track_order=True):
        pass
    content.seek(0)
    encoding = {
        name: {"zlib": True, "complevel": 2, "shuffle": True, "_FillValue": None}
        for name, values in dataset.data_vars.items()
        if "time" in values.dims and values.size
    }
    dataset.to_netcdf(content, mode="a", engine="h5netcdf", encoding=encoding)
    path.write_bytes(content.getbuffer())


def write_summary(rows: pd.DataFrame, path: Path) -> None:
    """Write the summary as Parquet, without the versions of the libraries that pandas would add."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.Table.from_pandas(rows, preserve_index=False).replace_schema_metadata(None)
    content = io.BytesIO()
    pq.write_table(table, content)
    path.write_bytes(content.getbuffer())


def check_target(path: Path, force: bool) -> None:
    """Whether a result may be written there, asked before anything is run.

    What a killed run left there is tidied up first: a result that it had moved away is put back.

    Raises:
        ResultError: something is there that is not to be replaced.
    """
    remove_leftovers(path)
    if path.is_symlink() or (path.exists() and not path.is_dir()):
        raise ResultError(path, f"{path} is not a folder; give another one with {option_words('out')}")
    if not path.exists() or not any(path.iterdir()):
        return
    if not all((path / name).is_file() for name in (EXPERIMENT, PROVENANCE)):
        raise ResultError(
            path,
            f"{path} holds files that are no result, and is left alone; give another folder with {option_words('out')}",
        )
    if not force:
        raise ResultError(
            path,
            f"there is a result in {path} already; "
            f"{flag_words('force')} replaces it, {option_words('out')} writes elsewhere",
        )


@contextmanager
def whole_or_not_at_all(path: Path, force: bool) -> Iterator[Path]:
    """A folder to write a result into, see `asmc_pin.disk.files.whole_folder`.

    Args:
        path: Where the result is to be.
        force: Whether it may replace a former one.

    Raises:
        ResultError: see `check_target`; or it cannot be written.
    """
    with whole_folder(path, lambda: check_target(path, force)) as made:
        yield made
