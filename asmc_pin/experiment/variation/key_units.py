"""The unit of what a key of an experiment holds, for axes of figures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from asmc_pin.experiment.law_lookup import LAWS
from asmc_pin.experiment.plant_parts import LISTS, TABLES
from asmc_pin.experiment.variation.key_paths import Parts, value_at
from asmc_pin.parameters import parameters_of
from asmc_pin.references import REFERENCES

_OWN: dict[Parts, str] = {
    ("period",): "s",
    ("duration",): "s",
    ("arm", "payload"): "kg",
    ("arm", "payload", "mass"): "kg",
    ("arm", "armature"): "kg·m² (kg)",
}
"""Of keys that are no parameter of a class: those say their unit themselves."""


def unit_of_key(data: Mapping[str, Any], parts: Parts) -> str:
    """The unit of a key's value; empty where it has none, or where nothing says it.

    Args:
        data: Tables of the experiment.
        parts: The key, taken apart.
    """
    if parts in _OWN:
        return _OWN[parts]
    names = [part for part in parts if isinstance(part, str)]
    for cls in _classes(data, names):
        parameter = parameters_of(cls).get(names[-1])
        if parameter is not None:
            return parameter.unit
    return ""


def _classes(data: Mapping[str, Any], names: list[str]) -> Iterable[type]:
    """Whose parameter the key may be."""
    known: Mapping[str, type]
    match names:
        case ["plant", table, _]:
            known, wanted = {**TABLES, **LISTS}, table
        case ["reference", _]:
            known, wanted = REFERENCES, value_at(data, ("reference", "kind"))
        case ["controllers", label, _]:
            known, wanted = LAWS, value_at(data, ("controllers", label, "law"))
        case ["defaults", _]:
            return LAWS.values()
        case _:
            return ()
    return [known[wanted]] if wanted in known else []
