"""What stands against better gains: the configurations, the noise, and the armature that would help."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.critical_points import Critical
from asmc_pin.sampled.gain_choice.gain_search import USEFUL, GainSearch, Margins
from asmc_pin.sampled.gain_choice.noise_budget import NoiseBudget
from asmc_pin.sampled.remedies import ALTERNATION
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.stability_report import angles

_MOST_ARMATURE, _LEAST_ARMATURE = 1e2, 1e-2  # times M̄


def hindrances(critical: Critical, loop: SampledLoop, asked: Margins) -> tuple[str, ...]:
    """Where a loop fails margins, a sentence each."""
    gains = f"with β = {loop.beta[0]:.3g}, k_s = {loop.ks[0]:.3g} 1/s"
    low, high = asked.gain
    torques = [(f"{x:.3g} times the torque", loop.scaled(mbar=x)) for x in dict.fromkeys((low, high))]
    late = (
        [(f"{asked.delay:.3g} periods more delay", replace(loop, delay=loop.delay + asked.delay))]
        if asked.delay
        else []
    )
    said = []
    for how, other in (*torques, *late):
        radius, point = critical.worst(other)
        if radius < 1.0:
            continue
        if other.undamped_delay == 0.0:
            said.append(f"with {how} {ALTERNATION}, whatever the gains")
            continue
        arms = critical.spaces[0].arms
        alone = np.append(point[:-1], 0.0)[None]
        heavy = point[-1] > 0.0 and float(critical.spaces[0].radii(other, alone)[0]) < 1.0
        cause = "gravity drives it away" if heavy else "it is unstable by inertia alone"
        said.append(f"{gains} and {how} {cause} at q = {angles(arms.q(point))} rad (spectral radius {radius:.6f})")
    return tuple(said)


def loudness(budget: NoiseBudget, loop: SampledLoop) -> tuple[str, ...]:
    """How far a loop is from keeping a budget, in a sentence; none where it keeps it."""
    share = budget.share(loop)
    if share <= 1.0:
        return ()
    said = f"{share:.3g} times what one joint may have" if math.isfinite(share) else "no stationary noise at all"
    return (f"with β = {loop.beta[0]:.3g}, k_s = {loop.ks[0]:.3g} 1/s the noise budget is not kept: {said}",)


def armature_wanted(search: GainSearch, asked: Margins) -> Array | None:
    """The armature, in proportion to M̄, that allows a useful k_s with the margins; None if 100 times M̄ is not enough.

    With κM̄ more on the joints every multiple of M̄ up to 1 + 2κ keeps the condition that M̄ keeps, so M̄ need not be
    designed again: docs/stability.md.
    """
    unit, critical = search.loop, search.critical

    def laden(share: float) -> GainSearch:
        more = share * unit.mbar
        arms = critical.spaces[0].arms
        heavier = replace(arms, armature_lower=arms.armature_lower + more, armature_upper=arms.armature_upper + more)
        spaces = tuple(replace(space, arms=heavier, points=_shifted(space.points, more)) for space in critical.spaces)
        largest = 1.0 + 2.0 * share if search.least < search.largest else search.largest
        return GainSearch(unit, Critical(spaces, _shifted(critical.points, more)), largest, search.least)

    low, high = _LEAST_ARMATURE, _MOST_ARMATURE
    if not laden(high).possible(asked, USEFUL):
        return None
    while high / low > 1.1:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if laden(middle).possible(asked, USEFUL) else (middle, high)
    while high <= _MOST_ARMATURE and laden(high).with_margins(asked, USEFUL) is None:
        high *= 1.1
    return high * unit.mbar if high <= _MOST_ARMATURE else None


def _shifted(points: Array, more: Array) -> Array:
    shifted = points.copy()
    shifted[:, -1 - more.size : -1] += more
    return shifted
