"""Whether what `check` says of a certificate is true of the arm that is inside it, by search."""

from __future__ import annotations

import io
import itertools
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from certificate_cases import climb, norms

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.arms import Arm, Payload
from asmc_pin.errors import AsmcPinError
from asmc_pin.text import printable

STATUS = {"holds": 0, "violated": 1, "undecided": 3}
ROUNDING = 1e-9


def contradictions(status: int, said: dict[str, Any], certificate: Path) -> list[str]:
    """What is false of what is said.

    Args:
        status: Exit status of ``check --json``.
        said: The object that it printed.
        certificate: The file.
    """
    if said.get("valid") is not True:
        return [] if status == 1 else [f"status of an invalid certificate: {status}"]
    if STATUS.get(said["verdict"]) != status:
        return [f"status: {status} with the verdict {said['verdict']}"]
    absent = {"arm", "joints", "mbar", "armature", "payload", "locked", "box", "condition"} - set(said)
    if absent:
        return [f"hypotheses are not said: {', '.join(sorted(absent))}"]
    if said.get("scope", "box") != "box":
        return []  # the box that is said is the hull of the tube's, and says less
    try:
        arms = variants(said, urdf_of(certificate), certificate.parent)
    except AsmcPinError as error:
        return [f"an arm that cannot be loaded: {error}"]
    return _false(said, arms)


def _false(said: dict[str, Any], arms: list[Arm]) -> list[str]:
    mbar, norm = np.array(said["mbar"], dtype=np.float64), norms(said["condition"])
    if not np.all(np.isfinite(mbar)) or np.any(mbar <= 0.0):
        return [f"M̄: {said['mbar']}"]

    def worst(scale: float) -> float:
        """Largest norm of scale · M̄ that a search finds."""
        found = 0.0
        for arm in arms:
            ends = [said["box"][printable(joint)] for joint in arm.joint_names]
            lower, upper = np.array(ends, dtype=np.float64).T

            def figure(mass: Array) -> Array:
                return norm(mass, scale * mbar)

            found = max(found, climb(arm.tree, lower, upper, figure, 0))
        return found

    false = []
    for arm in arms:
        if [printable(joint) for joint in arm.joint_names] != said["joints"] or len(mbar) != arm.nv:
            return [f"joints: {said['joints']} of an arm with {arm.joint_names}"]
    at_one = worst(1.0)
    if said["verdict"] == "holds" and at_one >= 1.0:
        false.append(f"holds: the norm is {at_one}")
    if said["verdict"] == "violated" and at_one < 1.0 - 1e-3:
        false.append(f"violated: no norm above {at_one} is found")
    if said.get("upper") is not None and at_one > said["upper"] * (1.0 + ROUNDING):
        false.append(f"upper: {said['upper']}, and the norm is {at_one}")
    if said.get("lower") is not None and at_one < said["lower"] * (1.0 - 1e-3):
        false.append(f"lower: {said['lower']}, and no norm above {at_one} is found")
    proven = said.get("scale_proven") or 0.0
    if proven > 0.0 and (at_scale := worst(proven)) >= 1.0 + ROUNDING:
        false.append(f"scale_proven: {proven}, and the norm is {at_scale}")
    refuted = said.get("scale_refuted")
    if refuted is not None and (at_scale := worst(refuted)) < 1.0 - 1e-3:
        false.append(f"scale_refuted: {refuted}, and no norm above {at_scale} is found")
    return false


def urdf_of(certificate: Path) -> str:
    """The URDF inside, read without this package."""
    with zipfile.ZipFile(certificate) as archive:
        content: Array = np.lib.format.read_array(io.BytesIO(archive.read("urdf.npy")), allow_pickle=False)
    return content.tobytes().decode()


def variants(said: dict[str, Any], urdf: str, folder: Path) -> list[Arm]:
    """The arms at the ends of all that is said to range: payload, armature, locked joints."""
    (folder / "inside.urdf").write_text(urdf, encoding="utf-8", newline="")
    locks = {name: value if isinstance(value, list) else [value] for name, value in said["locked"].items()}
    armatures = [value if isinstance(value, list) else [value] for value in said["armature"]]
    corners = [tuple(ends[0] for ends in armatures), tuple(ends[-1] for ends in armatures)]
    return [
        load_arm(folder / "inside.urdf", payload=payload, armature=list(armature), lock=dict(lock) or None)
        for payload in _payloads(said["payload"])
        for armature in dict.fromkeys(corners)
        for lock in itertools.islice(itertools.product(*[[(n, a) for a in angles] for n, angles in locks.items()]), 8)
    ]


def _payloads(said: dict[str, Any] | None) -> list[Payload | None]:
    if said is None:
        return [None]
    masses = said["mass"] if isinstance(said["mass"], list) else [said["mass"]]
    heaviest = said.get("inertia", [0.0] * 6)
    inertias = [said.get("inertia_lightest", heaviest), heaviest][-len(masses) :]
    return [
        Payload(mass, com=tuple(said["com"]), inertia=tuple(inertia), link=said["link"])
        for mass, inertia in zip(masses, inertias, strict=True)
    ]


def judge(certificate: Path, status: int, out: str) -> list[str]:
    """`contradictions` of what was printed, where it was an object at all."""
    if status not in (0, 1, 3):
        return []
    try:
        said = json.loads(out)
    except ValueError:
        return []
    return contradictions(status, said, certificate) if isinstance(said, dict) else []
