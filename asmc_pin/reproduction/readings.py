"""Other readings of the paper's units and gains: the printed numbers, in radians, are the first option on each axis."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import get_args

from asmc_pin.controllers import TdeLaw, parameters_of
from asmc_pin.words.choices import Acceleration

DEG = 180.0 / math.pi
AS_PRINTED = "as printed"

# Factors of β and of K_s.
GAINS: Mapping[str, tuple[float, float]] = {
    AS_PRINTED: (1.0, 1.0),
    "β × 180/π": (DEG, 1.0),
    "K_s × 180/π": (1.0, DEG),
    "β and K_s × √(180/π)": (math.sqrt(DEG), math.sqrt(DEG)),
    "β and K_s × 180/π": (DEG, DEG),
    "β and K_s × 5": (5.0, 5.0),
    "β and K_s × 10": (10.0, 10.0),
    "β and K_s × 15": (15.0, 15.0),
    "β and K_s × 20": (20.0, 20.0),
}
# Factors of parameters in the units of k̂ or its rate, and of those in the unit of s, which bring a law in other units
# to rad; and of s and k̂, which bring what is measured in rad to the figure's units.
ADAPTATION: Mapping[str, tuple[float, float, float, float]] = {
    AS_PRINTED: (1.0, 1.0, 1.0, 1.0),
    "s and k̂ in degrees": (1.0 / DEG, 1.0 / DEG, DEG, DEG),
    "k̂ in degrees, s in rad/s": (1.0 / DEG, 1.0, 1.0, DEG),
    "s in degrees, k̂ in rad/s²": (1.0, 1.0 / DEG, DEG, 1.0),
}
INERTIA: Mapping[str, float] = {AS_PRINTED: 1.0, "M̄ × 180/π (torque from degrees)": DEG}
# Factor of the friction, and the travel over which it builds up before a joint slides, rad: 0 for a jump, as printed.
FRICTION: Mapping[str, tuple[float, float]] = {
    AS_PRINTED: (1.0, 0.0),
    "half": (0.5, 0.0),
    "smoothed over 0.02 rad": (1.0, 0.02),
    "none": (0.0, 0.0),
}
MOTION: Mapping[str, float] = {"ours": 1.0, "gentler": 0.8, "quicker": 2.0}
ERRORS: Mapping[str, float] = {"deg": 1.0, "rad": 1.0 / DEG}
START: Sequence[str] = ("holding", "relaxed")
ESTIMATE: Sequence[str] = get_args(Acceleration)

AXES: Mapping[str, Sequence[str]] = {
    "gains": tuple(GAINS),
    "adaptation": tuple(ADAPTATION),
    "inertia": tuple(INERTIA),
    "friction": tuple(FRICTION),
    "motion": tuple(MOTION),
    "errors": tuple(ERRORS),
    "start": START,
    "estimate": ESTIMATE,
}
# In combination only these: the other options are steps between them, or move the figures by little.
_COMBINED: Mapping[str, Sequence[str]] = {
    **AXES,
    "friction": (AS_PRINTED, "none"),
    "motion": ("ours", "quicker"),
    "start": START[:1],
    "estimate": ESTIMATE[:1],
}


@dataclass(frozen=True)
class ReadingOutcome:
    """What a reading gives on one experiment of the paper.

    Attributes:
        reading: Option chosen on each axis.
        rms_deg: RMS error of PPC and of the proposed law, deg as the table would print it; NaN if it diverged.
        torque: Largest |τ| of the proposed law, N·m.
        gain: Its largest k̂, in the units of the reading.
        s: Its largest |s| by joint, in the units of the reading.
        distance: Squared logarithms of measured over printed, one for each figure that is compared; infinite if a law
            diverged.
    """

    reading: Mapping[str, str]
    rms_deg: Mapping[str, tuple[float, ...]]
    torque: float
    gain: float
    s: tuple[float, ...]
    distance: tuple[float, ...]

    @property
    def departures(self) -> int:
        """On how many axes it leaves what is printed."""
        return sum(option != AXES[axis][0] for axis, option in self.reading.items())


def readings(combined: bool) -> Iterator[dict[str, str]]:
    """Every combination of the axes that matter, or every option of every axis by itself."""
    if combined:
        for chosen in itertools.product(*_COMBINED.values()):
            yield dict(zip(_COMBINED, chosen, strict=True))
        return
    base = {axis: options[0] for axis, options in AXES.items()}
    yield base
    for axis, options in AXES.items():
        for option in options[1:]:
            yield {**base, axis: option}


def as_read(law: TdeLaw, reading: Mapping[str, str]) -> TdeLaw:
    """A law's parameters under a reading, in rad."""
    beta, ks = GAINS[reading["gains"]]
    changed = replace(
        law,
        beta=law.beta * beta,
        ks=law.ks * ks,
        mbar=law.mbar * INERTIA[reading["inertia"]],
        acceleration=reading["estimate"],
    )
    rate, size, _, _ = ADAPTATION[reading["adaptation"]]
    factors = {"rad/s": size, "rad/s²": rate, "rad/s³": rate}
    own = {name: item.unit for name, item in parameters_of(type(law)).items() if item.unit in factors}
    # A rule such as ε = 4 k̂ L follows from the gain, in whatever units that is.
    given = {name: getattr(changed, name) for name in own}
    numbers = {name: value for name, value in given.items() if not isinstance(value, str)}
    return replace(changed, **{name: value * factors[own[name]] for name, value in numbers.items()})
