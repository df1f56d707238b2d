"""Plain-words checks of a URDF's shape: names, numbers, and a tree that ends in a fixed base."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from asmc_pin.arms.registry import nearest
from asmc_pin.arms.urdf.magnitudes import LENGTH
from asmc_pin.arms.urdf.urdf_document import Document
from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError
from asmc_pin.words.text import as_number, printable

MOST_LINKS = 1_000
_LONGEST_NAME = 255

MOVING = ("revolute", "continuous", "prismatic")
_KINDS = (*MOVING, "fixed", "floating", "planar")
_VECTORS = {"origin": ("xyz", "rpy"), "axis": ("xyz",)}
_SCALARS = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "mimic": ("multiplier", "offset"),
}
NUMBERS = {**_VECTORS, **_SCALARS}
"""Attributes that hold numbers, by element."""

_REQUIRED = {"mass": ("value",), "inertia": ("ixx", "iyy", "izz")}


def where(document: Document, element: Any) -> str:
    """``joint 'elbow' in arm.urdf, line 12``; what a xacro file is expanded to has no lines of its own."""
    name = printable(element.get("name") or "")
    line = " (expanded)" if document.expanded else f", line {element.sourceline}"
    return f"{element.tag} '{name}' in {printable(document.path.name)}{line}"


def _named(document: Document, tag: str) -> list[Any]:
    elements = document.root.findall(tag)
    for element in elements:
        if not element.get("name"):
            place = f"a <{tag}> in {shown(document.path)}, line {element.sourceline}"
            raise ArmError(document.path, f'{place}, has no name; give it one: <{tag} name="…">')
        _check_name(document, element, tag, element.get("name"))
    for name, count in Counter(element.get("name") for element in elements).items():
        if count > 1:
            lines = _listed([str(e.sourceline) for e in elements if e.get("name") == name])
            place = f"{shown(document.path)} (lines {lines})"
            raise ArmError(document.path, f"{count} {tag}s are named '{name}' in {place}; names are unique, rename one")
    return list(elements)


def _check_name(document: Document, element: Any, what: str, name: str) -> None:
    """Names go to terminals, tables, pages and files: they hold nothing that one of these obeys."""
    place = f"in {shown(document.path)}, line {element.sourceline}"
    if len(name) > _LONGEST_NAME:
        raise ArmError(
            document.path,
            f"{place}: the {what} name '{printable(name)}' has {len(name)} characters; at most {_LONGEST_NAME} are "
            "taken, shorten it",
        )
    if printable(name[:100]) + printable(name[100:200]) + printable(name[200:]) != name:
        raise ArmError(
            document.path,
            f"{place}: the {what} name '{printable(name)}' has a control character, a line break or an odd space, "
            "shown here as a code; rename it",
        )


def _listed(names: Sequence[str]) -> str:
    """Names, as many of them as one reads."""
    more = f" and {len(names) - 10} more" if len(names) > 10 else ""
    return ", ".join(names[:10]) + more


def _quoted(element: Any, attribute: str, text: str) -> str:
    return f'<{element.tag} {attribute}="{printable(text)}">'


def _check_number(document: Document, owner: Any, element: Any, attribute: str, text: str) -> None:
    place = f"{where(document, owner)}: {_quoted(element, attribute, text)}"
    try:
        value = as_number(text)
    except ValueError:
        raise ArmError(document.path, f"{place} is not a number; write it like 0.25 or 2.5e-1") from None
    if element.tag == "origin" and math.isfinite(value) and abs(value) > LENGTH:
        unit = "m" if attribute == "xyz" else "rad"
        raise ArmError(document.path, f"{place}: at most {LENGTH:g} {unit} are taken; correct the number, or its unit")
    if math.isnan(value) or (math.isinf(value) and element.tag != "limit"):
        raise ArmError(
            document.path, f"{place} is not a finite number; a URDF exporter writes this when its input lacks data"
        )


def _check_numbers(document: Document, owner: Any) -> None:
    inertial = owner.find("inertial")
    for element in (*owner, *(inertial if inertial is not None else ())):
        for attribute in _REQUIRED.get(element.tag, ()):
            if element.get(attribute) is None:
                raise ArmError(document.path, f'{where(document, owner)}: <{element.tag}> lacks {attribute}="…"')
        for attribute in _SCALARS.get(element.tag, ()):
            if element.get(attribute) is not None:
                _check_number(document, owner, element, attribute, element.get(attribute))
        for attribute in _VECTORS.get(element.tag, ()):
            text = element.get(attribute)
            if text is None:
                continue
            if len(text.split()) != 3:
                place = f"{where(document, owner)}: {_quoted(element, attribute, text)}"
                raise ArmError(document.path, f"{place} needs three numbers, separated by spaces")
            for part in text.split():
                _check_number(document, owner, element, attribute, part)
    if inertial is not None:
        for part in ("mass", "inertia"):
            if inertial.find(part) is None:
                raise ArmError(
                    document.path, f"{where(document, owner)}: <inertial> has no <{part}>; add it, or remove <inertial>"
                )


def _check_joint(document: Document, joint: Any, links: Mapping[str, None]) -> None:
    place = where(document, joint)
    kind = joint.get("type")
    if kind not in _KINDS:
        raise ArmError(document.path, f"{place}: its type is {printable(repr(kind))}; a URDF knows {', '.join(_KINDS)}")
    if kind == "floating":
        raise ArmError(
            document.path,
            f'{place}: a floating base. These are arms on a fixed base: make the joint type="fixed", or remove it and '
            "its parent link",
        )
    if kind == "planar":
        raise ArmError(
            document.path,
            f"{place}: a planar joint has several coordinates, here every joint has one; make it fixed, or write it as "
            "two prismatic joints with a link between",
        )
    for role in ("parent", "child"):
        element = joint.find(role)
        name = None if element is None else element.get("link")
        if not name:
            raise ArmError(document.path, f'{place}: no <{role} link="…"/>')
        if name not in links:
            raise ArmError(
                document.path,
                f"{place}: its {role} link '{printable(name)}' does not exist; {nearest(name, list(links))}",
            )
    axis = joint.find("axis")
    if kind in MOVING and axis is not None and not any(float(x) for x in axis.get("xyz", "1 0 0").split()):
        raise ArmError(
            document.path, f"{place}: its axis is zero; give the direction about or along which it moves, such as 0 0 1"
        )
    mimic = joint.find("mimic")
    if mimic is not None and not mimic.get("joint"):
        raise ArmError(document.path, f"{place}: <mimic> names no joint")


def _check_tree(document: Document, links: list[str], joints: list[Any]) -> None:
    children: dict[str, str] = {}
    for joint in joints:
        child = joint.find("child").get("link")
        if child in children:
            raise ArmError(
                document.path,
                f"{where(document, joint)}: a closed loop, link '{child}' already hangs on joint '{children[child]}'. "
                "Closed chains are not supported: cut the loop at one joint, or use the equivalent open chain",
            )
        children[child] = joint.get("name")
    roots = [link for link in links if link not in children]
    if not roots:
        raise ArmError(
            document.path,
            f"{shown(document.path)}: every link hangs on another, a closed loop without a base; cut it at one joint",
        )
    if len(roots) > 1:
        raise ArmError(
            document.path,
            f"{shown(document.path)}: {len(roots)} links have no parent ({_listed(roots)}); an arm has one base. Join "
            "the others to it with fixed joints, or remove them",
        )
    below: dict[str, list[str]] = {}
    for joint in joints:
        below.setdefault(joint.find("parent").get("link"), []).append(joint.find("child").get("link"))
    reached, front = set(roots), list(roots)
    while front:
        found = below.get(front.pop(), [])
        reached.update(found)
        front.extend(found)
    if len(reached) < len(links):
        rest = _listed([link for link in links if link not in reached])
        raise ArmError(
            document.path,
            f"{shown(document.path)}: a closed loop, links {rest} hang on each other and not on the base '{roots[0]}'; "
            "cut it at one joint",
        )


def check_structure(document: Document) -> None:
    """Check names, numbers, joint types and the tree.

    Raises:
        ArmError: The first fault found, with the joint or link, the line, and how to correct it.
    """
    _check_name(document, document.root, "robot's", document.root.get("name") or "")
    count = len(document.root.findall("link"))
    if count > MOST_LINKS:
        raise ArmError(
            document.path,
            f"{shown(document.path)}: has {count} links, and at most {MOST_LINKS} are read; is it an arm?",
        )
    links = [link.get("name") for link in _named(document, "link")]
    joints = _named(document, "joint")
    known = dict.fromkeys(links)
    for owner in document.root:
        if owner.tag in ("link", "joint"):
            _check_numbers(document, owner)
    for joint in joints:
        _check_joint(document, joint, known)
    names = [joint.get("name") for joint in joints]
    for joint in joints:
        mimic = joint.find("mimic")
        if mimic is not None and mimic.get("joint") not in names:
            master = mimic.get("joint")
            raise ArmError(
                document.path,
                f"{where(document, joint)}: mimics joint '{printable(master)}', which does not exist; "
                f"{nearest(master, names)}",
            )
    _check_tree(document, links, joints)
    if not any(joint.get("type") in MOVING for joint in joints):
        raise ArmError(
            document.path,
            f"{shown(document.path)}: nothing movable; an arm needs a revolute, continuous or prismatic joint",
        )
