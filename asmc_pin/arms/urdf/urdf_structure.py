"""Plain-words checks of a URDF's shape: names, numbers, and a tree that ends in a fixed base."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from asmc_pin.arms.urdf.faults import Fault, refused
from asmc_pin.arms.urdf.magnitudes import LENGTH
from asmc_pin.arms.urdf.urdf_document import Document
from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError
from asmc_pin.words.nearest_name import nearest
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


def _number_problem(document: Document, owner: Any, element: Any, attribute: str, text: str) -> str:
    place = f"{where(document, owner)}: {_quoted(element, attribute, text)}"
    try:
        value = as_number(text)
    except ValueError:
        return f"{place} is not a number; write it like 0.25 or 2.5e-1"
    if element.tag == "origin" and math.isfinite(value) and abs(value) > LENGTH:
        unit = "m" if attribute == "xyz" else "rad"
        return f"{place}: at most {LENGTH:g} {unit} are taken; correct the number, or its unit"
    if math.isnan(value) or (math.isinf(value) and element.tag != "limit"):
        return f"{place} is not a finite number; a URDF exporter writes this when its input lacks data"
    return ""


def _number_problems(document: Document, owner: Any) -> Iterator[str]:
    inertial = owner.find("inertial")
    for element in (*owner, *(inertial if inertial is not None else ())):
        for attribute in _REQUIRED.get(element.tag, ()):
            if element.get(attribute) is None:
                yield f'{where(document, owner)}: <{element.tag}> lacks {attribute}="…"'
        for attribute in _SCALARS.get(element.tag, ()):
            if element.get(attribute) is not None:
                yield _number_problem(document, owner, element, attribute, element.get(attribute))
        for attribute in _VECTORS.get(element.tag, ()):
            text = element.get(attribute)
            if text is None:
                continue
            if len(text.split()) != 3:
                place = f"{where(document, owner)}: {_quoted(element, attribute, text)}"
                yield f"{place} needs three numbers, separated by spaces"
                continue
            found = (_number_problem(document, owner, element, attribute, part) for part in text.split())
            yield next((problem for problem in found if problem), "")
    if inertial is not None:
        for part in ("mass", "inertia"):
            if inertial.find(part) is None:
                yield f"{where(document, owner)}: <inertial> has no <{part}>; add it, or remove <inertial>"


def _joint_problems(document: Document, joint: Any, links: Mapping[str, None]) -> Iterator[str]:
    place = where(document, joint)
    kind = joint.get("type")
    if kind not in _KINDS:
        yield f"{place}: its type is {printable(repr(kind))}; a URDF knows {', '.join(_KINDS)}"
    if kind == "floating":
        yield (
            f'{place}: a floating base. These are arms on a fixed base: make the joint type="fixed", or remove it and '
            "its parent link"
        )
    if kind == "planar":
        yield (
            f"{place}: a planar joint has several coordinates, here every joint has one; make it fixed, or write it as "
            "two prismatic joints with a link between"
        )
    for role in ("parent", "child"):
        element = joint.find(role)
        name = None if element is None else element.get("link")
        if not name:
            yield f'{place}: no <{role} link="…"/>'
        elif name not in links:
            yield f"{place}: its {role} link '{printable(name)}' does not exist; {nearest(name, list(links))}"


def _joint_faults(document: Document, joint: Any, names: Sequence[str]) -> Iterator[Fault]:
    """What is wrong with a joint that can be told all the same."""
    place, about = where(document, joint), (joint.get("name"),)
    axis = joint.find("axis")
    if joint.get("type") in MOVING and axis is not None and not any(map(float, axis.get("xyz", "1 0 0").split())):
        told = "its axis is zero; give the direction about or along which it moves, such as 0 0 1"
        yield Fault("axis", about, f"{place}: {told}")
    mimic = joint.find("mimic")
    if mimic is None:
        return
    master = mimic.get("joint")
    if not master:
        yield Fault("mimic", about, f"{place}: <mimic> names no joint")
    elif master not in names:
        told = f"mimics joint '{printable(master)}', which does not exist; {nearest(master, list(names))}"
        yield Fault("mimic", about, f"{place}: {told}")


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


def check_structure(document: Document) -> tuple[Fault, ...]:
    """Check names, numbers, joint types and the tree.

    Returns:
        What it is to be refused for, although all of it can be read.

    Raises:
        ArmError: It cannot be told what is in it: the joints or links, their lines, and how to correct them.
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
    owners = [owner for owner in document.root if owner.tag in ("link", "joint")]
    problems = [problem for owner in owners for problem in _number_problems(document, owner) if problem]
    problems += [problem for joint in joints for problem in _joint_problems(document, joint, known)]
    if problems:
        raise refused(document.path, problems)
    _check_tree(document, links, joints)
    if not any(joint.get("type") in MOVING for joint in joints):
        raise ArmError(
            document.path,
            f"{shown(document.path)}: nothing movable; an arm needs a revolute, continuous or prismatic joint",
        )
    names = [joint.get("name") for joint in joints]
    return tuple(fault for joint in joints for fault in _joint_faults(document, joint, names))
