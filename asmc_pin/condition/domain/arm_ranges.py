"""The arms that one statement speaks of: payload and armature ranges, choices of locked joints.

M is affine in the mass of a payload (fixed centre and shape) and in the armature, and both conditions are linear matrix
inequalities in M: they hold between two ends where they hold at both. So a range costs its ends and nothing more; one
of a payload's place costs more, and is not covered (`payload_ranges`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike, asked_box, resolve_box
from asmc_pin.condition.domain.payload_ranges import PayloadRange as PayloadRange
from asmc_pin.condition.domain.payload_ranges import carrying
from asmc_pin.condition.search.samples import Domain
from asmc_pin.errors import ParameterError
from asmc_pin.words.given import check_arm
from asmc_pin.words.text import printable

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

ArmatureRange: TypeAlias = (
    "float | tuple[float, float] | Sequence[float | tuple[float, float]] | Array | Mapping[str, Any] | None"
)
"""kg·m²: one value, a tuple (lo, hi), or one of these per joint (list, or joint to value); None keeps the arm's own."""

LockChoices: TypeAlias = "Mapping[str, float | Sequence[float]] | None"
"""Joint to angle, or to several angles of which each is a case of its own."""


@dataclass(frozen=True, eq=False)
class Case:
    """One arm out of a range, with what makes it this one.

    Attributes:
        domain: The arm, its joint box and its armature range.
        label: What is particular about it, in words; empty where nothing is.
    """

    domain: Domain
    label: str


def cases(
    arm: Arm,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
) -> list[Case]:
    """All arms whose satisfaction of a condition is its satisfaction over the ranges.

    Args:
        arm: The arm.
        box: Joint box; see `BoxLike`.
        payload: See `PayloadRange`; None keeps the arm's own.
        armature: See `ArmatureRange`.
        lock: See `LockChoices`.

    Returns:
        One case per payload that is looked at (`payload_ranges`) and lock choice.

    Raises:
        ParameterError: No arm, a malformed or empty range, or an unknown joint.
    """
    check_arm(arm)
    if lock is not None and not isinstance(lock, Mapping):
        raise ParameterError("lock", f"{lock!r} given, joint to one or more angles expected, as a dictionary")
    found = []
    for held, lock_label in _locked(arm, lock):
        for laden, load_label in carrying(held, payload):
            lower, upper = armature_range(laden, armature)
            domain = Domain(laden, resolve_box(laden, asked_box(laden, box)), lower, upper)
            found.append(Case(domain, ", ".join(filter(None, (lock_label, load_label)))))
    return found


def _locked(arm: Arm, lock: LockChoices) -> list[tuple[Arm, str]]:
    if not lock:
        return [(arm, "")]
    choices = []
    for joint, angles in lock.items():
        try:
            values = [float(a) for a in np.atleast_1d(np.asarray(angles, dtype=np.float64))]
        except (TypeError, ValueError):
            raise ParameterError("lock", f"{angles!r} given for joint '{joint}', one or more angles expected") from None
        if not values:
            raise ParameterError("lock", f"no angle given for joint '{joint}'")
        choices.append([(joint, value) for value in dict.fromkeys(values)])
    several = any(len(choice) > 1 for choice in choices)
    found = []
    # As it was asked for, and not as it came out: what mimics a locked joint has to follow each choice.
    asked = arm.made_of.variant.lock or {}
    for chosen in product(*choices):
        label = ", ".join(f"{printable(joint)} locked at {value:g}" for joint, value in chosen) if several else ""
        found.append((arm.replace(lock={**asked, **dict(chosen)}), label))
    return found


def armature_range(arm: Arm, armature: ArmatureRange) -> tuple[Array, Array]:
    """Ends of the armature's range of an arm, each of shape (nv,), kg·m²."""
    if armature is None:
        return arm.armature, arm.armature
    if isinstance(armature, str):
        raise ParameterError("armature", f"{armature!r}: give it to load_arm, as load_arm(…, armature={armature!r})")
    items: list[Any]
    if isinstance(armature, Mapping):
        unknown = [joint for joint in armature if joint not in arm.joint_names]
        if unknown:
            raise ParameterError(
                "armature", f"'{unknown[0]}' is not a moving joint; these are: {', '.join(arm.joint_names)}"
            )
        items = [armature.get(joint, own) for joint, own in zip(arm.joint_names, arm.armature.tolist(), strict=True)]
    elif isinstance(armature, tuple) and len(armature) == 2:
        items = [armature] * arm.nv
    else:
        given: Any = armature
        items = list(given) if hasattr(given, "__len__") else [given]
        items = items * arm.nv if len(items) == 1 else items
    if len(items) != arm.nv:
        raise ParameterError(
            "armature", f"{len(items)} values given, 1 or {arm.nv} expected ({', '.join(arm.joint_names)})"
        )
    lower, upper = np.empty(arm.nv), np.empty(arm.nv)
    for i, item in enumerate(items):
        try:
            lower[i], upper[i] = item if isinstance(item, tuple) else (item, item)
        except (TypeError, ValueError):
            raise ParameterError("armature", f"{item!r} given, a number or a range (lo, hi) expected, kg·m²") from None
        if not (0.0 <= lower[i] <= upper[i] < np.inf):
            text = f"{lower[i]:g}" if lower[i] == upper[i] else f"the range {lower[i]:g}:{upper[i]:g}"
            raise ParameterError(
                "armature", f"{text} for joint '{arm.joint_names[i]}': finite, 0 or more, lower end first"
            )
    return lower, upper
