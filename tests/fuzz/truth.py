"""Whether what `check --json` says of a certificate fits its status, and is true of the arm that is inside."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from certificate_cases import climb, norms
from certificate_truth import LARGEST, arms_of, untruths

from asmc_pin._typing import Array
from asmc_pin.errors import ArmError

STATUS = {"holds": 0, "violated": 1, "undecided": 3}
CLOSE = 1.0 - 1e-3
"""How near to a counter-example that is said to exist a search has to come."""


def judge(certificate: Path, status: int, out: str) -> list[str]:
    """What is false of what was printed.

    Args:
        certificate: The file.
        status: Exit status.
        out: Standard output.
    """
    if status not in (0, 1, 3):
        return []
    said = json.loads(out)
    if said["valid"] is not True:
        good = status == 1 and said["problems"] and said["verdict"] is None
        return [] if good else [f"an invalid certificate: status {status}, verdict {said['verdict']}"]
    if STATUS[said["verdict"]] != status:
        return [f"status: {status} with the verdict {said['verdict']}"]
    folder = certificate.parent
    try:
        return [f"untrue: {line}" for line in [*untruths(certificate, said, folder), *_unfounded(said, folder)]]
    except ArmError as error:
        return [f"valid, of an arm that is refused everywhere else: {error}"]


def _unfounded(said: dict[str, Any], folder: Path) -> list[str]:
    """What is said to be broken, and by no configuration that a search finds."""
    ends = [end for value in said["armature"] for end in (value if isinstance(value, list) else [value])]
    if max(ends) > LARGEST:
        return []
    mbar, norm = np.array(said["mbar"]), norms(said["condition"])
    boxes = said.get("boxes") or [said["box"]]

    def worst(scale: float) -> float:
        def figure(mass: Array) -> Array:
            return norm(mass, scale * mbar)

        found = 0.0
        for arm in arms_of(folder / "inside.urdf", said):
            for box in boxes[:4]:
                lower, upper = np.array([box[name] for name in said["joints"]]).T
                found = max(found, climb(arm.tree, lower, upper, figure, 0))
        return found

    found = []
    if len(boxes) <= 4:
        if (highest := worst(1.0)) < said["lower"] * CLOSE:
            found.append(f"the norm is said to reach {said['lower']}, and no more than {highest} is found")
        refuted = said["scale_refuted"]
        if refuted and (highest := worst(refuted)) < CLOSE:
            found.append(f"M̄ × {refuted} is said to break the condition, and no norm above {highest} is found")
    return found
