"""An arm as the viewer draws it: one rigid body per joint, and the base, each with all that moves with it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.viewer.drawing.mesh_simplify import Shaded, simplify
from asmc_pin.viewer.drawing.skeleton import skeleton
from asmc_pin.viewer.drawing.surface import Surface, join
from asmc_pin.viewer.drawing.visuals import read_visuals

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

TRIANGLES = 60_000
"""Triangles an arm may have: as fine as a screen shows, in about a megabyte of page."""


Frame = tuple[int, Array, Array, bool]
"""Parent body, placement in it, axis, whether it slides along it."""


class DrawingWarning(UserWarning):
    """A picture of an arm lacks something."""


@dataclass(frozen=True)
class DrawnBody:
    """What moves with one joint, or stands with the base.

    Attributes:
        parent: Index of the body it hangs on; -1 for the base, which is body 0.
        placement: Pose of the joint's frame in the parent's frame at q = 0, shape (4, 4).
        joint: Index of the coordinate that moves it, -1 for the base.
        axis: Joint axis in the joint's frame, shape (3,).
        prismatic: It slides along the axis rather than turning about it.
        mesh: What is drawn, in the joint's frame.
        ratio: How far the joint goes for one of the coordinate; 1 unless it mimics another.
        offset: Where it is while the coordinate is 0, rad or m.
        opacity: 1 where nothing behind it is seen.
    """

    parent: int
    placement: Array
    joint: int
    axis: Array
    prismatic: bool
    mesh: Shaded
    ratio: float = 1.0
    offset: float = 0.0
    opacity: float = 1.0


@dataclass(frozen=True)
class DrawnArm:
    """An arm ready to be drawn.

    Attributes:
        name: The arm's name.
        bodies: The base first, then one per joint that moves, mimicking ones included.
        slides: Whether each coordinate's own joint slides.
        upright: Rotation that turns the arm's gravity downwards, shape (4, 4): an arm under a ceiling hangs.
        tip: DrawnBody and point in its frame, m, whose path is drawn.
        notes: What a person should know of the picture, such as missing meshes.
        marks: What is drawn besides and stands still in some body, see `with_marks`.
    """

    name: str
    bodies: tuple[DrawnBody, ...]
    slides: tuple[bool, ...]
    upright: Array
    tip: tuple[int, Array]
    notes: tuple[str, ...]
    marks: tuple[DrawnBody, ...] = ()

    def poses(self, q: Array) -> Array:
        """Poses of the bodies in the base frame. Shape of q (..., nv); of the result (..., bodies, 4, 4)."""
        moving = self.bodies[1:]
        ratio, offset = np.array([body.ratio for body in moving]), np.array([body.offset for body in moving])
        q = ratio * q[..., [body.joint for body in moving]] + offset
        return body_poses([(body.parent, body.placement, body.axis, body.prismatic) for body in self.bodies], q)


def draw(arm: Arm, triangles: int = TRIANGLES) -> DrawnArm:
    """Prepares an arm for the viewer.

    A body whose meshes are all missing, or that declares none, is drawn as cylinders between its joints.

    Args:
        arm: The arm.
        triangles: Triangles it may have in all.
    """
    parts = assemble(arm)
    meshes = simplify([join(surfaces) for surfaces in parts.surfaces], triangles)
    bodies = tuple(
        DrawnBody(parent, placement, joint, axis, prismatic, mesh, ratio, offset)
        for (parent, placement, axis, prismatic), mesh, (joint, ratio, offset) in zip(
            parts.frames, meshes, _moved_by(arm), strict=True
        )
    )
    slides = tuple(kind == "prismatic" for kind in arm.joint_kinds)
    return DrawnArm(arm.name, bodies, slides, _upright(arm.gravity_vector), (arm.tree.joints, parts.tip), parts.notes)


def _moved_by(arm: Arm) -> list[tuple[int, float, float]]:
    """Coordinate, ratio and offset of every body, the base first."""
    coupling = arm.tree.coupling
    parts = (coupling.coordinate, coupling.ratio, coupling.offset)
    return [(-1, 1.0, 0.0), *zip(*(part.tolist() for part in parts), strict=True)]


@dataclass(frozen=True)
class Parts:
    """What an arm is drawn from, as fine as its files are.

    Attributes:
        frames: Of every body, the base first.
        surfaces: What hangs on each body, in its frame.
        tip: The arm's tip in the last body's frame, m.
        notes: What a person should know of the picture.
    """

    frames: tuple[Frame, ...]
    surfaces: tuple[list[Surface], ...]
    tip: Array
    notes: tuple[str, ...]


def assemble(arm: Arm) -> Parts:
    """Reads an arm's visuals and hangs them on its bodies, a skeleton where there are none."""
    shown, problems = read_visuals(arm.urdf_text, arm.files)
    frames = joint_frames(arm)
    surfaces: tuple[list[Surface], ...] = tuple([] for _ in range(arm.tree.joints + 1))
    last = arm.tree.joints
    tip = np.zeros(3)
    for link, body, pose in attachments(arm):
        surfaces[body].extend(surface.moved(pose) for surface in shown.get(link, ()))
        if body == last and np.linalg.norm(pose[:3, 3]) > np.linalg.norm(tip):
            tip = pose[:3, 3]
    if np.linalg.norm(tip) < 1e-6 and surfaces[last]:
        tip = _far_end(join(surfaces[last]))
    for body, stick in skeleton(frames, tip, _slides(arm)).items():
        if not surfaces[body]:
            surfaces[body].append(stick)
    notes = []
    if problems:
        texts = [text for found in problems.values() for text in found]
        more = f" (and {len(texts) - 1} more)" if len(texts) > 1 else ""
        notes.append(f"Not drawn as the URDF says: {texts[0]}{more}.")
        warnings.warn(f"{arm.name}: not drawn as its URDF says: {texts[0]}{more}", DrawingWarning, stacklevel=2)
    elif not shown:
        notes.append("The URDF has no visuals: the arm is drawn as a skeleton.")
    return Parts(frames, surfaces, tip, tuple(notes))


