"""The keys of ``[arm]``: which arm it is, and what is changed about it."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from asmc_pin.errors import ParameterError
from asmc_pin.experiment.toml_values import NUMBERS_SCHEMA, TomlTable, is_number


class PayloadTable(TomlTable):
    """A body fixed to a link."""

    mass: float = Field(ge=0.0, description="kg")
    com: list[float] = Field(
        default=[0.0, 0.0, 0.0], min_length=3, max_length=3, description="centre of mass in the link's frame, m"
    )
    inertia: list[float] | None = Field(
        default=None,
        min_length=6,
        max_length=6,
        description="ixx, ixy, ixz, iyy, iyz, izz about the centre of mass, kg·m²; a point mass when omitted",
    )
    link: str | None = Field(default=None, description="name of the link; the last moving one when omitted")

    def words(self) -> str:
        """What it is, for a person to read."""
        centre = f" at {_in_words(self.com)} m" if any(self.com) else ""
        spread = f", inertia {_in_words(self.inertia)} kg·m²" if self.inertia is not None else ""
        return f"{self.mass:g} kg{centre}" + (f" on {self.link}" if self.link is not None else "") + spread


def _payload(value: Any) -> Any:
    if isinstance(value, str):
        from asmc_pin.arms.payload import as_payload

        try:
            load = as_payload(value)
        except ParameterError as error:
            raise ValueError(f"must be a mass, a text like '2@tool0' or a table, got {value!r} ({error})") from None
        assert load is not None
        return {"mass": load.mass, "link": load.link}
    return {"mass": value} if is_number(value) else value


def _armature(value: Any) -> Any:
    if isinstance(value, dict):
        for joint, item in value.items():
            if not (is_number(item) and math.isfinite(item) and item >= 0.0):
                raise ValueError(f"of joint {joint!r} must be a number of 0 or more, got {item!r}")
        return {joint: float(item) for joint, item in value.items()}
    if value == "published":
        return value
    many = value if isinstance(value, list) else [value]
    if not many or not all(is_number(item) and math.isfinite(item) and item >= 0.0 for item in many):
        raise ValueError(
            "must be a number of 0 or more, a list with one for each joint, a table joint = value, or "
            f'"published", got {value!r}'
        )
    return [float(item) for item in many] if isinstance(value, list) else float(value)


def _lock(value: Any) -> Any:
    if not isinstance(value, dict):
        raise ValueError(f"must be a table joint = angle, got {value!r}")
    for joint, item in value.items():
        if item != "free" and not (is_number(item) and math.isfinite(item)):
            raise ValueError(f'of joint {joint!r} must be an angle in rad (m), or "free", got {item!r}')
    return value


_LOCK_SCHEMA = {"type": "object", "additionalProperties": {"anyOf": [{"type": "number"}, {"const": "free"}]}}
_ARMATURE_SCHEMA = {
    "anyOf": [
        *NUMBERS_SCHEMA["anyOf"],
        {"type": "object", "additionalProperties": {"type": "number", "minimum": 0}},
        {"const": "published"},
    ],
}


class ArmTable(TomlTable):
    """The arm: a name from ``asmc-pin arms``, or a URDF."""

    source: str = Field(
        min_length=1, description="name of an arm, or path of a URDF or xacro file (relative to this file)"
    )
    payload: Annotated[PayloadTable | None, BeforeValidator(_payload)] = Field(
        default=None,
        description='kg, as a point mass at the last moving link; or `"2@tool0"`, at that link; or a table `mass`, '
        "`com`, `inertia`, `link`",
    )
    armature: Annotated[
        float | list[float] | dict[str, float] | Literal["published"] | None,
        BeforeValidator(_armature),
        WithJsonSchema(_ARMATURE_SCHEMA),
    ] = Field(
        default=None,
        description="reflected rotor inertia, kg·m² (kg): per joint, joint = value, or `published`; else the arm's own",
    )
    lock: Annotated[dict[str, Any] | None, BeforeValidator(_lock), WithJsonSchema(_LOCK_SCHEMA)] = Field(
        default=None,
        description='joints to fix: name or pattern = angle, rad (m); "free" frees one that is locked by default',
    )
    chain: list[str] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="links, base and tip: only joints between them move, the others are locked near zero",
    )
    gravity: list[float] | None = Field(
        default=None,
        min_length=3,
        max_length=3,
        description="gravity in the base frame, m/s²; [0, 0, -9.81] if omitted",
    )
    repair: bool = Field(
        default=False, description="take inertia tensors that no rigid body has to the nearest possible ones"
    )
    xacro: dict[str, str | int | float | bool] | None = Field(
        default=None, description="arguments of a xacro file: name = value"
    )
    package: dict[str, str] | None = Field(
        default=None, description="ROS packages: name = folder where it lies (relative to this file)"
    )
    estimate_inertia: float | dict[str, float] | None = Field(
        default=None, description="kg: missing inertias from shapes, one mass for all together, or link = mass"
    )

    def words(self) -> str:
        """What it is, for a person to read."""
        given = self.model_dump(exclude={"source", "payload"}, exclude_none=True, exclude_defaults=True)
        load = [] if self.payload is None else [f"payload {self.payload.words()}"]
        changed = (f"{key.replace('_', ' ')} {_in_words(value)}".rstrip() for key, value in given.items())
        return ", ".join([self.source, *load, *changed])


def _in_words(value: Any) -> str:
    """A key's value without the signs of Python; nothing for what is just asked for."""
    if isinstance(value, bool):
        return "" if value else "no"
    if isinstance(value, dict):
        return ", ".join(f"{key} = {_in_words(item)}" for key, item in value.items())
    if isinstance(value, list):
        return f"({', '.join(map(_in_words, value))})"
    return f"{value:g}" if is_number(value) else str(value)


def arm_table(value: Any) -> Any:
    """``arm = "ur5"`` is short for ``arm = { source = "ur5" }``."""
    return {"source": value} if isinstance(value, str) else value
