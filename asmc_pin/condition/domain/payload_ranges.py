"""What an arm may carry: one payload, a range of its mass, a range of its place.

M is affine in the mass of a payload with one centre and shape, so the ends of a range of masses cover it. In the place
it is not: a body at c adds m |v + ω × c|², which is convex in c and may be least in between. So a range of places is
looked at where its axes begin, in the middle and where they end; proofs cover what lies between (`places_between`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from asmc_pin.arms.payload import Payload
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

PayloadRange: TypeAlias = Any
"""What `load_arm` takes as a payload; a tuple of two such, the lightest and the heaviest of a range; or a mapping with
``mass`` and the entries of ``com`` as numbers or as ranges (lo, hi), and ``inertia`` of the heaviest, in whose
proportions lighter ones are."""


def is_range(payload: PayloadRange) -> bool:
    """Whether it stands for more than one payload."""
    if not isinstance(payload, Mapping):
        return isinstance(payload, tuple)
    com = payload.get("com", ())
    axes = com if isinstance(com, Sequence) and not isinstance(com, str) else ()
    return any(isinstance(value, tuple | list) for value in (payload.get("mass"), *axes))


def carrying(arm: Arm, payload: PayloadRange) -> list[tuple[Arm, str]]:
    """The arm with each payload that is looked at, and what it is in words; with the arm's own where none is given.

    Raises:
        ParameterError: A malformed or empty range.
    """
    if payload is None:
        return [(arm, "")]
    if not is_range(payload):
        return [(arm.replace(payload=payload), "")]
    if isinstance(payload, Mapping):
        return [(arm.replace(payload=load), _words(load)) for load in _over(payload)]
    if len(payload) != 2:
        raise ParameterError(
            "payload", f"{len(payload)} values given, one payload or a range (lightest, heaviest) expected"
        )
    ends = [arm.replace(payload=end) for end in payload]
    loads = [end.payload for end in ends]
    masses = [load.mass if load is not None else 0.0 for load in loads]
    if masses[0] > masses[1]:
        raise ParameterError("payload", f"the range {masses[0]:g}:{masses[1]:g} is empty: lower end above upper end")
    light, heavy = loads
    if light and heavy and light.mass > 0.0 and (light.com, light.link) != (heavy.com, heavy.link):
        raise ParameterError(
            "payload",
            "the ends have different centres or links, and between such the condition need not hold; verify each alone",
        )
    if masses[0] == masses[1] > 0.0 and light != heavy:
        raise ParameterError("payload", f"both ends weigh {masses[0]:g} kg; a range has a lighter and a heavier end")
    if light == heavy:
        ends, masses = ends[:1], masses[:1]
    return [(end, f"payload {mass:g} kg") for end, mass in zip(ends, masses, strict=True)]


def has_places(loads: Sequence[Payload | None]) -> bool:
    """Whether payloads hang at different places, so that what lies between them is not covered by them."""
    return len({load.com for load in loads if load is not None and load.mass > 0.0}) > 1


def _over(payload: Mapping[str, Any]) -> list[Payload]:
    """Both ends of the mass at every place, one without mass but once."""
    given = dict(payload)
    masses = _ends("payload.mass", given.pop("mass", None))
    com = given.pop("com", (0.0, 0.0, 0.0))
    if not isinstance(com, Sequence) or isinstance(com, str) or len(com) != 3:
        raise ParameterError("payload.com", f"{com!r} given, 3 numbers or ranges (lo, hi) expected")
    axes = [_ends("payload.com", value) for value in com]
    # The mass at its end makes the rest of the checks, with a message of its own.
    heaviest = Payload(**{**given, "mass": masses[-1], "com": tuple(ends[0] for ends in axes)})
    found = []
    looked_at = [(ends[0], 0.5 * (ends[0] + ends[1]), ends[1]) if len(ends) == 2 else ends for ends in axes]
    for number, place in enumerate(product(*looked_at)):
        for mass in masses:
            if mass > 0.0 or number == 0:
                share = mass / masses[-1] if masses[-1] > 0.0 else 0.0
                inertia = tuple((share * np.array(heaviest.inertia)).tolist())
                found.append(Payload(mass, place, inertia, heaviest.link))  # type: ignore[arg-type]  # of 3 and of 6
    return found


def _ends(name: str, value: Any) -> tuple[float, ...]:
    """One number, or two in ascending order."""
    try:
        ends = tuple(map(float, value)) if isinstance(value, tuple | list) else (float(value),)
    except (TypeError, ValueError):
        ends = ()
    if not ends or len(ends) > 2 or not all(map(math.isfinite, ends)):
        raise ParameterError(name, f"{value!r} given, a number or a range (lo, hi) expected")
    if ends[0] > ends[-1]:
        raise ParameterError(name, f"the range {ends[0]:g}:{ends[1]:g} is empty: lower end above upper end")
    return ends[:1] if ends[0] == ends[-1] else ends


def _words(load: Payload) -> str:
    return f"payload {load.mass:g} kg" + (f" at ({', '.join(f'{x:g}' for x in load.com)}) m" if load.mass else "")
