"""Fields of frozen dataclasses that validate and copy what they are given, on construction.

A field that is one of these carries its meaning, unit and bound with it, so that the constructor, the error message and
the table in the README cannot tell different stories:

    @dataclass(frozen=True, kw_only=True, eq=False)
    class MyLaw(TdeLaw):
        gain: PerJoint = PerJoint("switching gain", "rad/s²", at_least=0.0)

Reading ``law.gain`` gives a read-only float64 array. A wrong type, sign, size or NaN is a `ParameterError` that names
the field.
"""

from __future__ import annotations

from typing import Any, Generic, TypeVar, overload

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.errors import ParameterError
from asmc_pin.words.nearest_name import near_names, nearest

Value = TypeVar("Value")
Given = TypeVar("Given")

REQUIRED: Any = object()
"""Default of a field that has none."""


class Parameter(Generic[Value, Given]):
    """A validated field of a frozen dataclass; reading gives a `Value`, the constructor takes a `Given`.

    Attributes:
        name: The field's name, which error messages use.
        meaning: What it is, in a few words.
        unit: Its unit, empty if it has none.
        default: What is used if nothing is given, or `REQUIRED`.
    """

    def __init__(self, meaning: str, unit: str = "", *, default: Given = REQUIRED) -> None:
        self.name = ""
        self.meaning = meaning
        self.unit = unit
        self.default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> Any: ...
    @overload
    def __get__(self, instance: object, owner: type) -> Value: ...
    def __get__(self, instance: object | None, owner: type) -> Any:
        if instance is not None:
            return instance.__dict__[self.name]
        if self.default is REQUIRED:  # what tells dataclasses that the field is required
            raise AttributeError(self.name)
        return self.default

    def __set__(self, instance: object, value: Given) -> None:
        instance.__dict__[self.name] = self.convert(value)

    def convert(self, value: Given) -> Value:
        """The value as kept, or a `ParameterError`."""
        raise NotImplementedError

    @property
    def takes(self) -> str:
        """What may be given, in a few words for a table; its unit stands beside it."""
        return ""


class _Number:
    """Bounds of a number, and how they are said."""

    def __init__(
        self,
        unit: str,
        above: float | None,
        at_least: float | None,
        below: float | None = None,
        at_most: float | None = None,
        infinite: bool = False,
    ) -> None:
        self.above = above
        self.at_least = at_least
        self.below = below
        self.at_most = at_most
        self.infinite = infinite
        named = (("above", above), ("at least", at_least), ("below", below), ("at most", at_most))
        bounds = [f"{word} {x:g}" for word, x in named if x is not None]
        self.text = f"{' and '.join(bounds) or 'finite'} {unit}".strip() + (", or inf" if infinite else "")
        self.words = "".join(f", {bound}" for bound in bounds) + (", or inf" if infinite else "")

    def ok(self, values: Array) -> BoolArray:
        inside = np.isfinite(values) | (self.infinite & (values == np.inf))
        inside &= values > (-np.inf if self.above is None else self.above)
        inside &= values >= (-np.inf if self.at_least is None else self.at_least)
        if self.below is not None:
            inside &= values < self.below
        inside &= values <= (np.inf if self.at_most is None else self.at_most)
        return np.asarray(inside)


def _as_floats(name: str, value: object, expected: str) -> Array:
    """A float64 copy; numbers only, so that a stray string or boolean is not taken for one."""
    try:
        given = np.asarray(value)
    except ValueError:  # ragged nesting
        given = np.asarray(None)
    if given.dtype.kind not in "iuf" or (given.ndim > 0 and given.size == 0):
        raise ParameterError(name, f"got {value!r}; expected {expected}")
    return np.array(given, dtype=np.float64, order="C")


