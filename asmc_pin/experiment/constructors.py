"""What a constructor takes, read from the constructor itself, and calling it with a table of an experiment file."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from asmc_pin.errors import ParameterError
from asmc_pin.parameters import REQUIRED, Parameter, PerJoint, parameters_of


@dataclass(frozen=True, slots=True)
class Mistake:
    """One thing that is wrong with an experiment.

    Attributes:
        key: Path of the key, such as ``controllers.PPC.beta``.
        message: What is wrong, and how to correct it.
    """

    key: str
    message: str

    @classmethod
    def of(cls, path: str, error: ParameterError) -> Mistake:
        """What is wrong with a parameter that is given in the table at a path."""
        return cls(f"{path}.{error.parameter}", error.said)


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
        unit = f", {item.unit}" if item.unit else ""
        return {**item.schema, "description": f"{item.meaning}{unit}"}


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
        return None, [Mistake.of(path, error)]
    except (Exception, SystemExit) as error:  # a law of the user's own may raise anything
        return None, [Mistake(path, f"{cls.__name__} refuses these parameters: {type(error).__name__}: {error}")]
