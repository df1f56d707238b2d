"""The JSON Schema of an experiment file, for editors that complete and check as one types.

Editors that read TOML with a schema (Taplo, Even Better TOML) find it by the first line of the shipped files,
``#:schema experiment.schema.json``. `make docs` writes it from the same classes as the checks; a test says whether it
is fresh.
"""

from __future__ import annotations

import json
from typing import Any

from asmc_pin.experiment.constructors import Signature
from asmc_pin.experiment.law_lookup import LAWS
from asmc_pin.experiment.plant_parts import LISTS, TABLES
from asmc_pin.experiment.toml_keys import ExperimentTables
from asmc_pin.references import REFERENCES

# Parameters of a law that an experiment gives by itself.
_GIVEN = ("period", "arm")


def experiment_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of an experiment file."""
    schema = ExperimentTables.model_json_schema()
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "asmc_pin experiment"}
    properties = schema["properties"]
    arm, payload = (schema["$defs"][name] for name in ("ArmTable", "PayloadTable"))
    properties["arm"] = _described(properties["arm"], {"anyOf": [{"type": "string", "minLength": 1}, _ref("ArmTable")]})
    mass = {"type": "number", "minimum": 0}
    short = {"anyOf": [mass, {"type": "string", "pattern": "^[^@]+@.+$"}, _ref("PayloadTable")]}
    arm["properties"]["payload"] = _described(arm["properties"]["payload"], short)
    for table in (arm, payload, *(schema["$defs"][name] for name in ("PlantTable", "MetricsTable", "LimitsTable"))):
        for item in table["properties"].values():
            _drop_null(item)
    _plant(schema["$defs"]["PlantTable"]["properties"])
    properties["reference"] = _described(properties["reference"], {"oneOf": [_reference(kind) for kind in REFERENCES]})
    properties["defaults"] = _described(properties["defaults"], _defaults())
    laws = [_law(name) for name in LAWS]
    own = {
        "type": "object",
        "properties": {"law": {"type": "string", "pattern": "^[^:]+:[^:]+$", "description": "my_module:MyLaw"}},
        "required": ["law"],
    }
    controllers = {"type": "object", "minProperties": 1, "additionalProperties": {"oneOf": [*laws, own]}}
    properties["controllers"] = _described(properties["controllers"], controllers)
    return schema


def experiment_schema_text() -> str:
    """The schema as the text of ``experiments/experiment.schema.json``."""
    return json.dumps(experiment_schema(), indent=2, ensure_ascii=False) + "\n"


def _ref(name: str) -> dict[str, str]:
    return {"$ref": f"#/$defs/{name}"}


def _described(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    return {**new, "description": old["description"]} if "description" in old else new


def _drop_null(item: dict[str, Any]) -> None:
    """TOML has no null: a key is given or left out."""
    item.pop("default", None) if item.get("default", 0) is None else None
    kinds = [kind for kind in item.get("anyOf", ()) if kind != {"type": "null"}]
    if "anyOf" in item:
        item["anyOf"] = kinds
        if len(kinds) == 1:
            del item["anyOf"]
            item.update(kinds[0])


def _parameters(cls: type, skip: tuple[str, ...] = ()) -> dict[str, Any]:
    signature = Signature(cls)
    return {name: signature.json_schema(name) for name in signature.names if name not in skip}


def _reference(kind: str) -> dict[str, Any]:
    cls = REFERENCES[kind]
    return {
        "type": "object",
        "title": kind,
        "properties": {"kind": {"const": kind}, **_parameters(cls)},
        "required": ["kind", *Signature(cls).required],
        "additionalProperties": False,
    }


def _law(name: str) -> dict[str, Any]:
    # Required parameters may stand in [defaults], so none is required here but the law.
    return {
        "type": "object",
        "title": name,
        "properties": {"law": {"const": name}, **_parameters(LAWS[name], skip=_GIVEN)},
        "required": ["law"],
        "additionalProperties": False,
    }


def _plant(properties: dict[str, Any]) -> None:
    """The tables of ``[plant]`` that are the parameters of a class."""
    for key, cls in TABLES.items():
        properties[key] = _described(properties[key], _table(cls))
    for key, cls in LISTS.items():
        properties[key] = _described(properties[key], {"type": "array", "items": _table(cls)})


def _table(cls: type) -> dict[str, Any]:
    required = list(Signature(cls).required)
    table = {"type": "object", "properties": _parameters(cls), "additionalProperties": False}
    return {**table, "required": required} if required else table


def _defaults() -> dict[str, Any]:
    shared: dict[str, Any] = {}
    for law in LAWS.values():
        for name, item in _parameters(law, skip=_GIVEN).items():
            shared.setdefault(name, item)
    # A law of one's own may take others, so they are not refused here; the toolkit itself checks them.
    return {"type": "object", "properties": shared}
