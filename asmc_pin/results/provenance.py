"""Where a result comes from: the one file of it that carries times and versions."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from asmc_pin.arms import Arm
from asmc_pin.experiment import Experiment
from asmc_pin.references import reference_words
from asmc_pin.words.provisos import provisos_json

# What the figures depend on.
PACKAGES = (
    "asmc-pin",
    "pin",
    "example-robot-data",
    "numpy",
    "scipy",
    "numba",
    "xarray",
    "h5netcdf",
    "h5py",
    "pandas",
    "pyarrow",
    "matplotlib",
)


def provenance(
    experiment: Experiment, arm: Arm, started: datetime, seconds: Mapping[str, float], folder: Path
) -> dict[str, Any]:
    """Versions, hashes, seed and times of a run, ready for JSON; nothing of the folders of whoever ran it.

    Args:
        experiment: As run.
        arm: As run.
        started: When, with its time zone.
        seconds: Wall time of each controller's run, s.
        folder: The result, complete but for this; every file in it is listed with its SHA-256.
    """
    return {
        "experiment": {
            "name": experiment.name,
            "folder": _way(experiment.folder, folder),
            "sha256": _digest(experiment.to_toml().encode()),
        },
        "arm": {
            "name": arm.name,
            "urdf": arm.source.name,
            "sha256": arm.sha256,
            **(_made(arm) if arm.provisos else {}),
        },
        **({"reference": told} if (told := list(reference_words(experiment.build_reference()))) else {}),
        "seed": experiment.seed,
        "started": started.isoformat(timespec="seconds"),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "seconds": {label: round(value, 3) for label, value in seconds.items()},
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "packages": {name: package_version(name) for name in PACKAGES},
        "files": {
            path.relative_to(folder).as_posix(): _digest(path.read_bytes())
            for path in sorted(folder.rglob("*"))
            if path.is_file()
        },
    }


def _made(arm: Arm) -> dict[str, Any]:
    """Of an arm that is not as its file says: how, and the hash of what was computed with (``computed_arm.urdf``)."""
    return {"provisos": provisos_json(arm.provisos), "urdf_sha256": _digest(arm.urdf_text.encode())}


def _way(there: Path, result: Path) -> str | None:
    """The way from a result to the experiment's folder, where what they share is somebody's own; else None.

    A result that moves together with its experiment finds it again; one that is sent away tells no stranger's folders.
    """
    there, result = there.resolve(), result.resolve()
    try:
        shared = Path(os.path.commonpath([there, result]))
    except ValueError:  # on different drives
        return None
    if shared == Path(shared.anchor) or shared in _home().parents:
        return None
    return Path(os.path.relpath(there, result)).as_posix()


def _home() -> Path:
    try:
        return Path.home().resolve()
    except RuntimeError:
        return Path()


def package_version(package: str) -> str | None:
    """Version of a package as it is installed; None where it is not."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
