"""Coloured triangles, the form in which everything is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

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


def painted(vertices: Array, faces: IntArray, colour: tuple[int, int, int]) -> Surface:
    """Triangles of one colour."""
    return Surface(vertices, faces, np.tile(np.array(colour, dtype=np.uint8), (len(faces), 1)))
