"""Whether links of an arm collide at a configuration, by the shapes that its URDF gives them for that; coal lives here.

Links that a joint connects overlap by design and are not looked at, nor those that touch wherever the arm is.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import coal
import numpy as np
from scipy.stats import qmc

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import Box
from asmc_pin.viewer.drawing.drawn_bodies import attachments
from asmc_pin.viewer.drawing.surface import Surface, join
from asmc_pin.viewer.drawing.visuals import read_visuals
from asmc_pin.words.text import quoted

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_EVERYWHERE = 64
"""Configurations at all of which a pair touches that is taken to touch everywhere."""


@dataclass(frozen=True)
class CollisionAnswer:
    """What is known of one configuration.

    Attributes:
        known: Whether anything is.
        pairs: Links that collide, by name.
        text: The same in words.
    """

    known: bool
    pairs: tuple[tuple[str, str], ...]
    text: str


class LinkCollisions:
    """The collision shapes of an arm, ready to be asked about; several threads may ask at once."""

    def __init__(self, arm: Arm, box: Box) -> None:
        """Read the shapes.

        Args:
            arm: The arm.
            box: Where pairs that touch everywhere are looked for.
        """
        shown, problems = read_visuals(arm.urdf_text, arm.files, "collision")
        self._arm = arm
        self._shapes = {link: _shape(join(surfaces)) for link, surfaces in shown.items() if link in arm.link_names}
        self._unread = tuple(link for link in problems if link in arm.link_names)
        self._place = {link: number for number, link in enumerate(arm.link_names)}
        body = {link: number for link, number, _ in attachments(arm)}
        above = {number + 1: int(before) + 1 for number, before in enumerate(arm.tree.parent)}
        self._pairs = [
            (one, other)
            for one, other in combinations(self._shapes, 2)
            if body[one] != body[other] and above.get(body[one]) != body[other] and above.get(body[other]) != body[one]
        ]
        self.always = self._touching_everywhere(box)
        self._pairs = [pair for pair in self._pairs if pair not in self.always]

    def at(self, q: Array) -> CollisionAnswer:
        """What collides at a configuration, shape (nv,)."""
        if not self._pairs:
            why = (
                "no two links that could meet have shapes in the URDF"
                if self._shapes
                else (
                    "its collision shapes could not be read" if self._unread else "the URDF gives no collision shapes"
                )
            )
            return CollisionAnswer(False, (), f"Whether links collide is not known: {why}.")
        pairs = tuple(self._colliding(q))
        if pairs:
            text = "Links collide here: " + "; ".join(f"{quoted(a)} and {quoted(b)}" for a, b in pairs) + "."
        else:
            text = "No links collide here."
        return CollisionAnswer(True, pairs, f"{text} {self._proviso()}")

    def _proviso(self) -> str:
        said = "By the surfaces that the URDF gives for collisions; links that a joint connects are not looked at"
        if self.always:
            said += ", nor " + "; ".join(f"{quoted(a)} and {quoted(b)}" for a, b in self.always)
            said += f", which touch at each of {_EVERYWHERE} configurations tried"
        if self._unread:
            said += f"; not all shapes could be read: {', '.join(map(quoted, self._unread))}"
        return f"{said}."

    def _colliding(self, q: Array) -> list[tuple[str, str]]:
        poses = self._arm.link_poses(q)
        at = {link: coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy()) for link, pose in self._posed(poses)}
        request = coal.CollisionRequest()
        found = []
        for one, other in self._pairs:
            result = coal.CollisionResult()
            if coal.collide(self._shapes[one], at[one], self._shapes[other], at[other], request, result):
                found.append((one, other))
        return found

    def _posed(self, poses: Array) -> list[tuple[str, Array]]:
        return [(link, poses[self._place[link]]) for link in self._shapes]

    def _touching_everywhere(self, box: Box) -> tuple[tuple[str, str], ...]:
        sobol = qmc.Sobol(self._arm.nv, seed=0).random(_EVERYWHERE)
        left, pairs = set(self._pairs), self._pairs
        for q in box.lower + sobol * (box.upper - box.lower):
            if not left:
                break
            self._pairs = [pair for pair in pairs if pair in left]
            left &= set(self._colliding(q))
        self._pairs = pairs
        return tuple(pair for pair in pairs if pair in left)


def _shape(surface: Surface) -> coal.BVHModelOBBRSS:
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(surface.faces), len(surface.vertices))
    model.addVertices(np.ascontiguousarray(surface.vertices))
    model.addTriangles(np.ascontiguousarray(surface.faces))
    model.endModel()
    return model
