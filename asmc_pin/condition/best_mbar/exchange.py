"""The exchange of worst configurations: design on a few, search for the worst, add it, repeat.

Samples alone are too kind (an M̄ found on 4,000 of them had a true sup of 0.996 where they said 0.966), so every round
searches the box by local maximisation and takes in all the distinct local maxima that the program had not seen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.clock import Clock
from asmc_pin.condition.best_mbar.convex_program import Bounds, Solution, bandwidth_program, contraction_program
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import NORM, SCALE, Domain, sample_box
from asmc_pin.condition.search.worst_case import Found, maximise

Stopped = Literal["met", "time", "rounds", "solver"]

TOLERANCE = 1e-3
"""Of 1 − γ (or of μ): how far the searched worst case may lie from the program's bound at the end."""

_SMALLER = 0.9
"""Share taken of the factor at which a search saw M̄ break the condition: it may have missed a worse place."""

ROUNDS = 60
"""Programs after which an exchange ends."""

_SAMPLES, _STARTS, _FIRST, _TAKEN, _CONFIRMING = 2048, 24, 12, 8, 6


@dataclass(frozen=True)
class DesignProgress:
    """How far a design is.

    Attributes:
        doing: What is being looked for now, in words.
        rounds: Programs solved for it.
        bound: No M̄ has a smaller norm.
        norm: Largest norm found of the best M̄ so far; infinite before the first is searched.
        seconds: Since the beginning.
        share: Of the budget.
    """

    doing: str
    rounds: int
    bound: float
    norm: float
    seconds: float
    share: float


@dataclass(eq=False)
class Pace:
    """The time that a design may take, and who wants to know how it goes.

    Attributes:
        budget: s; infinite for as long as it takes.
        tell: Called every round.
        clock: Runs since the beginning, compiling left out.
        doing: What is being looked for now, in words.
        until: Time at which that has to end, where others come after it, s.
    """

    budget: float = np.inf
    tell: Callable[[DesignProgress], None] | None = None
    clock: Clock = field(default_factory=Clock)
    doing: str = ""
    until: float = np.inf

    def left(self) -> float:
        """Time left for what is being done, s; below zero when it is up."""
        return min(self.budget, self.until) - self.clock.seconds()

    def say(self, rounds: int, bound: float, norm: float) -> None:
        """Tell how it goes."""
        if self.tell is not None:
            seconds = self.clock.seconds()
            self.tell(DesignProgress(self.doing, rounds, bound, norm, seconds, seconds / self.budget))


@dataclass(eq=False)
class Active:
    """The configurations that the program knows, shared between programs on the same domains.

    Attributes:
        domains: One per payload end and lock choice, of the whole arm or all of one branch.
        masses: M_j, shape (configurations, nv, nv).
        q: Their configurations, shape (configurations, nv).
        armature: Their armatures, shape (configurations, nv).
        case: Index of their domain, shape (configurations,).
    """

    domains: Sequence[Domain]
    seed: int
    masses: Array = field(init=False)
    q: Array = field(init=False)
    armature: Array = field(init=False)
    case: IntArray = field(init=False)

    def __post_init__(self) -> None:
        nv = self.joints.size
        self.masses, self.q, self.armature = np.empty((0, nv, nv)), np.empty((0, nv)), np.empty((0, nv))
        self.case = np.empty(0, dtype=np.int64)
        for index, domain in enumerate(self.domains):
            q = sample_box(domain.box, _FIRST, self.seed)
            self.add(index, q, np.tile(domain.armature_lower, (_FIRST, 1)))

    @property
    def joints(self) -> IntArray:
        """Numbers of the joints that it is about."""
        return self.domains[0].joints

    def add(self, case: int, q: Array, armature: Array) -> None:
        """Take in configurations of one domain."""
        self.masses = np.concatenate((self.masses, self.domains[case].masses(q, armature)))
        self.q = np.concatenate((self.q, q))
        self.armature = np.concatenate((self.armature, armature))
        self.case = np.concatenate((self.case, np.full(len(q), case)))

    def keep(self, which: IntArray) -> None:
        """Forget the others."""
        self.masses, self.q, self.armature = self.masses[which], self.q[which], self.armature[which]
        self.case = self.case[which]


@dataclass(frozen=True, eq=False)
class Exchanged:
    """What an exchange ended with.

    Attributes:
        solution: Of the program whose M̄ this is; with ``contraction`` its bound is the best of all programs.
        norm: Largest norm that the search found for its M̄.
        bandwidth: Smallest λ_min(M⁻¹M̄) that the search found.
        rounds: Programs solved.
        configurations: Configurations evaluated by the searches.
        masses: What the last program knew: inertia matrices, shape (known, nv, nv), in the order of its weights.
        q: Their configurations, shape (known, nv).
        case: Index of their domain, shape (known,).
        stopped: Why it ended: ``met``: search and program met. ``time``: it was up. ``rounds``: they did not meet in as
            many programs as are allowed. ``solver``: it found no optimum.
    """

    solution: Solution
    norm: float
    bandwidth: float
    rounds: int
    configurations: int
    masses: Array
    q: Array
    case: IntArray
    stopped: Stopped

    @property
    def met(self) -> bool:
        """Whether search and program met."""
        return self.stopped == "met"


