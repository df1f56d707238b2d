"""The parts of ``[plant]`` whose keys are the parameters of a class: friction, drive, sensor and world.

As with laws and references, the class says what its keys are, so a new parameter needs no second list here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from asmc_pin.experiment.constructors import Mistake, Signature, construct
from asmc_pin.plant import Disturbance, Drive, EndStops, Friction, PayloadChange, Sensor, Spread
from asmc_pin.words.nearest_name import nearest

TABLES: dict[str, type] = {
    "friction": Friction,
    "drive": Drive,
    "sensor": Sensor,
    "end_stops": EndStops,
    "spread": Spread,
}
"""Keys of ``[plant]`` that are a table."""

LISTS: dict[str, type] = {"disturbances": Disturbance, "payload_changes": PayloadChange}
"""Keys of ``[plant]`` that are a list of tables."""


def plant_parts(plant: Any) -> tuple[dict[str, Any], list[Mistake]]:
    """The parts that a ``[plant]`` table describes, by key, and what is wrong with them."""
    made: dict[str, Any] = {}
    problems: list[Mistake] = []
    if not isinstance(plant, Mapping):
        return made, problems  # the schema has said so
    for key, cls in TABLES.items():
        if isinstance(plant.get(key), Mapping):
            made[key], found = _part(cls, plant[key], f"plant.{key}")
            problems += found
    for key, cls in LISTS.items():
        if isinstance(plant.get(key), list):
            parts = [_part(cls, item, f"plant.{key}[{i}]") for i, item in enumerate(plant[key])]
            made[key] = tuple(part for part, _ in parts)
            problems += [problem for _, found in parts for problem in found]
    return made, problems


def _part(cls: type, table: Any, path: str) -> tuple[Any, list[Mistake]]:
    if not isinstance(table, Mapping):
        return None, [Mistake(path, f"must be a table, got {table!r}")]
    signature = Signature(cls)
    names = signature.names
    wrong = [Mistake(f"{path}.{key}", f"unknown key: {nearest(key, names)}") for key in table if key not in names]
    wrong += [
        Mistake(f"{path}.{key}", f"must be a number, or a list with one for each joint, got {value!r}")
        for key, value in table.items()
        if signature.per_joint(key) and isinstance(value, list) and any(isinstance(item, list) for item in value)
    ]
    return (None, wrong) if wrong else construct(cls, table, path)
