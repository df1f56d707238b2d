"""M̄'s scale, β and k_s together and apart: the gains of least error under a drifting load that keep stated margins."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, product

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.critical_points import Critical
from asmc_pin.sampled.gain_choice.noise_budget import NoiseBudget
from asmc_pin.sampled.linear_map import inertia_ratios, modal_radius
from asmc_pin.sampled.loop_limits import margins_of
from asmc_pin.sampled.sampled_loop import SampledLoop

USEFUL = 1.0
"""Slowest k_s that is of use, 1/s: errors die with a time constant of a second."""

_SLACK = 1.003  # the search asks for a little more, so that what is found afterwards is what was asked for
_SLOWEST = 0.1  # 1/s, of k_s: what takes longer than ten seconds to die is not controlled
_ROUNDS = 6
_QUIET = 30  # loops with margins, the smallest m̄(β + k_s) first, among which the least noise is looked for

Rank = tuple[bool, float]
"""Whether gains are useful, and how large m̄βk_s is."""

_ANY: Rank = (True, math.inf)


@dataclass(frozen=True)
class Margins:
    """Margins asked for or reached.

    Attributes:
        gain: Factors, below and above 1, by which the drives' true torque may differ from the reported one.
        delay: Transport delay that may come on top, periods.
    """

    gain: tuple[float, float]
    delay: float

    def cover(self, other: Margins) -> bool:
        """Whether they are no smaller than others."""
        return self.gain[0] <= other.gain[0] and self.gain[1] >= other.gain[1] and self.delay >= other.delay

    def share(self, part: float) -> Margins:
        """A part of them: the same power of both factors, the same part of the delay."""
        return Margins((self.gain[0] ** part, self.gain[1] ** part), part * self.delay)

    @cached_property
    def torques(self) -> Array:
        """Torque factors to look at, the ends first."""
        low, high = math.log(self.gain[0] / _SLACK), math.log(self.gain[1] * _SLACK)
        return np.exp([low, high, 0.5 * low, 0.0, 0.5 * high])

    @cached_property
    def delays(self) -> Array:
        """Delays to look at, the end first."""
        return self.delay * _SLACK * np.array([1.0, 0.75, 0.5, 0.25]) if self.delay > 0.0 else np.zeros(0)


@dataclass
class GainSearch:
    """A search on the points that decide, and its exchange with the whole workspace.

    Attributes:
        loop: M̄ at scale 1 and the timing; its gains do not matter.
        critical: What decides; grows.
        largest: Largest scale of M̄.
        least: Smallest; the same where M̄ may not be scaled.
        budget: Noise that the torque may have; None for any.
        fineness: How many scales of M̄, β and k_s the grid has.
    """

    loop: SampledLoop
    critical: Critical
    largest: float = 1.0
    least: float = 0.05
    budget: NoiseBudget | None = None
    fineness: tuple[int, int, int] = (12, 20, 24)

    def __post_init__(self) -> None:
        """No mode is known yet."""
        self._modes: tuple[int, Array] = (0, np.zeros(0))

    def with_margins(self, asked: Margins, least_ks: float = 0.0) -> SampledLoop | None:
        """The best gains with these margins over the workspace, useful ones first; None if there are none.

        Best: m̄βk_s largest, to which the error under a drifting load and the integral of the error after a step are
        inversely proportional. Gains with k_s of at least `USEFUL` go before others.
        """
        ceiling, found = _ANY, None
        for _ in range(_ROUNDS):
            found = self._best(asked, ceiling, least_ks)
            if found is None:
                return None
            # The more points decide, the less is left; the climb may still end a little higher than before.
            useful, size = rank_of(found, self.loop)
            ceiling = useful, 1.1 * size
            quiet = self.budget is None or self.budget.holds(found)
            if Margins(*margins_of(self.critical, found)).cover(asked) and quiet:
                break
        return found

    def with_least_noise(self, asked: Margins, noise: NoiseBudget) -> SampledLoop | None:
        """Gains with margins and little noise, whatever the budget: the least of some with a small m̄(β + k_s)."""
        found = None
        for _ in range(_ROUNDS):
            slow_first = sorted(self._candidates(), key=lambda loop: float(loop.mbar[0] * loop.kd[0]))
            kept = (loop for loop in slow_first if self.keeps(loop, asked))
            found = min(islice(kept, _QUIET), key=noise.share, default=None)
            if found is None or Margins(*margins_of(self.critical, found)).cover(asked):
                break
        return found

    def with_most(self, asked: Margins) -> SampledLoop | None:
        """The gains that keep the largest share of margins that cannot be had; None where no gains are stable."""
        found = None
        for _ in range(_ROUNDS):
            share, found = self._most(asked)
            if found is None or Margins(*margins_of(self.critical, found)).cover(asked.share(share)):
                break
        return found

    def possible(self, asked: Margins, least_ks: float) -> bool:
        """Whether any gains of the grid keep margins on the points that decide."""
        return any(loop.ks[0] >= least_ks and self.keeps(loop, asked) for loop in self._candidates())

    def keeps(self, loop: SampledLoop, asked: Margins) -> bool:
        """Whether a loop keeps margins, and to the budget, on the points that decide."""
        torques = asked.torques
        if loop.undamped_delay <= asked.delay or self._modal_radius(loop, torques) >= 1.0:
            return False
        return (
            self.critical.radius_at_torques(loop, torques[:2]) < 1.0
            and all(self.critical.radius(replace(loop, delay=loop.delay + d)) < 1.0 for d in asked.delays)
            and self.critical.radius_at_torques(loop, torques[2:]) < 1.0
            and (self.budget is None or self.budget.keeps(loop))
        )

    def _modal_radius(self, loop: SampledLoop, torques: Array) -> float:
        """The same for the inertia alone at its extremes: what can be excluded fast."""
        if self._modes[0] != len(self.critical.points):
            ratios = inertia_ratios(self.critical.mass, self.loop.mbar)
            self._modes = (len(self.critical.points), np.array([ratios.min(), ratios.max()]))
        ratios = self._modes[1] * (loop.mbar[0] / self.loop.mbar[0])
        return float(modal_radius(np.multiply.outer(torques[:2], ratios), loop).max())

    def _candidates(self) -> Iterator[SampledLoop]:
        fastest = 1.0 / self.loop.period
        slowest = min(_SLOWEST, 1e-3 * fastest)
        many, rates, steps = self.fineness
        scales = np.geomspace(self.least, self.largest, many if self.least < self.largest else 1)
        betas = np.geomspace(2.0 * slowest, fastest, rates)
        # The map knows β + k_s and βk_s only: k_s ≤ β leaves nothing out.
        slopes = np.append(np.geomspace(slowest, fastest, steps), USEFUL)
        for scale in scales:
            # Noise grows with k_s too: a β that makes too much with the slowest k_s need not be tried with others.
            some = [beta for beta in betas if self.budget is None or self.budget.keeps(self._at(scale, beta, slowest))]
            for beta, ks in product(some, slopes):
                if ks <= beta:
                    yield self._at(float(scale), float(beta), float(ks))

    def _at(self, scale: float, beta: float, ks: float) -> SampledLoop:
        n = self.loop.nv
        return replace(self.loop, mbar=self.loop.mbar * scale, beta=np.full(n, beta), ks=np.full(n, ks))

    def first(self, asked: Margins) -> SampledLoop | None:
        """The best of the grid on the points at hand: where a search that costs more is worth while."""
        return self._best(asked, _ANY, 0.0, refined=False)

    def _best(self, asked: Margins, ceiling: Rank, least_ks: float, refined: bool = True) -> SampledLoop | None:
        ranked = [(rank_of(loop, self.loop), i, loop) for i, loop in enumerate(self._candidates())]
        for rank, _, loop in sorted(ranked, reverse=True):
            if rank <= ceiling and loop.ks[0] >= least_ks and self.keeps(loop, asked):
                return self._refined(loop, asked, ceiling) if refined else loop
        return None

    def _refined(self, loop: SampledLoop, asked: Margins, ceiling: Rank) -> SampledLoop:
        """Climb along the boundary from the best of the grid."""
        at = np.log([loop.mbar[0] / self.loop.mbar[0], loop.beta[0], loop.ks[0]])
        best, step = rank_of(loop, self.loop), 0.2
        moves = np.array([move for move in product((-1.0, 0.0, 1.0), repeat=3) if any(move)])
        low, high = math.log(self.least), math.log(self.largest)
        while step > 0.01:
            reached = None
            for move in moves:
                scale, beta, ks = at + step * move
                scale = min(max(scale, low), high)
                if ks > beta or beta > -math.log(self.loop.period):
                    continue
                other = self._at(math.exp(scale), math.exp(beta), math.exp(ks))
                rank = rank_of(other, self.loop)
                if best < rank <= ceiling and self.keeps(other, asked):
                    best, loop, reached = rank, other, np.array([scale, beta, ks])
            at, step = (at, 0.5 * step) if reached is None else (reached, step)
        return loop

    def _most(self, asked: Margins) -> tuple[float, SampledLoop | None]:
        """The largest share of margins on the points that decide: a pass in which only a better one costs anything."""
        share, found = 0.0, None
        everything = list(self._candidates())
        order = np.random.default_rng(0).permutation(len(everything))
        for loop in (everything[i] for i in order):
            if not self.keeps(loop, asked.share(share + 0.01)):
                continue
            low, high = share + 0.01, 1.0
            while high - low > 0.005:
                middle = 0.5 * (low + high)
                low, high = (middle, high) if self.keeps(loop, asked.share(middle)) else (low, middle)
            share, found = low, loop
        return share, found


def rank_of(loop: SampledLoop, unit: SampledLoop) -> Rank:
    """What is made as large as possible, in relation to PPC's βk_s under the same M̄; useful gains before all others."""
    stiffness = loop.ks[0] * loop.resting_beta[0] * unit.torque_age / loop.torque_age
    return bool(loop.ks[0] >= USEFUL), float(loop.mbar[0] / unit.mbar[0] * stiffness)
