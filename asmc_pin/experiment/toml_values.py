"""What a key of an experiment file may hold: numbers for all joints or one for each, and tables of known keys."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

NUMBERS_SCHEMA = {
    "anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}, "minItems": 1}],
}


def is_number(value: object) -> bool:
    """Whether a value of a file is a number, and not true or false."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _per_joint(what: str, allowed: Callable[[float], bool]) -> BeforeValidator:
    """Check of a number for all joints, or one per joint; `allowed` judges each of them."""

    def check(value: Any) -> float | list[float]:
        many = value if isinstance(value, list) else [value]
        if not many or not all(is_number(item) for item in many):
            raise ValueError(f"must be {what}, or a list with one for each joint, got {value!r}")
        for item in many:
            if not allowed(float(item)):
                raise ValueError(f"must be {what}, or a list with one for each joint, got {item!r}")
        return [float(item) for item in many] if isinstance(value, list) else float(value)

    return BeforeValidator(check)


_SCHEMA = WithJsonSchema(NUMBERS_SCHEMA)
_FINITE = _per_joint("a finite number", math.isfinite)
_POSITIVE = _per_joint("a positive number", lambda x: math.isfinite(x) and x > 0.0)
# TOML has inf, and a limit of inf says plainly that there is none.
_LIMIT = _per_joint("a positive number (inf for no limit)", lambda x: x > 0.0)
_Numbers = float | list[float]
PerJoint = Annotated[_Numbers, _FINITE, _SCHEMA]
PositivePerJoint = Annotated[_Numbers, _POSITIVE, _SCHEMA]
_Infinite = Annotated[float, Field(allow_inf_nan=True)]
LimitPerJoint = Annotated[_Infinite | list[_Infinite], _LIMIT, _SCHEMA]


class TomlTable(BaseModel):
    """A table of the file: unknown keys are errors, text is not a number, and nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)
