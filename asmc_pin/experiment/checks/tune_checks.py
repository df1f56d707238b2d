"""What is wrong with the keys of ``[tune] search``: each is the path of a parameter that some controller has."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment.constructors import Mistake, Signature
from asmc_pin.experiment.law_lookup import is_own, load_law
from asmc_pin.experiment.variation.key_paths import parts_of
from asmc_pin.words.nearest_name import nearest

NO_GAINS = ("law", "period", "acceleration", "filter_hz", "pairing", "switching", "arm")
"""What is no gain: it says how a law measures, when it runs and which form of it that is."""


def tune_problems(data: Mapping[str, Any], folder: Path, import_laws: bool) -> list[Mistake]:
    """Keys of ``[tune] search`` that stand for nothing which could be searched.

    Args:
        data: Tables as TOML gives them.
        folder: Where laws of one's own are looked for.
        import_laws: Whether they are; nothing is said of such a law where not.
    """
    tune, controllers = data.get("tune"), data.get("controllers")
    search = tune.get("search") if isinstance(tune, Mapping) else None
    if not isinstance(search, Mapping) or not isinstance(controllers, Mapping):
        return []  # the schema has said so
    taken: dict[str, list[str]] = {}
    for label, table in controllers.items():
        law = table.get("law") if isinstance(table, Mapping) else None
        if not isinstance(law, str) or (is_own(law) and not import_laws):
            return []
        try:
            names = Signature(load_law(law, folder)).names
        except ExperimentError:
            return []  # said where the controller is judged
        taken[label] = [name for name in names if name not in NO_GAINS]
    return [mistake for path in search for mistake in _problem(path, data, taken)]


def _problem(path: str, data: Mapping[str, Any], taken: Mapping[str, list[str]]) -> list[Mistake]:
    parts, key = parts_of(path, data), f'tune.search."{path}"'
    every = list(dict.fromkeys(name for names in taken.values() for name in names))
    if len(parts) == 2 and parts[0] == "defaults":
        known = every
    elif len(parts) == 3 and parts[0] == "controllers":
        if parts[1] not in taken:
            return [Mistake(key, f"there is no controller '{parts[1]}': {nearest(str(parts[1]), taken)}")]
        known = taken[str(parts[1])]
    else:
        text = "names no parameter; expected defaults.PARAMETER, for all controllers, or controllers.LABEL.PARAMETER"
        return [Mistake(key, text)]
    return [] if parts[-1] in known else [Mistake(key, f"no gain of that name: {nearest(str(parts[-1]), known)}")]
