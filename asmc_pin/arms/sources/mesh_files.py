"""Mesh files, read within bounds: the triangles of a file with the transforms of its own scene."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.disk.reading import check_file
from asmc_pin.errors import AsmcPinError
from asmc_pin.words.text import printable

_LARGEST = 200_000_000


@lru_cache(maxsize=64)
def placed_meshes(path: Path) -> tuple[tuple[Any, Array], ...]:
    """The meshes of a file, each with its pose, shape (4, 4), in the file's frame.

    Raises:
        ValueError: It cannot be read, or holds no triangles.
    """
    import trimesh

    name = printable(path.name)
    try:
        check_file(path, _LARGEST, "a mesh", lambda message: AsmcPinError(message))
        scene = trimesh.load_scene(path)
        found = [_placed(scene, node) for node in scene.graph.nodes_geometry]
    except AsmcPinError as error:
        raise ValueError(str(error)) from None
    except Exception as error:  # trimesh lets through whatever its format readers raise
        raise ValueError(f"{name} cannot be read as a mesh ({type(error).__name__})") from error
    triangles = tuple(item for item in found if item is not None)
    if not triangles:
        raise ValueError(f"{name} holds no triangles")
    return triangles


def _placed(scene: Any, node: Any) -> tuple[Any, Array] | None:
    import trimesh

    pose, name = scene.graph[node]
    mesh = scene.geometry[name]
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        return None
    faces, vertices = np.asarray(mesh.faces), np.asarray(mesh.vertices, dtype=np.float64)
    if faces.min() < 0 or faces.max() >= len(vertices) or not np.isfinite(vertices).all():
        raise ValueError("its triangles have corners that are nowhere")
    return mesh, np.asarray(pose, dtype=np.float64)
