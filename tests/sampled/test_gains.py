"""Gains by margin: the best that keep what is asked for, and honest words where nothing does."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.condition import design
from asmc_pin.condition.norm.two_conditions import lemma1_norm
from asmc_pin.errors import ParameterError
from asmc_pin.sampled import SampledLoop, closed_loop, stability
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.gain_choice.gain_design import GainDesign
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.workspace_worst import workspace_of

TWO_LINK_MBAR = 0.0444444


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def gains(two_link: Arm) -> GainDesign:
    return suggest_gains(two_link, TWO_LINK_MBAR, 0.001)


def rest_radii(arm: Arm, q: Array, loop: SampledLoop) -> Array:
    """The map at rest, without the search."""
    return closed_loop(arm.mass_matrix(q), loop, stiffness=gravity_stiffness(arm, q)).spectral_radius()


def keeps(arm: Arm, loop: SampledLoop, gain_margin: float, delay_margin: float) -> bool:
    limits = stability(arm, loop.mbar, loop.ks, loop.beta, loop.period, samples=512, seed=3).limits
    assert limits is not None
    low, high = limits.gain_margin
    return bool(low <= 1.0 / gain_margin and high >= gain_margin and limits.delay_margin >= delay_margin)


def test_suggested_gains_keep_the_margins_asked_for_and_stiffer_ones_do_not(two_link: Arm, gains: GainDesign) -> None:
    assert gains.met
    assert gains.useful
    assert keeps(two_link, gains.loop, 2.0, 1.0)
    # One of the three gives way at once.
    stiffer = [gains.loop.scaled(ks=1.1), gains.loop.scaled(mbar=1.1), gains.loop.scaled(beta=1.15)]
    assert not all(keeps(two_link, loop, 2.0, 1.0) for loop in stiffer)


def test_margins_hold_on_a_grid_of_the_whole_box_at_rest_under_gravity(two_link: Arm, gains: GainDesign) -> None:
    angles = np.linspace(-math.pi, math.pi, 81)
    q = np.stack(np.meshgrid(angles, angles), axis=-1).reshape(-1, 2)
    assert gains.reached is not None
    for factor in np.geomspace(*gains.reached.gain, 9):
        assert rest_radii(two_link, q, gains.loop.scaled(mbar=float(factor))).max() < 1.0
    for delay in np.linspace(0.0, gains.reached.delay, 5):
        later = SampledLoop(gains.loop.mbar, gains.loop.ks, gains.loop.beta, 0.001, delay=float(delay))
        assert rest_radii(two_link, q, later).max() < 1.0


def test_gains_apart_have_less_error_under_a_drifting_load_than_equal_ones(gains: GainDesign) -> None:
    # β = k_s = 24.8 at M̄ × 0.499 was the best of equal gains by inertia alone.
    assert gains.loop.ks[0] < gains.loop.beta[0]
    assert gains.mbar_scale * float(gains.loop.kp[0]) > 0.499 * 24.8**2


def test_scaling_mbar_down_has_kept_lemma_1(two_link: Arm, gains: GainDesign) -> None:
    assert gains.mbar_scale < 1.0
    assert lemma1_norm(workspace_of(two_link, samples=512).mass, gains.mbar).max() < 1.0


def test_a_fixed_mbar_without_room_gives_the_margins_that_can_be_had_and_says_why(two_link: Arm) -> None:
    design = suggest_gains(two_link, TWO_LINK_MBAR, 0.001, scale_mbar=False, samples=512)
    assert design.mbar_scale == 1.0
    assert not design.met
    assert design.reached is not None
    assert 1.0 < design.reached.gain[1] < 2.0
    text = "\n".join(design.lines())
    assert "no gains with the margins asked for were found: torque gain 0.5 to 2, extra delay 1 periods" in text
    assert "2 times the torque it is unstable by inertia alone at q = (" in text
    plain = json.loads(json.dumps(design.to_json_dict(), allow_nan=False))
    assert plain["asked"] == {"gain_margin": [0.5, 2.0], "delay_margin_periods": 1.0}
    assert plain["met"] is False
    assert plain["gain_margin"][1] == design.reached.gain[1]


def test_an_arm_on_which_nothing_is_stable_gives_its_mbar_and_the_reason(two_link: Arm) -> None:
    # A hundredth of an M̄ at 50 ms follows the load too slowly for any gains.
    design = suggest_gains(two_link, 0.001, 0.05, scale_mbar=False, samples=256)
    assert design.report is None
    plain = json.loads(json.dumps(design.to_json_dict(), allow_nan=False))
    assert plain["mbar"] == [0.001, 0.001]
    assert plain["ks"] is plain["gain_margin"] is None
    text = "\n".join(design.lines())
    assert "no β and k_s were found stable" in text
    assert "M̄ = 0.001" in text


@pytest.mark.long
def test_the_armature_that_is_advised_allows_what_it_is_said_to(two_link: Arm) -> None:
    poor = suggest_gains(two_link, 0.002, 0.004, samples=512)
    assert not (poor.met and poor.useful)
    assert poor.armature is not None
    heavier = two_link.replace(armature=poor.armature.tolist())
    # Every multiple of M̄ up to 1 + 2κ keeps what M̄ keeps: docs/stability.md.
    share = float(poor.armature[0] / 0.002)
    rich = suggest_gains(heavier, (1.0 + 2.0 * share) * 0.002, 0.004, samples=512)
    assert rich.met
    assert rich.useful
    assert lemma1_norm(workspace_of(heavier, samples=512).mass, np.full(2, 0.002 * (1.0 + 2.0 * share))).max() < 1.0


@pytest.mark.long
def test_so100_has_useful_gains_that_hold_with_gravity() -> None:
    arm = load_arm("so100")
    found = design(arm, explain=False)
    assert found.mbar is not None
    gains = suggest_gains(arm, found.mbar, 0.001, samples=1024)
    assert gains.met
    assert gains.useful
    many = workspace_of(arm, samples=2048, seed=11, gravity=True)
    assert gains.reached is not None
    for factor in gains.reached.gain:
        assert many.radii(gains.loop.scaled(mbar=factor)).max() < 1.0
    later = gains.loop.__class__(gains.loop.mbar, gains.loop.ks, gains.loop.beta, 0.001, delay=gains.reached.delay)
    assert many.radii(later).max() < 1.0


@pytest.mark.parametrize("change", [{"gain_margin": 0.5}, {"delay_margin": -1.0}, {"gain_margin": math.nan}])
def test_margins_that_make_no_sense_are_refused_by_name(two_link: Arm, change: dict[str, float]) -> None:
    (name,) = change
    with pytest.raises(ParameterError) as caught:
        suggest_gains(two_link, 0.01, 0.001, **change)  # type: ignore[arg-type]
    assert caught.value.parameter == name
