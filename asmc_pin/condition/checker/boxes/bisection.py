"""The cells of a certificate: decoded from its record piece by piece, and counted exactly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, IntArray

Bytes = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]

_LEAF = 255
_DEEPEST = 60
_PIECE = 4096


class Broken(ValueError):
    """A record that is no complete bisection; the message says why."""


@dataclass(frozen=True, eq=False)
class Cells:
    """Leaves of a bisection: cell `index` of 2^`level` equal parts of each joint's range, both of shape (leaves, n)."""

    level: IntArray
    index: IntArray

    def boxes(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Centres and half widths, each (leaves, n); widened by more than their rounding."""
        part = (upper - lower) * np.exp2(-self.level.astype(np.float64))
        centre = lower + part * (self.index + 0.5)
        widened = 0.5 * part + np.where(upper > lower, 1e-14 * (np.abs(lower) + np.abs(upper)), 0.0)
        return centre, widened


def leaves(record: Bytes) -> int:
    """How many leaves a record has, whole or not."""
    return int(np.count_nonzero(record == _LEAF))


def by_branch(record: Bytes, parent: IntArray) -> Iterator[tuple[IntArray, Bytes]]:
    """Cut a record into those of the branches that hang on the base, each a bisection of its own joints' box.

    A record that has the leaves of a single bisection is one of all joints together, as they were written before
    branches were told apart, and is left whole.

    Args:
        record: One complete bisection after the other, the branch of the first joint first.
        parent: Index of each joint's parent, −1 for the base, shape (n,).

    Yields:
        A branch's joints, and its record in which these are numbered from 0.

    Raises:
        Broken: A record ends too soon, goes on too long, or halves a joint of another branch.
    """
    root: list[int] = []
    for i, before in enumerate(parent.tolist()):
        root.append(i if before < 0 else root[before])
    if leaves(record) == record.size - leaves(record) + 1:
        yield np.arange(len(root)), record
        return
    at = 0
    for first in sorted(set(root)):
        joints = np.flatnonzero(np.array(root) == first)
        found, at = one_bisection(record, at, joints)
        yield joints, found
    if at != record.size:
        raise Broken(f"the record goes on after its last box, at byte {at}")


def one_bisection(record: Bytes, at: int, names: IntArray) -> tuple[Bytes, int]:
    """One complete bisection out of a record, its joints numbered from 0; and where the next begins.

    Raises:
        Broken: It ends too soon, or halves what it is not about.
    """
    local = {int(name): number for number, name in enumerate(names)} | {_LEAF: _LEAF}
    found, still_open = bytearray(), 1
    while still_open:
        if at == record.size:
            raise Broken(f"the record ends with {still_open} boxes open")
        byte = int(record[at])
        if byte not in local:
            raise Broken(f"byte {at} of the record halves a joint that is not of its branch")
        found.append(local[byte])
        still_open += -1 if byte == _LEAF else 1
        at += 1
    return np.frombuffer(bytes(found), dtype=np.uint8), at


def cells(record: Bytes, joints: int) -> Iterator[Cells]:
    """Decode a record: preorder, a byte per node, the joint that is halved (lower half first) or 255 for a leaf.

    Args:
        record: The record.
        joints: Number of joints.

    Yields:
        Its leaves, some thousand at a time, so that memory does not grow with the record. All together they are the
        whole box, which their volumes, added up as integers, confirm in the end.

    Raises:
        Broken: Too short, too long, or halving what there is not.
    """
    stack = [((0,) * joints, (0,) * joints)]
    levels, indices = [], []
    most = _DEEPEST * joints
    volume = 0
    for at, byte in enumerate(record.tobytes()):
        if not stack:
            raise Broken(f"the record goes on after its last box, at byte {at}")
        level, index = stack.pop()
        if byte == _LEAF:
            levels.append(level)
            indices.append(index)
            volume += 1 << (most - sum(level))
            if len(levels) == _PIECE:
                yield Cells(np.array(levels, dtype=np.int64), np.array(indices, dtype=np.int64))
                levels, indices = [], []
            continue
        if byte >= joints or level[byte] >= _DEEPEST:
            raise Broken(f"byte {at} of the record halves a joint that is not there, or too often")
        deeper = (*level[:byte], level[byte] + 1, *level[byte + 1 :])
        low, high = 2 * index[byte], 2 * index[byte] + 1
        stack.append((deeper, (*index[:byte], high, *index[byte + 1 :])))
        stack.append((deeper, (*index[:byte], low, *index[byte + 1 :])))
    if stack:
        raise Broken(f"the record ends with {len(stack)} boxes open")
    if volume != 1 << most:
        raise Broken("the volumes of the boxes do not add up to that of the whole")
    if levels:
        yield Cells(np.array(levels, dtype=np.int64), np.array(indices, dtype=np.int64))
