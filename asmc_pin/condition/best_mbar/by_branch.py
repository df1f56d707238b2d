"""A design for arms with several branches on the base: a program for each block of M(q), put together afterwards.

M(q) and M̄ have the same blocks, and a norm of the whole is the largest of its blocks'. So with one m̄ per joint the best
of the whole is the best of each branch, and no M̄ of the whole has less than the largest of the branches' bounds. One m̄
for all joints ties the branches together: then there is one program over the whole arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.best_mbar.convex_program import Bounds
from asmc_pin.condition.best_mbar.exchange import TOLERANCE, Active, Exchanged, Pace, Stopped, exchange
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import Domain


def blocks_of(domains: Sequence[Domain], bounds: Bounds, seed: int) -> list[Active]:
    """What the programs begin with: one for each branch on the base, or one for the whole where m̄ is one for all.

    Args:
        domains: One per payload end and lock choice, all with the same joints.
        bounds: What M̄ may be.
        seed: Of the searches.
    """
    if bounds.form == "scalar":
        return [Active(domains, seed)]
    return [Active(parts, seed) for parts in zip(*(domain.by_branch() for domain in domains), strict=True)]


@dataclass(frozen=True, eq=False)
class Designed:
    """What the exchanges of all branches came to, as one M̄.

    Attributes:
        parts: The outcome of each program.
        joints: Numbers of the joints in each.
        level: The norm that was allowed; None where the least was looked for.
    """

    parts: tuple[Exchanged, ...]
    joints: tuple[IntArray, ...]
    level: float | None

    @property
    def norm(self) -> float:
        """Largest norm that a search found."""
        return max(part.norm for part in self.parts)

    @property
    def bandwidth(self) -> float:
        """Smallest λ_min(M⁻¹M̄) that a search found."""
        return min(part.bandwidth for part in self.parts)

    @property
    def bound(self) -> float:
        """No M̄ has a smaller norm."""
        return max(part.solution.bound for part in self.parts)

    @property
    def mbar(self) -> Array:
        """Shape (nv,), kg·m²."""
        return self._whole([part.solution.mbar for part in self.parts])

    @property
    def rounds(self) -> int:
        """Programs solved, all branches together."""
        return sum(part.rounds for part in self.parts)

    @property
    def stopped(self) -> Stopped:
        """Why the exchange ended that did not meet, the first of them; ``met`` where all did."""
        return next((part.stopped for part in self.parts if not part.met), "met")

    @property
    def limiting(self) -> list[int]:
        """Which of the parts keep the whole from being better: those as bad as the worst, to the tolerance."""
        if self.level is None:
            value = max(part.solution.value for part in self.parts)
            return [k for k, part in enumerate(self.parts) if value - part.solution.value <= TOLERANCE * abs(1 - value)]
        value = min(part.solution.value for part in self.parts)
        return [k for k, part in enumerate(self.parts) if part.solution.value <= (1.0 + TOLERANCE) * value]

    @property
    def by_armature(self) -> Array:
        """Derivative of the figure by each joint's armature, shape (nv,); zero where another branch limits it."""
        worst = self.limiting
        slopes = [part.solution.by_armature for part in self.parts]
        return self._whole([slope if k in worst else 0.0 * slope for k, slope in enumerate(slopes)])

    @property
    def typical(self) -> Array:
        """Median inertia of each joint over the configurations known, shape (nv,), kg·m²."""
        return self._whole([np.median(np.diagonal(part.masses, axis1=1, axis2=2), axis=0) for part in self.parts])

    def _whole(self, values: Sequence[Array]) -> Array:
        out = np.empty(sum(mine.size for mine in self.joints))
        for mine, part in zip(self.joints, values, strict=True):
            out[mine] = part
        return out


def exchange_all(
    blocks: Sequence[Active], condition: Condition, bounds: Bounds, level: float | None = None, pace: Pace | None = None
) -> Designed | None:
    """Solve a design over whole domains, branch by branch.

    Args:
        blocks: Configurations to begin with, of each branch; left with those that limit.
        condition: ``lemma1`` or ``weighted``.
        bounds: What M̄ may be, of all joints.
        level: As for `exchange`.
        pace: When to stop with what there is; each branch gets its share of the time left, and what is over at the end
            goes to those whose search and program have not met.

    Returns:
        The outcome, None where some branch has none.
    """
    pace = pace or Pace()
    doing = pace.doing
    found: list[Exchanged | None] = [None] * len(blocks)

    def go(k: int, share: float) -> None:
        pace.doing = f"{doing}, branch {k + 1} of {len(blocks)}" if len(blocks) > 1 else doing
        pace.until = pace.clock.seconds() + share * pace.left()
        found[k] = exchange(blocks[k], condition, bounds.of(blocks[k].joints), level, pace)
        pace.until = np.inf

    for k in range(len(blocks)):
        go(k, 1.0 / (len(blocks) - k))
        if found[k] is None:
            return None
    for k, part in enumerate(found):
        if len(blocks) > 1 and part is not None and part.stopped == "time" and pace.left() > 0.0:
            before = part
            go(k, 1.0)
            after = found[k]
            worse = after is None or (level is None and after.norm > before.norm)
            found[k] = before if worse else after
    pace.doing = doing
    outcomes = tuple(part for part in found if part is not None)
    return Designed(outcomes, tuple(block.joints for block in blocks), level)
