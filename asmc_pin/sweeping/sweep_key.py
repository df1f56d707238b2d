"""The key of a sweep: a hash of all that its rows depend on, so that a stale row is never taken for a fresh one."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from asmc_pin.experiment import Experiment
from asmc_pin.experiment.law_lookup import is_own, load_law
from asmc_pin.experiment.variation.key_paths import value_at
from asmc_pin.results.provenance import PACKAGES, package_version


def sweep_key(experiment: Experiment) -> str:
    """SHA-256 of the experiment, of the files that it names and of the code that runs it, in hex.

    The files: URDFs, recorded motions, and the modules of laws of one's own, though not what those import. The code:
    the package's sources, and the versions of the libraries that figures depend on.
    """
    variation = experiment.variation
    tables = {**variation.data, "sweep": experiment.sweep}
    every = [variation.data, *(axis.placed(variation.data, value) for axis in variation.axes for value in axis.values)]
    found = [tables, _arms(experiment, every), _files(experiment, every), code_key(), sys.version]
    return hashlib.sha256(json.dumps(found, sort_keys=True, default=str).encode()).hexdigest()


@cache
def code_key() -> str:
    """SHA-256 of the package's sources and of the versions of what they compute with, in hex."""
    root = Path(__file__).resolve().parent.parent
    found = hashlib.sha256(json.dumps({name: package_version(name) for name in PACKAGES}).encode())
    for path in sorted(root.rglob("*.py")):
        found.update(path.relative_to(root).as_posix().encode())
        found.update(path.read_bytes())
    return found.hexdigest()


def _arms(experiment: Experiment, every: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Hash of each URDF that the experiment or a value of a grid names."""
    found: dict[str, str] = {}
    for tables in every:
        source = str(value_at(tables, ("arm", "source")))
        if source not in found:
            found[source] = experiment.replace(**{**tables, "sweep": None}).build_arm().sha256
    return found


def _files(experiment: Experiment, every: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Hash of each recorded motion and of each module with a law of one's own."""
    found: dict[str, str] = {}
    for tables in every:
        motion = value_at(tables, ("reference", "path"))
        if isinstance(motion, str):
            found[f"motion {motion}"] = _digest(experiment.folder / motion)
        for law in _laws(tables):
            module = sys.modules[load_law(law, experiment.folder).__module__]
            if module.__file__ is not None:
                found[f"law {law}"] = _digest(Path(module.__file__))
    return found


def _laws(tables: Any) -> list[str]:
    return [table["law"] for table in tables["controllers"].values() if is_own(table["law"])]


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
