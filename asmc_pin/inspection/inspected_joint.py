"""One moving joint of a URDF as `inspect` shows it, with the body that it carries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.urdf_reading import Mimic
from asmc_pin.words.text import printable


@dataclass(frozen=True, eq=False)
class InspectedJoint:
    """One moving joint, and the body that it carries up to the next ones; SI units, limits infinite where undeclared.

    Attributes:
        name: Its name.
        hangs_on: The moving joint that it hangs on; empty for the base.
        kind: ``revolute``, ``continuous`` or ``prismatic``.
        follows: The driven joint that it mimics, and how; None where it has a coordinate of its own.
        axis: In the base frame with all joints at zero, shape (3,); zero where the URDF's is.
        place: Of its frame in the base frame there, shape (3,), m.
        limits: Lower and upper limit, effort and velocity.
        losses: Friction and damping.
        armature: Reflected rotor inertia, kg·m² (kg).
        links: The links of the body, the joint's child first.
        mass: Of the body, kg.
        com: Its centre of mass in the joint's frame, shape (3,), m; NaN where its mass is not above 0.
        inertia: About that centre in the joint's axes, shape (3, 3), kg·m².
        radii: Its radii of gyration, ascending, shape (3,), m.
    """

    name: str
    hangs_on: str
    kind: str
    follows: Mimic | None
    axis: Array
    place: Array
    limits: tuple[float, float, float, float]
    losses: tuple[float, float]
    armature: float
    links: tuple[str, ...]
    mass: float
    com: Array
    inertia: Array
    radii: Array

    def to_json_dict(self) -> dict[str, Any]:
        """All of it; undeclared limits are null."""
        keys = ("lower", "upper", "effort", "velocity")
        limits = {key: value if np.isfinite(value) else None for key, value in zip(keys, self.limits, strict=True)}
        body = {
            "links": [printable(link) for link in self.links],
            "mass": self.mass,
            "com": self.com.tolist() if self.mass > 0.0 else None,
            "inertia": self.inertia[np.triu_indices(3)].tolist(),
            "radii_of_gyration": self.radii.tolist(),
        }
        return {
            "joint": printable(self.name),
            "hangs_on": printable(self.hangs_on) or None,
            "kind": self.kind,
            "follows": None if self.follows is None else printable(self.follows.joint),
            "multiplier": None if self.follows is None else self.follows.multiplier,
            "offset": None if self.follows is None else self.follows.offset,
            "axis": self.axis.tolist(),
            "place": self.place.tolist(),
            **limits,
            "friction": self.losses[0],
            "damping": self.losses[1],
            "armature": self.armature,
            "body": body,
        }
