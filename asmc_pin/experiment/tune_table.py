"""The keys of ``[tune]``: what is made small, within which limits, over which gains and on how many draws."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from asmc_pin.experiment.toml_values import PositivePerJoint, TomlTable
from asmc_pin.metrics import METRICS
from asmc_pin.words.nearest_name import nearest

MOST_DRAWS = 10_000
OBJECTIVES = tuple(name for name, metric in METRICS.items() if metric.best == "smallest")
"""Metrics that can be made small."""

_ENDS = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
_WAYS = [
    {
        "type": "object",
        "properties": {way: _ENDS, "each": {"type": "boolean"}},
        "required": [way],
        "additionalProperties": False,
    }
    for way in ("factor", "range")
]
SEARCH_SCHEMA = {"type": "object", "additionalProperties": {"anyOf": _WAYS}}


class LimitsTable(TomlTable):
    """What no controller may do beyond, in any training trial."""

    chatter: PositivePerJoint | None = Field(
        default=None, description="largest torque variation, N·m/s (N/s), see metric `torque_variation`"
    )
    torque_noise: PositivePerJoint | None = Field(
        default=None, description="largest RMS of the torque above `metrics.cutoff_hz`, N·m (N), metric `torque_noise`"
    )
    torque_rate: PositivePerJoint | None = Field(
        default=None, description="largest change of the torque from tick to tick over the period, N·m/s (N/s)"
    )


def _is_objective(name: str) -> str:
    if name not in OBJECTIVES:
        raise ValueError(f"there is no metric '{name}' to make small: {nearest(name, OBJECTIVES)}")
    return name


def _search(value: Any) -> Any:
    """Each line a table with one of `factor` and `range`, two positive numbers, the lower first."""
    if not isinstance(value, dict):
        return value  # pydantic says so
    for key, table in value.items():
        where = f'"{key}"'
        if not isinstance(table, dict):
            raise ValueError(f"{where} must be a table such as {{ factor = [0.1, 10.0] }}, got {table!r}")
        ways = [way for way in ("factor", "range") if way in table]
        if len(ways) != 1:
            raise ValueError(f"{where} takes one of factor and range, got {', '.join(table) or 'nothing'}")
        unknown = [name for name in table if name not in (*ways, "each")]
        if unknown:
            raise ValueError(f"{where} has an unknown key '{unknown[0]}': {nearest(unknown[0], (*ways, 'each'))}")
        ends = table[ways[0]]
        good = isinstance(ends, list) and len(ends) == 2 and all(map(_is_positive, ends)) and ends[0] <= ends[1]
        if not good:
            raise ValueError(f"{where} takes {ways[0]} = [lowest, largest], both positive; got {ends!r}")
        if not isinstance(table.get("each", False), bool):
            raise ValueError(f"{where} takes each = true or false, got {table['each']!r}")
    return value


def _is_positive(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and value > 0.0


class TuneTable(TomlTable):
    """How gains are searched, the same for every controller."""

    objective: Annotated[str, AfterValidator(_is_objective)] = Field(
        default="rms_error", description="metric to make small: geometric mean over joints and training trials"
    )
    limits: LimitsTable = Field(default_factory=LimitsTable, description="what no joint may exceed in a training trial")
    search: Annotated[dict[str, Any], BeforeValidator(_search), WithJsonSchema(SEARCH_SCHEMA)] = Field(
        default={}, description='other ranges than the rule\'s: `"defaults.ks" = { factor = [0.5, 2] }`, or `range`'
    )
    train: int = Field(default=4, ge=1, le=MOST_DRAWS, description="draws of `[sweep]` that gains are searched on")
    held_out: int = Field(default=16, ge=1, le=MOST_DRAWS, description="further draws, that the best are judged on")
    stable: bool = Field(
        default=False, description="whether only gains are run whose sampled loop is stable where it was searched"
    )
