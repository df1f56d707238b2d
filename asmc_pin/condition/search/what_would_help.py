"""Why an M̄ breaks a condition, and by how much: the joint to blame, and the multiple of M̄ that would hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import NORM, SCALE
from asmc_pin.condition.search.worst_case import maximise
from asmc_pin.condition.search.worst_of_arm import breaking_factor
from asmc_pin.words.text import printable, rounded_down

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case

Side = Literal["small", "large"]

_SAMPLES, _STARTS = 4096, 16
"""Of the search for the multiple: a hint, which `verify` then checks with all its samples."""


def joint_to_blame(condition: Condition, mass: Array, mbar: Array) -> tuple[int, Side]:
    """Whose m̄ moves the norm at M(q) most if it alone is changed by a share of itself, and whether it is too large.

    With A = M⁻¹M̄, σ = uᵀ(I − A)v gives ∂σ/∂ln m̄ᵢ = −(M⁻¹u)ᵢ m̄ᵢ vᵢ, and λ(A), of which z = M⁻¹M̄^½w, gives m̄ᵢ zᵢ²
    as ∂λ/∂ln m̄ᵢ, with ‖w‖ = 1.

    Args:
        condition: ``lemma1`` or ``weighted``.
        mass: M(q), shape (nv, nv).
        mbar: Diagonal of M̄, shape (nv,).

    Returns:
        Index of the joint, and the side.
    """
    left, right = np.empty(len(mbar)), np.empty(len(mbar))
    _, factor = compiled_norms.extreme(NORM[condition], mass, mbar, left, right)
    # `extreme` gives M⁻¹u and M⁻¹M̄v, and of the weighted norm z twice, with −1 where λ > 1.
    slope = -left * (mass @ right) if condition == "lemma1" else -factor * mbar * left * right
    joint = int(np.argmax(np.abs(slope)))
    return joint, "large" if slope[joint] > 0.0 else "small"


@dataclass(frozen=True)
class WhatWouldHelp:
    """Of a violated condition.

    Attributes:
        joint: Name of the joint whose m̄ is to blame at the worst configuration.
        side: What it is there.
        scale: A short search of the box refutes no multiple of M̄ below it; 0 where it refutes all. None: not asked.
    """

    joint: str
    side: Side
    scale: float | None

    def lines(self) -> list[str]:
        """The same for a person."""
        blamed = f"to blame at the worst q: m̄ of joint '{printable(self.joint)}' is too {self.side} there"
        if self.scale is None:
            return [blamed]
        if self.scale <= 0.0:
            return [blamed, "no multiple of this M̄ satisfies the condition: its joints do not suit each other"]
        return [blamed, f"a short search refutes no multiple of this M̄ below {rounded_down(self.scale)}"]


def what_would_help(
    all_cases: Sequence[Case],
    condition: Condition,
    mbar: Array,
    worst: Case,
    q: Array,
    armature: Array,
    *,
    over_box: bool,
    seed: int,
) -> WhatWouldHelp:
    """Explain a violation.

    Args:
        all_cases: The arms that the condition was asked of.
        condition: ``lemma1`` or ``weighted``.
        mbar: Diagonal of M̄, shape (nv,).
        worst: The arm with the largest norm.
        q: Where, shape (nv,).
        armature: Its armature there, shape (nv,).
        over_box: Whether it was asked over the joint box, which then is searched for the multiple too.
        seed: Of that search.
    """
    arm = worst.domain.arm
    mass = arm.mass_matrix(q) + np.diag(armature - arm.armature)
    joint, side = joint_to_blame(condition, mass, mbar)
    scale = None
    if over_box:
        kind = SCALE[condition]
        found = [
            maximise(kind, case.domain, mbar, samples=_SAMPLES, starts=_STARTS, seed=seed).value for case in all_cases
        ]
        scale = breaking_factor(kind, max(found))
    return WhatWouldHelp(arm.joint_names[joint], side, scale)
