"""The search's half of a bound of M: the least or the largest eigenvalue of W^(−½) M W^(−½) that was seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.search.samples import figures_at
from asmc_pin.condition.search.worst_case import Found, maximise

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case

Side = Literal["least", "largest"]

_KIND = {"least": compiled_norms.WEIGHTED_SCALE, "largest": compiled_norms.BANDWIDTH}
"""λ_max(M⁻¹W) and −λ_min(M⁻¹W): of both more is worse."""


class Extreme:
    """What is known of one end of the spectrum; `value` is of a configuration that was evaluated.

    Attributes:
        value: The least, or the largest, eigenvalue seen.
        q: Where, shape (nv,), rad (m where prismatic).
        armature: With which armature, shape (nv,), kg·m².
        case: Index of the case.
        evaluations: How many configurations were evaluated.
    """

    def __init__(
        self, cases: Sequence[Case], weights: Array, side: Side, *, samples: int, starts: int, seed: int
    ) -> None:
        self._cases, self._weights, self.side = cases, weights, side
        self._kind, self._worst = _KIND[side], -np.inf
        self.evaluations = 0
        for index, case in enumerate(cases):
            self._take(index, maximise(self._kind, case.domain, weights, samples=samples, starts=starts, seed=seed))

    def climb(self, case: int, q: Array, armature: Array) -> None:
        """Search on from a configuration at which a proof did not get on."""
        domain = self._cases[case].domain
        also = domain.box.wrap(q)[None, :], np.clip(armature, domain.armature_lower, domain.armature_upper)[None, :]
        self._take(case, maximise(self._kind, domain, self._weights, samples=256, starts=4, also=also))

    def _take(self, case: int, found: Found) -> None:
        self.evaluations += found.configurations
        tree = self._cases[case].domain.tree
        worst = float(figures_at(self._kind, tree, found.q[None, :], self._weights, found.armature)[0])
        if worst > self._worst:
            self._worst, self.value = worst, 1.0 / abs(worst)
            self.q, self.armature, self.case = found.q, found.armature, case
