"""Fewer triangles that still look the same: vertices of a small cell become one, the shading stays the fine mesh's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from asmc_pin._typing import Array, IntArray
from asmc_pin.viewer.drawing.surface import Colours, Surface

CREASE = np.radians(38.0)
"""Faces that meet at a larger angle keep an edge between them; below it the shading runs round."""


@dataclass(frozen=True)
class Shaded:
    """Triangles ready to be drawn.

    Attributes:
        vertices: Shape (n, 3), m.
        normals: Unit normals of the vertices in 1/127, shape (n, 3).
        colours: RGB of the vertices, shape (n, 3).
        faces: Shape (m, 3).
    """

    vertices: Array
    normals: npt.NDArray[np.int8]
    colours: Colours
    faces: IntArray


_STEP = 1.2
"""Ratio of the cell sizes that are tried."""

Clustered = tuple[Array, IntArray, IntArray]


def simplify(surfaces: Sequence[Surface], budget: int, finest: float = 2e-4) -> list[Shaded]:
    """Clusters the vertices of several surfaces in the smallest cells that keep them within a budget.

    One cell size serves all of them, so that an arm looks equally fine everywhere.

    Args:
        surfaces: What to simplify.
        budget: Triangles in total that may remain.
        finest: Edge of the smallest cell, m.

    Returns:
        One shaded surface for each given.
    """
    clustered = _clusters(surfaces, finest)
    coarse, fine = 0, -1
    while _count(clustered) > budget:  # some arm's cells will do: at the latest those as large as the arm
        coarse, fine = 2 * coarse + 4, coarse
        clustered = _clusters(surfaces, finest * _STEP**coarse)
    while coarse - fine > 1:
        middle = (coarse + fine) // 2
        trial = _clusters(surfaces, finest * _STEP**middle)
        if _count(trial) <= budget:
            coarse, clustered = middle, trial
        else:
            fine = middle
    return [
        _shade(surface, *parts)
        if len(surface.faces)
        else Shaded(surface.vertices, np.empty((0, 3), dtype=np.int8), surface.colours, surface.faces)
        for surface, parts in zip(surfaces, clustered, strict=True)
    ]


def _clusters(surfaces: Sequence[Surface], cell: float) -> list[Clustered]:
    return [_cluster(surface, cell) for surface in surfaces]


def _count(clustered: Sequence[Clustered]) -> int:
    return sum(len(kept) for _, _, kept in clustered)


def _cluster(surface: Surface, cell: float) -> Clustered:
    """Clusters the corners of the triangles; those of different colours stay apart, which keeps colours' borders clean.

    Returns:
        Centres of the clusters, the cluster of each triangle's corners, and the triangles that span three clusters.
    """
    corners = surface.faces.ravel()
    if not len(corners):
        return surface.vertices, surface.faces, np.empty(0, dtype=np.int64)
    points = surface.vertices[corners]
    grid = np.floor((points - points.min(axis=0)) / cell + 0.5).astype(np.int64)
    size = grid.max(axis=0) + 1
    _, paint = np.unique(surface.colours @ np.array([1, 256, 65536]), return_inverse=True)
    key = ((np.repeat(paint, 3) * size[0] + grid[:, 0]) * size[1] + grid[:, 1]) * size[2] + grid[:, 2]
    _, cells = np.unique(key, return_inverse=True)
    count = np.bincount(cells)
    centres = np.stack([np.bincount(cells, points[:, k]) / count for k in range(3)], axis=1)
    clusters = cells.reshape(-1, 3)
    low, middle, high = np.sort(clusters, axis=1).T
    kept = np.flatnonzero((low != middle) & (middle != high))
    # Of triangles that now coincide, the first stays: twins would flicker.
    total = len(centres)
    _, first = np.unique((low[kept] * total + middle[kept]) * total + high[kept], return_index=True)
    return centres, clusters, kept[np.sort(first)]


def _shade(surface: Surface, centres: Array, clusters: IntArray, kept: IntArray) -> Shaded:
    triangles = surface.vertices[surface.faces[kept]]
    area = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(area, axis=1, keepdims=True)
    direction = np.divide(area, length, out=np.zeros_like(area), where=length > 0)
    corners = clusters[kept].ravel()
    face = np.repeat(np.arange(len(kept)), 3)
    # The normal of a corner: the area-weighted mean over the triangles of its cell that lie within the crease angle.
    order = np.argsort(corners, kind="stable")
    count = np.bincount(corners[order], minlength=len(centres))
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    partners = count[corners]
    mine = np.repeat(np.arange(len(corners)), partners)
    offset = np.arange(partners.sum()) - np.repeat(np.cumsum(partners) - partners, partners)
    theirs = order[start[corners[mine]] + offset]
    close = np.einsum("ij,ij->i", direction[face[mine]], direction[face[theirs]]) > np.cos(CREASE)
    mine, theirs = mine[close], theirs[close]
    total = np.stack([np.bincount(mine, area[face[theirs], k], len(corners)) for k in range(3)], axis=1)
    norm = np.linalg.norm(total, axis=1, keepdims=True)
    normal = np.divide(total, norm, out=direction[face], where=norm > 0)
    normals = np.rint(127 * normal).astype(np.int8)
    key = np.concatenate(
        [corners[:, None], normals.astype(np.int64), surface.colours[kept][face].astype(np.int64)], axis=1
    )
    unique, index = np.unique(key, axis=0, return_inverse=True)
    return Shaded(
        centres[unique[:, 0]], unique[:, 1:4].astype(np.int8), unique[:, 4:].astype(np.uint8), index.reshape(-1, 3)
    )
