"""The worst configuration of an arm under a condition, searched: its norm, and the factor of M̄ that it refutes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.norm.two_conditions import Condition, check_condition, check_mbar
from asmc_pin.condition.search.samples import NORM, SCALE, domain_of
from asmc_pin.condition.search.worst_case import SAMPLES, STARTS, maximise

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


def search_worst(
    arm: Arm,
    mbar: Array,
    condition: Condition = "lemma1",
    box: BoxLike = None,
    seed: int = 0,
    *,
    samples: int = SAMPLES,
    starts: int = STARTS,
    threads: int = 1,
) -> tuple[float, Array]:
    """Largest norm of a condition that a search finds, and where.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, a number or nv of them, kg·m².
        condition: ``lemma1`` (‖I − M⁻¹M̄‖₂) or ``weighted`` (max|1 − λ(M⁻¹M̄)|).
        box: Joint box; see `BoxLike`.
        seed: Of the samples.
        samples: Number of samples.
        starts: Number of local climbs.
        threads: Worker threads.

    Returns:
        The norm and the configuration, shape (nv,), which has exactly that norm up to rounding.
    """
    kind = NORM[check_condition(condition)]
    found = maximise(
        kind, domain_of(arm, box), check_mbar(mbar, arm.nv), samples=samples, starts=starts, seed=seed, threads=threads
    )
    return found.value, found.q


def scale_refuted(
    arm: Arm,
    mbar: Array,
    condition: Condition = "lemma1",
    box: BoxLike = None,
    seed: int = 0,
    *,
    samples: int = SAMPLES,
    starts: int = STARTS,
    threads: int = 1,
) -> tuple[float, Array]:
    """Smallest factor f found such that f·M̄ violates the condition, and where.

    Lemma 1 for f·M̄ reads N M + M N ≻ f I with N = M̄⁻¹, and the weighted condition f λ_max(M⁻¹M̄) < 2: both figures are
    searched as they stand, without a search over f. At the returned configuration every larger factor violates too.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, a number or nv of them, kg·m².
        condition: ``lemma1`` or ``weighted``.
        box: Joint box; see `BoxLike`.
        seed: Of the samples.
        samples: Number of samples.
        starts: Number of local climbs.
        threads: Worker threads.

    Returns:
        The factor (0 where no positive one satisfies Lemma 1) and the configuration, shape (nv,).
    """
    kind = SCALE[check_condition(condition)]
    found = maximise(
        kind, domain_of(arm, box), check_mbar(mbar, arm.nv), samples=samples, starts=starts, seed=seed, threads=threads
    )
    return breaking_factor(kind, found.value), found.q


def breaking_factor(kind: int, value: float) -> float:
    """The factor of M̄ at which a condition breaks, from its figure; 0 where no positive one satisfies it.

    Args:
        kind: `compiled_norms.LEMMA1_SCALE` or `compiled_norms.WEIGHTED_SCALE`.
        value: The figure at one M(q), or the largest of many.
    """
    return max(-value, 0.0) if kind == compiled_norms.LEMMA1_SCALE else 2.0 / value
