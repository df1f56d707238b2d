"""Fields that are arrays of numbers: one value for each joint, and for each trial."""

from __future__ import annotations

from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.parameters.number_bounds import NUMBER, NumberBound, as_floats
from asmc_pin.parameters.parameter_field import REQUIRED, Parameter, parameters_of

_LIST = {"type": "array", "items": NUMBER, "minItems": 1}
_NESTED = (NUMBER, _LIST, {"type": "array", "items": _LIST, "minItems": 1})
"""Numbers with 0, 1 and 2 axes, as JSON Schema."""


class Values(Parameter[Array, Any]):
    """Numbers as a read-only array with one of the stated numbers of axes; given as a number, nested lists or an array.

    For type checkers any value may be given. A narrower type would also become the type of the attribute where a frozen
    dataclass inherits the field.
    """

    def __init__(
        self,
        meaning: str,
        unit: str = "",
        *,
        axes: tuple[int, ...],
        shape: str,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
        default: float = REQUIRED,
    ) -> None:
        super().__init__(meaning, unit, default=default)
        self.axes = axes
        self.shape = shape
        self.bound = NumberBound(unit, above, at_least, at_most=at_most)

    def convert(self, value: Any) -> Array:
        """A read-only copy whose entries are finite and within the bound."""
        expected = f"{self.shape}, each {self.bound.text}"
        array = as_floats(self.name, value, expected)
        if array.ndim not in self.axes:
            raise ParameterError(self.name, f"got an array of shape {array.shape}; expected {expected}")
        inside = self.bound.ok(array)
        if not np.all(inside):
            index = tuple(int(i) for i in np.argwhere(~inside)[0])
            where = f"entry {', '.join(str(i + 1) for i in index)} is " if index else ""
            raise ParameterError(
                self.name,
                f"{where or 'got '}{float(array[index])!r}; {'it' if not index else 'each'} must be {self.bound.text}",
            )
        array.setflags(write=False)
        return array

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return f"{self.shape}{self.bound.words}"

    @property
    def schema(self) -> dict[str, Any]:
        """Numbers with one of the numbers of axes."""
        return {"anyOf": [_NESTED[axes] for axes in self.axes]}


class PerJoint(Values):
    """A parameter that is one number for all joints, or one for each; kept with shape () or (nv,)."""

    def __init__(
        self,
        meaning: str,
        unit: str = "",
        *,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
        default: float = REQUIRED,
    ) -> None:
        super().__init__(
            meaning,
            unit,
            axes=(0, 1),
            shape="a number or a list of one per joint",
            above=above,
            at_least=at_least,
            at_most=at_most,
            default=default,
        )

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return f"per joint{self.bound.words}"


class PerTrial(PerJoint):
    """As `PerJoint`, or (batch, nv) values, one row for each trial; None where that is the default.

    Files have no trials, so an experiment gives it as it gives a `PerJoint`.
    """

    def __init__(
        self,
        meaning: str,
        unit: str = "",
        *,
        above: float | None = None,
        at_least: float | None = None,
        default: float | None = REQUIRED,
    ) -> None:
        super().__init__(meaning, unit, above=above, at_least=at_least)
        self.default = default
        self.axes = (0, 1, 2)
        self.shape = "a number, a list of one per joint, or a row of these for each trial"

    @property
    def schema(self) -> dict[str, Any]:
        """As of a `PerJoint`: a row for each trial is for Python alone."""
        return {"anyOf": [_NESTED[axes] for axes in (0, 1)]}

    def convert(self, value: Any) -> Any:
        """A read-only array of shape (), (nv,) or (batch, nv); None if that is the default."""
        return None if value is None and self.default is None else super().convert(value)


class OptionalPerJoint(PerJoint):
    """A parameter as `PerJoint`, or None: what it describes is absent."""

    def __init__(
        self,
        meaning: str,
        unit: str = "",
        *,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
    ) -> None:
        super().__init__(meaning, unit, above=above, at_least=at_least, at_most=at_most)
        self.default = None

    def convert(self, value: Any) -> Any:
        """None, or a read-only array of shape () or (nv,)."""
        return None if value is None else super().convert(value)


def match_joints(instance: object) -> int | None:
    """Bring all `PerJoint` fields of a dataclass to one length.

    Call it in ``__post_init__``. Scalars are broadcast if any field has nv values; if all are scalars, they stay so.

    Returns:
        nv, or None if every field is a scalar.

    Raises:
        ParameterError: two fields have different lengths; it names the later one.
    """
    fields = {n: instance.__dict__[n] for n, p in parameters_of(type(instance)).items() if isinstance(p, PerJoint)}
    values = {name: value for name, value in fields.items() if value is not None}
    first = next((name for name, value in values.items() if value.ndim == 1), None)
    if first is None:
        return None
    nv = int(values[first].size)
    for name, value in values.items():
        if value.ndim == 1 and value.size != nv:
            raise ParameterError(
                name,
                f"has {value.size} values but {first} has {nv}; give both one value per joint, or a single number",
            )
        # broadcast_to alone would leave a strided view with no memory of its own, slower in every step
        full = np.array(np.broadcast_to(value, (nv,)))
        full.setflags(write=False)
        instance.__dict__[name] = full
    return nv
