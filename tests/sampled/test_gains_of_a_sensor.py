"""Gains for the sensor that is named: its loop's margins, and noise within a budget."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.errors import ParameterError
from asmc_pin.sampled import LoopSensor, SampledLoop, closed_loop, loop_sensor, stability
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.gain_choice.gain_design import GainDesign
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.noise.noise_response import noise_rms
from asmc_pin.sampled.proof.loop_certificate import certify_loop

MBAR, PERIOD = 0.0444444, 0.001
BUDGET = np.array([0.3, 0.1])


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def encoder() -> LoopSensor:
    return loop_sensor(2, encoder_bits=17)


@pytest.fixture(scope="module")
def plain(two_link: Arm) -> GainDesign:
    return suggest_gains(two_link, MBAR, PERIOD, samples=512)


@pytest.fixture(scope="module")
def seen(two_link: Arm, encoder: LoopSensor) -> GainDesign:
    return suggest_gains(two_link, MBAR, PERIOD, sensor=encoder, samples=512)


@pytest.fixture(scope="module")
def quiet(two_link: Arm, encoder: LoopSensor) -> GainDesign:
    return suggest_gains(two_link, MBAR, PERIOD, sensor=encoder, noise_budget=BUDGET, samples=512)


def grid() -> Array:
    angles = np.linspace(-math.pi, math.pi, 41)
    return np.stack(np.meshgrid(angles, angles), axis=-1).reshape(-1, 2)


def worst(arm: Arm, loop: SampledLoop) -> float:
    """Largest radius of the map at rest on a grid of the box, without the search."""
    mass, stiffness = arm.mass_matrix(grid()), gravity_stiffness(arm, grid())
    return float(closed_loop(mass, loop, stiffness=stiffness).spectral_radius().max())


def noise(arm: Arm, loop: SampledLoop, sensor: LoopSensor) -> Array:
    """Torque RMS at rest on the same grid, each joint's largest, N·m."""
    rms, _ = noise_rms(arm.mass_matrix(grid()), loop, sensor, stiffness=gravity_stiffness(arm, grid()))
    return np.asarray(rms.max(axis=0))


def edges(loop: SampledLoop) -> list[SampledLoop]:
    """The margins of the default, a torque gain of 2 either way and a period."""
    return [loop.scaled(mbar=0.5), loop.scaled(mbar=2.0), replace(loop, delay=1.0)]


def size(design: GainDesign) -> float:
    """What the error under a drifting load is inversely proportional to, and not how old the torque is."""
    return float(design.loop.mbar[0] * design.loop.kp[0])


def test_margins_are_those_of_the_sensor_that_is_named(two_link: Arm, seen: GainDesign, plain: GainDesign) -> None:
    assert seen.met
    assert seen.loop.velocity == "difference"
    assert seen.loop.averages_torque
    assert all(worst(two_link, loop) < 1.0 for loop in edges(seen.loop))
    # The gains for a measured v do not keep them on this sensor: that it is counted matters.
    mistaken = replace(plain.loop, velocity="difference")
    assert max(worst(two_link, loop) for loop in edges(mistaken)) > 1.0


def test_the_pairing_asked_for_is_the_one_that_is_counted(two_link: Arm, encoder: LoopSensor) -> None:
    last = suggest_gains(
        two_link, MBAR, PERIOD, sensor=encoder, pairing="last", gain_margin=1.5, delay_margin=0.6, samples=256
    )
    assert last.met
    assert not last.loop.averages_torque
    ends = [last.loop.scaled(mbar=1.5), last.loop.scaled(mbar=1.0 / 1.5), replace(last.loop, delay=0.6)]
    assert all(worst(two_link, loop) < 1.0 for loop in ends)
    assert any("it is the loop of these margins" in line for line in last.lines())


def test_a_period_more_is_not_promised_where_an_alternating_torque_would_go_on_for_ever(
    two_link: Arm, encoder: LoopSensor
) -> None:
    last = suggest_gains(two_link, MBAR, PERIOD, sensor=encoder, pairing="last", samples=256)
    assert not last.met
    assert last.reached is not None
    assert 0.9 < last.reached.delay < 1.0
    assert any("alternates from tick to tick" in reason for reason in last.why)


def test_stability_says_the_same_of_a_period_more_and_names_the_pairing_that_helps(
    two_link: Arm, encoder: LoopSensor
) -> None:
    gains: dict[str, float] = {"mbar": 0.017, "ks": 7.0, "beta": 100.0, "period": PERIOD}
    limits = stability(two_link, **gains, sensor=encoder, pairing="last", samples=128).limits
    assert limits is not None
    assert 0.99 < limits.delay_margin < 1.0
    late = stability(two_link, **gains, sensor=encoder, pairing="last", delay=1.0, samples=128)
    assert not late.stable
    assert "alternates from tick to tick" in late.remedy
    assert stability(two_link, **gains, sensor=encoder, pairing="mean", delay=1.0, samples=128).stable