class Scalar(Parameter[float, float]):
    """A parameter that is one number; inf only where that is said to be allowed."""

    def __init__(
        self,
        meaning: str,
        unit: str = "",
        *,
        above: float | None = None,
        at_least: float | None = None,
        below: float | None = None,
        at_most: float | None = None,
        infinite: bool = False,
        default: float = REQUIRED,
    ) -> None:
        super().__init__(meaning, unit, default=default)
        self.bound = _Number(unit, above, at_least, below, at_most, infinite)

    def convert(self, value: float) -> float:
        """A float within the bound."""
        number = _as_floats(self.name, value, f"one number, {self.bound.text}")
        if number.ndim != 0:
            raise ParameterError(self.name, f"got {value!r}; expected one number, {self.bound.text}, for all joints")
        if not self.bound.ok(number):
            raise ParameterError(self.name, f"got {float(number)!r}; it must be {self.bound.text}")
        return float(number)

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return f"a number{self.bound.words}"


class ScalarOrWord(Parameter["float | str", "float | str"]):
    """A parameter that is one number, or a word for a rule by which the law computes it."""

    def __init__(
        self,
        meaning: str,
        unit: str = "",
        *,
        words: tuple[str, ...],
        above: float | None = None,
        default: float | str = REQUIRED,
    ) -> None:
        super().__init__(meaning, unit, default=default)
        self.words = words
        self._scalar = Scalar(meaning, unit, above=above)
        self.bound = self._scalar.bound

    def convert(self, value: float | str) -> float | str:
        """One of the words, or a finite float within the bound."""
        self._scalar.name = self.name
        if not isinstance(value, str):
            return self._scalar.convert(value)
        if value in self.words:
            return value
        expected = f"one number, {self._scalar.bound.text}, or {' or '.join(map(repr, self.words))}"
        raise ParameterError(self.name, f"got {value!r}; expected {expected}")

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return ", ".join([self._scalar.takes, *(f'or "{word}"' for word in self.words)])


class OptionalScalar(Parameter["float | None", "float | None"]):
    """A parameter that is one number, or None."""

    def __init__(
        self, meaning: str, unit: str = "", *, above: float | None = None, default: float | None = None
    ) -> None:
        super().__init__(meaning, unit, default=default)
        self._scalar = Scalar(meaning, unit, above=above)
        self.bound = self._scalar.bound

    def convert(self, value: float | None) -> float | None:
        """None, or a finite float within the bound."""
        self._scalar.name = self.name
        return None if value is None else self._scalar.convert(value)

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return self._scalar.takes


class AsGiven(Parameter[Any, Any]):
    """A parameter that is kept as it is given: text, a table, a list of names. The class that has it checks it.

    Attributes:
        shape: What may be given, in words.
    """

    def __init__(self, meaning: str, unit: str = "", *, shape: str, default: Any = REQUIRED) -> None:
        super().__init__(meaning, unit, default=default)
        self.shape = shape

    def convert(self, value: Any) -> Any:
        """The value."""
        return value

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return self.shape


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
        self.bound = _Number(unit, above, at_least, at_most=at_most)

    def convert(self, value: Any) -> Array:
        """A read-only copy whose entries are finite and within the bound."""
        expected = f"{self.shape}, each {self.bound.text}"
        array = _as_floats(self.name, value, expected)
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


class Choice(Parameter[str, str]):
    """A parameter that is one of a few words."""

    def __init__(self, meaning: str, options: tuple[str, ...], *, default: str = REQUIRED) -> None:
        super().__init__(meaning, default=default)
        self.options = options

    def convert(self, value: str) -> str:
        """One of the options."""
        if value in self.options:
            return value
        hint = f"; {nearest(str(value), self.options)}" if near_names(str(value), self.options) else ""
        raise ParameterError(self.name, f"got {value!r}; expected one of {', '.join(map(repr, self.options))}{hint}")

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return ", ".join(f'"{option}"' for option in self.options)


def parameters_of(cls: type) -> dict[str, Parameter[Any, Any]]:
    """The fields of a class that are `Parameter`s, base classes first, in the order of their definition."""
    found: dict[str, Parameter[Any, Any]] = {}
    for base in reversed(cls.__mro__):
        found.update({name: item for name, item in vars(base).items() if isinstance(item, Parameter)})
    return found


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
