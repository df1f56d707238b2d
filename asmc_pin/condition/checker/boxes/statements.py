"""Replaying one statement of a certificate: every cell of it, and some of them in ball arithmetic too."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.boxes.bisection import cells, leaves
from asmc_pin.condition.checker.boxes.box_bounds import WIDE, holds
from asmc_pin.condition.checker.boxes.pieces_of_statement import parts_of, whole_form
from asmc_pin.condition.checker.boxes.quadratic_form import Form, least_eigenvalues
from asmc_pin.condition.checker.conclusions import armature_words
from asmc_pin.condition.checker.outcome import CheckedStatement
from asmc_pin.condition.checker.reading.header_parts import Header, WrittenStatement
from asmc_pin.condition.checker.reading.link_chain import Chain
from asmc_pin.condition.checker.spot_checks import Spots, spot_checks

_ROOM = 4_000_000
"""Numbers that the forms of one batch of boxes have."""

_MOST_ROOM = 30_000_000
"""Of a single box; with more corners than that, this route does not take it."""

_DEEPER = 14
"""How often a cell that this route does not prove as it is may be halved on."""

_MORE = 20.0
"""How many more boxes than the certificate has it may take."""

_NEAR = 1e-10
"""Least eigenvalue over the largest that is below zero for sure."""

_POINTS = 64
"""Configurations drawn from the whole box for balls, over all statements; of each statement four at the least."""

_SPOTS = 32
"""Cells that are put to the condition in balls, over all statements; of each statement two at the least."""


def replay_statement(
    told: Header,
    statement: WrittenStatement,
    record: np.ndarray[Any, np.dtype[np.uint8]],
    chain: Chain,
    balls: BallArm,
    words: str,
    seed: int,
    tell: Callable[[float], None],
) -> tuple[CheckedStatement, str]:
    """Prove one statement again.

    Args:
        told: The header.
        statement: The statement.
        record: Its bisection.
        chain: Its case's arm in floating point.
        balls: The same in ball arithmetic.
        words: What is particular about the case.
        seed: Of the cells that are drawn.
        tell: Called with the share that is done.

    Returns:
        What came of it, and what is wrong with it, empty for nothing.

    Raises:
        Broken: The record is no bisection.
        Malformed: The statement is about another armature than its case.
    """
    case = told.cases[statement.case]
    spotted = max(2, _SPOTS // len(told.statements))
    words = ", ".join(filter(None, (words, armature_words(told, statement))))
    total, halved, problem = 0, 0, ""
    centres, halves = [], []
    whole = whole_form(told, statement, chain)
    # M is block diagonal where branches hang on the base one by one: each has boxes of its own joints alone.
    for part in parts_of(told, statement, record, chain, balls.follow):
        replay = _Replay(part.form, leaves(part.record), spotted, seed, tell)
        total += replay.total
        for piece in cells(part.record, part.joints.size):
            problem = replay.prove(*piece.boxes(part.form.lower, part.form.upper))
            if problem:
                break
        halved += replay.halved
        if problem:
            break
        for centre, half in zip(*replay.chosen(), strict=True):
            middle, still = part.among(centre, half, case)
            centres.append(middle)
            halves.append(still)
    spots = Spots()
    if not problem:
        least = max(4, _POINTS // len(told.statements))
        some = np.array(centres), np.array(halves)
        if chain.follows:  # every piece has some, and there may be a hundred
            some = _some_of(whole, *some, 2 * spotted)
        spots = spot_checks(
            balls, lambda q: least_eigenvalues(whole, q), statement, case, told.mbar, *some, seed, least
        )
        problem = spots.problem
    result = CheckedStatement(
        statement.kind, statement.scale, statement.level, words, total, halved, not problem, spots
    )
    return result, problem


def _some_of(form: Form, centres: Array, halves: Array, count: int) -> tuple[Array, Array]:
    """So many cells: one half those with least left at their centres, the other half from everywhere else."""
    order = np.argsort(least_eigenvalues(form, centres), kind="stable")
    first, rest = order[: count // 2], order[count // 2 :]
    at = np.concatenate((first, rest[:: max(1, -(-rest.size // (count - count // 2)))]))
    return centres[at], halves[at]


class _Replay:
    """Proves boxes, halving where that takes it, and remembers the hardest of them."""

    def __init__(self, form: Form, total: int, spots: int, seed: int, tell: Callable[[float], None]) -> None:
        self._form, self.total, self._tell = form, total, tell
        self.halved, self._done = 0, 0.0
        self._idle = form.chain.parent < 0
        if form.exact:
            self._idle = self._idle.copy()
            self._idle[1] = True
        self._spots, self._rng = spots, np.random.default_rng(seed)
        # Of all cells those with least left, and some that are drawn; the number makes ties comparable.
        self._hardest: list[tuple[float, int, Array, Array]] = []
        self._drawn: list[tuple[float, int, Array, Array]] = []
        self._seen = 0

    def prove(self, centre: Array, half: Array) -> str:
        """Prove boxes (k, n); what could not be proven, empty for nothing."""
        least = np.full(len(centre), np.nan)
        problem = self._all(centre, half, least)
        if not problem:
            self._remember(centre, half, least)
        return problem

    def chosen(self) -> tuple[Array, Array]:
        """Centres and half widths of the cells to look at more closely, each (k, n)."""
        found = {number: (c, h) for _, number, c, h in (*self._hardest, *self._drawn)}
        return np.array([c for c, _ in found.values()]), np.array([h for _, h in found.values()])

    def _remember(self, centre: Array, half: Array, least: Array) -> None:
        for c, h, value, draw in zip(centre, half, least, self._rng.random(len(centre)), strict=True):
            self._seen += 1
            for heap, key in ((self._hardest, -float(value)), (self._drawn, float(draw))):
                heapq.heappush(heap, (key, self._seen, c, h))
                if len(heap) > max(1, self._spots // 2):
                    heapq.heappop(heap)

    def _all(self, centre: Array, half: Array, least: Array) -> str:
        still = np.where(self._idle, 0.0, half)
        waiting = [(centre, still, np.zeros(len(centre), dtype=np.int64))]
        first = True
        while waiting:
            c, r, depth = waiting.pop()
            for at in self._batches(r):
                good, cost, values = holds(self._form, c[at], r[at])
                if first:
                    least[at] = values
                self._done += float(np.sum(np.exp2(-depth[at[good]].astype(np.float64))))
                self._tell(self._done / self.total)
                if good.all():
                    continue
                if np.any(values[~good] < -_NEAR):
                    return "at the centre of a box it is not so"
                at, cost = at[~good], cost[~good]
                if np.any(depth[at] >= _DEEPER) or np.all(self._idle) or self.halved > _MORE * (self.total + 100.0):
                    return "a box of it could not be proven again"
                self.halved += at.size
                waiting.append(_halves(c[at], r[at], depth[at], cost))
            first = False
        return ""

    def _batches(self, r: Array) -> Iterator[IntArray]:
        """Indices of boxes that have the same joints wide, and so the same corners, some at a time."""
        _, code = np.unique(r > WIDE, axis=0, return_inverse=True)
        for value in range(int(code.max()) + 1):
            same = np.flatnonzero(code == value)
            two_ends = ~self._idle & (self._form.chain.slides | (r[same[0]] <= WIDE))
            size = 2 ** int(np.count_nonzero(two_ends)) * r.shape[1] * (6 * self._form.pairing.shape[0]) ** 2
            if size > _MOST_ROOM:
                raise np.linalg.LinAlgError(f"a box has 2 to the {np.count_nonzero(two_ends)} corners")
            batch = max(1, _ROOM // size)
            for start in range(0, same.size, batch):
                yield np.asarray(same[start : start + batch], dtype=np.int64)


def _halves(c: Array, r: Array, depth: IntArray, cost: Array) -> tuple[Array, Array, IntArray]:
    """Boxes halved at the joint that costs most; the halves together cover them, rounding included."""
    joint = np.argmax(np.where(r > 0.0, np.nan_to_num(cost, nan=np.inf) + 1e-300, -1.0), axis=1)
    rows = np.arange(len(c))
    whole, middle = r[rows, joint], np.abs(c[rows, joint])
    narrow, left, right = r.copy(), c.copy(), c.copy()
    # A centre that is shifted by half a width is rounded at its own size, not at the width's.
    narrow[rows, joint] = 0.5 * whole + 4.0 * np.finfo(np.float64).eps * (middle + whole)
    left[rows, joint] -= 0.5 * whole
    right[rows, joint] += 0.5 * whole
    both = np.stack((left, right), axis=1).reshape(-1, c.shape[1])
    return both, np.repeat(narrow, 2, axis=0), np.repeat(depth + 1, 2)
