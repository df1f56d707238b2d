"""Finding an experiment: by path, or by the name of one that the package ships."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.disk.reading import read_file, shown, user_path
from asmc_pin.disk.resources import shipped
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment.measured_values import read_measured, with_measured
from asmc_pin.experiment.toml_text import LARGEST, read_toml
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.text import printable

if TYPE_CHECKING:
    from asmc_pin.experiment.experiment import Experiment

TUNED = "tuned.toml"
"""In the folder of a tuning: the experiment with the best gains."""


def experiment_names() -> list[str]:
    """Names of the experiments that the package ships."""
    return sorted(path.stem for path in shipped("experiments").glob("*.toml"))


def load_experiment(
    source: str | Path, *, import_laws: bool = True, plant: str | Path | Mapping[str, Any] | None = None
) -> Experiment:
    """Read and check an experiment.

    Args:
        source: Path of a TOML file, or the name of a shipped experiment. A result's ``experiment.toml`` works too:
            what it names by a relative path is looked for where the experiment lay when it was run.
        import_laws: Whether a law of one's own (``my_module:MyLaw``) is imported, which runs the code of that module.
            False for a file that is only looked at: its arm, motion and plant are there, its controllers are not.
        plant: A file of ``asmc-pin identify --out``, whose ``[arm]`` and ``[plant]`` are laid over the experiment's; or
            these tables.

    Raises:
        ExperimentError: there is no such file, its TOML is broken (names the line), or keys or values are wrong (lists
            every mistake, with the path of its key and the nearest known one).
    """
    path = find_experiment(source)
    text: str | None
    text, data = read_toml(path)
    if plant is not None:
        # The text of the experiment is no longer what is run.
        text = None
        data = with_measured(data, plant if isinstance(plant, Mapping) else read_measured(user_path(plant)))
    from asmc_pin.experiment.experiment import Experiment  # only now: it brings all that an experiment may be made of

    return Experiment.from_dict(data, folder=_folder(path), origin=str(path), text=text, import_laws=import_laws)


def find_experiment(source: str | Path) -> Path:
    """The file that a name or a path stands for.

    Raises:
        ExperimentError: there is none; names the nearest known experiment.
    """
    names = experiment_names()
    if isinstance(source, str) and source in names:
        return shipped("experiments") / f"{source}.toml"
    path = user_path(source)
    try:
        there, folder = path.exists(), path.is_dir()
    except OSError as error:
        raise ExperimentError("", f"{shown(path)}: cannot be read ({error.strerror})") from None
    if folder:
        inside = path / "experiment.toml"
        hint = f"; did you mean {shown(inside)}?" if inside.is_file() else ""
        raise ExperimentError("", f"{shown(path)} is a folder, an experiment is a TOML file{hint}")
    if there:
        return path
    hint = nearest(str(source), names, "shipped are")
    name = printable(str(source))
    raise ExperimentError("", f"there is no experiment '{name}', neither a file nor a shipped one; {hint}")


def _folder(path: Path) -> Path:
    folder = path.resolve().parent
    provenance = folder / "provenance.json"
    if path.name in ("experiment.toml", TUNED) and provenance.is_file():
        try:
            text = read_file(provenance, LARGEST, "a provenance", lambda message: ExperimentError("", message))
            origin = folder / json.loads(text)["experiment"]["folder"]
        except (ExperimentError, ValueError, KeyError, TypeError, RecursionError):
            return folder
        return origin if origin.is_dir() else folder
    return folder
