"""Reads what a URDF shows: the `<visual>` elements of its links, as coloured triangles in the links' frames.

The `<collision>` elements are written alike and read alike.

A run is never lost over a picture: what cannot be drawn as written is left out or grey, and said.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.urdf_document import read_again
from asmc_pin.viewer.drawing.meshes import load_mesh
from asmc_pin.viewer.drawing.surface import PLAIN, Surface, painted
from asmc_pin.words.text import as_number, printable

_MOST_VISUALS = 500
_MOST_TRIANGLES = 3_000_000
_FURTHEST = 1e6
"""m; a picture of something larger shows nothing else."""

Colour = tuple[int, int, int]


def read_visuals(
    urdf_text: str, files: RobotFiles, of: Literal["visual", "collision"] = "visual"
) -> tuple[dict[str, list[Surface]], dict[str, list[str]]]:
    """Triangles of every link that shows something.

    A mesh file's own colours count before the URDF's material: files that carry colours are coloured finer.

    Args:
        urdf_text: The URDF.
        files: Where meshes are looked for.
        of: What is shown, or the shapes that are meant for collisions.

    Returns:
        Surfaces by link name, in the link's frame; and, by link name, what is not drawn as written: a mesh that was
        not found, a colour that is none.
    """
    root = read_again(urdf_text)
    materials: dict[str, Colour] = {}
    for material in root.findall("material"):
        colour, _ = _colour(material, {})
        if colour is not None:
            materials[material.get("name", "")] = colour
    shown: dict[str, list[Surface]] = {}
    problems: dict[str, list[str]] = {}
    visuals = triangles = 0
    for link in root.findall("link"):
        name = link.get("name", "")
        for visual in link.findall(of):
            visuals += 1
            try:
                if visuals > _MOST_VISUALS or triangles > _MOST_TRIANGLES:
                    raise ValueError(f"the picture has {visuals} parts of {triangles} triangles by then")
                surfaces, found = _visual(visual, materials, files)
            except Exception as error:  # readers of mesh formats raise whatever they like
                problems.setdefault(name, []).append(f"link '{name}': {_said(error)}; left out")
                continue
            triangles += sum(len(surface.faces) for surface in surfaces)
            problems.setdefault(name, []).extend(f"link '{name}': {text}" for text in found)
            if surfaces:
                shown.setdefault(name, []).extend(surfaces)
    return shown, {name: texts for name, texts in problems.items() if texts}


def _said(error: Exception) -> str:
    if isinstance(error, OSError | ValueError):
        return printable(str(error))
    return f"cannot be drawn ({type(error).__name__}: {printable(str(error))})"


def _visual(visual: Any, materials: dict[str, Colour], files: RobotFiles) -> tuple[list[Surface], list[str]]:
    """Surfaces of one visual in the link's frame, and what of it is not drawn as written."""
    geometry = visual.find("geometry")
    if geometry is None:
        return [], []
    problems = []
    material = visual.find("material")
    colour, problem = (None, "") if material is None else _colour(material, materials)
    if problem:
        problems.append(f"{problem}; drawn in grey")
    try:
        pose = _origin(visual.find("origin"))
    except ValueError as error:
        problems.append(f"{error}; drawn at the link's frame, in grey")
        pose, colour = np.eye(4), PLAIN
    surfaces = [surface.moved(pose) for surface in _surfaces(geometry, colour, files)]
    for surface in surfaces:
        if not np.all(np.abs(surface.vertices) <= _FURTHEST):
            raise ValueError(f"a point is not within {_FURTHEST:g} m")
    return surfaces, problems


def _numbers(element: Any, attribute: str, default: str, counts: tuple[int, ...]) -> list[float]:
    text = element.get(attribute, default)
    try:
        values = [as_number(part) for part in text.split()]
        if len(values) in counts and all(map(math.isfinite, values)):
            return values
    except ValueError:
        pass
    expected = " or ".join(map(str, counts))
    raise ValueError(f'<{element.tag} {attribute}="{printable(text)}"> is not {expected} finite number(s)')


def _surfaces(geometry: Any, colour: Colour | None, files: RobotFiles) -> Iterator[Surface]:
    for element in geometry:
        if element.tag == "mesh":
            scale = np.array(_numbers(element, "scale", "1 1 1", (1, 3))) * np.ones(3)
            if not np.all(scale):
                raise ValueError(f'<mesh scale="{printable(element.get("scale"))}"> leaves nothing to draw')
            for surface, own in load_mesh(files.mesh(element.get("filename", ""))):
                scaled = surface.moved(np.diag([*scale, 1.0]))
                yield scaled if own or colour is None else painted(scaled.vertices, scaled.faces, colour)
        elif (shape := _primitive(element)) is not None:
            yield painted(np.asarray(shape.vertices), np.asarray(shape.faces), colour or PLAIN)


def _primitive(element: Any) -> Any:
    from trimesh import creation

    def value(name: str) -> float:
        return _numbers(element, name, "0", (1,))[0]

    if element.tag == "box":
        return creation.box(extents=_numbers(element, "size", "", (3,)))
    if element.tag == "sphere":
        return creation.icosphere(subdivisions=3, radius=value("radius"))
    if element.tag == "cylinder":
        return creation.cylinder(radius=value("radius"), height=value("length"), sections=48)
    if element.tag == "capsule":
        return creation.capsule(radius=value("radius"), height=value("length"), count=[24, 32])
    return None


def _colour(material: Any, known: dict[str, Colour]) -> tuple[Colour | None, str]:
    """Colour of a material, None where it has none; and what is wrong with it."""
    element = material.find("color")
    if element is None:
        return known.get(material.get("name", "")), ""
    try:
        red, green, blue, *_ = (
            round(255 * min(max(x, 0.0), 1.0)) for x in _numbers(element, "rgba", "1 1 1 1", (3, 4))
        )
    except ValueError as error:
        return None, str(error)
    return (red, green, blue), ""


def _origin(origin: Any) -> Array:
    """Homogeneous transform of an `<origin>`: roll, pitch, yaw about fixed axes, then the translation."""
    from scipy.spatial.transform import Rotation

    pose = np.eye(4)
    if origin is not None:
        pose[:3, :3] = Rotation.from_euler("xyz", _numbers(origin, "rpy", "0 0 0", (3,))).as_matrix()
        pose[:3, 3] = _numbers(origin, "xyz", "0 0 0", (3,))
    return pose
