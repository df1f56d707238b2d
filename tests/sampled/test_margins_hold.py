"""The margins that are printed hold for the nonlinear sampled arm, and end where they are said to end."""

from __future__ import annotations

import math

import numpy as np
import pytest
from held_arms import grow, held_arms, later

from asmc_pin.arms import arm_names, load_arm
from asmc_pin.condition import design
from asmc_pin.sampled import SampledLoop
from asmc_pin.sampled.critical_points import Critical, critical_set
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.gain_choice.gain_design import GainDesign
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.loop_analysis import spaces_of
from asmc_pin.sampled.loop_limits import margins_of

PERIOD = 0.001
QUICK = ("two_link", "rv4fd", "double_pendulum", "two_dofs")
OTHERS = 50
CLEAR = 1.0003  # growth that shows in a run of some ten seconds


def promised(name: str, **ranges: object) -> tuple[GainDesign, Critical]:
    """Gains of the best M̄ of an arm, and the points that decide about their margins."""
    arm = load_arm(name)
    found = design(arm, explain=False, **ranges)  # type: ignore[arg-type]
    assert found.mbar is not None
    gains = suggest_gains(arm, found.mbar, PERIOD, samples=512, **ranges)  # type: ignore[arg-type]
    spaces = spaces_of(frozen_arms(arm, **ranges), samples=512, seed=0)  # type: ignore[arg-type]
    critical = critical_set(spaces, gains.loop, [space.worst(gains.loop)[1] for space in spaces])
    margins_of(critical, gains.loop)
    return gains, critical


def edges(gains: GainDesign, share: float) -> list[dict[str, float]]:
    """Each margin, used to a share; in the logarithm of the torque."""
    assert gains.reached is not None
    low, high = gains.reached.gain
    assert math.isfinite(gains.reached.delay)
    return [{"factor": low**share}, {"factor": high**share}, {"delay": share * gains.reached.delay}]


def moved(loop: SampledLoop, edge: dict[str, float]) -> SampledLoop:
    return later(loop, edge["delay"]) if "delay" in edge else loop.scaled(mbar=edge["factor"])


def check(name: str, **ranges: object) -> None:
    gains, critical = promised(name, **ranges)
    arms = critical.spaces[0].arms
    others = arms.sample(OTHERS, 99, arms.heavy)
    points = np.concatenate([critical.points, others])
    for edge in edges(gains, 0.97):
        # Until the slowest pole's transients are over.
        seconds = max(3.0, 3.0 / float(gains.loop.ks[0]))
        growing = grow(held_arms(arms, points), arms.q(points), gains.loop, seconds, **edge)
        assert not growing.any(), (edge, points[growing])
    for which in range(3):
        assert critical.worst(moved(gains.loop, edges(gains, 1.002)[which]))[0] > 1.0
        beyond = (edges(gains, share)[which] for share in (1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0))
        worst = ((edge, *critical.worst(moved(gains.loop, edge))) for edge in beyond)
        edge, radius, point = next(item for item in worst if item[1] > CLEAR)
        seconds = PERIOD * max(1000, round(6.0 / math.log(radius)))
        assert grow(held_arms(arms, point[None]), arms.q(point[None]), gains.loop, seconds, **edge).all(), edge


@pytest.mark.parametrize("name", QUICK)
def test_margins_of_small_arms_hold_and_end_for_the_nonlinear_arm(name: str) -> None:
    check(name)


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(set(arm_names()) - set(QUICK)))
def test_margins_of_every_other_arm_hold_and_end_for_the_nonlinear_arm(name: str) -> None:
    check(name)


def test_margins_over_a_payload_range_hold_at_its_ends() -> None:
    check("two_link", payload=(0.0, 3.0))


@pytest.mark.long
def test_margins_over_payload_and_armature_ranges_hold_on_the_ur5() -> None:
    check("ur5", payload=(0.0, 3.0), armature=(0.05, 0.2))
