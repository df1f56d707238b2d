"""A URDF's text as the checker reads it: names, and numbers still as the decimals that they are written as.

Written a second time on purpose, without Pinocchio and without the loader: a checker that reads the arm as the prover
did repeats its mistakes. What readers of URDF take differently, or take silently for something else, is refused here:
a text has to mean one arm. Both of the checker's own arithmetics begin here.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from xml.parsers import expat

from asmc_pin.words.text import as_number, printable

Decimals = tuple[str, ...]

_DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,3})?")
_LONGEST = 400
_LEAST, _MOST = 1e-60, 1e9
"""Sizes of a number that is not zero: beyond them floats are no longer what the text says."""

MOST_LINKS = 2000

MOVING = ("revolute", "continuous", "prismatic")
_UNUSED = {"limit": ("lower", "upper", "effort", "velocity"), "dynamics": ("damping", "friction")}


class Unreadable(ValueError):
    """The text does not describe the arm that the certificate speaks of; the message says why."""


@dataclass(frozen=True)
class Pose:
    """``<origin>``: translation, m, and roll, pitch, yaw, rad."""

    xyz: Decimals
    rpy: Decimals


@dataclass(frozen=True)
class WrittenBody:
    """``<inertial>`` of a link: kg, and ixx, ixy, ixz, iyy, iyz, izz about the centre in the pose's axes, kg·m²."""

    mass: str
    inertia: Decimals
    pose: Pose


@dataclass(frozen=True)
class WrittenMimic:
    """``<mimic>``: value = multiplier · the other's + offset."""

    joint: str
    multiplier: str
    offset: str


@dataclass(frozen=True)
class WrittenJoint:
    """A joint of the text, the fixed ones included."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Pose
    axis: Decimals
    mimic: WrittenMimic | None


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
    bodies: Mapping[str, WrittenBody | None]
    children: Mapping[str, Sequence[WrittenJoint]]


def description(text: str) -> Description:
    """Read a URDF.

    Raises:
        Unreadable: It is not well-formed, not a tree of links, or has numbers that are none.
    """
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise Unreadable("the URDF declares entities or a document type, which are not read here")
    root = _parsed(text)
    if root.tag != "robot":
        raise Unreadable(f"the URDF begins with <{printable(root.tag)}>, <robot> expected")
    if root.get("version", "1.0") not in ("1.0", "1.1", "1.2"):
        raise Unreadable(f"the URDF is of version '{printable(root.get('version', ''))}', which is not read here")
    bodies: dict[str, WrittenBody | None] = {}
    for link in root.findall("link"):
        name = _name(link)
        if name in bodies:
            raise Unreadable(f"the URDF has two links '{name}'")
        bodies[name] = _body(link)
    if len(bodies) > MOST_LINKS:
        raise Unreadable(f"the URDF has {len(bodies)} links, at most {MOST_LINKS} are read here")
    children: dict[str, list[WrittenJoint]] = {}
    carried: set[str] = set()
    names: set[str] = set()
    for element in root.findall("joint"):
        joint = _joint(element)
        if joint.name in names:
            raise Unreadable(f"the URDF has two joints '{joint.name}'")
        # Two joints to one link would make it a graph, with more ways through it than there are links.
        if joint.child in carried or joint.child not in bodies or joint.parent not in bodies:
            raise Unreadable(f"joint '{joint.name}' of the URDF does not join two links of a tree")
        names.add(joint.name)
        carried.add(joint.child)
        children.setdefault(joint.parent, []).append(joint)
    roots = [name for name in bodies if name not in carried]
    if len(roots) != 1:
        raise Unreadable(f"the URDF has {len(roots)} links that nothing carries, one expected")
    reached = list(roots)
    for name in reached:
        reached += [joint.child for joint in children.get(name, ())]
    if len(reached) != len(bodies):
        raise Unreadable("the URDF has joints that go round in a circle")
    return Description(_name(root), roots[0], bodies, children)


def _parsed(text: str) -> ET.Element:
    """The text's elements by the names that they are written with: a prefix makes another name, as in other readers."""
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate(encoding="utf-8")
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    try:
        parser.Parse(text.encode(), True)
        return builder.close()
    except (expat.ExpatError, AssertionError) as error:
        raise Unreadable(f"the URDF is not well-formed XML: {printable(str(error))}") from None


def _name(element: ET.Element) -> str:
    name = element.get("name", "")
    if not name or name != printable(name):
        raise Unreadable(
            f"the name '{printable(name)}' in the URDF is empty, too long, or has signs that cannot be shown"
        )
    return name