def exchange(
    active: Active, condition: Condition, bounds: Bounds, level: float | None = None, pace: Pace | None = None
) -> Exchanged | None:
    """Solve a design over whole domains.

    Args:
        active: Configurations to begin with; left with those that limit.
        condition: ``lemma1`` or ``weighted``.
        bounds: What M̄ may be.
        level: None: least norm. Else: largest λ_min(M⁻¹M̄) with a norm of at most this.
        pace: When to stop with what there is, after the first round at the earliest.

    Returns:
        The outcome, None where even the configurations known so far leave no M̄ at the level.
    """
    pace = pace or Pace()
    configurations, effort, bound = 0, 1, 0.0
    best: Exchanged | None = None
    for count in range(1, ROUNDS + 1):
        pace.say(count, bound, np.inf if best is None else best.norm)
        if level is None:
            solution = contraction_program(active.masses, condition, bounds, pace.left())
            # Every program's bound is one of them all.
            bound = max(bound, solution.bound)
            solution = replace(solution, bound=bound)
        else:
            found_one = bandwidth_program(active.masses, condition, bounds, level, pace.left())
            if found_one is None:
                return None if best is None else replace(best, stopped="solver")
            solution = found_one
        pace.say(count, bound, np.inf if best is None else best.norm)
        goal = solution.value if level is None else level
        # Configurations far from limiting only cost time; the search brings them back if they come to matter.
        if len(active.q) > 60:
            few = np.argsort(-solution.weights)[:40]
            active.keep(few)
            solution = replace(solution, weights=solution.weights[few])
        snapshot = active.masses, active.q, active.case
        norm, bandwidth, new = 0.0, np.inf, 0
        for index, domain in enumerate(active.domains):
            seed = active.seed + 1 + count
            known = active.q[active.case == index], active.armature[active.case == index]
            found = maximise(
                NORM[condition],
                domain,
                solution.mbar,
                samples=effort * _SAMPLES,
                starts=effort * _STARTS,
                seed=seed,
                also=known,
            )
            norm = max(norm, found.value)
            new += _take(active, index, found, goal + 0.1 * TOLERANCE * abs(1.0 - goal))
            configurations += found.configurations
            slow = maximise(
                compiled_norms.BANDWIDTH,
                domain,
                solution.mbar,
                samples=_SAMPLES // 4,
                starts=_STARTS // 4,
                seed=seed,
                also=known,
            )
            bandwidth = min(bandwidth, -slow.value)
            configurations += slow.configurations
            if level is not None:
                new += _take(active, index, slow, -solution.value * (1.0 - 0.1 * TOLERANCE))
        met = norm - goal <= TOLERANCE * abs(1.0 - goal) + 1e-9
        if level is not None:
            met = met and bandwidth >= solution.value * (1.0 - TOLERANCE)
        stopped: Stopped = "met" if met and effort > 1 else "rounds"
        now = Exchanged(solution, norm, bandwidth, count, configurations, *snapshot, stopped)
        if now.met:
            return now
        # Stopped early, the M̄ of least norm that there was; with a level the last, of the program that knows most.
        if best is None or level is not None or norm <= best.norm:
            best = now
        if pace.left() <= 0.0:
            if level is None and best.norm >= 1.0:
                best = _shrunk(active, condition, bounds, best)
            return replace(best, solution=replace(best.solution, bound=bound), rounds=count, stopped="time")
        # A wider search has the last word; what it finds is taken in like the rest.
        effort = _CONFIRMING if met or new == 0 else 1
    return best


def _shrunk(active: Active, condition: Condition, bounds: Bounds, best: Exchanged) -> Exchanged:
    """An M̄ that breaks the condition, made small enough not to, as far as a search can tell and the bounds allow."""
    mbar = best.solution.mbar

    def worst(kind: int) -> float:
        found = (
            maximise(kind, domain, mbar, samples=_SAMPLES, starts=_STARTS, seed=active.seed)
            for domain in active.domains
        )
        return max(item.value for item in found)

    value = worst(SCALE[condition])
    factor = _SMALLER * (-value if condition == "lemma1" else 2.0 / value)
    if not 0.0 < factor < 1.0 or np.any(factor * mbar < bounds.lower):
        return best
    mbar = factor * mbar
    norm, bandwidth = worst(NORM[condition]), -worst(compiled_norms.BANDWIDTH)
    if not norm < best.norm:
        return best
    return replace(best, solution=replace(best.solution, mbar=mbar), norm=norm, bandwidth=bandwidth)


def _take(active: Active, case: int, found: Found, above: float) -> int:
    """Add the distinct local maxima above a value, the highest first; how many were added."""
    order = np.argsort(-found.maxima)
    order = order[found.maxima[order] > above]
    if not order.size:
        return 0
    # Mirror images have the same value and, up to signs, the same inertia: one of them is enough.
    distinct = np.concatenate(([True], np.diff(-found.maxima[order]) > 1e-7 * np.abs(found.maxima[order[1:]])))
    chosen = order[distinct][:_TAKEN]
    active.add(case, found.maxima_q[chosen], found.maxima_armature[chosen])
    return len(chosen)
