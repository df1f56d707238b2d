"""Why the best M̄ is no better: what limits it, and what would help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms.published_armature import PUBLISHED_ARMATURE
from asmc_pin.condition.best_mbar.by_branch import Designed, blocks_of, exchange_all
from asmc_pin.condition.best_mbar.convex_program import Bounds
from asmc_pin.condition.best_mbar.design_findings import (
    PUBLISHED_ROTORS,
    ArmaturePurchase,
    DesignLimit,
    DesignPoint,
    WeightedDesign,
)
from asmc_pin.condition.best_mbar.exchange import Pace
from asmc_pin.condition.domain.arm_ranges import Case
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.condition.search.samples import NORM, Domain
from asmc_pin.condition.search.worst_case import maximise

_SHARE = 0.1
"""Of a joint's median inertia: the armature that `what_armature_buys` adds."""


def limits_of(
    all_cases: Sequence[Case], condition: Condition, outcome: Designed, most: int = 4
) -> tuple[DesignLimit, ...]:
    """The configurations with the largest multipliers.

    Args:
        all_cases: What was designed for.
        condition: ``lemma1`` or ``weighted``.
        outcome: Of the exchanges. Branches that do not limit the whole have no part in it. Where a branch limits, the
            joints of the others stand in the middle of their ranges.
        most: How many at most; those below a hundredth of all multipliers are left out.

    Returns:
        The limits, strongest first.
    """
    worst = [(outcome.parts[k], outcome.joints[k]) for k in outcome.limiting]
    total = max(sum(float(part.solution.weights.sum()) for part, _ in worst), 1e-300)
    ranked = [
        (weight / total, index, part, joints)
        for part, joints in worst
        for index, weight in enumerate(part.solution.weights.tolist())
    ]
    found = []
    for share, index, part, joints in sorted(ranked, key=lambda item: -item[0])[:most]:
        if share < 0.01:
            break
        mass, mbar = part.masses[index], np.array(part.solution.mbar)
        left, right = np.empty(len(mbar)), np.empty(len(mbar))
        norm, factor = compiled_norms.extreme(NORM[condition], mass, mbar, left, right)
        larger, _ = compiled_norms.extreme(
            NORM[condition], mass, mbar * (1.0 + 1e-6), np.empty(len(mbar)), np.empty(len(mbar))
        )
        case = all_cases[part.case[index]]
        q = case.domain.box.centre
        q[joints] = part.q[index]
        # The joint whose own inertia, changed by the same share of itself, moves the norm most.
        joint = int(joints[np.argmax(np.abs(factor * left * right) * np.diag(mass))])
        found.append(
            DesignLimit(
                q=q,
                share=share,
                joint=case.domain.arm.joint_names[joint],
                side="small" if larger < norm else "large",
                case=case.label,
            )
        )
    return tuple(found)


def what_armature_buys(
    all_cases: Sequence[Case], condition: Condition, bounds: Bounds, least: Designed, seed: int, pace: Pace
) -> tuple[ArmaturePurchase, ...]:
    """The least norm after adding a tenth of its own median inertia to the most promising joint, and to every joint.

    Where several branches limit alike, it is the most promising joint of each.

    Reflected inertia is the rotor's times the gear ratio squared, so this is what gearing or a heavier rotor would buy.
    """
    typical = least.typical
    gain = -least.by_armature * typical
    names = all_cases[0].domain.arm.joint_names
    found = []
    limiting = [least.joints[k] for k in least.limiting]
    promising = [int(mine[np.argmax(gain[mine])]) for mine in limiting]
    for where, joints in (
        (" and ".join(f"'{names[joint]}'" for joint in promising), promising),
        ("every joint", list(range(len(names)))),
    ):
        added = np.zeros(len(names))
        added[joints] = _SHARE * typical[joints]
        domains = [
            replace(d, armature_lower=d.armature_lower + added, armature_upper=d.armature_upper + added)
            for d in (case.domain for case in all_cases)
        ]
        outcome = exchange_all(blocks_of(domains, bounds, seed), condition, bounds, pace=pace)
        if outcome is not None:
            found.append(ArmaturePurchase(where, added, outcome.norm))
    return tuple(found)


def what_published_rotors_buy(
    all_cases: Sequence[Case], condition: Condition, bounds: Bounds, seed: int, pace: Pace
) -> tuple[ArmaturePurchase, ...]:
    """The least norm with the rotors that are published of this arm, where it has none so far."""
    arm = all_cases[0].domain.arm
    entry = arm.made_of.entry
    known = PUBLISHED_ARMATURE.get(entry.name) if entry is not None else None
    # What a simulation model has is no prospect for the robot.
    if known is None or known.simulated or any(np.any(case.domain.armature_upper > 0.0) for case in all_cases):
        return ()
    rotors = np.array([known.armature.get(name, 0.0) for name in arm.joint_names])
    domains = [replace(case.domain, armature_lower=rotors, armature_upper=rotors) for case in all_cases]
    outcome = exchange_all(blocks_of(domains, bounds, seed), condition, bounds, pace=pace)
    return () if outcome is None else (ArmaturePurchase(PUBLISHED_ROTORS, rotors, outcome.norm),)


def other_condition(
    all_cases: Sequence[Case], bounds: Bounds, mbar: Array, seed: int, pace: Pace
) -> WeightedDesign | None:
    """What the weighted condition would allow where Lemma 1 gave `mbar`."""
    domains = [case.domain for case in all_cases]
    least = exchange_all(blocks_of(domains, bounds, seed), "weighted", bounds, pace=pace)
    if least is None:
        return None
    largest = max(_worst(compiled_norms.WEIGHTED_SCALE, domain, mbar, seed) for domain in domains)
    lemma1 = min(-_worst(compiled_norms.LEMMA1_SCALE, domain, mbar, seed) for domain in domains)
    return WeightedDesign(DesignPoint(least.norm, least.bandwidth, least.mbar), 2.0 / largest, max(lemma1, 0.0))


def _worst(kind: int, domain: Domain, mbar: Array, seed: int) -> float:
    return maximise(kind, domain, mbar, samples=8192, seed=seed).value
