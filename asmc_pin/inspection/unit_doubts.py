"""Numbers that look like another unit than the URDF's: g·mm² and its like, grams, millimetres, degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from asmc_pin.inspection.subject_of_doubt import Doubt, Sized, SubjectOfDoubt, some

_TENSOR_UNITS = {"kg·cm²": 4, "kg·mm²": 6, "g·cm²": 7, "g·mm²": 9}
"""By what power of ten a number in this unit is larger than in kg·m²."""

_FAR_BEYOND = 1.5
"""Times the extent of a body: no body has such a radius of gyration that does not reach far beyond its joints."""

_PLAIN_UNIT = 3.4
"""Power of ten from which on it is a unit; what is less has other causes too."""

_LONGEST_REACH = 30.0
"""m; beyond it lengths are in millimetres."""

_HEAVIEST = 3000.0
"""kg of moving mass per m³ of reach: arms have 5 to 200, in grams a thousand times that."""

_DENSEST, _LIGHTEST = 8000.0, 50.0
"""kg/m³: steel through and through has 7850, a shell with next to nothing in it some hundred."""

_LARGEST_LIMIT = 4.0 * math.pi
"""rad."""

_LARGEST_ANGLE = 2.0 * math.pi + 0.1
"""rad, of roll, pitch and yaw."""


def unit_doubts(subject: SubjectOfDoubt, root: Any, invented: set[str]) -> Iterator[Doubt]:
    """Doubts about units.

    Args:
        subject: The robot.
        root: Its ``<robot>`` element.
        invented: Links whose tensors are doubted for another reason already.
    """
    if subject.reach > _LONGEST_REACH:
        yield Doubt(
            "lengths",
            (),
            f"the arm reaches {subject.reach:.4g} m: origins look like millimetres ({1e-3 * subject.reach:.3g} m?)",
        )
    else:
        yield from _masses(subject)
        yield from _centres(subject)
        yield from _tensors(subject, invented)
    yield from _densities(subject)
    yield from _limits(subject)
    yield from _angles(root)


def _masses(subject: SubjectOfDoubt) -> Iterator[Doubt]:
    mass, room = subject.mass, subject.reach**3
    if mass > _HEAVIEST * room > 0.0:
        text = f"{mass:.4g} kg move within a reach of {subject.reach:.2g} m: masses that look like grams"
        yield Doubt("masses", (), text)


def _centres(subject: SubjectOfDoubt) -> Iterator[Doubt]:
    # A centre in millimetres makes the reach: so it is held against the way between the joints alone.
    steps = [float(np.linalg.norm(p.translation)) for p in subject.parts.model.jointPlacements]
    way = sum(steps)
    bodies = [s for s in subject.bodies if s.body.mass > 0.0]
    far = [s for s in bodies if float(np.linalg.norm(s.body.com)) > 5.0 * way > 0.0]
    if far:
        names = [sized.body.links[0] for sized in far]
        distance = max(float(np.linalg.norm(sized.body.com)) for sized in far)
        text = f"centre of mass of {some(names)} up to {distance:.3g} m from its joint: looks like millimetres"
        yield Doubt("centres", tuple(names), text)


def _tensors(subject: SubjectOfDoubt, invented: set[str]) -> Iterator[Doubt]:
    units: dict[str, list[Sized]] = {}
    large: list[Sized] = []
    for sized in subject.bodies:
        if (
            sized.extent <= 0.0
            or invented & set(sized.body.links)
            or float(sized.radii[-1]) <= _FAR_BEYOND * sized.extent
        ):
            continue
        # A third of its extent is what a body's radius of gyration commonly is.
        power = 2.0 * math.log10(float(sized.radii[-1]) / (0.3 * sized.extent))
        unit = min(_TENSOR_UNITS, key=lambda name: abs(_TENSOR_UNITS[name] - power))
        if power > _PLAIN_UNIT:
            units.setdefault(unit, []).append(sized)
        else:
            large.append(sized)
    for unit, found in units.items():
        names = [sized.body.links[0] for sized in found]
        radius = max(float(sized.radii[-1]) for sized in found)
        text = f"inertia of {some(names)} looks like {unit}: in kg·m² its radius of gyration is up to {radius:.3g} m"
        yield Doubt("tensor unit", tuple(names), text)
    if large:
        names = [sized.body.links[0] for sized in large]
        worst = max(large, key=lambda sized: float(sized.radii[-1]) / sized.extent)
        text = (
            f"radius of gyration far beyond the link: {some(names)}; '{worst.body.links[0]}' has "
            f"{worst.radii[-1]:.2g} m, and extends some {worst.extent:.2g} m"
        )
        yield Doubt("radius of gyration", tuple(names), text)


def _densities(subject: SubjectOfDoubt) -> Iterator[Doubt]:
    """Of links whose inertia was estimated from shapes and a mass."""
    densities = subject.parts.robot.densities
    for odd, than in (
        ({link: value for link, value in densities.items() if value > _DENSEST}, "more than steel's 7850"),
        ({link: value for link, value in densities.items() if value < _LIGHTEST}, "less than a hollow shell's"),
    ):
        if odd:
            low, high = min(odd.values()), max(odd.values())
            values = f"{low:.3g}" if high < 1.01 * low else f"{low:.3g} to {high:.3g}"
            text = (
                f"the mass given for {some(list(odd))} means {values} kg/m³, {than}: check the mass, and the scale of "
                "the shapes"
            )
            yield Doubt("density", tuple(odd), text)


def _limits(subject: SubjectOfDoubt) -> Iterator[Doubt]:
    found = []
    for joint in (sized.body.joint for sized in subject.bodies):
        ends = [abs(end) for end in (joint.lower, joint.upper) if math.isfinite(end)]
        if joint.kind == "revolute" and ends and max(ends) > _LARGEST_LIMIT:
            found.append(joint)
    if found:
        names = [joint.name for joint in found]
        first = found[0]
        text = f"limits of {some(names)} look like degrees: {first.lower:g} … {first.upper:g} rad"
        yield Doubt("limits", tuple(names), text)


def _angles(root: Any) -> Iterator[Doubt]:
    found = []
    for owner in root:
        for origin in owner.iter("origin") if owner.tag in ("joint", "link") else ():
            if origin.getparent().tag in ("visual", "collision"):
                continue
            if any(abs(float(x)) > _LARGEST_ANGLE for x in origin.get("rpy", "0 0 0").split()):
                found.append(owner.get("name"))
    if found:
        names = list(dict.fromkeys(found))
        yield Doubt("angles", tuple(names), f"roll, pitch or yaw beyond a turn at {some(names)}: looks like degrees")
