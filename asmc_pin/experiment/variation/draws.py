"""Random numbers of a trial: how one is drawn, and from which generator."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin.plant.sensor.trial_noise import SWEEP, generator

DISTRIBUTIONS: Mapping[str, str] = {
    "uniform": "two numbers, [lowest, largest]",
    "normal": "a standard deviation about the file's own value, or [mean, standard deviation]",
    "lognormal": "a standard deviation of the logarithm about the file's own value, or [median, standard deviation]",
}
"""How a number can be drawn, and what each is told."""

_MOST_REDRAWS = 10_000


@dataclass(frozen=True)
class Distribution:
    """A distribution.

    Attributes:
        kind: Key of `DISTRIBUTIONS`.
        centre: Lowest value, mean or median; None for the file's own value (of a factor: 1).
        width: Largest value, or standard deviation, of the logarithm where it is lognormal.
        at_least: What is drawn below it is drawn again.
        at_most: What is drawn above it is drawn again.
        each: Whether every number of a list is drawn for itself.
    """

    kind: str
    centre: float | None
    width: float
    at_least: float = -math.inf
    at_most: float = math.inf
    each: bool = False

    def numbers(self, source: np.random.Generator, own: list[float]) -> list[float] | None:
        """Numbers about the file's own ones; None where hardly any lie within the bounds.

        Args:
            source: Where the randomness comes from.
            own: What the file has, one value or those of a list; without `each` one draw serves all of them.
        """
        for _ in range(_MOST_REDRAWS):
            chances = [self._chance(source) for _ in own] if self.each else [self._chance(source)] * len(own)
            found = [self._number(chance, value) for chance, value in zip(chances, own, strict=True)]
            if all(self.at_least <= number <= self.at_most for number in found):
                return found
        return None

    def _chance(self, source: np.random.Generator) -> float:
        return source.random() if self.kind == "uniform" else source.standard_normal()

    def _number(self, chance: float, own: float) -> float:
        centre = own if self.centre is None else self.centre
        if self.kind == "uniform":
            return centre + (self.width - centre) * chance
        return centre + self.width * chance if self.kind == "normal" else centre * math.exp(self.width * chance)


def draw_generator(seed: int, draw: int, path: str) -> np.random.Generator:
    """The generator of one draw of one key: whatever else varies, in whatever block it runs, it is the same.

    Args:
        seed: Seed of the experiment.
        draw: Number of the draw.
        path: Of the key that varies.
    """
    words = np.frombuffer(hashlib.sha256(path.encode()).digest()[:16], dtype="<u4")
    return generator(seed, draw, SWEEP, *words.tolist())


def read_draw(table: Mapping[str, Any], factor: bool) -> Distribution:
    """The distribution that a table describes.

    Raises:
        ValueError: what is wrong with it, in words.
    """
    kind = next(iter(table.keys() & DISTRIBUTIONS.keys()))
    given = table[kind]
    numbers = given if isinstance(given, list) else [given]
    if not all(is_finite(x) for x in numbers) or not 1 <= len(numbers) <= 2 or (kind == "uniform" and len(numbers) < 2):
        raise ValueError(f"{kind} takes {DISTRIBUTIONS[kind]}; got {given!r}")
    if kind == "uniform" and not numbers[0] < numbers[1]:
        raise ValueError(f"uniform takes the lowest value first; got {given!r}")
    if kind != "uniform" and numbers[-1] < 0.0:
        raise ValueError(f"the standard deviation of {kind} cannot be negative; got {given!r}")
    if kind == "lognormal" and len(numbers) == 2 and numbers[0] <= 0.0:
        raise ValueError(f"the median of lognormal must be positive; got {given!r}")
    bounds = {}
    for name in ("at_least", "at_most"):
        if name in table:
            if not is_finite(table[name]):
                raise ValueError(f"{name} must be a number; got {table[name]!r}")
            bounds[name] = float(table[name])
    each = table.get("each", False)
    if not isinstance(each, bool):
        raise ValueError(f"each must be true or false; got {each!r}")
    alone = 1.0 if factor else None
    centre = float(numbers[0]) if len(numbers) == 2 else alone
    found = Distribution(kind, centre, float(numbers[-1]), each=each, **bounds)
    if not found.at_least < found.at_most:
        raise ValueError(f"at_least must be below at_most; got {found.at_least:g} and {found.at_most:g}")
    return found


def is_finite(value: object) -> bool:
    """Whether a value of a file is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
