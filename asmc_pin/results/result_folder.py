"""What a comparison leaves on disk, and reading it back.

A result is a folder: ``experiment.toml``, ``trajectories.nc``, ``summary.parquet``, ``summary.md``, ``summary.tex``,
``claims.parquet``, ``monitors.nc``, ``figures/``, ``report.html``, ``provenance.json``. It appears as a whole or not at
all.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.disk.files import remove_leftovers, whole_folder
from asmc_pin.disk.reading import shown, user_path
from asmc_pin.errors import AsmcPinError, ResultError
from asmc_pin.results.kept_ticks import LOG_EVERY
from asmc_pin.results.result_files import LARGEST

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from asmc_pin.arms import Arm
    from asmc_pin.engine import Rollout
    from asmc_pin.experiment import Experiment

EXPERIMENT, TRAJECTORIES, SUMMARY, PROVENANCE = (
    "experiment.toml",
    "trajectories.nc",
    "summary.parquet",
    "provenance.json",
)
MONITORS, CLAIMS = "monitors.nc", "claims.parquet"
"""What the theorems' monitors found (docs/monitors.md); a result made without them is whole too."""
EXPANDED = "computed_arm.urdf"
"""The URDF that was computed with, where it is not the file that was read."""

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


@dataclass(frozen=True)
class Result:
    """A result read back.

    Attributes:
        path: Its folder.
        experiment: The experiment as it was run.
        dataset: Trajectories; dimensions controller, trial, time, joint. Of the control ticks those are in it that the
            experiment's `log_every` divides.
        summary: One row for each controller, trial and joint; metrics in SI units.
        provenance: Versions, hashes, seed, times.
        claims: The paper's claims on each controller and trial, see `asmc_pin.monitors.claim_rows`; None without.
        monitors: The arrays behind them, see `asmc_pin.monitors.monitor_dataset`; None without.
    """

    path: Path
    experiment: Experiment
    dataset: xr.Dataset
    summary: pd.DataFrame
    provenance: dict[str, Any]
    claims: pd.DataFrame | None = None
    monitors: xr.Dataset | None = None


def find_result(path: str | Path) -> Path:
    """Folder of a result, not yet read; for arguments and errors see `load_result`."""
    folder = user_path(path)
    try:
        if not folder.exists() and (Path("results") / folder).is_dir():
            folder = Path("results") / folder
    except OSError as error:
        raise ResultError(folder, f"{shown(folder)}: cannot be read ({error.strerror})") from None
    if not folder.is_dir():
        raise ResultError(folder, f"there is no result {shown(folder)}; {_maker_of(folder)}")
    absent = [name for name in (EXPERIMENT, TRAJECTORIES, SUMMARY, PROVENANCE) if not (folder / name).exists()]
    if absent:
        said = f"{shown(folder)} is not a result of asmc-pin compare: it has no {', '.join(absent)}"
        raise ResultError(folder, said + _instead_of(folder))
    return folder


def _maker_of(folder: Path) -> str:
    """How a result that is not there comes to be; the name of a shipped experiment is what a beginner gives."""
    from asmc_pin.experiment.finding import experiment_names

    if str(folder) in experiment_names():
        return f"make it with: asmc-pin compare {folder}"
    return "asmc-pin compare makes one"


def _instead_of(folder: Path) -> str:
    """What to do with the folder of a sweep or of a tuning, which have no trajectories."""
    if (folder / "rows.parquet").exists() or (folder / "rows").is_dir():
        return (
            "; it is a sweep: its report.html has the figures, 'asmc-pin sweep … --replay TRIAL' the motion of a trial"
        )
    if (folder / "tuned.toml").exists():
        return f"; it is a tuning: run its gains with 'asmc-pin compare {shown(folder / 'tuned.toml')}'"
    return ""


