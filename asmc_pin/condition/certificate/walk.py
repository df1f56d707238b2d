"""The bisection of one statement's box, on several threads, until it is proven, refuted or told to stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.certificate.compiled import bisection_tree
from asmc_pin.condition.certificate.compiled.working_state import Problem

Record = bisection_tree.Bytes
"""A bisection in preorder: see `bisection_tree`."""

Status = Literal["proven", "refuted", "narrow", "rounding", "stopped"]

UNKNOWN: Record = np.array([bisection_tree.LEAF], dtype=np.uint8)
_SLICE = 0.05  # s of one compiled call, between which threads share work and heed a stop


@dataclass(frozen=True, eq=False)
class Walk:
    """What a bisection came to.

    Attributes:
        status: ``proven``; ``refuted``: not positive at `q`, up to rounding; ``rounding``: not even `q` alone is
            proven, though it is positive there; ``narrow``: that is proven, and a cell around it is not that was halved
            as often as any is; ``stopped``: by the clock or the caller.
        record: What was done, also where it stopped: what is open stands in it as a leaf.
        tests: Boxes tested.
        volume: Share of the box that is proven.
        q: Shape (nv,), where it did not get on.
    """

    status: Status
    record: Record
    tests: int
    volume: float
    q: Array | None


@dataclass(eq=False)
class _Segment:
    """Boxes one after the other in preorder, and who has the rest of them."""

    levels: IntArray
    indices: IntArray
    count: int
    hint: Record
    done: list[Record] = field(default_factory=list)
    given: list[_Segment] = field(default_factory=list)

    def record(self) -> list[Record]:
        """What is known of the segment, given-away boxes included: the last given lie nearest."""
        parts = list(self.done)
        if self.count:
            parts.append(self.hint)
        for segment in reversed(self.given):
            parts += segment.record()
        return parts

    def give(self) -> _Segment:
        """Split off the lower half of the stack, which holds the larger boxes."""
        share = self.count // 2
        cut = 0
        for _ in range(self.count - share):
            cut = int(bisection_tree.subtree_end(self.hint, cut))
        levels, indices = np.zeros_like(self.levels), np.zeros_like(self.indices)
        levels[:share], indices[:share] = self.levels[:share], self.indices[:share]
        other = _Segment(levels, indices, share, self.hint[cut:])
        kept = self.count - share
        self.levels[:kept], self.indices[:kept] = self.levels[share : self.count], self.indices[share : self.count]
        self.count, self.hint = kept, self.hint[:cut]
        self.given.append(other)
        return other


class _Crew:
    """The state that the threads of one bisection share."""

    def __init__(self, problem: Problem, first: _Segment, threads: int) -> None:
        self.problem = problem
        self.waiting = [first]
        self.idle = 0
        self.threads = threads
        self.over = False
        self.status: Status = "proven"
        self.q: Array | None = None
        self.tests = 0
        self.volume = 0.0
        self.error: BaseException | None = None
        self.changed = threading.Condition()
        self.ended = threading.Event()

    def take(self) -> _Segment | None:
        with self.changed:
            self.idle += 1
            while not self.waiting and not self.over:
                if self.idle == self.threads:
                    self.over = True
                    self.ended.set()
                    self.changed.notify_all()
                    break
                self.changed.wait()
            if self.over:
                return None
            self.idle -= 1
            return self.waiting.pop()

    def stop(self, status: Status, q: Array | None = None) -> None:
        with self.changed:
            if not self.over:
                self.over, self.status, self.q = True, status, q
            self.ended.set()
            self.changed.notify_all()

    def work(self) -> None:
        try:
            most = 16
            while (segment := self.take()) is not None:
                while segment.count and not self.over:
                    most = self._slice(segment, most)
                    with self.changed:
                        if self.idle and not self.waiting and segment.count > 1:
                            self.waiting.append(segment.give())
                            self.changed.notify()
        except BaseException as error:
            self.error = error
            self.stop("stopped")

    def _slice(self, segment: _Segment, most: int) -> int:
        record = np.empty(most + segment.hint.size, dtype=np.uint8)
        began = time.perf_counter()
        status, count, fresh, written, used, tests, volume, q = bisection_tree.explore(
            self.problem, segment.levels, segment.indices, segment.count, segment.hint, most, record
        )
        took = time.perf_counter() - began
        segment.done.append(record[:written].copy())
        segment.count = count
        segment.hint = np.concatenate((np.repeat(UNKNOWN, fresh), segment.hint[used:]))
        with self.changed:
            self.tests += tests
            self.volume += volume
        if status == bisection_tree.HIT:
            self.stop("refuted", q)
        elif status == bisection_tree.NARROW:
            self.stop("narrow" if _holds_at(self.problem, q) else "rounding", q)
        elif status == bisection_tree.WHOLE:
            self.stop("rounding", q)
        return max(8, min(4 * most, int(most * _SLICE / max(took, 1e-6))))


def _holds_at(problem: Problem, q: Array) -> bool:
    """Whether a statement is proven at one configuration alone."""
    stack = np.zeros((3, q.size), dtype=np.int64)
    point = problem._replace(lower=q.copy(), upper=q.copy())
    status = bisection_tree.explore(point, stack, stack.copy(), 1, UNKNOWN, 1, UNKNOWN.copy())[0]
    return bool(status == bisection_tree.DONE)


def in_joints(record: Record, joints: IntArray) -> Record:
    """The record of some joints' box in the numbers that these joints have in the whole arm."""
    numbers = np.arange(256, dtype=np.uint8)
    numbers[: len(joints)] = joints
    return numbers[record]


