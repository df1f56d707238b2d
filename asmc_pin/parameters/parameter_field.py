"""A validated field of a frozen dataclass: what all kinds share, and those that hold no numbers."""

from __future__ import annotations

from typing import Any, Generic, TypeVar, overload

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

    @property
    def schema(self) -> dict[str, Any]:
        """What a file may give, as JSON Schema; anything where nothing is said."""
        return {}


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


class Choice(Parameter[str, str]):
    """A parameter that is one of a few words."""

    def __init__(self, meaning: str, options: tuple[str, ...], *, default: str = REQUIRED) -> None:
        super().__init__(meaning, default=default)
        self.options = options

    def convert(self, value: str) -> str:
        """One of the options."""
        if value in self.options:
            return value
        near = near_names(str(value), self.options)
        hint = f"; {nearest(str(value), near)}" if near else ""
        raise ParameterError(self.name, f"got {value!r}; expected one of {', '.join(map(repr, self.options))}{hint}")

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return ", ".join(f'"{option}"' for option in self.options)

    @property
    def schema(self) -> dict[str, Any]:
        """One of the words."""
        return {"enum": list(self.options)}


def parameters_of(cls: type) -> dict[str, Parameter[Any, Any]]:
    """The fields of a class that are `Parameter`s, base classes first, in the order of their definition."""
    found: dict[str, Parameter[Any, Any]] = {}
    for base in reversed(cls.__mro__):
        found.update({name: item for name, item in vars(base).items() if isinstance(item, Parameter)})
    return found
