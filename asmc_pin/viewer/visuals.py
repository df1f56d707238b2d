"""Reads what a URDF shows: the `<visual>` elements of its links, as coloured triangles in the links' frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from lxml import etree

from asmc_pin._typing import Array, IntArray

Colours = npt.NDArray[np.uint8]
"""RGB per triangle, shape (m, 3)."""

PLAIN = (176, 180, 186)
"""Colour of what declares none."""


@dataclass(frozen=True)
class Surface:
    """Coloured triangles.

    Attributes:
        vertices: Corner positions, shape (n, 3), m.
        faces: Indices into `vertices`, shape (m, 3).
        colours: RGB per triangle, shape (m, 3), 0 … 255.
    """

    vertices: Array
    faces: IntArray
    colours: Colours

    def moved(self, pose: Array) -> Surface:
        """The same triangles after a homogeneous transform, shape (4, 4); a mirroring one keeps the outside outside."""
        faces = self.faces if np.linalg.det(pose[:3, :3]) > 0 else self.faces[:, ::-1]
        return Surface(self.vertices @ pose[:3, :3].T + pose[:3, 3], faces, self.colours)


def join(surfaces: Sequence[Surface]) -> Surface:
    """One surface out of several, in their order."""
    if not surfaces:
        return Surface(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), np.empty((0, 3), dtype=np.uint8))
    starts = np.cumsum([0] + [len(surface.vertices) for surface in surfaces[:-1]])
    return Surface(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate([surface.faces + start for surface, start in zip(surfaces, starts, strict=True)]),
        np.concatenate([surface.colours for surface in surfaces]),
    )


def read_visuals(
    urdf_text: str, package_dirs: Sequence[str | Path], folder: str | Path
) -> tuple[dict[str, list[Surface]], dict[str, list[str]]]:
    """Triangles of every link that shows something.

    A mesh file's own colours count before the URDF's material: files that carry colours are coloured finer.

    Args:
        urdf_text: The URDF.
        package_dirs: Folders in which ``package://NAME/…`` looks for ``NAME/…``.
        folder: Where relative file names start, the URDF's own folder.

    Returns:
        Surfaces by link name, in the link's frame; and the mesh files that could not be found or read, by link name.
    """
    # Entities stay unexpanded and nothing is fetched: a URDF may come from anywhere.
    root = etree.fromstring(
        urdf_text.encode(), etree.XMLParser(encoding="utf-8", resolve_entities=False, no_network=True)
    )
    materials = {m.get("name", ""): c for m in root.findall("material") if (c := _colour(m)) is not None}
    shown: dict[str, list[Surface]] = {}
    missing: dict[str, list[str]] = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        for visual in link.findall("visual"):
            geometry = visual.find("geometry")
            if geometry is None:
                continue
            material = visual.find("material")
            colour = None
            if material is not None:
                colour = _colour(material) or materials.get(material.get("name", ""))
            try:
                surfaces = list(_surfaces(geometry, colour, package_dirs, Path(folder)))
            except (OSError, ValueError) as error:
                missing.setdefault(name, []).append(str(error))
                continue
            pose = _origin(visual.find("origin"))
            shown.setdefault(name, []).extend(surface.moved(pose) for surface in surfaces)
    return shown, missing


def resolve(filename: str, package_dirs: Sequence[str | Path], folder: Path) -> Path:
    """The file that a URDF's mesh name means.

    Raises:
        FileNotFoundError: It lies nowhere that was looked at; the message says where.
    """
    scheme, _, rest = filename.rpartition("://")
    if scheme in ("package", "model"):
        package, _, inside = rest.partition("/")
        candidates = [Path(d) / rest for d in package_dirs]
        candidates += [Path(d) / inside for d in package_dirs if Path(d).name == package]
    else:
        candidates = [folder / rest]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise FileNotFoundError(f"{filename} not found")


def _surfaces(
    geometry: Any, colour: tuple[int, int, int] | None, package_dirs: Sequence[str | Path], folder: Path
) -> Iterator[Surface]:
    for element in geometry:
        if element.tag == "mesh":
            scale = np.array([float(x) for x in element.get("scale", "1 1 1").split()]) * np.ones(3)
            for surface, own in _load(resolve(element.get("filename", ""), package_dirs, folder)):
                scaled = surface.moved(np.diag([*scale, 1.0]))
                yield scaled if own or colour is None else _painted(scaled.vertices, scaled.faces, colour)
        elif (shape := _primitive(element)) is not None:
            yield _painted(np.asarray(shape.vertices), np.asarray(shape.faces), colour or PLAIN)


def _primitive(element: Any) -> Any:
    from trimesh import creation

    def value(name: str) -> float:
        return float(element.get(name, "0"))

    if element.tag == "box":
        return creation.box(extents=[float(x) for x in element.get("size", "").split()])
    if element.tag == "sphere":
        return creation.icosphere(subdivisions=3, radius=value("radius"))
    if element.tag == "cylinder":
        return creation.cylinder(radius=value("radius"), height=value("length"), sections=48)
    if element.tag == "capsule":
        return creation.capsule(radius=value("radius"), height=value("length"), count=[24, 32])
    return None


def _painted(vertices: Array, faces: IntArray, colour: tuple[int, int, int]) -> Surface:
    return Surface(vertices, faces, np.tile(np.array(colour, dtype=np.uint8), (len(faces), 1)))


@lru_cache(maxsize=64)
def _load(path: Path) -> tuple[tuple[Surface, bool], ...]:
    """The meshes of a file, with the file's own scene transforms applied, and whether each carries its own colours."""
    import trimesh

    try:
        scene = trimesh.load_scene(path)
    except Exception as error:  # trimesh lets through whatever its format readers raise
        raise ValueError(f"{path.name} cannot be read as a mesh ({type(error).__name__})") from error
    found = []
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
            continue
        colours = _own_colours(mesh)
        faces = np.asarray(mesh.faces, dtype=np.int64)
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        surface = _painted(vertices, faces, PLAIN) if colours is None else Surface(vertices, faces, colours)
        found.append((surface.moved(np.asarray(pose)), colours is not None))
    if not found:
        raise ValueError(f"{path.name} holds no triangles")
    return tuple(found)


def _own_colours(mesh: Any) -> Colours | None:
    visual = mesh.visual
    if not visual.defined:
        return None
    if visual.kind == "texture":
        material = visual.material
        if getattr(material, "image", None) is None and getattr(material, "baseColorTexture", None) is None:
            return np.tile(np.asarray(material.main_color, dtype=np.uint8)[:3], (len(mesh.faces), 1))
        corner = np.asarray(visual.to_color().vertex_colors)[np.asarray(mesh.faces), :3]
        return np.asarray(corner.mean(axis=1), dtype=np.uint8)
    return np.asarray(visual.face_colors, dtype=np.uint8)[:, :3]


def _colour(material: Any) -> tuple[int, int, int] | None:
    colour = material.find("color")
    if colour is None:
        return None
    red, green, blue = (round(255 * min(max(float(x), 0.0), 1.0)) for x in colour.get("rgba", "1 1 1 1").split()[:3])
    return red, green, blue


def _origin(origin: Any) -> Array:
    """Homogeneous transform of an `<origin>`: roll, pitch, yaw about fixed axes, then the translation."""
    from scipy.spatial.transform import Rotation

    pose = np.eye(4)
    if origin is not None:
        pose[:3, :3] = Rotation.from_euler("xyz", [float(x) for x in origin.get("rpy", "0 0 0").split()]).as_matrix()
        pose[:3, 3] = [float(x) for x in origin.get("xyz", "0 0 0").split()]
    return pose