def load_result(path: str | Path, *, largest: float = LARGEST) -> Result:
    """Read the result of a comparison, which a stranger may have made.

    What the files hold is checked against each other and against the experiment, and no code is run that they name: a
    law of one's own is not imported, see `asmc_pin.experiment.load_experiment`.

    Args:
        path: Its folder, or the name of one in ``results/``.
        largest: Bytes of arrays at most, as they lie in memory.

    Raises:
        ResultError: the folder is missing, is not a whole result, or is damaged.
    """
    folder = find_result(path)
    from asmc_pin.arms.sources.carried import carried_urdf
    from asmc_pin.experiment import load_experiment
    from asmc_pin.experiment.experiment import take_carried_arm
    from asmc_pin.results import result_schema as schema
    from asmc_pin.results.result_files import check_digest, read_arrays, read_json, read_rows

    hashed = (EXPERIMENT, TRAJECTORIES, SUMMARY, CLAIMS, MONITORS, EXPANDED)
    files = {name: folder / name for name in (*hashed, PROVENANCE)}
    try:
        experiment = load_experiment(files[EXPERIMENT], import_laws=False)
        provenance = read_json(files[PROVENANCE])
        schema.check_provenance(files[PROVENANCE], provenance)
        for name in hashed:
            if files[name].exists():
                check_digest(files[name], provenance, largest)
        take_carried_arm(experiment, carried_urdf(files[EXPANDED], provenance.get("arm", {})))
        dataset = read_arrays(files[TRAJECTORIES], largest)
        schema.check_trajectories(files[TRAJECTORIES], dataset, experiment)
        trials = max(dataset.sizes["trial"], experiment.ensemble.trials)
        rows = len(dataset.controller) * trials * dataset.sizes["joint"]
        summary = read_rows(files[SUMMARY], rows)
        schema.check_summary(files[SUMMARY], summary, dataset)
        claims = monitors = None
        if files[CLAIMS].exists():
            claims = read_rows(files[CLAIMS], 100 * rows)
            schema.check_claims(files[CLAIMS], claims, dataset)
        if files[MONITORS].exists():
            monitors = read_arrays(files[MONITORS], largest)
            schema.check_monitors(files[MONITORS], monitors, dataset)
    except AsmcPinError as error:
        raise ResultError(folder, f"{shown(folder)} cannot be read, run the comparison again: {error}") from error
    return Result(folder, experiment, dataset, summary, provenance, claims, monitors)


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


def recorded_run(dataset: xr.Dataset, label: str, trial: int = 0) -> Rollout:
    """One run out of a comparison's trajectories, for `asmc_pin.metrics.METRICS`; the inverse of `trajectories`.

    Args:
        dataset: Trajectories, or a part of them in time: a trial that diverged after that part counts as ``"ok"``.
        label: Controller.
        trial: Which; the run has it as its only one.

    Returns:
        The run as the plant had it. What the law was told and which joints left their limits is not recorded; and a
        result with `log_every` has not every tick, without which there are no metrics.
    """
    import numpy as np

    from asmc_pin.engine import Rollout

    run = dataset.sel(controller=label).isel(trial=[trial])
    time = dataset.time.to_numpy()
    end = run.end_time.to_numpy()
    shared = ("q_ref", "v_ref", "a_ref")
    status = str(run.status.item()) if end[0] <= time[-1] else "ok"
    return Rollout(
        time=time,
        **{name: run[name].to_numpy() for name in VARIABLES if name not in shared},
        **{name: dataset[name].to_numpy() for name in shared},
        status=(status,),
        end_time=np.minimum(end, time[-1]),
        joint_names=tuple(map(str, dataset.joint.to_numpy())),
        period=float(dataset.attrs["period"]),
        limit_violations=(),
        log_every=int(dataset.attrs.get(LOG_EVERY, 1)),
    )


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
        raise ResultError(path, f"{path} is not a folder; give another one with --out")
    if not path.exists() or not any(path.iterdir()):
        return
    if not all((path / name).is_file() for name in (EXPERIMENT, PROVENANCE)):
        raise ResultError(
            path, f"{path} holds files that are no result, and is left alone; give another folder with --out"
        )
    if not force:
        raise ResultError(path, f"there is a result in {path} already; --force replaces it, --out writes elsewhere")


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
