"""Gains for a law with one parameter more than PPC: the low-pass of `dob`, the share of `implicit`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers import CONTROLLERS, Dob, Implicit, TdeLaw
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.gain_choice.gain_search import GainSearch, Margins, rank_of
from asmc_pin.sampled.gain_choice.noise_budget import NoiseBudget
from asmc_pin.sampled.sampled_loop import SampledLoop

_WEIGHTS = (1.0, 0.7, 0.45, 0.3, 0.2, 0.12, 0.07)
_SHARES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
_FINENESS = (8, 12, 12)


@dataclass(frozen=True, eq=False)
class Bought:
    """What a law's gains are worth against PPC's with the same margins, on the same arm and ranges.

    Attributes:
        drift: Error under a drifting load over PPC's.
        reversal: RMS error after reversals of friction over PPC's, shape (nv,).
        noise: RMS of torque from the sensors' noise over PPC's, shape (nv,); None where no noise is named.
        allowed: Whether PPC kept to the noise budget that both were given, or set the one of this law.
    """

    drift: float
    reversal: Array
    noise: Array | None
    allowed: bool

    def to_json_dict(self) -> dict[str, Any]:
        """The figures by name."""
        noise = None if self.noise is None else self.noise.tolist()
        return {"drift_ratio": self.drift, "reversal_ratio": self.reversal.tolist(), "noise_ratio": noise}

    def line(self) -> str:
        """In a sentence."""
        if self.noise is None:
            same = "noise is not compared, for none is named (--encoder-bits, --velocity-noise)"
        elif self.allowed:
            same = f"noise in torque {_range(self.noise)} times"
        else:
            same = f"noise in torque {_range(self.noise)} times, which PPC does not keep within the budget"
        verdict = "" if self.drift < 1.0 else "; it buys nothing here"
        return (
            f"against PPC's own best gains with these margins: error under a drifting load {self.drift:.3g} times, "
            f"after friction reverses {_range(self.reversal)} times, {same}{verdict}"
        )


DESIGNED: Mapping[str, type[TdeLaw]] = {"dob": Dob, "implicit": Implicit}
"""Laws that gains can be chosen for, besides PPC."""

_CHOSEN = {"dob": "cutoff_hz", "implicit": "share"}


def checked_law(name: str) -> None:
    """Whether there is a choice of gains for a law.

    Raises:
        ParameterError: There is none.
    """
    if name not in DESIGNED:
        known = ", ".join(DESIGNED)
        said = (
            "is what gains are for without a law" if name == "ppc" else f"has no choice of gains; these have: {known}"
        )
        raise ParameterError("law", f"'{name}' {said}")


def law_searches(
    search: GainSearch, name: str, settings: Mapping[str, Any], budget: NoiseBudget | None
) -> list[GainSearch]:
    """A search for each value of the law's own parameter, or for the one that is given.

    For `dob` M̄ may be larger by 1/c, for the condition is one on cM̄, which then is M̄ at most.

    Args:
        search: The one for PPC, with M̄ at scale 1.
        name: Of the law.
        settings: Parameters of its own that are given.
        budget: Noise that the torque may have.

    Raises:
        ParameterError: The law does not take a value.
    """
    unit, key = search.loop, _CHOSEN[name]
    given = dict(settings)
    values = [given.pop(key)] if key in given else _values(name, unit.period)
    if name == "implicit":
        given.setdefault("gain", CONTROLLERS[name].typical["gain"])
    shared: dict[str, Any] = {"mbar": 1.0, "ks": 1.0, "beta": 1.0, "period": unit.period}
    shared |= {"acceleration": unit.acceleration, "filter_hz": unit.filter_hz}
    shared["pairing"] = "mean" if unit.averages_torque else "last"
    found = []
    for value in values:
        law = DESIGNED[name](**{**shared, **given, key: value})
        more = 1.0 / float(law.estimate_weight) if search.least < search.largest else 1.0
        found.append(
            replace(
                search,
                loop=replace(unit, law=law),
                least=more * search.least,
                largest=more * search.largest,
                budget=budget,
                fineness=_FINENESS,
            )
        )
    return found


def best_of_law(tries: list[GainSearch], asked: Margins, unit: SampledLoop) -> SampledLoop | None:
    """The gains of the parameter that is best on a grid, searched finely; None where none has the margins."""
    ranked = []
    for i, trial in enumerate(tries):
        found = trial.first(asked)
        if found is not None:
            ranked.append((rank_of(found, unit), i))
    for _, i in sorted(ranked, reverse=True):
        found = tries[i].with_margins(asked)
        if found is not None:
            return found
    return None


def _values(name: str, period: float) -> list[float]:
    if name == "implicit":
        return list(_SHARES)
    return [math.inf if c == 1.0 else float(f"{-math.log1p(-c) / (2.0 * math.pi * period):.3g}") for c in _WEIGHTS]


def _range(values: Array) -> str:
    low, high = float(np.min(values)), float(np.max(values))
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} to {high:.3g}"
