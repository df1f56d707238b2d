"""What a compiled proof reads and works in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from asmc_pin._typing import Array, BoolArray, IntArray


class Problem(NamedTuple):
    """A statement "this quadratic form of joint and link velocities is positive for all q", in compiled form.

    Attributes:
        parent: Shape (n,); −1 for the base.
        slides: Prismatic, shape (n,).
        place: Motion transform from the parent's frame to the joint's at q = 0, z along the axis, shape (n, 6, 6).
        rigid: Spatial inertias in the joints' frames, shape (n, 6, 6).
        link: Forms of the links, shape (n, m, m).
        motion: How the joint's velocities enter the p twists, shape (n, p, e).
        joint: The joints' own forms, shape (n, e, e).
        lower: Box, shape (n,).
        upper: Box, shape (n,).
        exact: Whether joint 1 is followed exactly by `first_joints`.
        spread: Share of the rigid metric in the metric of losses.
    """

    parent: IntArray
    slides: BoolArray
    place: Array
    rigid: Array
    link: Array
    motion: Array
    joint: Array
    lower: Array
    upper: Array
    exact: bool
    spread: float


class Scratch(NamedTuple):
    """Workspace of one thread."""

    A: Array
    saved: Array
    F: Array
    size: Array
    saved_size: Array
    U: Array
    D: Array
    Ua: Array
    Da: Array
    Fc: Array
    K: Array
    composite: Array
    rigid: Array
    compliance: Array
    twist: Array
    basis: Array
    inverse: Array
    metric: Array
    work: Array
    rows: Array
    C: Array
    stack: Array
    angle: Array
    side: IntArray
    kept: Array
    six: Array
    line: Array


@njit(cache=True, nogil=True, error_model="numpy")
def scratch(n: int, m: int, e: int) -> Scratch:
    """Workspace for n joints, forms of m rows, e velocities per joint."""
    return Scratch(
        np.zeros((n, m, m)),
        np.zeros((n, m, m)),
        np.zeros((n, m, m)),
        np.zeros((n, m)),
        np.zeros((n, m)),
        np.zeros((n, e, m)),
        np.zeros((n, e, e)),
        np.zeros((e, m)),
        np.zeros((e, e)),
        np.zeros((n, m, m)),
        np.zeros((n, m, m)),
        np.zeros((n, 6, 6)),
        np.zeros((n, 6, 6)),
        np.zeros((n, m, m)),
        np.zeros((n, m)),
        np.zeros((n, m, m)),
        np.zeros((n, m, m)),
        np.zeros((n, m, m)),
        np.zeros((10, m, m)),
        np.zeros((6, m)),
        np.zeros((5, e, e)),
        np.zeros((64, 4)),
        np.zeros((n, 6)),
        np.zeros(n, dtype=np.int64),
        np.zeros((n, m)),
        np.zeros((4, 6, 6)),
        np.zeros((4, 6)),
    )
