"""A joint box cut into smaller ones, each with what is known of a condition in it: proven, refuted, or neither yet.

A proof says that all of its boxes hold; this says where M̄ holds and where it does not, also of an M̄ that is violated.
The test of a box is the prover's own.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.certificate.compiled import bisection_tree
from asmc_pin.condition.certificate.compiled.working_state import Problem
from asmc_pin.condition.certificate.statement import Statement
from asmc_pin.condition.certificate.statement_forms import problem_of
from asmc_pin.condition.certificate.walk import UNKNOWN, Record, get_ready, in_joints
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import NORM, figures_at
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.condition.search.samples import Domain

PROVEN, REFUTED, OPEN = bisection_tree.LEAF, 254, 253
"""What is known of a box: the condition is proven in it; a configuration in it violates it; neither."""

MOST = 20_000
"""Boxes at most: a page of them stays light."""

FINEST = 1.0 / 64.0
"""Share of a joint's range that is not halved any more: a picture shows nothing finer."""


@dataclass(frozen=True, eq=False)
class BoxPartition:
    """What is known of a condition, box by box.

    Attributes:
        records: Of each branch on the base a bisection of the joint box, a byte for each box in preorder: the joint
            that it is halved at, the lower half first, or `PROVEN`, `REFUTED`, `OPEN`. A configuration is proven where
            it is in each of them.
    """

    records: tuple[Record, ...]

    def boxes(self, mark: int) -> int:
        """How many boxes have a mark."""
        return sum(int(np.count_nonzero(record == mark)) for record in self.records)

    @property
    def holds(self) -> bool:
        """Whether all boxes are proven, which together are the whole."""
        return self.boxes(OPEN) == self.boxes(REFUTED) == 0


@dataclass(eq=False)
class _Cell:
    """A box of one branch."""

    lower: Array
    upper: Array
    witness: Array | None = None
    mark: int = OPEN
    joint: int = -1
    halves: list[_Cell] = field(default_factory=list)

    def record(self) -> list[int]:
        """Itself and what it is cut into, in preorder."""
        found, todo = [], [self]
        while todo:
            cell = todo.pop()
            found.append(cell.joint if cell.halves else cell.mark)
            todo += reversed(cell.halves)
        return found


def partition(
    domain: Domain,
    mbar: Array,
    condition: Condition,
    *,
    budget: float = 10.0,
    known: Array | None = None,
    most: int = MOST,
    progress: Callable[[float], None] | None = None,
) -> BoxPartition:
    """Cut a joint box, the largest part of which nothing is proven first, until all is proven or the time is up.

    Args:
        domain: The arm and the box, without a range of armature.
        mbar: Diagonal of M̄, shape (nv,), kg·m².
        condition: ``lemma1`` or ``weighted``.
        budget: s.
        known: A configuration that may violate the condition, shape (nv,).
        most: Boxes at most.
        progress: Called now and then with the share of the time that is gone.

    Returns:
        The boxes.

    Raises:
        ParameterError: Joints mimic others: what is proven of them is not proven box by box.
    """
    if domain.arm.mimics:
        raise ParameterError("arm", "has joints that mimic others, of which no boxes are proven one by one")
    get_ready()
    began = time.monotonic()
    parts = domain.by_branch()
    records: list[Record] = []
    for number, part in enumerate(parts, start=1):
        until = began + budget * number / len(parts)
        own = None if known is None else known[part.joints]
        cut = _Cutting(part, mbar[part.joints], condition, own)
        cut.run(until, most // len(parts), lambda: progress((time.monotonic() - began) / budget) if progress else None)
        records.append(in_joints(np.array(cut.whole.record(), dtype=np.uint8), part.joints))
    return BoxPartition(tuple(records))


class _Cutting:
    """The cutting of one branch's box."""

    def __init__(self, part: Domain, mbar: Array, condition: Condition, known: Array | None) -> None:
        statement = Statement(condition, 1.0, 1.0, 0, part.armature_lower, np.zeros_like(mbar))
        self._problem = problem_of(part.tree, part.box.lower, part.box.upper, mbar, statement)
        self._part, self._mbar, self._kind = part, mbar, NORM[condition]
        self.whole = _Cell(np.array(part.box.lower), np.array(part.box.upper))
        self._span = np.where(self.whole.upper > self.whole.lower, self.whole.upper - self.whole.lower, 1.0)
        if known is not None and self._violates(known):
            self.whole.witness = known

    def run(self, until: float, most: int, told: Callable[[], None]) -> None:
        """Test and halve, the largest boxes first, those of which nothing is known before those that are refuted."""
        numbers = count()
        queue = [(0.0, next(numbers), self.whole)]
        leaves = 1
        while queue and leaves < most and (time.monotonic() < until or leaves == 1):
            _, number, cell = heapq.heappop(queue)
            if number % 64 == 0:
                told()
            joint = self._test(cell)
            if joint < 0:
                continue
            self._halve(cell, joint)
            leaves += 1
            for half in cell.halves:
                size = float(np.prod(np.where(half.upper > half.lower, (half.upper - half.lower) / self._span, 1.0)))
                heapq.heappush(queue, (-size, next(numbers), half))

    def _test(self, cell: _Cell) -> int:
        """Mark a box; the joint to halve it at, −1 if it is proven or cannot be halved."""
        joint = -1
        if cell.witness is None:
            status, joint, q = _tested(self._problem, cell.lower, cell.upper)
            if status == bisection_tree.DONE:
                cell.mark = PROVEN
                return -1
            if status == bisection_tree.HIT and self._violates(q):
                cell.witness = q
        if cell.witness is not None:
            cell.mark = REFUTED
        width = np.where(self._part.box.free, cell.upper - cell.lower, 0.0)
        width[width <= FINEST * self._span * (1.0 + 1e-9)] = 0.0
        if joint < 0 or not width[joint]:
            joint = int(np.argmax(width))
        return joint if width[joint] else -1

    def _halve(self, cell: _Cell, joint: int) -> None:
        cell.joint = joint
        middle = 0.5 * (cell.lower[joint] + cell.upper[joint])
        below, above = cell.upper.copy(), cell.lower.copy()
        below[joint] = above[joint] = middle
        cell.halves = [_Cell(cell.lower, below), _Cell(above, cell.upper)]
        if cell.witness is not None:
            half = cell.halves[int(cell.witness[joint] > middle)]
            half.witness, half.mark = cell.witness, REFUTED

    def _violates(self, q: Array) -> bool:
        """Whether the norm is 1 or more at a configuration, evaluated and not only bounded."""
        inside = np.clip(q, self.whole.lower, self.whole.upper)[None]
        return bool(figures_at(self._kind, self._part.tree, inside, self._mbar)[0] >= 1.0)


def _tested(problem: Problem, lower: Array, upper: Array) -> tuple[int, int, Array]:
    """Status of one test, the joint whose cell costs most there (−1 if none is told), and where it was not positive."""
    here = problem._replace(lower=np.array(lower), upper=np.array(upper))
    stack: IntArray = np.zeros((3, lower.size), dtype=np.int64)
    record = np.empty(2, dtype=np.uint8)
    found = bisection_tree.explore(here, stack, stack.copy(), 1, UNKNOWN, 1, record)
    status, written, q = int(found[0]), int(found[3]), found[7]
    return status, int(record[0]) if status == bisection_tree.MORE and written else -1, q
