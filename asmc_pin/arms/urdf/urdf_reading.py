"""What a URDF says, as yourdfpy reads it: it keeps the mimic, friction, damping and limit data that Pinocchio drops."""

from __future__ import annotations

import copy
import io
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yourdfpy
from lxml import etree

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.faults import Fault
from asmc_pin.arms.urdf.magnitudes import FRICTION, LIMIT
from asmc_pin.arms.urdf.mjcf_conversion import MjcfModel
from asmc_pin.arms.urdf.repair_record import read_repair
from asmc_pin.arms.urdf.rigid_inertia import LinkInertia
from asmc_pin.arms.urdf.urdf_document import Document
from asmc_pin.arms.urdf.urdf_structure import MOVING, NUMBERS, check_structure, where
from asmc_pin.words.provisos import Proviso

# Pinocchio wants to see a range at every joint; nothing reads this one, `Joint` has the real limits.
_WIDE = "1e6"

# Some files give a joint and a link the same name, which Pinocchio cannot tell apart when it locks a joint.
JOINT_PREFIX = "__joint__:"


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: value = multiplier · master + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """One joint of a URDF that can move; SI units.

    Attributes:
        name: Its name.
        kind: ``revolute`` or ``prismatic``.
        continuous: Whether it turns without end.
        child: Its child link.
        lower: Lower limit, −inf where undeclared.
        upper: Upper limit, +inf where undeclared.
        effort: Torque limit, inf where undeclared.
        velocity: Velocity limit, inf where undeclared.
        friction: Coulomb friction, N·m (N).
        damping: Viscous friction, N·m·s/rad (N·s/m).
        mimic: The joint that it follows.
        where: The joint and its place in the file, for messages.
    """

    name: str
    kind: str
    continuous: bool
    child: str
    lower: float
    upper: float
    effort: float
    velocity: float
    friction: float
    damping: float
    mimic: Mimic | None
    where: str


@dataclass(frozen=True)
class Robot:
    """A checked URDF.

    Attributes:
        path: The file.
        name: What to call it: the file's stem, and of a file that stands for several robots what it came to.
        text: See `Document`.
        sha256: Hex digest of the file's bytes.
        joints: Joints that can move, by name.
        fixed: Names of the joints that cannot.
        links: Names of the links.
        carried: By link, the joint that carries it and the link that this hangs on; the base has none.
        xml: The same robot for Pinocchio: dynamics only, every continuous joint an unbounded revolute one, and
            `JOINT_PREFIX` before every joint's name.
        inertials: Masses and tensors as they are written, by link; links without are left out.
        provisos: See `Document`; and what was repaired of it, as the text itself says.
        faults: What it is to be refused for, although it can be read.
        mjcf: See `Document`.
        densities: See `Document`.
    """

    path: Path
    name: str
    text: str
    sha256: str
    joints: Mapping[str, Joint]
    fixed: tuple[str, ...]
    links: tuple[str, ...]
    carried: Mapping[str, tuple[str, str]]
    xml: str
    inertials: Mapping[str, LinkInertia]
    provisos: tuple[Proviso, ...]
    faults: tuple[Fault, ...]
    mjcf: MjcfModel | None
    densities: Mapping[str, float]


def _stripped(document: Document) -> Any:
    """The tree without what dynamics does not need, so that no reader looks for meshes or trips over extensions."""
    root = etree.Element("robot", name=document.root.get("name") or document.path.stem)
    keep = {"link": {"inertial"}, "joint": {"parent", "child", "origin", "axis", "limit", "dynamics", "mimic"}}
    for element in document.root:
        if element.tag in keep:
            attributes = {key: element.get(key) for key in ("name", "type") if element.get(key) is not None}
            slim = etree.SubElement(root, element.tag, attributes)
            slim.extend(copy.deepcopy(part) for part in element if part.tag in keep[element.tag])
    for inertia in root.iter("inertia"):
        for product in ("ixy", "ixz", "iyz"):
            inertia.set(product, inertia.get(product, "0"))
    for element in root.iter():
        for name in NUMBERS.get(element.tag, ()) if element.tag != "axis" else ():  # a direction has no size
            if element.get(name) is not None:
                element.set(name, " ".join(map(_plainly, element.get(name).split())))
    return root


def _plainly(number: str) -> str:
    """The same double as every reader takes it: Pinocchio's refuses some that Python takes, and those below 1e-307."""
    value = float(number)
    return repr(value) if abs(value) >= sys.float_info.min else "0.0"


def _float(value: object, default: float) -> float:
    # yourdfpy leaves some numbers as text, and absent ones as None.
    return default if value is None else float(str(value))


