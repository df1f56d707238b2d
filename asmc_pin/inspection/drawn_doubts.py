"""What the meshes say against the numbers; they are read for `inspect` alone, never on loading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from asmc_pin._typing import Array
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.inspection.subject_of_doubt import Doubt, SubjectOfDoubt, some
from asmc_pin.viewer import link_shapes

_MARGIN = 0.05
"""Of the size of what is drawn: a centre this far outside of it is not doubted."""


def drawn_doubts(subject: SubjectOfDoubt, files: RobotFiles) -> Iterator[Doubt]:
    """Doubts about meshes and where the centres of mass are in them.

    Args:
        subject: The robot.
        files: Where its meshes are looked for.
    """
    robot = subject.parts.robot
    points, problems = link_shapes(robot.text, files)
    missing = [name for name, texts in problems.items() if any("not found" in text for text in texts)]
    if missing:
        first = next(text for text in problems[missing[0]] if "not found" in text)
        text = f"meshes of {some(missing)} are missing, such as {first.partition(': ')[2].removesuffix('; left out')}"
        yield Doubt("meshes missing", tuple(missing), f"{text}; they are drawn as rods", serious=False)
    yield from _sizes(subject, points)
    yield from _centres(subject, points)


def _sizes(subject: SubjectOfDoubt, points: Mapping[str, Array]) -> Iterator[Doubt]:
    large = [name for name, drawn in points.items() if _size(drawn) > 20.0 * max(subject.reach, 0.05)]
    if large:
        text = f"what is drawn of {some(large)} is {_size(points[large[0]]):.3g} m large: meshes in millimetres?"
        yield Doubt("mesh unit", tuple(large), f'{text} scale="0.001 0.001 0.001"', serious=False)


def _centres(subject: SubjectOfDoubt, points: Mapping[str, Array]) -> Iterator[Doubt]:
    found = []
    for sized in subject.bodies:
        for link in sized.body.links:
            own, drawn = subject.parts.robot.inertials.get(link), points.get(link)
            if own is None or drawn is None or own.mass < 1e-3 * subject.mass:
                continue
            distance = _outside(drawn, own.com)
            if distance > _MARGIN * _size(drawn):
                found.append((link, distance))
    if found:
        names = [link for link, _ in found]
        worst, distance = max(found, key=lambda pair: pair[1])
        text = f"centre of mass outside of what is drawn of {some(names)}; of '{worst}' by {distance:.2g} m"
        yield Doubt("centre outside", tuple(names), text)


def _size(drawn: Array) -> float:
    return float(np.linalg.norm(np.ptp(drawn, axis=0)))


def _outside(drawn: Array, point: Array) -> float:
    """How far a point lies outside of the convex hull of what is drawn, m; of its box where it is flat."""
    try:
        hull = ConvexHull(drawn)
    except (QhullError, ValueError):
        beyond = np.maximum(np.maximum(drawn.min(axis=0) - point, point - drawn.max(axis=0)), 0.0)
        return float(np.linalg.norm(beyond))
    return float(np.max(hull.equations[:, :3] @ point + hull.equations[:, 3]))
