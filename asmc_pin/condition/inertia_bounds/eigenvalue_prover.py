"""The prover's half of a bound of M: m W ≺ M(q), or M(q) ≺ m W, over every case, for a better and better m.

Both are statements that a certificate has: at γ = 1 ``weighted`` says M ≻ (f/2) W, at γ = ½ ``bounded`` says M ≺ 2 f W.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.proof_progress import ProofProgress
from asmc_pin.condition.certificate.statement import Statement
from asmc_pin.condition.certificate.strategy import Attempted, Prover
from asmc_pin.condition.certificate.worst_known import STRICT
from asmc_pin.condition.inertia_bounds.extreme_eigenvalue import Extreme

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case


class _Share:
    """What was seen, as the prover's strategy takes it: a scale that is refuted, half of its unit at the start."""

    norm = np.inf

    def __init__(self, extreme: Extreme) -> None:
        self._extreme = extreme
        self.unit = 2.0 * extreme.value if extreme.side == "least" else 0.5 * extreme.value

    @property
    def scale(self) -> float:
        """The bound at this scale is false."""
        seen = self._extreme.value / self.unit
        return (seen if self._extreme.side == "least" else 1.0 / seen) * (1.0 + STRICT)

    def climb(self, case: int, q: Array, armature: Array) -> None:
        """Search on from there."""
        self._extreme.climb(case, q, armature)


class EigenvalueProver(Prover):
    """Proves a bound of one end of the spectrum; the larger the strategy's scale, the closer the bound.

    Args:
        cases: The arms that it is about.
        weights: Diagonal of W, shape (nv,), kg·m².
        extreme: What the search has seen of that end.
        began: `time.monotonic()` of the beginning, s.
        budget: Wall time from then on, s.
        threads: Worker threads.
        progress: Called some times a second, with bounds in place of scales.
    """

    def __init__(
        self,
        cases: Sequence[Case],
        weights: Array,
        extreme: Extreme,
        *,
        began: float,
        budget: float,
        threads: int,
        progress: Callable[[ProofProgress], None] | None,
    ) -> None:
        self._share, self._side = _Share(extreme), extreme.side
        self._exact: float | None = None

        def tell(state: ProofProgress) -> None:
            assert progress is not None
            words = f"{self._side} eigenvalue"
            progress(
                ProofProgress(self.bound or np.nan, extreme.value, words, state.volume, state.tests, state.seconds)
            )

        super().__init__(
            cases,
            weights,
            "weighted",
            self._share,  # type: ignore[arg-type]  # all that the strategy asks of the worst
            began=began,
            budget=budget,
            threads=threads,
            progress=None if progress is None else tell,
        )

    @property
    def bound(self) -> float | None:
        """The m that is proven; None for none."""
        if self._exact is not None and self.scale == self._scale_of(self._exact):
            return self._exact
        return self._at(self.scale) if self.scale > 0.0 else None

    def try_bound(self, bound: float) -> Attempted:
        """Prove that very m; where it is, `raise_scale` goes on from there."""
        outcome = self._attempt(self._of(bound), f"{bound:.6g}", True)
        if outcome == "proven":
            # Its scale is rounded, and back would be another bound.
            self.scale, self._exact = self._scale_of(bound), bound
        return outcome

    def why_not(self, bound: float) -> str:
        """Why `try_bound` was blocked at that bound."""
        scale = self._scale_of(bound)
        return self.why_blocked(self._share.scale - scale, scale)

    def _at(self, scale: float) -> float:
        return self._share.unit * scale if self._side == "least" else self._share.unit / scale

    def _scale_of(self, bound: float) -> float:
        return bound / self._share.unit if self._side == "least" else self._share.unit / bound

    def _scale_statements(self, scale: float) -> list[Statement]:
        return self._of(self._at(scale))

    def _of(self, bound: float) -> list[Statement]:
        found = []
        for index, corner in enumerate(self.corners):
            domain = self._domain(index)
            lower, upper = domain.armature_lower, domain.armature_upper
            # Halving and doubling are exact: what is proven is this float.
            if self._side == "least" and corner.least:
                found.append(Statement("weighted", 2.0 * bound, 1.0, index, lower, np.zeros_like(lower)))
            elif self._side == "largest" and corner.most:
                found.append(Statement("bounded", 0.5 * bound, 0.5, index, lower, upper - lower))
        return found
