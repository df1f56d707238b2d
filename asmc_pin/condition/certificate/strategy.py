"""In which order to try scales and levels, so that there is something to say whenever the time is up."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.certificate import stopping
from asmc_pin.condition.certificate.compiled.bisection_tree import LEAF
from asmc_pin.condition.certificate.mimic_shares import Unfolded, halved, weights_of
from asmc_pin.condition.certificate.proof_progress import ProofProgress, WalkWatch
from asmc_pin.condition.certificate.statement import Kind, Statement
from asmc_pin.condition.certificate.statement_forms import MARGIN, freed, problem_of_unfolded
from asmc_pin.condition.certificate.stopping import Obstacle
from asmc_pin.condition.certificate.walk import UNKNOWN, Record, Walk, in_joints, prove
from asmc_pin.condition.certificate.worst_known import Worst
from asmc_pin.condition.certificate.writing import Proof
from asmc_pin.condition.domain.along_motion import armature_ends
from asmc_pin.condition.domain.base_branches import branch_of, branches
from asmc_pin.condition.domain.places_between import corners
from asmc_pin.condition.norm.two_conditions import Condition

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case
    from asmc_pin.condition.search.samples import Domain
    from asmc_pin.rigid_body.tree import Tree

Attempted = Literal["proven", "blocked", "slow", "stopped"]

_CORNERS = 8
"""Ends of an armature range that a level of Lemma 1 is proven at one by one; more are bounded together."""


_CUTS = 128
"""How often a box of joints that mimic others is cut, each piece with shares of its own."""

_QUICK = 0.1
"""Share of the time left below which an attempt was quick, and the next may ask for all at once."""


class Prover:
    """Raises the scale and lowers the level that are proven; its fields are right at any moment.

    Attributes:
        scale: Scale proven so far, 0 for none.
        level: Level proven so far for M̄ itself, None for none.
        proofs: Proofs of `scale`, and of `level`.
        history: (seconds, scale) at each advance.
        tests: Boxes tested.
        worst: What is refuted.
        reason: Why it stopped.
        obstacle: Where the last attempt did not get on, though nothing contradicts it.
        corners: The arms that its statements are of; their `case` is an index of these.
    """

    def __init__(
        self,
        cases: Sequence[Case],
        mbar: Array,
        condition: Condition,
        worst: Worst,
        *,
        began: float,
        budget: float,
        threads: int,
        progress: Callable[[ProofProgress], None] | None,
    ) -> None:
        self._cases, self._mbar, self._condition, self.worst = cases, mbar, condition, worst
        self.began, self.deadline, self._threads, self.progress = began, began + budget, threads, progress
        self._hints: dict[tuple[Kind, int, int, bytes], Record] = {}
        self.scale = 0.0
        self.level: float | None = None
        self.proofs: dict[str, tuple[Proof, ...]] = {}
        self.history: list[tuple[float, float]] = []
        self.tests = 0
        self.reason = ""
        self.obstacle: Obstacle | None = None
        self.corners = corners(cases)

    def raise_scale(self, gap: float) -> None:
        """Prove the condition for larger and larger factors of M̄, until the gap is met and M̄ itself is decided."""
        ceiling, patient, took = np.inf, False, 0.0
        blocked: str | None = None
        while True:
            refuted = self.worst.scale
            if refuted <= 0.0:
                self.reason = stopping.NO_MULTIPLE
                return
            # A hair closer, so that the gap is met in floating point too.
            goal = refuted * (1.0 - gap * (1.0 - 1e-9))
            if self.scale >= goal:
                if not self.scale < 1.0 < refuted:
                    self.reason = stopping.GAP_MET
                    return
                goal = 1.0
            if self.scale == 0.0:
                # Something to say, soon; less if even half is too much.
                trying = 0.5 * min(ceiling, refuted)
            elif goal < ceiling * (1.0 - MARGIN):
                # M̄ itself is what was asked about. Where a step takes its time, a quarter of the gap at once, so that
                # there is news in between.
                target = 1.0 if self.scale < 1.0 < min(refuted, ceiling) else goal
                quarter = refuted - 0.25 * (refuted - self.scale)
                quick = took < _QUICK * (self.deadline - time.monotonic())
                trying = target if quick else min(target, quarter)
            else:
                trying = refuted - float(np.sqrt((refuted - self.scale) * max(refuted - ceiling, 0.0)))
                if self.scale < 1.0 < trying:
                    trying = 1.0
            near = (refuted - self.scale) < 1.15 * (refuted - ceiling) or trying < 1e-3 * refuted
            if near and blocked is not None:
                self.reason = blocked
                return
            if near:
                ceiling, patient = np.inf, True
                continue
            before = time.monotonic()
            outcome = self._attempt(self._scale_statements(trying), f"scale {trying:.4g}", patient)
            took = time.monotonic() - before
            if outcome == "proven":
                self.scale = trying
                self.history.append((time.monotonic() - self.began, trying))
            elif outcome == "stopped":
                self.reason = stopping.OUT_OF_TIME
                return
            elif outcome == "slow":
                ceiling, blocked = trying, None
            elif self.worst.scale >= refuted * (1.0 - MARGIN):
                # Less than that is no news, and would be tried for ever.
                ceiling, blocked = trying, self.why_blocked(self.worst.scale - trying, trying)

    def lower_level(self, seconds: float, goal: float | None = None) -> None:
        """Prove lower and lower levels of M̄ itself, in addition to its scale; with a goal only that one."""
        late = stopping.OUT_OF_TIME
        if (until := time.monotonic() + seconds) < self.deadline:
            self.deadline, late = until, stopping.SHARE_SPENT
        why = ""
        for share in (0.5, 0.2, 0.05) if goal is None else (0.0,):
            level = goal if goal is not None else 1.0 - (1.0 - self.worst.norm) * (1.0 - share)
            if not self.worst.norm < level < 1.0:
                why = stopping.NORM_REFUTED
                break
            outcome = self._attempt(self._level_statements(level), f"level {level:.6g}", goal is not None, "level")
            if outcome == "proven":
                self.level, why = level, stopping.LEVEL_PROVEN if goal is not None else ""
            elif outcome == "blocked" and self.worst.norm < level:
                why = self.why_blocked(level - self.worst.norm, level)
                break
            elif outcome == "blocked":
                why = stopping.NORM_REFUTED
            else:
                why = late if outcome == "stopped" else stopping.TOO_SLOW
                if outcome == "stopped":
                    break
        if goal is not None:
            self.reason = why
        elif why:
            self.reason = f"{self.reason}; the bound of the norm is not lower because: {why}"

    def why_blocked(self, left: float, of: float) -> str:
        """Why the last attempt was blocked.

        Args:
            left: How far what was tried is from what is refuted.
            of: What was tried.
        """
        assert self.obstacle is not None
        if self._cases[0].domain.arm.mimics:
            return stopping.SHARES
        if len(self.corners) > len(self._cases) or not all(corner.least for corner in self.corners):
            return stopping.CORNERS
        return self.obstacle.reason(near=left <= stopping.NEAREST * of)

    def _scale_statements(self, scale: float) -> list[Statement]:
        # Both conditions only gain by armature: its lower end covers the range.
        kind: Kind = "weighted" if self._condition == "weighted" else "lemma1"
        return [
            Statement(kind, scale, 1.0, number, self._domain(number).armature_lower, np.zeros_like(self._mbar))
            for number, corner in enumerate(self.corners)
            if kind == "lemma1" or corner.least
        ]

    def _domain(self, number: int) -> Domain:
        """The arm's case of a statement, but for what is taken off its inertia."""
        return self._cases[self.corners[number].case].domain

    def _level_statements(self, level: float) -> list[Statement]:
        found = []
        for index, corner in enumerate(self.corners):
            domain = self._domain(index)
            lower, upper = domain.armature_lower, domain.armature_upper
            none, width = np.zeros_like(lower), upper - lower
            if self._condition == "weighted":
                found += [Statement("weighted", 1.0, level, index, lower, none)] if corner.least else []
                found += [Statement("bounded", 1.0, level, index, lower, width)] if corner.most else []
            elif 2 ** np.count_nonzero(width) <= _CORNERS:
                found += [Statement("level", 1.0, level, index, end, none) for end in armature_ends(lower, upper)]
            else:
                found.append(Statement("level", 1.0, level, index, lower, width))
        return found

    def _attempt(self, statements: list[Statement], label: str, patient: bool, key: str = "scale") -> Attempted:
        """Prove all of some statements, or say why not; where one is not positive, search on from there."""
        proofs = []
        parts = [branches(self.corners[statement.case].tree) for statement in statements]
        number, count = 0, sum(map(len, parts))
        for statement, mine in zip(statements, parts, strict=True):
            records: list[Record] = []
            weights: list[Array] = []
            for joints in mine:
                watch = WalkWatch(self, label, patient, number, count)
                walk, own, borne = self._branch(statement, joints, watch)
                if walk.status == "stopped":
                    return "slow" if watch.slow else "stopped"
                if walk.q is not None:
                    # The other branches do not matter to this one: anywhere will do.
                    corner = self.corners[statement.case]
                    q = np.array(self._domain(statement.case).box.centre)
                    q[joints] = walk.q[branch_of(corner.tree, joints).coupling.leader]
                    self.worst.climb(corner.case, q, statement.armature)
                    self.obstacle = Obstacle(walk.status, statement, q)
                    return "blocked"
                records += own
                weights += borne
                number += 1
            proofs.append(Proof(statement, np.concatenate(records), tuple(weights)))
        self.proofs[key] = tuple(proofs)
        return "proven"

    def _branch(
        self, statement: Statement, joints: IntArray, watch: WalkWatch
    ) -> tuple[Walk, list[Record], list[Array]]:
        """Prove one branch's box, in pieces where joints mimic others.

        Returns:
            The last walk, the records, and where joints mimic others the weights of every piece.
        """
        every = self.corners[statement.case].tree
        tree, whole = branch_of(every, joints), self._domain(statement.case).box.of(joints)
        if not every.coupling.follows:
            walk = self._walk(statement, joints, tree, (whole.lower, whole.upper), watch)[0]
            self.tests += walk.tests
            return walk, [in_joints(walk.record, joints)], []
        moving = np.flatnonzero(np.isin(every.coupling.coordinate, joints))
        pieces, cuts, cut_at = [(whole.lower, whole.upper)], 0, bytearray()
        records: list[Record] = []
        weights: list[Array] = []
        while True:
            piece = pieces.pop()
            walk, unfolded = self._walk(statement, joints, tree, piece, watch)
            self.tests += walk.tests
            if walk.status == "proven":
                cut_at.append(LEAF)
                records.append(in_joints(walk.record, moving))
                weights.append(weights_of(tree, self._mbar[joints], unfolded))
                if pieces:
                    continue
                return walk, [np.frombuffer(bytes(cut_at), dtype=np.uint8), *records], weights
            # What is only sufficient loses less over a smaller box.
            halves = halved(tree, whole, piece) if tree.coupling.follows and walk.q is not None else []
            if not halves or cuts == _CUTS:
                return walk, [], []
            if time.monotonic() > self.deadline:
                return replace(walk, status="stopped"), [], []
            low, high = halves
            cut_at.append(int(joints[np.argmax(low[1] != high[1])]))
            pieces += [high, low]
            cuts += 1

    def _walk(
        self, statement: Statement, joints: IntArray, tree: Tree, box: tuple[Array, Array], watch: WalkWatch
    ) -> tuple[Walk, Unfolded]:
        """Bisect a box of one branch, beginning with the halvings of the last walk of it that was one to the end."""
        lower, upper = box
        own = replace(statement, armature=statement.armature[joints], slack=statement.slack[joints])
        place = np.concatenate((statement.armature, lower, upper)).tobytes()
        name = statement.kind, statement.case, int(joints[0]), place
        unfolded = freed(tree, lower, upper, self._mbar[joints], own)
        walk = prove(
            problem_of_unfolded(unfolded),
            hint=self._hints.get(name, UNKNOWN),
            deadline=self.deadline,
            threads=self._threads,
            watch=watch,
        )
        if walk.status == "proven":
            self._hints[name] = walk.record
        return walk, unfolded
