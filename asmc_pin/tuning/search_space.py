"""What is searched of a controller, and in which range: one rule for every law.

Searched are M̄, K_s and β, and of the law's own parameters those that it requires or that the file gives. A list is
searched as a whole, by one factor on all of its numbers. The range is a factor of `SPAN` to either side of the start,
cut to what the law takes. Words, zeros and infinities have no such range and stay. ``[tune] search`` gives other
ranges, names parameters that the rule leaves alone, and asks for each joint by itself (`each`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from asmc_pin.controllers import REQUIRED, TdeLaw, parameters_of
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.checks.tune_checks import NO_GAINS
from asmc_pin.experiment.constructors import Signature
from asmc_pin.experiment.law_lookup import load_law

SPAN = 10.0
"""Of the rule: each start is searched from itself over this to itself times this."""

DIGITS = 4
"""Of a candidate's numbers: what is tried is what a file can show."""

_LOOP = ("mbar", "ks", "beta")
_INSIDE = 1e-3  # of a bound that a parameter may not reach


@dataclass(frozen=True)
class SearchedGain:
    """One parameter that is searched.

    Attributes:
        name: Of the parameter.
        start: The file's value; a law's default where `search` names one that the file does not give.
        low: Lowest factor on the start.
        high: Largest factor.
        each: Whether every number of a list has a factor of its own.
    """

    name: str
    start: float | list[float]
    low: float
    high: float
    each: bool = False

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of its factors: one, or one for each number of the list."""
        if self.each and isinstance(self.start, list):
            return tuple(f"{self.name}[{i}]" for i in range(len(self.start)))
        return (self.name,)

    def value(self, factors: Mapping[str, float]) -> float | list[float]:
        """The parameter at these factors, by the names of `factors`; the start itself, with all digits, at 1."""
        own = [factors[name] for name in self.factors]
        if isinstance(self.start, list):
            spread = own if len(own) == len(self.start) else own * len(self.start)
            return [_rounded(x, factor) for x, factor in zip(self.start, spread, strict=True)]
        return _rounded(self.start, own[0])


@dataclass(frozen=True)
class SearchSpace:
    """Everything that is searched of one controller.

    Attributes:
        label: Of the controller.
        law: Name of its law.
        table: Its parameters as they stand, those of ``[defaults]`` that its law takes among them.
        gains: What is searched.
    """

    label: str
    law: str
    table: Mapping[str, Any]
    gains: tuple[SearchedGain, ...]

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and largest factor by name; what stands still has none."""
        return {name: (gain.low, gain.high) for gain in self.gains for name in gain.factors if gain.low < gain.high}

    @property
    def holds_the_start(self) -> bool:
        """Whether the file's own gains lie within the ranges."""
        return all(gain.low <= 1.0 <= gain.high for gain in self.gains)

    def setting(self, factors: Mapping[str, float]) -> dict[str, float | list[float]]:
        """The parameters at these factors, as TOML takes them; a factor that is not given is the least that may be."""
        found = {}
        for gain in self.gains:
            known = {name: factors.get(name, gain.low) for name in gain.factors}
            found[gain.name] = gain.value(known)
        return found

    def start(self) -> dict[str, float | list[float]]:
        """The parameters as they stand."""
        return {gain.name: gain.start for gain in self.gains}


def search_space(experiment: Experiment, label: str) -> SearchSpace:
    """What is searched of a controller.

    Raises:
        ExperimentError: a range has nothing that the law takes, or stands at a parameter without a positive value.
    """
    own = experiment.controllers[label]
    law = load_law(str(own["law"]), experiment.folder)
    signature = Signature(law)
    taken = {key: value for key, value in experiment.defaults.items() if signature.takes(key)}
    table = taken | {key: value for key, value in own.items() if key != "law"}
    gains = tuple(_gains(law, table, _asked(experiment, label), label))
    return SearchSpace(label, str(own["law"]), table, gains)


def _asked(experiment: Experiment, label: str) -> dict[str, tuple[str, Mapping[str, Any]]]:
    """Lines of ``[tune] search`` that are about a controller, by parameter; its own go before general ones."""
    search = experiment.tune.search
    found = {path.removeprefix("defaults."): (path, item) for path, item in search.items() if path[:9] == "defaults."}
    before = f"controllers.{label}."
    return found | {path.removeprefix(before): (path, item) for path, item in search.items() if path.startswith(before)}


def _gains(
    law: type, table: Mapping[str, Any], asked: Mapping[str, tuple[str, Mapping[str, Any]]], label: str
) -> Iterator[SearchedGain]:
    shared = parameters_of(TdeLaw)
    for name, item in parameters_of(law).items():
        start = table.get(name, None if item.default is REQUIRED else item.default)
        by_rule = name in table and name not in NO_GAINS and (name in _LOOP or name not in shared)
        if name not in asked:
            if by_rule and _is_positive(start):
                yield _cut(item, SearchedGain(name, start, 1.0 / SPAN, SPAN))
            continue
        path, line = asked[name]
        key = f'tune.search."{path}"'
        if not _is_positive(start):
            told = f"{label} has {name} = {start!r}, and a range starts from a positive number; give it one"
            raise ExperimentError(key, told)
        each = bool(line.get("each", False))
        if "factor" in line:
            low, high = line["factor"]
        elif isinstance(start, list):
            raise ExperimentError(key, f"{label} has a list there; give factor instead of range")
        else:
            low, high = (end / start for end in line["range"])
        gain = _cut(item, SearchedGain(name, start, float(low), float(high), each))
        if not gain.low <= gain.high:
            bound: Any = getattr(item, "bound", None)
            raise ExperimentError(key, f"{label} takes nothing between these ends; {name} must be {bound.text}")
        yield gain


def _cut(item: Any, gain: SearchedGain) -> SearchedGain:
    """The range cut to what the law takes."""
    bound, low, high = getattr(item, "bound", None), gain.low, gain.high
    if bound is None:
        return gain
    numbers = gain.start if isinstance(gain.start, list) else [gain.start]
    if bound.above is not None and bound.above > 0.0:
        low = max(low, *(bound.above * (1.0 + _INSIDE) / x for x in numbers))
    if bound.at_least is not None and bound.at_least > 0.0:
        low = max(low, *(bound.at_least / x for x in numbers))
    if bound.below is not None:
        high = min(high, *(bound.below * (1.0 - _INSIDE) / x for x in numbers))
    if bound.at_most is not None:
        high = min(high, *(bound.at_most / x for x in numbers))
    return SearchedGain(gain.name, gain.start, low, high, gain.each)


def _is_positive(value: Any) -> bool:
    numbers = value if isinstance(value, list) and value else [value]
    return all(isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x) and x > 0.0 for x in numbers)


def _rounded(start: float, factor: float) -> float:
    return start if factor == 1.0 else float(f"{start * factor:.{DIGITS}g}")
