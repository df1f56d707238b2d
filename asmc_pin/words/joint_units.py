"""Units of what belongs to a joint: a table of a gripper's arm has metres and kilograms beside radians and kg·m²."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

Quantity: TypeAlias = Literal["inertia", "place", "acceleration"]

_UNITS: dict[Quantity, tuple[str, str]] = {
    "inertia": ("kg·m²", "kg"),
    "place": ("rad", "m"),
    "acceleration": ("rad/s²", "m/s²"),
}


def joint_units(quantity: Quantity, slides: Sequence[bool]) -> list[str]:
    """The unit of each joint's figure, of one that turns or one that slides."""
    return [_UNITS[quantity][int(each)] for each in slides]


def column_head(name: str, quantity: Quantity, slides: Sequence[bool]) -> str:
    """A column's head: with the unit where all joints have the same."""
    units = set(joint_units(quantity, slides))
    return f"{name} {units.pop()}" if len(units) == 1 else name


def column_cells(figures: Sequence[str], quantity: Quantity, slides: Sequence[bool]) -> list[str]:
    """A column's figures, base first: each with its unit where the head can have none."""
    units = joint_units(quantity, slides)
    if len(set(units)) == 1:
        return list(figures)
    return [f"{figure} {unit}" for figure, unit in zip(figures, units, strict=True)]


def listed_with_units(figures: Sequence[str], quantity: Quantity, slides: Sequence[bool]) -> str:
    """Figures in brackets: ``(1, 2) kg·m²``, or each with its own unit where they differ."""
    units = set(joint_units(quantity, slides))
    unit = f" {units.pop()}" if len(units) == 1 else ""
    return f"({', '.join(column_cells(figures, quantity, slides))}){unit}"
