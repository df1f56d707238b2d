"""What is drawn of an arm besides itself: bodies of numbers, in the frames of the joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from asmc_pin.viewer.drawing.drawn_bodies import DrawnArm, DrawnBody
from asmc_pin.viewer.drawing.mesh_simplify import simplify
from asmc_pin.viewer.drawing.surface import Surface, painted


@dataclass(frozen=True, eq=False)
class Mark:
    """One thing to draw.

    Attributes:
        body: Index of the body in whose frame it stands still; the base is 0.
        surface: In that frame.
        opacity: 1 where nothing behind it is seen.
    """

    body: int
    surface: Surface
    opacity: float


def with_marks(arm: DrawnArm, marks: Sequence[Mark], opacity: float) -> DrawnArm:
    """The arm drawn with some opacity, and marks in it."""
    meshes = simplify([mark.surface for mark in marks], 40_000)
    drawn = tuple(
        DrawnBody(mark.body, np.eye(4), -1, np.array([0.0, 0.0, 1.0]), False, mesh, opacity=mark.opacity)
        for mark, mesh in zip(marks, meshes, strict=True)
    )
    return replace(arm, bodies=tuple(replace(body, opacity=opacity) for body in arm.bodies), marks=drawn)


def ball(radius: float, colour: tuple[int, int, int]) -> Surface:
    """A ball about the origin, m."""
    from trimesh import creation

    shape = creation.icosphere(subdivisions=3, radius=radius)
    return painted(np.asarray(shape.vertices), np.asarray(shape.faces), colour)
