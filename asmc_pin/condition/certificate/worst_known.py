"""The refuting half of a certificate: the worst that search has found so far, over all cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import NORM, SCALE, figures_at
from asmc_pin.condition.search.worst_case import Found, maximise
from asmc_pin.condition.search.worst_of_arm import breaking_factor

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case

STRICT = 1e-9
"""A scale is refuted this much above where the search found equality, so that rounding cannot have made it."""


class Worst:
    """The worst that is known; every figure in it is of a configuration that was evaluated.

    Attributes:
        scale: The condition is violated for M̄ times this, at `scale_q`.
        scale_q: Shape (nv,).
        scale_armature: Shape (nv,), kg·m².
        scale_case: Index of the case.
        norm: Largest norm seen, at `norm_q`.
        norm_q: Shape (nv,).
        norm_armature: Shape (nv,), kg·m².
        norm_case: Index of the case.
    """

    def __init__(self, cases: Sequence[Case], mbar: Array, condition: Condition, samples: int, starts: int, seed: int):
        self._cases, self._mbar, self._condition = cases, mbar, condition
        self.scale, self.norm = np.inf, -np.inf
        self.evaluations = 0
        for index, case in enumerate(cases):
            for kind in (SCALE[condition], NORM[condition]):
                self._take(index, maximise(kind, case.domain, mbar, samples=samples, starts=starts, seed=seed))

    def climb(self, case: int, q: Array, armature: Array) -> None:
        """Search on from a configuration at which a proof did not get on."""
        domain = self._cases[case].domain
        q = domain.box.wrap(q)
        for kind in (SCALE[self._condition], NORM[self._condition]):
            also = q[None, :], np.clip(armature, domain.armature_lower, domain.armature_upper)[None, :]
            self._take(case, maximise(kind, domain, self._mbar, samples=256, starts=4, also=also))

    def _take(self, case: int, found: Found) -> None:
        self.evaluations += found.configurations
        domain = self._cases[case].domain
        scale_kind, norm_kind = SCALE[self._condition], NORM[self._condition]
        at = found.q[None, :]
        scale = breaking_factor(
            scale_kind, float(figures_at(scale_kind, domain.tree, at, self._mbar, found.armature)[0])
        )
        norm = float(figures_at(norm_kind, domain.tree, at, self._mbar, found.armature)[0])
        if scale * (1.0 + STRICT) < self.scale:
            self.scale, self.scale_q = scale * (1.0 + STRICT), found.q
            self.scale_armature, self.scale_case = found.armature, case
        if norm > self.norm:
            self.norm, self.norm_q, self.norm_armature, self.norm_case = norm, found.q, found.armature, case
