"""What `inspect` gives: what was read, joint by joint, and all doubts at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Payload
from asmc_pin.arms.urdf.urdf_reading import Mimic
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ArmError
from asmc_pin.inspection.inspected_joint import InspectedJoint
from asmc_pin.inspection.subject_of_doubt import Doubt
from asmc_pin.words.provisos import Proviso, provisos_json
from asmc_pin.words.shown import UNDEFINED, Cells, Shown
from asmc_pin.words.text import printable, quoted


@dataclass(frozen=True, eq=False, repr=False)
class Inspection(Shown):
    """What was read of a URDF, and what is doubtful.

    Attributes:
        name: The arm's name, or the file's stem.
        source: The file.
        sha256: Hash of the URDF.
        joints: What moves, base first.
        standing: Links that stand still with the base.
        locked: Joints that were locked, and where, rad (m).
        payload: What it carries besides; None for nothing, and where it is refused.
        refusal: Why other commands refuse it; empty where they take it.
        doubts: All that looks unmeant, the serious ones first.
        notes: What was taken otherwise than written.
        provisos: In what it is not as its file says.
        page: The 3-D page; empty where the arm is refused.
    """

    name: str
    source: Path
    sha256: str
    joints: Sequence[InspectedJoint]
    standing: tuple[str, ...]
    locked: dict[str, float]
    payload: Payload | None
    refusal: str
    doubts: tuple[Doubt, ...]
    notes: tuple[str, ...]
    provisos: tuple[Proviso, ...]
    page: Any

    def lines(self) -> list[str]:
        """What it is, and whether other commands take it."""
        count = sum(joint.follows is None for joint in self.joints)
        mass = sum(joint.mass for joint in self.joints)
        said = [
            f"{quoted(self.name)}: {count} moving joint{'s' if count != 1 else ''}, {mass:.4g} kg move "
            f"(URDF {self.sha256[:16]}…)"
        ]
        if self.locked:
            said.append("locked: " + ", ".join(f"{quoted(name)} at {angle:g}" for name, angle in self.locked.items()))
        if self.payload is not None:
            load = self.payload
            place = ", ".join(f"{x:g}" for x in load.com)
            said.append(f"carries {load.mass:g} kg at ({place}) m on {quoted(str(load.link))}, not counted below")
        said += [f"{proviso.kind}: {proviso.text}" for proviso in self.provisos]
        if self.refusal:
            said += [f"REFUSED by other commands: {line}" if not k else line for k, line in enumerate(self._why())]
        return said

    def table(self) -> Cells:
        """The joints: where they hang, their axes and limits, what they lose."""
        rows = []
        for joint in self.joints:
            lower, upper, effort, velocity = (_limit(value) for value in joint.limits)
            span = f"{lower} … {upper}" if joint.kind != "continuous" else "endless"
            losses = [f"{value:.3g}" for value in (*joint.losses, joint.armature)]
            rows.append(
                [
                    printable(joint.name),
                    printable(joint.hangs_on) or "base",
                    joint.kind if joint.follows is None else f"follows {_followed(joint.follows)}",
                    _axis(joint.axis),
                    span,
                    effort,
                    velocity,
                    *losses,
                ]
            )
        figures = ["axis at q = 0", "range", "torque", "speed", "friction", "damping", "armature"]
        return ["joint (SI units)", "hangs on", "kind", *figures], rows

    def bodies(self) -> Cells:
        """The bodies: masses, centres, radii of gyration, links."""
        rows = [
            [
                printable(joint.name),
                f"{joint.mass:.4g}",
                "  ".join(f"{x:.3f}" for x in joint.com) if joint.mass > 0.0 else UNDEFINED,
                "  ".join(f"{x:.3f}" for x in joint.radii),
                ", ".join(map(quoted, joint.links[:4])) + (" …" if len(joint.links) > 4 else ""),
            ]
            for joint in self.joints
        ]
        return ["moves with", "mass kg", "centre m, joint's frame", "radii of gyration m", "links"], rows

    def tables(self) -> list[Cells]:
        """The joints, and the bodies that they move."""
        return [self.table(), self.bodies()]

    def remarks(self) -> list[str]:
        """What does not move, then the doubts and the notes."""
        said: list[str] = []
        if self.standing:
            more = f" and {len(self.standing) - 6} more" if len(self.standing) > 6 else ""
            said.append("stands still: " + ", ".join(map(quoted, self.standing[:6])) + more)
        said += ["", *([] if self.doubts else ["no doubts"])]
        said += [f"{'doubt' if doubt.serious else 'remark'}: {doubt.text}" for doubt in self.doubts]
        return said + [f"note: {note}" for note in self.notes]

    def to_json_dict(self) -> dict[str, Any]:
        """All of it, ready for JSON."""
        doubts = [
            {"kind": d.kind, "about": [printable(name) for name in d.about], "text": d.text, "serious": d.serious}
            for d in self.doubts
        ]
        return {
            "arm": printable(self.name),
            "sha256": self.sha256,
            "joints": [joint.to_json_dict() for joint in self.joints],
            "standing": [printable(link) for link in self.standing],
            "locked": {printable(name): value for name, value in self.locked.items()},
            "payload": None if self.payload is None else _payload_json(self.payload),
            "refused": self.refusal or None,
            "doubts": doubts,
            "notes": list(self.notes),
            "provisos": provisos_json(self.provisos),
        }

    def write_page(self, path: str | Path) -> None:
        """Write the 3-D page: inertia ellipsoids, centres of mass and axes in what is drawn of the arm.

        Args:
            path: The file.

        Raises:
            ArmError: The arm is refused, so there is nothing to draw.
            ResultError: It cannot be written.
        """
        if self.page is None:
            raise ArmError(self.source, f"{self.source}: is refused, so it cannot be drawn: {self.refusal}")
        write_whole(path, self.page())

    def _why(self) -> list[str]:
        return self.refusal.split("\n")


def _payload_json(load: Payload) -> dict[str, Any]:
    """A payload as other commands' JSON has it: ``mass``, ``link``, ``com``, and its inertia."""
    return {
        "mass": load.mass,
        "link": printable(str(load.link)),
        "com": list(load.com),
        "inertia": list(load.inertia),
    }


def _followed(mimic: Mimic) -> str:
    """How a joint follows another: ``-1 · 'master' + 0.2``."""
    offset = f" {'+' if mimic.offset > 0.0 else '-'} {abs(mimic.offset):.6g}" if mimic.offset else ""
    return f"{mimic.multiplier:.6g} · {printable(mimic.joint)}{offset}"


def _limit(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "?"


def _axis(axis: Array) -> str:
    if not np.any(axis):
        return UNDEFINED
    for name, unit in zip("xyz", np.eye(3), strict=True):
        for sign in (1.0, -1.0):
            if np.allclose(axis, sign * unit, atol=1e-4):
                return f"{'+' if sign > 0 else '-'}{name}"
    return " ".join(f"{x:.3f}" for x in axis)
