"""Mesh files as surfaces with colours."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.arms.sources.mesh_files import placed_meshes
from asmc_pin.viewer.drawing.surface import PLAIN, Colours, Surface, painted


@lru_cache(maxsize=64)
def load_mesh(path: Path) -> tuple[tuple[Surface, bool], ...]:
    """The meshes of a file, with the file's own scene transforms applied, and whether each carries its own colours.

    Raises:
        ValueError: It cannot be read, or holds nothing to draw.
    """
    return tuple(_surface(mesh, pose) for mesh, pose in placed_meshes(path))


def _surface(mesh: Any, pose: Array) -> tuple[Surface, bool]:
    faces = np.asarray(mesh.faces, dtype=np.int64)
    vertices: Array = np.asarray(mesh.vertices, dtype=np.float64)
    colours = _own_colours(mesh, faces)
    surface = painted(vertices, faces, PLAIN) if colours is None else Surface(vertices, faces, colours)
    return surface.moved(pose), colours is not None


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