def _joint(raw: Any, place: str, faults: list[Fault]) -> Joint:
    """A joint as it is written; what it is to be refused for joins `faults`."""
    limit = raw.limit or yourdfpy.Limit()
    dynamics = raw.dynamics or yourdfpy.Dynamics()
    lower, upper = _float(limit.lower, 0.0), _float(limit.upper, 0.0)
    continuous = raw.type == "continuous"
    if continuous or lower == upper == 0.0:
        lower, upper = -np.inf, np.inf
    lower, upper = -np.inf if lower < -LIMIT else lower, np.inf if upper > LIMIT else upper
    if lower > upper:
        told = f"its lower limit {lower:g} is above its upper limit {upper:g}; swap them"
        faults.append(Fault("limits", (raw.name,), f"{place}: {told}"))
    effort, velocity = _float(limit.effort, 0.0), _float(limit.velocity, 0.0)
    friction, damping = _float(dynamics.friction, 0.0), _float(dynamics.damping, 0.0)
    for what, value in (("friction", friction), ("damping", damping)):
        if value < 0.0:
            told = f"its {what} {value:g} is negative, which would drive it; make it ≥ 0"
            faults.append(Fault("friction", (raw.name,), f"{place}: {told}"))
        if value > FRICTION:
            told = f"its {what} is {value:g}, and at most {FRICTION:g} is taken; correct the number"
            faults.append(Fault("friction", (raw.name,), f"{place}: {told}"))
    follows_none = any(fault.kind == "mimic" and fault.about == (raw.name,) for fault in faults)
    mimic = raw.mimic and Mimic(raw.mimic.joint, _float(raw.mimic.multiplier, 1.0), _float(raw.mimic.offset, 0.0))
    return Joint(
        name=raw.name,
        kind="prismatic" if raw.type == "prismatic" else "revolute",
        continuous=continuous,
        child=raw.child,
        lower=lower,
        upper=upper,
        effort=effort if effort > 0.0 else np.inf,
        velocity=velocity if velocity > 0.0 else np.inf,
        friction=friction,
        damping=damping,
        mimic=None if follows_none else mimic,
        where=place,
    )


def _pinocchio_xml(root: Any) -> str:
    """Rewrite the stripped tree so that Pinocchio gives every joint one coordinate, and nothing but inertia."""
    root = copy.deepcopy(root)
    for joint in root.findall("joint"):
        joint.set("name", JOINT_PREFIX + joint.get("name"))
        for tag in ("limit", "dynamics", "mimic"):
            for element in joint.findall(tag):
                joint.remove(element)
        axis = joint.find("axis")
        zero = axis is not None and not any(map(float, axis.get("xyz", "1 0 0").split()))
        if joint.get("type") == "fixed" or zero:
            # Files write "0 0 0" there, which is no direction; of a joint that moves it is a fault.
            if axis is not None:
                joint.remove(axis)
            axis = None
        if joint.get("type") == "fixed":
            continue
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
        if axis is not None:
            direction: Array = np.array([float(x) for x in axis.get("xyz", "1 0 0").split()])
            if not 1e-150 < np.max(np.abs(direction)) < 1e150:  # squares would over- or underflow
                direction /= np.max(np.abs(direction))
            axis.set("xyz", " ".join(repr(float(x)) for x in direction / np.linalg.norm(direction)))
        etree.SubElement(joint, "limit", lower=f"-{_WIDE}", upper=_WIDE, effort=_WIDE, velocity=_WIDE)
    text: str = etree.tostring(root, encoding="unicode")
    return text


def _inertials(document: Document, links: list[Any]) -> dict[str, LinkInertia]:
    elements = {element.get("name"): element for element in document.root.findall("link")}
    found = {}
    for link in links:
        if link.inertial is None:
            continue
        pose = np.eye(4) if link.inertial.origin is None else np.asarray(link.inertial.origin, dtype=np.float64)
        found[link.name] = LinkInertia(
            mass=float(link.inertial.mass),
            com=pose[:3, 3],
            turn=pose[:3, :3],
            written=np.asarray(link.inertial.inertia, dtype=np.float64),
            where=where(document, elements[link.name]),
        )
    return found


def read_robot(document: Document) -> Robot:
    """Check a URDF and read it.

    Args:
        document: The file.

    Returns:
        Its joints and links, and the XML for Pinocchio.

    Raises:
        ArmError: It cannot be told what is in it; the message names the joint or link, the line, and how to correct it.
    """
    faults = list(check_structure(document))
    root = _stripped(document)
    raw = yourdfpy.URDF.load(io.BytesIO(etree.tostring(root)), build_scene_graph=False, load_meshes=False).robot
    elements = {element.get("name"): element for element in document.root.findall("joint")}
    return Robot(
        path=document.path,
        name=root.get("name") if document.expanded else document.path.stem,
        text=document.text,
        sha256=document.sha256,
        joints={j.name: _joint(j, where(document, elements[j.name]), faults) for j in raw.joints if j.type in MOVING},
        fixed=tuple(j.name for j in raw.joints if j.type not in MOVING),
        links=tuple(link.name for link in raw.links),
        carried={joint.child: (joint.name, joint.parent) for joint in raw.joints},
        xml=_pinocchio_xml(root),
        inertials=_inertials(document, raw.links),
        provisos=tuple(dict.fromkeys((*document.provisos, *read_repair(document)))),
        faults=tuple(faults),
        mjcf=document.mjcf,
        densities=document.densities,
    )
