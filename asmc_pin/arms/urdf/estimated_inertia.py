"""Inertias for links that have none, from their shapes and a mass: an estimate, and marked as one.

Density is uniform over a link, and with one total mass over all links that are estimated. A real link is a shell with
motors in it; its mass may lie elsewhere, which nothing here can know.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from lxml import etree

from asmc_pin._typing import Array
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.magnitudes import MASS
from asmc_pin.arms.urdf.rigid_inertia import ENTRIES
from asmc_pin.arms.urdf.solid_shapes import KINDS, LinkSolid, solids_of
from asmc_pin.arms.urdf.urdf_document import Document
from asmc_pin.arms.urdf.urdf_structure import MOVING, check_structure
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.provisos import Proviso
from asmc_pin.words.text import counted, printable

EstimateInertia = float | Mapping[str, float]
"""kg: the mass of all links that are estimated together, or link to mass."""


def read_estimate(value: Any) -> EstimateInertia | None:
    """Check the masses that a user gives.

    Raises:
        ParameterError: A mass that is none.
    """
    if value is None:
        return None
    if isinstance(value, Mapping):
        if not value:
            raise ParameterError("estimate_inertia", "no link given; give a total mass in kg, or link = kg")
        return {str(link): _mass(f"link '{printable(str(link))}': ", mass) for link, mass in value.items()}
    return _mass("", value)


def with_estimated_inertia(document: Document, masses: EstimateInertia, files: RobotFiles) -> Document:
    """Put inertias into the links of a URDF.

    Args:
        document: The URDF.
        masses: One mass: it is spread over all links that have shapes and, with all that is fixed to them, no mass, in
            proportion to their volumes; the base counts. Link to mass: these links, whatever the file says of them.
        files: Where meshes are looked for.

    Returns:
        The URDF with these inertias, and a proviso that says which and from what.

    Raises:
        ArmError: The URDF is at fault, or a link's shapes cannot be read.
        ParameterError: An unknown link, or none without inertia.
    """
    check_structure(document)
    links = {link.get("name"): link for link in document.root.findall("link")}
    solids: dict[str, LinkSolid] = {}
    unreadable: list[str] = []
    for together in _chosen(document, links, masses):
        found, problems = solids_of({name: links[name] for name in together}, files)
        if not found and (problems or isinstance(masses, Mapping)):
            raise ArmError(document.path, _shapeless(document, together[0], problems))
        solids |= found
        unreadable += problems
    if not solids:
        raise ParameterError(
            "estimate_inertia",
            f"no link of {printable(document.path.name)} that is without inertia has a shape to estimate it from",
        )
    volume = sum(found.solid.volume for found in solids.values())
    given = masses if isinstance(masses, Mapping) else {n: masses * f.solid.volume / volume for n, f in solids.items()}
    for name, shape in solids.items():
        _write(links[name], float(given[name]), shape)
    density = None if isinstance(masses, Mapping) else masses / volume
    densities = {name: float(given[name]) / found.solid.volume for name, found in solids.items()}
    told = Proviso("estimated inertia", _told(solids, given, density, unreadable))
    return replace(document, densities=densities).rewritten(told)


def _chosen(document: Document, links: Mapping[str, Any], masses: EstimateInertia) -> list[list[str]]:
    """Names of the links that get an inertia, those that are fixed to each other together."""
    if isinstance(masses, Mapping):
        for name in masses:
            if name not in links:
                told = f"no link '{printable(name)}' in {printable(document.path.name)}; {nearest(name, list(links))}"
                raise ParameterError("estimate_inertia", told)
        return [[name] for name in masses]
    bare = _without_mass(document, links)
    moving = {each.find("child").get("link") for each in document.root.findall("joint") if each.get("type") in MOVING}
    if not any(moving & set(body) for body in bare):
        raise ParameterError(
            "estimate_inertia",
            f"every link that a joint of {printable(document.path.name)} moves has an inertia, or one fixed to it has; "
            "leave it out, or name the links whose inertia is to be replaced: link=kg",
        )
    return bare


def _without_mass(document: Document, links: Mapping[str, Any]) -> list[list[str]]:
    """Links that are fixed to each other and have no mass, body by body: a frame beside a mass needs none."""
    held = {
        joint.find("child").get("link"): joint.find("parent").get("link")
        for joint in document.root.findall("joint")
        if joint.get("type") not in MOVING
    }
    bodies: dict[str, list[str]] = {}
    for name in links:
        root = name
        while root in held:
            root = held[root]
        bodies.setdefault(root, []).append(name)
    return [body for body in bodies.values() if not any(_has_mass(links[name]) for name in body)]


def _has_mass(link: Any) -> bool:
    mass = link.find("inertial/mass")
    return mass is not None and float(mass.get("value")) > 0.0


def _mass(where: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not 0.0 < float(value) <= MASS:
        raise ParameterError("estimate_inertia", f"{where}{value!r} given, a mass above zero expected, kg")
    return float(value)


def _shapeless(document: Document, name: str, problems: Sequence[str]) -> str:
    why = "; ".join(problems) or "it has neither visual nor collision shapes"
    return (
        f"{printable(document.path.name)}: no inertia can be estimated for link '{printable(name)}': {why}. Say where "
        "its meshes are (--package NAME=DIR), or give the link an <inertial>"
    )


def _write(link: Any, mass: float, found: LinkSolid) -> None:
    """Put the ``<inertial>`` of a mass into a link, in place of one that is there."""
    for old in link.findall("inertial"):
        link.remove(old)
    inertia: Array = mass / found.solid.volume * found.solid.inertia
    inertial = etree.Element("inertial")
    etree.SubElement(inertial, "origin", xyz=" ".join(repr(float(x)) for x in found.solid.centre), rpy="0 0 0")
    etree.SubElement(inertial, "mass", value=repr(mass))
    etree.SubElement(inertial, "inertia", {name: repr(float(inertia[at])) for name, at in ENTRIES.items()})
    link.insert(0, inertial)


def _told(
    solids: Mapping[str, LinkSolid], given: Mapping[str, float], density: float | None, unreadable: Sequence[str]
) -> str:
    """What was estimated, from what, and what is doubtful about it."""
    of = ", ".join(f"'{printable(name)}' {given[name]:.4g} kg" for name in solids)
    if density is None:
        said = f"{of}; uniform density in each link"
    else:
        total = sum(given[name] for name in solids)
        over = counted(len(solids), "link")
        said = f"{total:g} kg over {over} in proportion to volume, {density:.4g} kg/m³ throughout: {of}"
    for kind in KINDS:
        names = [f"'{printable(name)}'" for name, found in solids.items() if found.kind == kind]
        if names:
            said += f"; from {kind} shapes: {'all' if len(names) == len(solids) else ', '.join(names)}"
    hulls = [f"'{printable(name)}'" for name, found in solids.items() if found.hulls]
    if hulls:
        said += f"; convex hulls in place of meshes that are not closed: {', '.join(hulls)}"
    if unreadable:
        said += f"; left out: {'; '.join(unreadable)}"
    return said