def _joint(element: ET.Element) -> WrittenJoint:
    name, kind = _name(element), element.get("type", "")
    if kind != "fixed" and kind not in MOVING:
        raise Unreadable(f"joint '{name}' of the URDF is of type '{printable(kind)}', not read here")
    if kind in ("revolute", "prismatic") and element.find("limit") is None:
        raise Unreadable(f"joint '{name}' of the URDF has no <limit>, without which others do not read it")
    _check_unused(element, name)
    parent, child = (_part(element, tag, name).get("link", "") for tag in ("parent", "child"))
    axis = _only(element, "axis", {"xyz"})
    along = ("1", "0", "0") if axis is None else _decimals(axis.get("xyz"), 3)
    if kind != "fixed" and all(float(x) == 0.0 for x in along):
        raise Unreadable(f"joint '{name}' of the URDF has no axis")
    return WrittenJoint(name, kind, parent, child, _pose(element), along, _mimic(element, name))


def _check_unused(element: ET.Element, name: str) -> None:
    """Nothing is computed from these here, but an arm where they are no numbers is one that nobody else reads."""
    for tag, keys in _UNUSED.items():
        for found, key in product(element.findall(tag), keys):
            text = found.get(key, "0")
            try:
                known = not math.isnan(as_number(text)) and (tag == "limit" or math.isfinite(as_number(text)))
            except ValueError:
                known = False
            if not known:
                raise Unreadable(f"joint '{name}' of the URDF has <{tag} {key}=\"{printable(text)}\">, not a number")


def _mimic(element: ET.Element, name: str) -> WrittenMimic | None:
    mimic = _only(element, "mimic", {"joint", "multiplier", "offset"})
    if mimic is None:
        return None
    master = mimic.get("joint", "")
    if not master:
        raise Unreadable(f"joint '{name}' of the URDF follows a joint without a name")
    (multiplier,), (offset,) = _decimals(mimic.get("multiplier", "1"), 1), _decimals(mimic.get("offset", "0"), 1)
    return WrittenMimic(master, multiplier, offset)


def _body(link: ET.Element) -> WrittenBody | None:
    inertial = _only(link, "inertial")
    if inertial is None:
        return None
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    mass, tensor = _only(inertial, "mass", {"value"}), _only(inertial, "inertia", set(keys))
    if mass is None or tensor is None:
        raise Unreadable(f"link '{_name(link)}' of the URDF has an <inertial> without <mass> or <inertia>")
    (value,) = _decimals(mass.get("value"), 1)
    return WrittenBody(value, tuple(_decimals(tensor.get(key), 1)[0] for key in keys), _pose(inertial))


def _pose(element: ET.Element) -> Pose:
    origin = _only(element, "origin", {"xyz", "rpy"})
    zero = ("0", "0", "0")
    if origin is None:
        return Pose(zero, zero)
    found = {key: _decimals(origin.get(key), 3) for key in ("xyz", "rpy") if key in origin.attrib}
    return Pose(found.get("xyz", zero), found.get("rpy", zero))


def _only(element: ET.Element, tag: str, attributes: set[str] | None = None) -> ET.Element | None:
    """The one child of that name, with no attributes but those: of two, or of others, readers make different things."""
    found = element.findall(tag)
    if len(found) > 1:
        raise Unreadable(f"'{printable(element.get('name', element.tag))}' of the URDF has two <{tag}>")
    if found and attributes is not None and not set(found[0].keys()) <= attributes:
        other = min(set(found[0].keys()) - attributes)
        raise Unreadable(f"<{tag}> of the URDF has an attribute '{printable(other)}', not read here")
    return found[0] if found else None


def _part(element: ET.Element, tag: str, name: str) -> ET.Element:
    found = _only(element, tag)
    if found is None:
        raise Unreadable(f"joint '{name}' of the URDF has no <{tag}>")
    return found


def _decimals(text: str | None, count: int) -> Decimals:
    parts = () if text is None else (text,) if count == 1 else tuple(part for part in text.split(" ") if part)
    if len(parts) != count:
        what = "a number" if count == 1 else f"a row of {count} numbers"
        raise Unreadable(f"'{printable(text or '')}' in the URDF is not {what}")
    for part in parts:
        if len(part) > _LONGEST or not _DECIMAL.fullmatch(part):
            raise Unreadable(f"'{printable(part)}' in the URDF is not a number")
        size = abs(float(part))
        if (size == 0.0 and _digits(part)) or not (size == 0.0 or _LEAST <= size <= _MOST):
            raise Unreadable(f"'{printable(part)}' in the URDF is not 0 or of a size from {_LEAST:g} to {_MOST:g}")
    return parts


def _digits(part: str) -> bool:
    """Whether a decimal that a float takes for zero is none."""
    return any(digit in "123456789" for digit in re.split("[eE]", part)[0])
