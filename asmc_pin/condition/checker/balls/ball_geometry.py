"""Vectors and rotations in balls: each encloses what the decimals, or any numbers in the balls, come to."""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, arb_mat

from asmc_pin.condition.checker.reading.urdf_text import Decimals, Pose


def unit() -> arb_mat:
    """The unit matrix, 3 × 3."""
    return arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, 1]])


def zero() -> arb_mat:
    """The zero vector, 3 × 1."""
    return arb_mat(3, 1)


def still() -> tuple[arb_mat, arb_mat]:
    """No rotation and no translation."""
    return unit(), zero()


def column(values: Decimals) -> arb_mat:
    """Decimals as a vector."""
    return arb_mat(len(values), 1, [arb(x) for x in values])


def dot(a: arb_mat, b: arb_mat) -> arb:
    """aᵀ b."""
    return (a.transpose() * b)[0, 0]


def cross(a: arb_mat, b: arb_mat) -> arb_mat:
    """A × b."""
    (x, y, z), (u, v, w) = ([m[k, 0] for k in range(3)] for m in (a, b))
    return arb_mat(3, 1, [y * w - z * v, z * u - x * w, x * v - y * u])


def symmetric(entries: Sequence[arb]) -> arb_mat:
    """The symmetric matrix of xx, xy, xz, yy, yz, zz."""
    xx, xy, xz, yy, yz, zz = entries
    return arb_mat([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def normalised(axis: Decimals) -> arb_mat:
    """The unit vector along an axis that is not zero."""
    vector = column(axis)
    return vector * (1 / dot(vector, vector).sqrt())


def about(axis: arb_mat, angle: arb) -> arb_mat:
    """Rotation about a unit axis (Rodrigues)."""
    x, y, z = (axis[k, 0] for k in range(3))
    K = arb_mat([[arb(0), -z, y], [z, arb(0), -x], [-y, x, arb(0)]])
    return unit() + K * angle.sin() + K * K * (2 * (angle / 2).sin() ** 2)


def rotation(pose: Pose) -> arb_mat:
    """Roll about x, then pitch about y, then yaw about z, all fixed axes."""
    roll, pitch, yaw = (arb(x) for x in pose.rpy)
    z, y, x = (column(axis) for axis in (("0", "0", "1"), ("0", "1", "0"), ("1", "0", "0")))
    return about(z, yaw) * about(y, pitch) * about(x, roll)
