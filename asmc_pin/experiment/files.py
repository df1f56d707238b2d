"""Finding an experiment: by path, or by the name of one that the package ships."""

from __future__ import annotations

import difflib
import json
from pathlib import Path
from typing import TYPE_CHECKING

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment.toml import read_toml
from asmc_pin.resources import shipped

if TYPE_CHECKING:
    from asmc_pin.experiment.model import Experiment


def experiment_names() -> list[str]:
    """Names of the experiments that the package ships."""
    return sorted(path.stem for path in shipped("experiments").glob("*.toml"))


def load_experiment(source: str | Path) -> Experiment:
    """Read and check an experiment.

    Args:
        source: Path of a TOML file, or the name of a shipped experiment. A result's ``experiment.toml`` works too:
            what it names by a relative path is looked for where the experiment lay when it was run.

    Raises:
        ExperimentError: there is no such file, its TOML is broken (names the line), or keys or values are wrong (lists
            every mistake, with the path of its key and the nearest known one).
    """
    path = find_experiment(source)
    text, data = read_toml(path)
    from asmc_pin.experiment.model import Experiment  # only now: it brings all that an experiment may be made of

    return Experiment.from_dict(data, folder=_folder(path), origin=str(path), text=text)


def find_experiment(source: str | Path) -> Path:
    """The file that a name or a path stands for.

    Raises:
        ExperimentError: there is none; names the nearest known experiment.
    """
    names = experiment_names()
    if isinstance(source, str) and source in names:
        return shipped("experiments") / f"{source}.toml"
    path = Path(source).expanduser()
    if path.is_file():
        return path
    if path.is_dir():
        inside = path / "experiment.toml"
        hint = f"; did you mean {inside}?" if inside.is_file() else ""
        raise ExperimentError("", f"{source} is a folder, an experiment is a TOML file{hint}")
    near = difflib.get_close_matches(str(source), names, n=1)
    hint = f"did you mean '{near[0]}'?" if near else f"shipped are {', '.join(names)}"
    raise ExperimentError("", f"there is no experiment '{source}', neither a file nor a shipped one; {hint}")


def _folder(path: Path) -> Path:
    folder = path.resolve().parent
    provenance = folder / "provenance.json"
    if path.name == "experiment.toml" and provenance.is_file():
        try:
            origin = folder / json.loads(provenance.read_text(encoding="utf-8"))["experiment"]["folder"]
        except (ValueError, KeyError, TypeError):
            return folder
        return origin if origin.is_dir() else folder
    return folder
