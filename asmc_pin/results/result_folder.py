"""What a comparison leaves on disk, and reading it back.

A result is a folder: ``experiment.toml``, ``trajectories.nc``, ``summary.parquet``, ``summary.md``, ``summary.tex``,
``claims.parquet``, ``monitors.nc``, ``figures/``, ``report.html``, ``provenance.json``. It appears as a whole or not at
all.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.disk.reading import shown, user_path
from asmc_pin.errors import AsmcPinError, ResultError
from asmc_pin.results.result_files import LARGEST
from asmc_pin.words.nearest_name import near_names
from asmc_pin.words.shown import Cells, Shown
from asmc_pin.words.text import counted

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

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


@dataclass(frozen=True, eq=False, repr=False)
class Result(Shown):
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

    def lines(self) -> list[str]:
        """What was compared, and where it lies."""
        controllers = counted(len(self.dataset.controller), "controller")
        trials = counted(int(self.summary.trial.nunique()), "trial")
        return [
            f"{self.experiment.name}: {controllers} on {self.experiment.arm.words()}, {trials} of each",
            f"folder: {self.path}",
        ]

    def table(self) -> Cells:
        """The controllers: their laws, and in how many trials each diverged."""
        rows = []
        for label, mine in self.summary.groupby("controller", sort=False):
            ends = mine.drop_duplicates("trial").status
            rows.append([str(label), str(mine.law.iloc[0]), f"{(ends == 'diverged').sum()} of {len(ends)}"])
        return ["controller", "law", "diverged"], rows


def find_result(path: str | Path) -> Path:
    """Folder of a result, not yet read; for arguments and errors see `load_result`."""
    folder = user_path(path)
    try:
        if not folder.exists() and (Path("results") / folder).is_dir():
            folder = Path("results") / folder
    except OSError as error:
        raise ResultError(folder, f"{shown(folder)}: cannot be read ({error.strerror})") from None
    if folder.is_file():
        raise ResultError(folder, f"{shown(folder)} is a file, and a result is a folder; give the folder")
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
    made = {each.name: each for above in (folder.parent, Path("results")) for each in _folders_in(above)}
    if near := near_names(folder.name, {*made, *experiment_names()}):
        return f"did you mean {' or '.join(shown(made.get(name, Path(name))) for name in near)}?"
    return "asmc-pin compare makes one"


def _folders_in(folder: Path) -> list[Path]:
    try:
        return [each for each in folder.iterdir() if (each / EXPERIMENT).is_file()]
    except OSError:
        return []


def _instead_of(folder: Path) -> str:
    """What to do with the folder of a sweep, of a tuning or of a benchmark, which have no trajectories."""
    if (folder / "rows.parquet").exists() or (folder / "rows").is_dir():
        return (
            "; it is a sweep: its report.html has the figures, 'asmc-pin sweep … --replay TRIAL' the motion of a trial"
        )
    if (folder / "tuned.toml").exists():
        return f"; it is a tuning: run its gains with 'asmc-pin compare {shown(folder / 'tuned.toml')}'"
    if (folder / "bench.json").exists():
        return f"; it is a benchmark: read {shown(folder / 'report.html')}"
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