def get_ready() -> None:
    """Compile what a walk needs, or read it from numba's cache, so that no clock runs meanwhile."""
    still, one = np.zeros((1, 6, 6)), np.ones((1, 1, 1))
    nothing = Problem(
        np.array([-1], dtype=np.int64),
        np.array([False]),
        still,
        still,
        still,
        one,
        one,
        np.zeros(1),
        np.zeros(1),
        False,
        1.0,
    )
    stack = np.zeros((2, 1), dtype=np.int64)
    bisection_tree.explore(nothing, stack, stack.copy(), 1, UNKNOWN, 0, UNKNOWN.copy())
    bisection_tree.subtree_end(UNKNOWN, 0)


def prove(
    problem: Problem,
    *,
    hint: Record = UNKNOWN,
    deadline: float = np.inf,
    threads: int = 2,
    watch: Callable[[int, float], bool] | None = None,
) -> Walk:
    """Bisect a statement's box until every leaf is proven.

    Args:
        problem: The statement.
        hint: Record of an earlier walk of the same box: where that split, this splits without a test.
        deadline: `time.monotonic()` at which to stop, s.
        threads: Worker threads; the compiled code releases the interpreter's lock.
        watch: Called every so often with the tests made and the share proven; True stops.

    Returns:
        What it came to.
    """
    n = problem.parent.size
    # Depth first, each halving leaves one box more, and a box is halved at most this often.
    stack = np.zeros((bisection_tree.DEEPEST * n + 3, n), dtype=np.int64)
    first = _Segment(stack, stack.copy(), 1, hint)
    crew = _Crew(problem, first, threads)
    workers = [threading.Thread(target=crew.work, daemon=True) for _ in range(threads)]
    for worker in workers:
        worker.start()
    try:
        while not crew.ended.wait(0.05):
            if time.monotonic() > deadline or (watch is not None and watch(crew.tests, crew.volume)):
                crew.stop("stopped")
    finally:
        crew.stop("stopped")
        for worker in workers:
            worker.join()
    if crew.error is not None:
        raise crew.error
    return Walk(crew.status, np.concatenate(first.record()), crew.tests, crew.volume, crew.q)
