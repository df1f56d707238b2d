"""Joint motions as the page's player takes them: few enough frames to be mailed, enough to look continuous."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.errors import ParameterError
from asmc_pin.viewer.drawing.drawn_bodies import DrawnArm
from asmc_pin.viewer.meshcat_commands import mesh_command
from asmc_pin.viewer.stage import stage
from asmc_pin.viewer.time_marks import TimeMark

FRAMES = 6000
"""Frames at most: 100 s at 60 per second; longer motions get fewer per second."""


@dataclass(frozen=True)
class PlayedMotion:
    """The motion of one arm.

    Attributes:
        label: What stands under the arm.
        colour: CSS colour of its label and path, ``#rrggbb``, the one it has in the figures.
        q: Joint positions over time, shape (T, nv), rad or m; NaN after a divergence.
        end: Time at which the motion broke off, s; None where it did not.
        shades: Colour of the arm and of its path over time, red, green and blue from 0 to 1, shape (T, 3); None leaves
            the arm its own.
        torque: Torques over their limits, ±1 at the limit, shape (T, nv): arcs at the joints show them; None for none.
        reading: A figure over time to stand under the arm, with its name; values of shape (T,).
    """

    label: str
    colour: str
    q: Array
    end: float | None = None
    shades: Array | None = None
    torque: Array | None = None
    reading: tuple[str, Array] | None = None


def describe(
    arm: DrawnArm,
    joint_names: Sequence[str],
    time: Array,
    motions: Sequence[PlayedMotion],
    reference: Array | None,
    fps: float = 60.0,
    marks: Sequence[TimeMark] = (),
) -> dict[str, Any]:
    """What the player needs, ready for JSON: the arm's bodies, Meshcat's packed commands, and the motions.

    Args:
        arm: The arm that all motions share.
        joint_names: Its joints.
        time: Instants, increasing from 0, shape (T,), s.
        motions: At least one.
        reference: Where the joints should be, shape (T, nv); None for no ghost.
        fps: Frames per second kept, at most.
        marks: What happens on the way, in the order of time.
    """
    if not motions:
        raise ParameterError("motions", "none given; at least one is needed")
    for motion in motions:
        if motion.q.shape != (len(time), len(joint_names)):
            expected = (len(time), len(joint_names))
            raise ParameterError("q", f"the motion '{motion.label}' has shape {motion.q.shape}, expected {expected}")
    duration = float(time[-1])
    grid = np.linspace(0.0, duration, max(2, min(round(duration * fps), FRAMES) + 1)) if duration > 0 else time[:1]
    frames = [_resample(time, motion.q, grid) for motion in motions]
    wanted = None if reference is None else _resample(time, reference, grid)
    drawn = (*arm.bodies, *arm.marks)
    around = stage(arm, [*frames, *([] if wanted is None else [wanted])])
    return {
        "arm": {
            "name": arm.name,
            "bodies": [
                {
                    "parent": body.parent,
                    "joint": body.joint,
                    "ratio": body.ratio,
                    "offset": body.offset,
                    "prismatic": body.prismatic,
                    "axis": _rounded(body.axis),
                    "placement": _rounded(body.placement.T),
                }
                for body in drawn
            ],
            "upright": _rounded(arm.upright.T),
            "tip": {"body": arm.tip[0], "point": _rounded(arm.tip[1])},
        },
        "commands": [
            mesh_command(f"body{k}", body.mesh, body.opacity) if len(body.mesh.faces) else None
            for k, body in enumerate(drawn)
        ],
        "joints": [{"name": name, "prismatic": slides} for name, slides in zip(joint_names, arm.slides, strict=True)],
        "duration": duration,
        "marks": [asdict(mark) for mark in marks],
        "motions": [
            {
                "label": motion.label,
                "colour": motion.colour,
                "q": _packed(q),
                "end": motion.end,
                **_shown(motion, time, grid),
            }
            for motion, q in zip(motions, frames, strict=True)
        ],
        "reference": None if wanted is None else _packed(wanted),
        "stage": {
            "low": _rounded(around.low),
            "high": _rounded(around.high),
            "ground": around.ground,
            "outline": [_rounded(point) for point in around.outline],
            "centre": _rounded(around.centre),
            "radius": around.radius,
            "azimuth": around.azimuth,
            "pedestal": around.pedestal,
        },
    }


def _resample(time: Array, q: Array, grid: Array) -> Array:
    """Joint positions at the grid's instants; after the last finite one they stay, as the drawn arm does."""
    finite = np.isfinite(q).all(axis=1)
    last = len(time) if finite.all() else max(1, int(np.argmin(finite)))
    known = np.nan_to_num(q[:last])
    return np.stack([np.interp(grid, time[:last], known[:, joint]) for joint in range(q.shape[1])], axis=1)


def _shown(motion: PlayedMotion, time: Array, grid: Array) -> dict[str, Any]:
    """What a motion shows beside itself, at the grid's instants; nothing for most."""
    shown: dict[str, Any] = {}
    if motion.shades is not None:
        shown["shades"] = _packed(_resample(time, np.asarray(motion.shades, dtype=np.float64), grid))
    if motion.torque is not None:
        shown["torque"] = base64.b64encode(_largest(time, motion.torque, grid).tobytes()).decode()
    if motion.reading is not None:
        name, values = motion.reading
        shown["reading"] = {"name": name, "values": _packed(np.interp(grid, time, values))}
    return shown


def _largest(time: Array, torque: Array, grid: Array) -> IntArray:
    """The largest torque of each frame's ticks, in 127ths of the limit; 127 at the limit alone. Shape (frames, nv).

    A drive that stands at its limit for a tick is not lost between two frames.
    """
    shares = np.nan_to_num(torque)
    begins = np.searchsorted(time, grid - 0.5 * (grid[1] - grid[0] if len(grid) > 1 else 0.0)).clip(0, len(time) - 1)
    large, small = np.maximum.reduceat(shares, begins, axis=0), np.minimum.reduceat(shares, begins, axis=0)
    of_frame = np.where(large >= -small, large, small)
    full = np.abs(of_frame) >= 1.0 - 1e-9
    return np.where(full, 127 * np.sign(of_frame), np.clip(np.trunc(127.0 * of_frame), -126, 126)).astype(np.int8)


def _packed(values: Array) -> str:
    return base64.b64encode(values.astype("<f4").tobytes()).decode()


def _rounded(values: Array) -> list[float]:
    # Nanometres; what lies below is the noise of the arithmetic. Adding 0 turns -0 into 0.
    return [float(value) + 0.0 for value in np.round(values, 9).ravel()]
