"""Fields that are one number."""

from __future__ import annotations

from typing import Any

from asmc_pin.errors import ParameterError
from asmc_pin.parameters.number_bounds import NUMBER, NumberBound, as_floats
from asmc_pin.parameters.parameter_field import REQUIRED, Parameter


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
        self.bound = NumberBound(unit, above, at_least, below, at_most, infinite)

    def convert(self, value: float) -> float:
        """A float within the bound."""
        number = as_floats(self.name, value, f"one number, {self.bound.text}")
        if number.ndim != 0:
            raise ParameterError(self.name, f"got {value!r}; expected one number, {self.bound.text}, for all joints")
        if not self.bound.ok(number):
            raise ParameterError(self.name, f"got {float(number)!r}; it must be {self.bound.text}")
        return float(number)

    @property
    def takes(self) -> str:
        """What may be given, in a few words."""
        return f"a number{self.bound.words}"

    @property
    def schema(self) -> dict[str, Any]:
        """A number."""
        return dict(NUMBER)


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

    @property
    def schema(self) -> dict[str, Any]:
        """A number or one of the words."""
        return {"anyOf": [NUMBER, {"enum": list(self.words)}]}


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

    @property
    def schema(self) -> dict[str, Any]:
        """A number; a file leaves out what is absent."""
        return dict(NUMBER)
