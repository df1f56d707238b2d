"""Reading and changing the tables of an experiment by the path of a key, such as ``plant.friction.coulomb``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, TypeAlias

Parts: TypeAlias = tuple[str | int, ...]

MISSING: Any = object()
"""What `value_at` gives where the tables have no such key."""

# Values that are short for a table, and the key of that table that they stand for.
_SHORT: dict[Parts, str] = {("arm",): "source", ("arm", "payload"): "mass"}


def parts_of(path: str, data: Mapping[str, Any]) -> Parts:
    """The keys that a path stands for; ``[i]`` is a place in a list, from 0.

    Args:
        path: Keys with dots between them. A controller's label may have dots of its own.
        data: Tables of the experiment, which know the labels.
    """
    labels = data.get("controllers")
    if path.startswith("controllers.") and isinstance(labels, Mapping):
        rest = path.removeprefix("controllers.")
        fitting = [label for label in labels if rest == label or rest.startswith(f"{label}.")]
        if fitting:
            label = max(fitting, key=len)
            return "controllers", label, *_split(rest[len(label) + 1 :])
    return _split(path)


def _split(path: str) -> Parts:
    found: list[str | int] = []
    for key in path.split(".") if path else ():
        name, *places = re.split(r"\[(\d+)\]", key)
        found += [name] if name or not places else []
        found += [int(item) for item in places if item.isdigit()]
        found += [item for item in places if item and not item.isdigit()]
    return tuple(found)


def value_at(data: Mapping[str, Any], parts: Parts) -> Any:
    """The value there, or `MISSING`."""
    here: Any = data
    for depth, part in enumerate(parts):
        here = _opened(here, parts[:depth])
        if isinstance(part, int):
            if not isinstance(here, list) or part >= len(here):
                return MISSING
            here = here[part]
        else:
            if not isinstance(here, Mapping) or part not in here:
                return MISSING
            here = here[part]
    return here


def with_value(data: Any, parts: Parts, value: Any, _above: Parts = ()) -> Any:
    """The tables with another value there; what lies beside the path is shared with the given ones, not copied.

    Raises:
        KeyError: a part of the path stands in no list or table; its argument is the number of parts that do fit.
    """
    if not parts:
        return value
    first, rest = parts[0], parts[1:]
    data = _opened(data, _above)
    below = (*_above, first)
    if isinstance(first, int):
        if not isinstance(data, list) or first >= len(data):
            raise KeyError(len(_above))
        changed = list(data)
        changed[first] = with_value(data[first], rest, value, below)
        return changed
    if not isinstance(data, Mapping):
        raise KeyError(len(_above))
    return {**data, first: with_value(data.get(first, {}), rest, value, below)}


def _opened(value: Any, parts: Parts) -> Any:
    """A table where the value is short for one: ``arm = "ur5"``, ``payload = 2.0``."""
    key = _SHORT.get(parts)
    return {key: value} if key is not None and not isinstance(value, Mapping) else value
