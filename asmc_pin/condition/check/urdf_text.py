"""A URDF's text as the checker reads it: names, and numbers still as the decimals that they are written as.

Written a second time on purpose, without Pinocchio and without the loader: a checker that reads the arm as the prover
did repeats its mistakes. Both of the checker's own arithmetics begin here.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asmc_pin.text import printable

Decimals = tuple[str, ...]

_DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?")
_LONGEST = 400

MOVING = ("revolute", "continuous", "prismatic")


class Unreadable(ValueError):
    """The text does not describe the arm that the certificate speaks of; the message says why."""


@dataclass(frozen=True)
class Pose:
    """``<origin>``: translation, m, and roll, pitch, yaw, rad."""

    xyz: Decimals = ("0", "0", "0")
    rpy: Decimals = ("0", "0", "0")


@dataclass(frozen=True)
class Body:
    """``<inertial>`` of a link: kg, and ixx, ixy, ixz, iyy, iyz, izz about the centre in the pose's axes, kg·m²."""

    mass: str
    inertia: Decimals
    pose: Pose


@dataclass(frozen=True)
class Joint:
    """A joint of the text, the fixed ones included."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Pose
    axis: Decimals
    mimics: bool


@dataclass(frozen=True, eq=False)
class Description:
    """A robot.

    Attributes:
        name: As the text gives it.
        root: The link that nothing carries.
        bodies: Inertia by link; None for a link without one.
        children: The joints on each link.
    """

    name: str
    root: str
    bodies: Mapping[str, Body | None]
    children: Mapping[str, Sequence[Joint]]


def description(text: str) -> Description:
    """Read a URDF.

    Raises:
        Unreadable: It is not well-formed, not a tree of links, or has numbers that are none.
    """
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise Unreadable("the URDF declares entities or a document type, which are not read here")
    try:
        root = ET.fromstring(text)
    except (ET.ParseError, LookupError, ValueError) as error:
        raise Unreadable(f"the URDF is not well-formed XML: {printable(str(error))}") from None
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    bodies: dict[str, Body | None] = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        if name in bodies:
            raise Unreadable(f"the URDF has two links '{printable(name)}'")
        bodies[name] = _body(link)
    children: dict[str, list[Joint]] = {}
    carried: set[str] = set()
    names: set[str] = set()
    for element in root.findall("joint"):
        joint = _joint(element)
        if joint.name in names:
            raise Unreadable(f"the URDF has two joints '{printable(joint.name)}'")
        # Two joints to one link would make it a graph, with more ways through it than there are links.
        if joint.child in carried or joint.child not in bodies or joint.parent not in bodies:
            raise Unreadable(f"joint '{printable(joint.name)}' of the URDF does not join two links of a tree")
        names.add(joint.name)
        carried.add(joint.child)
        children.setdefault(joint.parent, []).append(joint)
    roots = [name for name in bodies if name not in carried]
    if len(roots) != 1:
        raise Unreadable(f"the URDF has {len(roots)} links that nothing carries, one expected")
    return Description(root.get("name", ""), roots[0], bodies, children)


def _joint(element: ET.Element) -> Joint:
    name, kind = element.get("name", ""), element.get("type", "")
    if kind != "fixed" and kind not in MOVING:
        raise Unreadable(
            f"joint '{printable(name)}' of the URDF is of type '{printable(kind)}', which is not read here"
        )
    parent, child = (_part(element, tag, name).get("link", "") for tag in ("parent", "child"))
    axis = _decimals(None if (found := _only(element, "axis")) is None else found.get("xyz"), ("1", "0", "0"))
    if kind != "fixed" and all(float(x) == 0.0 for x in axis):
        raise Unreadable(f"joint '{printable(name)}' of the URDF has no axis")
    return Joint(name, kind, parent, child, pose=_pose(element), axis=axis, mimics=element.find("mimic") is not None)


def _body(link: ET.Element) -> Body | None:
    inertial = _only(link, "inertial")
    if inertial is None:
        return None
    mass, tensor = _only(inertial, "mass"), _only(inertial, "inertia")
    (value,) = _decimals(None if mass is None else mass.get("value", "0"), ("0",))
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    entries = [_decimals("0" if tensor is None else tensor.get(key, "0"), ("0",))[0] for key in keys]
    return Body(value, tuple(entries), _pose(inertial))


def _pose(element: ET.Element) -> Pose:
    origin = _only(element, "origin")
    nothing = Pose()
    if origin is None:
        return nothing
    return Pose(_decimals(origin.get("xyz"), nothing.xyz), _decimals(origin.get("rpy"), nothing.rpy))


def _only(element: ET.Element, tag: str) -> ET.Element | None:
    """The one child of that name: of two, another reader may take the other."""
    found = element.findall(tag)
    if len(found) > 1:
        raise Unreadable(f"'{printable(element.get('name', ''))}' of the URDF has two <{tag}>")
    return found[0] if found else None


def _part(element: ET.Element, tag: str, name: str) -> ET.Element:
    found = _only(element, tag)
    if found is None:
        raise Unreadable(f"joint '{printable(name)}' of the URDF has no <{tag}>")
    return found


def _decimals(text: str | None, default: Decimals) -> Decimals:
    parts = default if text is None else tuple(text.split())
    if len(parts) != len(default):
        raise Unreadable(f"'{printable(text or '')}' in the URDF is not a row of {len(default)} numbers")
    for part in parts:
        # Shorter than a float's largest: a decimal is read exactly, and 1e999 would be no float.
        if len(part) > _LONGEST or not _DECIMAL.fullmatch(part) or abs(float(part)) > 1e30:
            raise Unreadable(f"'{printable(part)}' in the URDF is not a number of use")
    return parts
