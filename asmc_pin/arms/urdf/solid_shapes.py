"""The shapes of a link as one solid of uniform density: volume, centroid, inertia.

Boxes, spheres, cylinders and capsules are exact. A mesh whose surface is closed is integrated over; of any other the
convex hull is taken. Shapes that overlap count twice where they do.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.sources.mesh_files import placed_meshes
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.words.text import as_number, printable

KINDS = ("visual", "collision")
_FLAT = 1e-12
"""Of the cube of a shape's size: a volume below it is a sheet, up to rounding."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A body of density 1 kg/m³.

    Attributes:
        volume: m³.
        centre: Centroid in the link's frame, shape (3,), m.
        inertia: About the centroid, in the link's axes, shape (3, 3), m⁵.
    """

    volume: float
    centre: Array
    inertia: Array

    def placed(self, turn: Array, shift: Array) -> Solid:
        """The same turned by a rotation, shape (3, 3), and then shifted, shape (3,)."""
        return Solid(self.volume, turn @ self.centre + shift, turn @ self.inertia @ turn.T)


@dataclass(frozen=True, eq=False)
class LinkSolid:
    """What the shapes of a link come to.

    Attributes:
        solid: All of them together.
        kind: ``visual`` or ``collision``: which of the link's shapes.
        hulls: How many of them are convex hulls of meshes that are not closed.
    """

    solid: Solid
    kind: str
    hulls: int


def solids_of(links: Mapping[str, Any], files: RobotFiles) -> tuple[dict[str, LinkSolid], list[str]]:
    """The solids of links that move together.

    Visual shapes come first: they are what is there. Collision shapes are often padded, and may stand on helper links
    beside the visible one; they are taken where none of these links has a visual one that can be read.

    Args:
        links: The URDF's elements by the links' names.
        files: Where meshes are looked for.

    Returns:
        Solids of those links that have one; and shapes that could not be read, one sentence each.
    """
    problems: list[str] = []
    for kind in KINDS:
        found: dict[str, LinkSolid] = {}
        for name, link in links.items():
            solids: list[Solid] = []
            hulls = 0
            for element in link.findall(kind):
                try:
                    some, is_hull = _shape(element, files)
                except (ValueError, OSError) as error:
                    problems.append(f"{kind} of link '{printable(name)}': {printable(str(error))}")
                    continue
                solids += some
                hulls += is_hull
            if solids:
                found[name] = LinkSolid(_together(solids), kind, hulls)
        if found:
            return found, problems
    return {}, problems


def _shape(element: Any, files: RobotFiles) -> tuple[list[Solid], bool]:
    """The solid of one ``<collision>`` or ``<visual>`` in the link's frame, and whether it is a hull."""
    from scipy.spatial.transform import Rotation

    geometry = element.find("geometry")
    if geometry is None or len(geometry) == 0:
        return [], False
    origin = element.find("origin")
    shift = np.array(_numbers(origin, "xyz", 3)) if origin is not None and origin.get("xyz") else np.zeros(3)
    angles = _numbers(origin, "rpy", 3) if origin is not None and origin.get("rpy") else [0.0] * 3
    turn = Rotation.from_euler("xyz", angles).as_matrix()
    shape = geometry[0]
    if shape.tag == "mesh":
        scale = np.array(_numbers(shape, "scale", 3)) if shape.get("scale") else np.ones(3)
        solid, is_hull = _mesh(shape.get("filename", ""), scale, files)
    else:
        solid, is_hull = _primitive(shape), False
    return [solid.placed(turn, shift)], is_hull


def _primitive(shape: Any) -> Solid:
    def size(name: str) -> float:
        return _positive(shape, name, 1)[0]

    if shape.tag == "box":
        x, y, z = _positive(shape, "size", 3)
        volume, moments = x * y * z, np.array([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0
    elif shape.tag == "sphere":
        r = size("radius")
        volume, moments = 4.0 / 3.0 * math.pi * r**3, np.full(3, 0.4 * r * r)
    elif shape.tag == "cylinder":
        r, h = size("radius"), size("length")
        across = (3.0 * r * r + h * h) / 12.0
        volume, moments = math.pi * r * r * h, np.array([across, across, r * r / 2.0])
    elif shape.tag == "capsule":
        r, h = size("radius"), size("length")
        tube, ball = math.pi * r * r * h, 4.0 / 3.0 * math.pi * r**3
        volume = tube + ball
        # Each half ball's centroid is 3r/8 beyond the tube's end.
        across = tube * (3.0 * r * r + h * h) / 12.0 + ball * (0.4 * r * r + h * h / 4.0 + 3.0 * h * r / 8.0)
        moments = np.array([across, across, tube * r * r / 2.0 + ball * 0.4 * r * r]) / volume
    else:
        raise ValueError(f"<{printable(str(shape.tag))}> is no shape whose volume is known")
    return Solid(volume, np.zeros(3), np.diag(volume * moments))


def _mesh(filename: str, scale: Array, files: RobotFiles) -> tuple[Solid, bool]:
    """A mesh file's solid, and whether it is the convex hull: one open part makes it that of the whole file."""
    import trimesh

    parts = []
    for mesh, pose in placed_meshes(files.mesh(filename)):
        # Files repeat a corner for each triangle at it; only merged do they show whether the surface is closed.
        part = trimesh.Trimesh(np.array(mesh.vertices), np.array(mesh.faces), process=True)
        part.merge_vertices(merge_tex=True, merge_norm=True)
        part.apply_transform(pose)
        part.vertices = part.vertices * scale
        parts.append(part)
    closed = all(part.is_watertight and part.is_winding_consistent and part.volume != 0.0 for part in parts)
    if closed:
        return _together([_integrated(part) for part in parts]), False
    corners = np.vstack([part.vertices for part in parts])
    try:
        hull = trimesh.convex.convex_hull(corners)
    except Exception:  # Qhull's own error, on what has no volume
        raise ValueError(f"{printable(filename)} is flat and encloses nothing") from None
    return _integrated(hull, printable(filename)), True


def _integrated(mesh: Any, name: str = "a mesh") -> Solid:
    volume = float(mesh.volume)
    centre, inertia = np.array(mesh.center_mass, dtype=np.float64), np.array(mesh.moment_inertia, dtype=np.float64)
    if volume < 0.0:  # its triangles face inwards
        volume, inertia = -volume, -inertia
    size = float(np.ptp(mesh.vertices, axis=0).max())
    if not volume > _FLAT * size**3 or not np.isfinite(inertia).all():
        raise ValueError(f"{name} is flat and encloses nothing")
    return Solid(volume, centre, 0.5 * (inertia + inertia.T))


def _together(solids: Sequence[Solid]) -> Solid:
    volume = sum(solid.volume for solid in solids)
    centre = sum((solid.volume * solid.centre for solid in solids), np.zeros(3)) / volume
    inertia = np.zeros((3, 3))
    for solid in solids:
        arm = solid.centre - centre
        inertia += solid.inertia + solid.volume * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Solid(volume, centre, inertia)


def _positive(element: Any, name: str, count: int) -> list[float]:
    values = _numbers(element, name, count)
    if not all(value > 0.0 for value in values):
        raise ValueError(f'<{element.tag} {name}="{printable(element.get(name, ""))}"> encloses nothing')
    return values


def _numbers(element: Any, name: str, count: int) -> list[float]:
    text = element.get(name, "")
    try:
        values = [as_number(part) for part in text.split()]
    except ValueError:
        values = []
    values = values * count if len(values) == 1 and name == "scale" else values
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ValueError(f'<{element.tag} {name}="{printable(text)}"> is not {count} finite number(s)')
    return values
