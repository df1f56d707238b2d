"""Mesh files, read within bounds."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.disk.reading import check_file
from asmc_pin.errors import AsmcPinError
from asmc_pin.viewer.drawing.surface import PLAIN, Colours, Surface, painted
from asmc_pin.words.text import printable

_LARGEST = 200_000_000


@lru_cache(maxsize=64)
def load_mesh(path: Path) -> tuple[tuple[Surface, bool], ...]:
    """The meshes of a file, with the file's own scene transforms applied, and whether each carries its own colours.

    Raises:
        ValueError: It cannot be read, or holds nothing to draw.
    """
    import trimesh

    name = printable(path.name)
    try:
        check_file(path, _LARGEST, "a mesh", lambda message: AsmcPinError(message))
        scene = trimesh.load_scene(path)
        found = [_mesh(scene, node) for node in scene.graph.nodes_geometry]
    except AsmcPinError as error:
        raise ValueError(str(error)) from None
    except Exception as error:  # trimesh lets through whatever its format readers raise
        raise ValueError(f"{name} cannot be read as a mesh ({type(error).__name__})") from error
    drawn = tuple(item for item in found if item is not None)
    if not drawn:
        raise ValueError(f"{name} holds no triangles")
    return drawn


def _mesh(scene: Any, node: Any) -> tuple[Surface, bool] | None:
    import trimesh

    pose, name = scene.graph[node]
    mesh = scene.geometry[name]
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        return None
    faces = np.asarray(mesh.faces, dtype=np.int64)
    vertices: Array = np.asarray(mesh.vertices, dtype=np.float64)
    if faces.min() < 0 or faces.max() >= len(vertices) or not np.isfinite(vertices).all():
        raise ValueError("its triangles have corners that are nowhere")
    colours = _own_colours(mesh, faces)
    surface = painted(vertices, faces, PLAIN) if colours is None else Surface(vertices, faces, colours)
    return surface.moved(np.asarray(pose)), colours is not None


def _own_colours(mesh: Any, faces: IntArray) -> Colours | None:
    """Colours of the triangles, None where the file has none, or none that can be read."""
    visual = mesh.visual
    if not visual.defined:
        return None
    try:
        if visual.kind != "texture":
            colours = np.asarray(visual.face_colors, dtype=np.uint8)[:, :3]
        elif _is_plain(visual.material):
            colours = np.tile(np.asarray(visual.material.main_color, dtype=np.uint8)[:3], (len(faces), 1))
        else:
            corner = np.asarray(visual.to_color().vertex_colors)[faces, :3]
            colours = np.asarray(corner.mean(axis=1), dtype=np.uint8)
    except Exception:  # a texture that is missing, damaged or endless
        return None
    return colours if colours.shape == (len(faces), 3) else None


def _is_plain(material: Any) -> bool:
    return getattr(material, "image", None) is None and getattr(material, "baseColorTexture", None) is None
