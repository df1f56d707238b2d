"""What a certificate speaks of, derived from the URDF and the cases inside it; its own labels are not asked."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin.condition.checker.reading.certificate_schema import Contents
from asmc_pin.condition.checker.reading.coupled_joints import following
from asmc_pin.condition.checker.reading.header_parts import Header, Load, Malformed, WrittenCase
from asmc_pin.condition.checker.reading.link_chain import Chain
from asmc_pin.condition.checker.reading.urdf_text import Description
from asmc_pin.condition.hypotheses import Carried, Hypotheses, Premises, Proviso, fold_locks
from asmc_pin.words.text import printable


@dataclass(frozen=True, eq=False)
class Subject:
    """The theorem's hypotheses, and the words that tell its cases apart.

    Attributes:
        hypotheses: Of all cases together.
        labels: One per case; empty where nothing is particular about it.
    """

    hypotheses: Premises
    labels: tuple[str, ...]


def subject(told: Header, urdf: str, robot: Description, chain: Chain) -> Subject:
    """Derive what the statements, all together, are about.

    Args:
        told: The header.
        urdf: The URDF's text.
        robot: The same, read.
        chain: Any case's chain.

    Returns:
        The hypotheses.

    Raises:
        Malformed: The cases are not what one statement's ranges come to, so that no one sentence says what is proven.
    """
    cases = told.cases
    locked, together = _locked(cases)
    loads = _loads(cases)
    boxes = sorted({(case.lower, case.upper) for case in cases})
    ranges = {(case.armature_lower, case.armature_upper) for case in cases}
    if len(ranges) != 1:
        raise Malformed("the cases have different ranges of the armature")
    held = {tuple(sorted(case.locked.items())) for case in cases}
    # All are different and as many as there can be: then they are all of them.
    there = {(tuple(sorted(case.locked.items())), case.load, case.lower, case.upper) for case in cases}
    if len(there) != len(held) * len(loads) * len(boxes) or len(cases) != len(there):
        raise Malformed("the cases are not all the ends of its ranges, each once")
    low, high = next(iter(ranges))
    hull = zip(
        (min(ends) for ends in zip(*(box[0] for box in boxes), strict=True)),
        (max(ends) for ends in zip(*(box[1] for box in boxes), strict=True)),
        strict=True,
    )
    premises: dict[str, Any] = dict(
        arm=robot.name,
        sha256=hashlib.sha256(urdf.encode()).hexdigest(),
        joints=told.joints,
        slides=tuple(bool(slides) for slides in (chain.slides[chain.leader] if chain.follows else chain.slides)),
        armature=tuple(a if a == b else (a, b) for a, b in zip(low, high, strict=True)),
        payload=_carried(loads),
        locked=locked,
        together=together,
        box=dict(zip(told.joints, hull, strict=True)),
        where="box" if len(boxes) == 1 else "boxes",
        parts=len(boxes),
        boxes=tuple(boxes) if len(boxes) > 1 else (),
        mimics=following(robot, told.joints, told.moving).mimics(),
        elsewhere=_elsewhere(told.joints, chain),
        provisos=tuple(Proviso(p.kind, f"as the certificate's maker says: {p.text}") for p in told.provisos),
    )
    hypotheses = Premises(**premises)
    if isinstance(told, Contents):
        hypotheses = Hypotheses(**premises, condition=told.condition, level=told.level, mbar=told.mbar)
    return Subject(hypotheses, tuple(_label(case, locked, loads, boxes) for case in cases))


def _elsewhere(joints: tuple[str, ...], chain: Chain) -> tuple[str, ...]:
    """The joints after a whole turn of which what follows them is elsewhere."""
    if not chain.follows:
        return ()
    back = ~chain.slides & (chain.ratio == np.round(chain.ratio))
    return tuple(name for c, name in enumerate(joints) if not back[chain.coordinate == c].all())


def _locked(cases: tuple[WrittenCase, ...]) -> tuple[dict[str, float | tuple[float, ...]], bool]:
    names = set(cases[0].locked)
    if any(set(case.locked) != names for case in cases):
        raise Malformed("the cases lock different joints")
    return fold_locks(sorted((case.locked for case in cases), key=lambda locked: [locked[n] for n in cases[0].locked]))


def _loads(cases: tuple[WrittenCase, ...]) -> tuple[Load | None, ...]:
    """The one payload, or the two ends of a range, the lightest first."""
    loads = tuple(sorted({case.load for case in cases}, key=lambda load: load.mass if load is not None else -1.0))
    if len(loads) > 2:
        raise Malformed("more than two payloads are no range of one")
    if len(loads) == 2:
        light, heavy = loads
        # M is affine between two loads only where both hang at one point.
        if light is not None and heavy is not None:
            if (light.link, light.com) != (heavy.link, heavy.com):
                raise Malformed("the two payloads hang at different points: what is between is not proven by them")
            if light.mass == heavy.mass:
                raise Malformed("two payloads of one mass are no range of it")
    return loads


def _carried(loads: tuple[Load | None, ...]) -> Carried | None:
    heavy = loads[-1]
    if heavy is None:
        return None
    if len(loads) == 1:
        return Carried(heavy.mass, heavy.link, heavy.com, heavy.inertia)
    light = loads[0]
    lightest = (0.0,) * 6 if light is None else light.inertia
    mass = (0.0 if light is None else light.mass, heavy.mass)
    return Carried(mass, heavy.link, heavy.com, heavy.inertia, lightest)


def _label(
    case: WrittenCase,
    locked: dict[str, float | tuple[float, ...]],
    loads: tuple[Load | None, ...],
    boxes: list[tuple[tuple[float, ...], tuple[float, ...]]],
) -> str:
    parts = [
        f"{printable(name)} locked at {case.locked[name]!r}"
        for name, angles in locked.items()
        if isinstance(angles, tuple)
    ]
    if len(loads) > 1:
        parts.append(f"payload {case.load.mass if case.load is not None else 0.0!r} kg")
    if len(boxes) > 1:
        parts.append(f"box {boxes.index((case.lower, case.upper)) + 1} of {len(boxes)}")
    return ", ".join(parts)
