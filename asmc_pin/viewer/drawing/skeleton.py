"""An arm without meshes: drums at the joints, rods between them, and rails where they slide."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.viewer.drawing.surface import Surface, join

ROD = (148, 156, 168)
DRUM = (72, 80, 94)


def skeleton(frames: Sequence[tuple[int, Array, Array, bool]], tip: Array, slides: Array) -> dict[int, Surface]:
    """A stick figure of every body.

    Args:
        frames: Parent, placement in it (4, 4), axis (3,), and whether it slides, of every body, the base first.
        tip: The arm's tip in the last body's frame, m.
        slides: From where to where each body slides, m, shape (2, bodies); not finite where it has no ends.

    Returns:
        Surfaces by body, in the bodies' frames.
    """
    lengths = [float(np.linalg.norm(placement[:3, 3])) for _, placement, _, _ in frames] + [float(np.linalg.norm(tip))]
    radius = 0.035 * (sum(lengths) or 1.0) ** 0.5 * max([*lengths, 0.05]) ** 0.5
    parts: dict[int, list[Surface]] = {body: [] for body in range(len(frames))}
    ends = [(parent, placement[:3, 3]) for parent, placement, _, _ in frames[1:]] + [(len(frames) - 1, tip)]
    for body, end in ends:
        if np.linalg.norm(end) > 1e-9:
            parts[body].append(rod(np.zeros(3), end, 0.55 * radius))
    for body, (parent, placement, axis, prismatic) in enumerate(frames):
        low, high = slides[:, body]
        if prismatic and 0.0 < high - low < np.inf:  # what slides would hang in the air
            start, end = (placement[:3, 3] + placement[:3, :3] @ axis * where for where in (low, high))
            parts[parent].append(rod(start, end, 0.3 * radius))
        reach = radius * (1.1 if prismatic else 1.5) * axis / np.linalg.norm(axis)
        parts[body].append(rod(-reach, reach, radius * (0.8 if prismatic else 1.0), DRUM))
    return {body: join(surfaces) for body, surfaces in parts.items()}


def rod(start: Array, end: Array, radius: float, colour: tuple[int, int, int] = ROD) -> Surface:
    """A round rod between two points, m."""
    from trimesh import creation

    made: Any = creation.cylinder(radius=radius, segment=np.stack([start, end]), sections=24)
    faces = np.asarray(made.faces, dtype=np.int64)
    return Surface(np.asarray(made.vertices), faces, np.tile(np.array(colour, dtype=np.uint8), (len(faces), 1)))
