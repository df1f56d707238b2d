"""The table of named arms that `asmc-pin arms` and README.md show."""

from __future__ import annotations

from collections import Counter

import numpy as np

from asmc_pin.arms.loading import load_arm
from asmc_pin.arms.published_armature import PUBLISHED_ARMATURE
from asmc_pin.arms.registry import ARMS, ArmEntry


def arms_table() -> list[dict[str, str]]:
    """One row per named arm, as it is loaded without options.

    Returns:
        Rows with the keys name, joints, kinds, mass, published rotors, effort limits, origin, licence. The mass is what
        moves; the rotors are what ``armature="published"`` takes, or those that the arm has without being asked.
    """
    rows = []
    for name, entry in ARMS.items():
        arm = load_arm(name)
        kinds = (
            "continuous" if endless else kind for kind, endless in zip(arm.joint_kinds, arm.continuous, strict=True)
        )
        rows.append(
            {
                "name": name,
                "joints": str(arm.nv),
                "kinds": ", ".join(f"{count} {kind}" for kind, count in Counter(kinds).items()),
                "mass": f"{arm.tree.mass.sum():.1f} kg",
                "published rotors": _rotors(name, entry),
                "effort limits": "declared" if np.all(np.isfinite(arm.effort_limit)) else "not declared",
                "origin": entry.origin,
                "licence": entry.licence,
            }
        )
    return rows


def _rotors(name: str, entry: ArmEntry) -> str:
    """What ``armature="published"`` takes."""
    known = PUBLISHED_ARMATURE.get(name)
    if known is not None:
        return "simulated" if known.simulated else "yes"
    return "own" if entry.armature else "no"
