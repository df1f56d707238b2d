"""The hypotheses of a statement, read off the arms that it speaks of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.hypotheses import (
    Carried,
    Condition,
    Hypotheses,
    Premises,
    Where,
    fold_locks,
)

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.arms.payload import Payload
    from asmc_pin.condition.domain.arm_ranges import Case
    from asmc_pin.condition.domain.joint_box import Box


def premises_of(
    arms: Sequence[Arm],
    boxes: Sequence[tuple[Array, Array]],
    armature: tuple[Array, Array],
    where: Where = "box",
) -> Premises:
    """What is supposed about an arm.

    Args:
        arms: The arms of all cases; they differ in their payload and in the angles of their locked joints.
        boxes: Lower and upper ends, each (nv,), of a joint box, of a motion's range, or of each slice of a tube.
        armature: Its ends, each (nv,), in place of the arms' own.
        where: What the boxes are.

    Returns:
        The subject.
    """
    first = arms[0]
    distinct = tuple(dict.fromkeys((tuple(lo.tolist()), tuple(hi.tolist())) for lo, hi in boxes))
    locked, together = fold_locks([arm.locked for arm in arms])
    lower, upper = (end(axis=0) for end in (np.array([b[0] for b in boxes]).min, np.array([b[1] for b in boxes]).max))
    return Premises(
        arm=first.name,
        sha256=first.sha256,
        joints=first.joint_names,
        slides=tuple(kind == "prismatic" for kind in first.joint_kinds),
        armature=tuple(lo if lo == hi else (lo, hi) for lo, hi in zip(*(a.tolist() for a in armature), strict=True)),
        payload=_carried([arm.payload for arm in arms]),
        locked=locked,
        together=together,
        box=dict(zip(first.joint_names, zip(lower.tolist(), upper.tolist(), strict=True), strict=True)),
        where=where,
        parts=len(distinct),
        boxes=distinct if len(distinct) > 1 else (),
        provisos=first.provisos,
        mimics={name: (m.joint, m.multiplier, m.offset) for name, m in first.mimics.items()},
        elsewhere=tuple(name for name, same in zip(first.joint_names, first.returns, strict=True) if not same)
        if first.mimics
        else (),
    )


def premises_along(arm: Arm, q: Array) -> Premises:
    """What is supposed about one arm along a motion through the configurations q, shape (T, nv)."""
    return premises_of([arm], [(q.min(axis=0), q.max(axis=0))], (arm.armature, arm.armature), "motion")


def hypotheses_of(
    cases: Sequence[Case],
    mbar: Array | None,
    condition: Condition,
    *,
    where: Where = "box",
    boxes: Sequence[tuple[Array, Array]] | None = None,
    level: float = 1.0,
) -> Hypotheses:
    """All that a statement on M̄ rests on.

    Args:
        cases: The arms that it speaks of.
        mbar: Shape (nv,), kg·m²; None where one was looked for in vain.
        condition: ``lemma1`` or ``weighted``.
        where: Over what.
        boxes: See `premises_of`; the joint box of the cases when omitted.
        level: γ of the condition.

    Returns:
        The hypotheses.
    """
    domain = cases[0].domain
    return hypotheses_on(
        premises_of(
            [case.domain.arm for case in cases],
            [ends_of(domain.box)] if boxes is None else boxes,
            (domain.armature_lower, domain.armature_upper),
            where,
        ),
        mbar,
        condition,
        level,
    )


def hypotheses_on(premises: Premises, mbar: Array | None, condition: Condition, level: float = 1.0) -> Hypotheses:
    """The hypotheses of a condition on a subject; see `hypotheses_of`."""
    about: dict[str, Any] = {name: getattr(premises, name) for name in Premises.__dataclass_fields__}
    values = () if mbar is None else tuple(np.asarray(mbar).tolist())
    return Hypotheses(**about, condition=condition, level=level, mbar=values)


def ends_of(box: Box) -> tuple[Array, Array]:
    """Lower and upper ends of a box."""
    return box.lower, box.upper


def worst_keys(about: Premises, arm: Arm, armature: Array) -> dict[str, Any]:
    """Keys of ``verify --json`` that say which arm of the ranges `worst_q` is a configuration of.

    Args:
        about: What is supposed.
        arm: That arm.
        armature: Its armature, shape (nv,), kg·m².

    Returns:
        ``worst_payload`` and ``worst_armature``, and ``worst_locked`` where locked joints had a choice.
    """
    payload = None
    if about.payload is not None:
        # The light end of a range may be no payload at all: one without mass, at the same place.
        none = Carried(0.0, about.payload.link, about.payload.com, (0.0,) * 6)
        payload = (none if arm.payload is None else _one(arm.payload)).to_json_dict()
    content: dict[str, Any] = {"worst_payload": payload, "worst_armature": armature.tolist()}
    if any(isinstance(angles, tuple) for angles in about.locked.values()):
        content["worst_locked"] = dict(arm.locked)
    return content


def _carried(payloads: Sequence[Payload | None]) -> Carried | None:
    """The payloads of all cases: none, one, or those of a range, the first the lightest and the last the heaviest."""
    ends = list(dict.fromkeys(payloads))
    heaviest = ends[-1]
    if heaviest is None or (len(ends) == 1 and heaviest.mass == 0.0):
        return None
    if len(ends) == 1:
        return _one(heaviest)
    lightest = ends[0]
    least = 0.0 if lightest is None else lightest.mass
    places = [load.com for load in ends if load is not None and load.mass > 0.0]
    axes = [(min(axis), max(axis)) for axis in zip(*places, strict=True)]
    return Carried(
        mass=(least, heaviest.mass) if least < heaviest.mass else heaviest.mass,
        link=str(heaviest.link),
        com=tuple(lo if lo == hi else (lo, hi) for lo, hi in axes) or heaviest.com,
        inertia=heaviest.inertia,
        inertia_lightest=((0.0,) * 6 if lightest is None else lightest.inertia) if least < heaviest.mass else None,
    )


def _one(load: Payload) -> Carried:
    return Carried(load.mass, str(load.link), load.com, load.inertia)