def test_the_noise_of_the_gains_found_is_told(two_link: Arm, seen: GainDesign, encoder: LoopSensor) -> None:
    report = json.loads(json.dumps(seen.to_json_dict()))
    told = np.array(report["torque_noise_rms"])
    np.testing.assert_allclose(told, noise(two_link, seen.loop, encoder), rtol=0.02)
    assert report["velocity"] == "difference"
    assert report["pairing"] == "mean"
    assert any("v a difference of angles" in line for line in seen.lines())
    assert any(line.startswith("noise where counts are crossed") for line in seen.lines())


def test_a_noise_budget_is_kept_all_over_the_box_and_the_margins_with_it(
    two_link: Arm, seen: GainDesign, quiet: GainDesign, encoder: LoopSensor
) -> None:
    assert (noise(two_link, seen.loop, encoder) > BUDGET).any()
    assert quiet.met
    assert quiet.quiet
    assert (noise(two_link, quiet.loop, encoder) <= BUDGET).all()
    assert all(worst(two_link, loop) < 1.0 for loop in edges(quiet.loop))
    assert size(quiet) < size(seen)
    assert any(line.startswith("noise budget kept") for line in quiet.lines())


def test_the_low_pass_is_chosen_and_none_of_the_others_allows_better_gains(
    two_link: Arm, quiet: GainDesign, encoder: LoopSensor
) -> None:
    assert quiet.loop.filter_hz is not None
    for corner in (2.0 * quiet.loop.filter_hz, 0.5 * quiet.loop.filter_hz, 1e5):
        other = suggest_gains(
            two_link, MBAR, PERIOD, sensor=encoder, noise_budget=BUDGET, filter_hz=corner, samples=512
        )
        assert other.loop.filter_hz == corner
        assert size(other) < 1.02 * size(quiet)


def test_a_budget_that_spares_nothing_costs_nothing(two_link: Arm, seen: GainDesign, encoder: LoopSensor) -> None:
    free = suggest_gains(two_link, MBAR, PERIOD, sensor=encoder, noise_budget=1e3, samples=512)
    assert free.met
    assert free.quiet
    assert size(free) > 0.98 * size(seen)


def test_a_budget_that_cannot_be_had_is_told_beside_what_is_reached(two_link: Arm, encoder: LoopSensor) -> None:
    poor = suggest_gains(two_link, MBAR, PERIOD, sensor=encoder, noise_budget=1e-6, filter_hz=20.0, samples=256)
    assert poor.met
    assert not poor.quiet
    report = poor.to_json_dict()
    assert report["noise_budget"] == [1e-6, 1e-6]
    assert report["noise_met"] is False
    assert min(report["torque_noise_rms"]) > 1e-6
    assert any(
        line.startswith("no gains that were tried with these margins keep to the noise budget") for line in poor.lines()
    )
    assert any("the noise budget is not kept" in reason for reason in poor.why)


@pytest.mark.parametrize(
    ("sensor", "budget", "said"),
    [
        (None, 1.0, "name encoder bits"),
        ("encoder", 0.0, "above 0"),
        ("encoder", [1.0, 2.0, 3.0], "expected a number or 2 of them"),
        ("encoder", [1.0, math.nan], "finite"),
    ],
)
def test_a_budget_that_means_nothing_is_refused(
    two_link: Arm, encoder: LoopSensor, sensor: str | None, budget: object, said: str
) -> None:
    with pytest.raises(ParameterError, match=said):
        suggest_gains(
            two_link,
            MBAR,
            PERIOD,
            sensor=encoder if sensor else None,
            noise_budget=budget,  # type: ignore[arg-type]
            samples=64,
        )


def test_the_loop_of_gains_for_a_measured_velocity_is_proven(two_link: Arm, plain: GainDesign) -> None:
    proof = certify_loop(two_link, plain.loop)
    assert proof.verdict == "stable"
    assert plain.report is not None
    told = replace(plain, report=replace(plain.report, proof=proof))
    assert told.to_json_dict()["proof"]["verdict"] == "stable"
    assert told.to_json_dict()["kind"] == "certified"
    assert "the margins are searched, not proven" in told.lines()


def test_the_last_torque_asked_for_by_name_is_the_plain_loop_too(two_link: Arm, plain: GainDesign) -> None:
    assert certify_loop(two_link, replace(plain.loop, pairing="last")).verdict == "stable"
