"""What a constructor takes, read from the constructor itself, and calling it with a table of an experiment file."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from asmc_pin.errors import ParameterError
from asmc_pin.parameters import (
    REQUIRED,
    Choice,
    OptionalScalar,
    Parameter,
    PerJoint,
    Scalar,
    ScalarOrWord,
    Values,
    parameters_of,
)

_NUMBER = {"type": "number"}
_LIST = {"type": "array", "items": _NUMBER, "minItems": 1}
_NESTED = {"type": "array", "items": _LIST, "minItems": 1}


@dataclass(frozen=True, slots=True)
class Mistake:
    """One thing that is wrong with an experiment.

    Attributes:
        key: Path of the key, such as ``controllers.PPC.beta``.
        message: What is wrong, and how to correct it.
    """

    key: str
    message: str


class Signature:
    """The keyword parameters of a class.

    Attributes:
        names: All of them, in the order of the constructor.
        required: Those without a default.
        open: Whether the constructor takes any keyword at all (``**kwargs``).
        described: Those that carry their meaning, unit and bound.
    """

    def __init__(self, cls: type) -> None:
        keywords, self.open = _keywords(cls)
        self.described: dict[str, Parameter[Any, Any]] = parameters_of(cls)
        self.names = tuple(item.name for item in keywords)
        self.required = tuple(item.name for item in keywords if self._required(item))

    def _required(self, item: inspect.Parameter) -> bool:
        described = self.described.get(item.name)
        return item.default is item.empty if described is None else described.default is REQUIRED

    def takes(self, name: str) -> bool:
        """Whether there is a parameter of this name."""
        return self.open or name in self.names

    def per_joint(self, name: str) -> bool:
        """Whether a list given for it has one value for each joint."""
        return isinstance(self.described.get(name), PerJoint)

    def json_schema(self, name: str) -> dict[str, Any]:
        """JSON Schema of one parameter; of any value if the parameter does not say what it is."""
        item = self.described.get(name)
        if item is None:
            return {}
        schema: dict[str, Any]
        if isinstance(item, Choice):
            schema = {"enum": list(item.options)}
        elif isinstance(item, (Scalar, OptionalScalar)):
            schema = dict(_NUMBER)
        elif isinstance(item, ScalarOrWord):
            schema = {"anyOf": [_NUMBER, {"enum": list(item.words)}]}
        elif isinstance(item, Values):
            kinds = (_NUMBER, _LIST, _NESTED)
            in_files = (0, 1) if isinstance(item, PerJoint) else item.axes  # a row per trial is for Python alone
            schema = {"anyOf": [kinds[min(axes, 2)] for axes in in_files]}
        else:
            schema = {}
        unit = f", {item.unit}" if item.unit else ""
        return {**schema, "description": f"{item.meaning}{unit}"}


@functools.cache  # sweeps ask again and again, and reading a constructor takes a tenth of a millisecond
def _keywords(cls: type) -> tuple[tuple[inspect.Parameter, ...], bool]:
    """The keyword parameters of a constructor, and whether it takes any other as well."""
    parameters: list[inspect.Parameter] = []
    takes_any = True
    with suppress(TypeError, ValueError):  # some classes of compiled modules have no signature
        parameters = list(inspect.signature(cls).parameters.values())
        takes_any = any(item.kind is item.VAR_KEYWORD for item in parameters)
    kinds = inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY
    return tuple(item for item in parameters if item.kind in kinds), takes_any


def construct(cls: type, values: Mapping[str, Any], path: str) -> tuple[Any, list[Mistake]]:
    """Call a constructor with the values of a table.

    Args:
        cls: The class; its parameters are keywords.
        values: Parameters that it takes.
        path: Path of the table in the file.

    Returns:
        The object and no problem, or None and what is wrong.
    """
    missing = [name for name in Signature(cls).required if name not in values]
    if missing:
        return None, [Mistake(f"{path}.{name}", "is missing") for name in missing]
    try:
        return cls(**values), []
    except ParameterError as error:
        key = f"{path}.{error.parameter}"
        return None, [Mistake(key, str(error).removeprefix(f"{error.parameter}: "))]
    except (Exception, SystemExit) as error:  # a law of the user's own may raise anything
        return None, [Mistake(path, f"{cls.__name__} refuses these parameters: {type(error).__name__}: {error}")]
