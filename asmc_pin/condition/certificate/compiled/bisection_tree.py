"""Depth-first bisection of a box until every leaf is proven; what was done is written down in preorder.

A box of cells is named exactly: cell `index` of 2^`level` equal parts of each joint's range. The record of a subtree
has one byte per node in preorder: the joint that was halved (lower half first), or `LEAF`.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from numba import njit

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.certificate.compiled.one_box import PROVEN, REFUTED, test_box
from asmc_pin.condition.certificate.compiled.working_state import Problem, scratch

Bytes: TypeAlias = npt.NDArray[np.uint8]

LEAF = 255
DONE = 0
MORE = 1
HIT = 2
NARROW = 3
WHOLE = 4
DEEPEST = 40
"""Halvings of one joint after which the proof gives up: cells of some 1e-12 of the range."""


@njit(cache=True, nogil=True, error_model="numpy")
def cell(problem: Problem, level: IntArray, index: IntArray, c: Array, r: Array) -> None:
    """Centre and half width of a box of cells, widened by the rounding of both."""
    for j in range(c.shape[0]):
        lower, upper = problem.lower[j], problem.upper[j]
        part = (upper - lower) * 0.5 ** level[j]
        c[j] = lower + part * (index[j] + 0.5)
        r[j] = 0.5 * part
        if upper > lower:
            r[j] += 2e-15 * (abs(lower) + abs(upper))


@njit(cache=True, nogil=True, error_model="numpy")
def subtree_end(record: Bytes, start: int) -> int:
    """Where the record of the subtree that begins at `start` ends."""
    open_nodes = 1
    at = start
    while open_nodes > 0:
        open_nodes += -1 if record[at] == LEAF else 1
        at += 1
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def explore(
    problem: Problem, levels: IntArray, indices: IntArray, count: int, hint: Bytes, most: int, record: Bytes
) -> tuple[int, int, int, int, int, int, float, Array]:
    """Work off a stack of boxes, from its top, depth first.

    Args:
        problem: The statement.
        levels: Stack of boxes, shape (capacity, n), the top at count − 1; in and out.
        indices: The same.
        count: How many boxes are on it.
        hint: Records of an earlier walk, one per box, top first, uint8: where that split, this splits without a test.
            `LEAF` alone for a box of which nothing is known.
        most: Tests after which to stop.
        record: Out, uint8, at least `most` + length of hint long.

    Returns:
        (status, boxes left, of which without a hint, bytes recorded, bytes of hint used, tests, share of the volume
        proven, configuration). Status `DONE`, `MORE`, `HIT` (not positive at the configuration, up to rounding),
        `NARROW` (a cell that was halved most often is not proven) or `WHOLE` (nor is one without anything to halve).
    """
    n = problem.parent.shape[0]
    k = scratch(n, problem.link.shape[1], problem.motion.shape[2])
    c, r, share = np.zeros(n), np.zeros(n), np.zeros(n)
    tests = 0
    written = 0
    used = 0
    hinted = count  # boxes at the bottom of the stack that still have a hint
    volume = 0.0
    while count > 0:
        if tests >= most or written >= record.shape[0] or count + 1 >= levels.shape[0]:
            return MORE, count, count - hinted, written, used, tests, volume, c
        split = -1
        known = count == hinted
        if known:
            hinted -= 1
            if hint[used] != LEAF:
                split = int(hint[used])
            used += 1
        if split < 0:
            cell(problem, levels[count - 1], indices[count - 1], c, r)
            tests += 1
            verdict = test_box(problem, c, r, k, share)
            if verdict == PROVEN:
                record[written] = LEAF
                written += 1
                count -= 1
                share_of_box = 1.0
                for j in range(n):
                    share_of_box *= 0.5 ** levels[count, j]
                volume += share_of_box
                continue
            if verdict == REFUTED:
                return HIT, count, count - hinted, written, used, tests, volume, c
            largest = 0.0
            for j in range(n):
                if r[j] > 0.0 and share[j] > largest:
                    largest = share[j]
                    split = j
            if split < 0:
                return WHOLE, count, count - hinted, written, used, tests, volume, c
            if levels[count - 1, split] >= DEEPEST:
                return NARROW, count, count - hinted, written, used, tests, volume, c
        elif known:
            hinted += 2
        record[written] = split
        written += 1
        for j in range(n):
            levels[count, j] = levels[count - 1, j]
            indices[count, j] = indices[count - 1, j]
        level = levels[count - 1, split] + 1
        index = indices[count - 1, split] * 2
        levels[count - 1, split] = level
        levels[count, split] = level
        indices[count - 1, split] = index + 1
        indices[count, split] = index
        count += 1
    return DONE, 0, 0, written, used, tests, volume, c