def _slides(arm: Arm) -> Array:
    """From where to where each body goes, the base first, rad or m; shape (2, bodies)."""
    coupling = arm.tree.coupling
    ends = [coupling.ratio * end[coupling.coordinate] + coupling.offset for end in (arm.lower, arm.upper)]
    return np.pad(np.sort(ends, axis=0), ((0, 0), (1, 0)))


def joint_frames(arm: Arm) -> tuple[Frame, ...]:
    """The bodies of an arm without what is drawn of them, the base first."""
    tree = arm.tree
    frames: list[Frame] = [(-1, np.eye(4), np.array([0.0, 0.0, 1.0]), False)]
    for joint in range(tree.joints):
        placement = np.eye(4)
        placement[:3, :3], placement[:3, 3] = tree.rotation[joint], tree.translation[joint]
        frames.append((int(tree.parent[joint]) + 1, placement, tree.axis[joint], bool(tree.prismatic[joint])))
    return tuple(frames)


def attachments(arm: Arm) -> list[tuple[str, int, Array]]:
    """Name of every link, the body it belongs to, and its pose there: the one body in whose frame it stands still."""
    # Angles without a pattern, so that no two joints cancel.
    q = np.stack([np.zeros(arm.nv), 0.7 + 0.31 * np.sin(1.0 + 2.0 * np.arange(arm.nv))])
    inverse = np.linalg.inv(body_poses(joint_frames(arm), arm.tree.coupling.joints(q)))
    relative = inverse[:, :, None] @ arm.link_poses(q)[:, None]
    change = np.abs(relative[1] - relative[0]).max(axis=(-2, -1))
    return [
        (name, int(np.argmin(change[:, link])), relative[0, np.argmin(change[:, link]), link])
        for link, name in enumerate(arm.link_names)
    ]


def _far_end(surface: Surface) -> Array:
    """The end of a body away from its joint: where no link marks the tip, what is drawn does."""
    distance = np.linalg.norm(surface.vertices, axis=1)
    return np.asarray(surface.vertices[distance > 0.95 * distance.max()].mean(axis=0))


def body_poses(frames: Sequence[Frame], q: Array) -> Array:
    """Poses of all bodies in the base frame, at the n joints' own values.

    Shape of q (..., n); of the result (..., n + 1, 4, 4).
    """
    found: list[Array] = []
    for index, (parent, placement, axis, prismatic) in enumerate(frames):
        if index == 0:
            found.append(np.broadcast_to(placement, (*q.shape[:-1], 4, 4)))
        else:
            found.append(found[parent] @ placement @ _motion(axis, prismatic, q[..., index - 1]))
    return np.stack(found, axis=-3)


def _motion(axis: Array, prismatic: bool, q: Array) -> Array:
    moved = np.zeros((*q.shape, 4, 4))
    moved[..., range(4), range(4)] = 1.0
    if prismatic:
        moved[..., :3, 3] = q[..., None] * axis
        return moved
    from scipy.spatial.transform import Rotation

    moved[..., :3, :3] = Rotation.from_rotvec(q.reshape(-1, 1) * axis).as_matrix().reshape(*q.shape, 3, 3)
    return moved


def _upright(gravity: Array) -> Array:
    from scipy.spatial.transform import Rotation

    upright = np.eye(4)
    strength = np.linalg.norm(gravity)
    if strength > 0 and (down := gravity / strength)[2] > -1 + 1e-12:
        # Upside down, any horizontal axis would do; the x axis is taken, so that the result is defined.
        turn = (
            Rotation.from_euler("x", np.pi) if down[2] > 1 - 1e-12 else Rotation.align_vectors([[0, 0, -1]], [down])[0]
        )
        upright[:3, :3] = turn.as_matrix()
    return upright
