"""Mistakes in the controllers of an experiment: laws that are none, parameters that no law takes, sizes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from asmc_pin.arms import Arm
from asmc_pin.controllers import TdeLaw
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment.checks.experiment_checks import wrong_sizes
from asmc_pin.experiment.constructors import Mistake, Signature, construct
from asmc_pin.experiment.law_lookup import LAWS, is_own, load_law
from asmc_pin.experiment.toml_keys import ExperimentTables
from asmc_pin.plant import Sensor
from asmc_pin.words.nearest_name import nearest

_RESERVED = {
    "period": "stands once, at the top of the file, for every controller",
    "arm": "stands once, at the top of the file; a law that knows the model is given that arm",
}


def controller_problems(
    data: Mapping[str, Any], folder: Path, import_laws: bool = True
) -> tuple[dict[str, Any], list[Mistake]]:
    """The controllers of a file by label, and what is wrong with their tables and with ``[defaults]``.

    Args:
        data: Tables as TOML gives them.
        folder: Where laws of one's own are looked for.
        import_laws: Whether they are; a controller with one is left out, unjudged, where not.
    """
    defaults = data.get("defaults", {})
    tables = data.get("controllers")
    if not isinstance(tables, Mapping) or not isinstance(defaults, Mapping):
        return {}, []
    made: dict[str, Any] = {}
    problems: list[Mistake] = []
    signatures = [Signature(law) for law in LAWS.values()]
    all_known = True
    for label, table in tables.items():
        path = f"controllers.{label}"
        if not isinstance(table, Mapping):
            if label == "law":
                problems.append(Mistake(path, "a law stands in a table of its own, [controllers.LABEL]"))
            continue
        if not import_laws and is_own(table.get("law")):
            all_known = False
            continue
        law, found = _law(table, folder, path)
        problems += found
        if law is None:
            continue
        signature = Signature(law)
        signatures.append(signature)
        found = _unknown_parameters(table, signature, path)
        problems += found
        if found:
            continue
        values = {key: value for key, value in defaults.items() if signature.takes(key) and key not in _RESERVED}
        values |= {key: value for key, value in table.items() if key != "law"}
        if signature.takes("period"):
            values["period"] = data.get("period")
        if issubclass(law, TdeLaw) and values.get("pairing", "matched") == "matched" and _differences(data):
            values["pairing"] = "mean"  # what fits: the law cannot see how its velocities are made
        if len({len(values[key]) for key in values if _is_list(signature, key, values[key])}) > 1:
            continue  # one of them does not fit the arm; told when the arm is known, with its joints
        made[label], found = construct(law, values, path)
        problems += [_where_it_stands(item, path, table, defaults) for item in found]
    if all_known:  # what a law that was not imported takes, nobody knows
        problems += _default_problems(defaults, signatures)
    return made, problems


def _differences(data: Mapping[str, Any]) -> bool:
    """Whether the plant's sensor makes velocities from differences of its readings."""
    plant = data.get("plant")
    sensor = plant.get("sensor") if isinstance(plant, Mapping) else None
    return isinstance(sensor, Mapping) and sensor.get("velocity", Sensor.velocity) != "exact"


def _law(table: Mapping[str, Any], folder: Path, path: str) -> tuple[type | None, list[Mistake]]:
    name = table.get("law")
    if not isinstance(name, str):
        state = "is missing" if name is None else f"must be text, got {name!r}"
        return None, [Mistake(f"{path}.law", f"{state}; one of {', '.join(LAWS)}, or 'my_module:MyLaw'")]
    try:
        return load_law(name, folder, f"{path}.law"), []
    except ExperimentError as error:
        return None, [Mistake(error.key, error.said)]


def _unknown_parameters(table: Mapping[str, Any], signature: Signature, path: str) -> list[Mistake]:
    problems = []
    for key in table:
        if key in _RESERVED:
            problems.append(Mistake(f"{path}.{key}", _RESERVED[key]))
        elif key != "law" and not signature.takes(key):
            known = ["law", *(name for name in signature.names if name not in _RESERVED)]
            problems.append(
                Mistake(f"{path}.{key}", f"unknown parameter of law '{table['law']}': {nearest(key, known)}")
            )
    return problems


def _default_problems(defaults: Mapping[str, Any], signatures: Sequence[Signature]) -> list[Mistake]:
    """A default may be for some of the laws only; one that no law takes is a slip of the pen."""
    known = dict.fromkeys(name for signature in signatures for name in signature.names if name not in _RESERVED)
    problems = []
    for key in defaults:
        if key in _RESERVED:
            problems.append(Mistake(f"defaults.{key}", _RESERVED[key]))
        elif not any(signature.takes(key) for signature in signatures):
            problems.append(Mistake(f"defaults.{key}", f"no law takes this parameter: {nearest(key, known)}"))
    return problems


def _where_it_stands(problem: Mistake, path: str, table: Mapping[str, Any], defaults: Mapping[str, Any]) -> Mistake:
    name = problem.key.removeprefix(f"{path}.")
    if name == "period":
        return Mistake("period", problem.message)
    if name not in table and name in defaults:
        return Mistake(f"defaults.{name}", problem.message)
    if problem.message == "is missing":
        return Mistake(problem.key, "is missing; give it here, or in [defaults] for all controllers")
    return problem


def controller_size_problems(tables: ExperimentTables, folder: Path, arm: Arm) -> list[Mistake]:
    """Lists of the controllers whose length is not the number of the arm's joints."""
    signatures = {label: Signature(load_law(table["law"], folder)) for label, table in tables.controllers.items()}
    shared = [name for name in tables.defaults if any(item.per_joint(name) for item in signatures.values())]
    given = [(f"defaults.{name}", tables.defaults[name]) for name in shared]
    for label, table in tables.controllers.items():
        own = [name for name in table if signatures[label].per_joint(name)]
        given += [(f"controllers.{label}.{name}", table[name]) for name in own]
    return wrong_sizes(given, arm)


def _is_list(signature: Signature, name: str, value: Any) -> bool:
    return signature.per_joint(name) and isinstance(value, list)
