"""Claims about the drives: delay, current loop, speed bounds, gear, elastic joints with play."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from plant_cases import OpenLoop, Still, slider

from asmc_pin.arms import load_arm
from asmc_pin.controllers import Ppc
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Drive, Friction, Plant
from asmc_pin.plant.drive.elastic_state import ElasticMechanics
from asmc_pin.sampled import SampledLoop
from asmc_pin.sampled.linear_map import closed_loop

MASS = 2.0


@pytest.fixture
def arm(tmp_path):
    return slider(tmp_path, MASS)


def run(arm, torque, duration, period=1e-3, substeps=2, v0=0.0, **options):
    law = OpenLoop(torque, period)
    plant = Plant(arm, substeps=substeps, start="relaxed", friction=Friction(), **options)
    return rollout(plant, law, Still(np.zeros(1)), duration, v0=[v0]), law


# Transport delay, as docs/stability.md defines it


@pytest.mark.parametrize("delay", [0.25, 0.6, 1.0, 2.5, 3.0])
@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_command_of_t_k_acts_from_t_k_plus_the_delay_and_its_impulse_is_exact(arm, delay, substeps):
    result, law = run(arm, lambda t: 5.0 * np.cos(300.0 * t), 0.05, substeps=substeps, drive=Drive(delay=delay))
    whole, fraction = int(delay), delay - int(delay)
    commands = np.concatenate([np.zeros(whole + 1), 5.0 * np.cos(300.0 * result.time)])
    ticks = len(result.time)
    older, recent = commands[:ticks], commands[1 : 1 + ticks]
    expected = fraction * older + (1.0 - fraction) * recent
    np.testing.assert_allclose(result.torque[0, :, 0], expected, rtol=0, atol=1e-13)
    # What the drive reports goes with the change of velocity, exactly.
    told = np.array([sample.torque[0, 0] for sample in law.seen])
    np.testing.assert_array_equal(told[1:], result.torque[0, :-1, 0])
    np.testing.assert_allclose(MASS * np.diff(result.v[0, :, 0]) / 1e-3, told[1:], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("delay", "substeps"), [(0.0, 1), (0.5, 2), (0.6, 5), (1.0, 2), (1.4, 5), (2.0, 1)])
def test_the_closed_loop_with_delay_follows_its_linear_map_tick_by_tick(arm, delay, substeps):
    gains = {"mbar": 1.4, "ks": 11.0, "beta": 7.0, "period": 2e-3}
    plant = Plant(arm, substeps=substeps, friction=Friction(), drive=Drive(delay=delay))
    result = rollout(plant, Ppc(**gains), Still(np.zeros(1)), 0.6, q0=[0.02], v0=[0.1])
    loop = closed_loop(np.array([[MASS]]), SampledLoop(**gains, delay=delay), substeps=substeps)
    state = np.zeros(loop.matrix.shape[0])
    state[:2] = 0.02, 0.1
    for k in range(len(result.time)):
        np.testing.assert_allclose([result.q[0, k, 0], result.v[0, k, 0]], state[:2], rtol=0, atol=1e-11)
        state = loop.matrix @ state


def test_the_delay_that_the_map_calls_unstable_is_unstable_and_not_sooner(arm):
    gains = {"mbar": MASS, "ks": 60.0, "beta": 60.0, "period": 4e-3}
    ends = {}
    for delay in (0.5, 1.5, 2.5, 3.5, 6.0):
        radius = closed_loop(np.array([[MASS]]), SampledLoop(**gains, delay=delay), substeps=10).spectral_radius()
        plant = Plant(arm, substeps=10, friction=Friction(), effort_limit=np.inf, drive=Drive(delay=delay))
        result = rollout(plant, Ppc(**gains), Still(np.zeros(1)), 4.0, q0=[1e-6])
        size = np.abs(result.q[0, :, 0])
        grows = result.status == ("diverged",) or size[-50:].max() > size[:50].max()
        assert grows == (radius > 1.0), (delay, float(radius))
        ends[delay] = grows
    assert set(ends.values()) == {True, False}


# Current loop and speed


@pytest.mark.parametrize("substeps", [1, 4])
def test_the_current_loop_lags_exactly_to_first_order(arm, substeps):
    bandwidth, period = 80.0, 1e-3
    result, _ = run(arm, lambda t: 3.0, 0.02, substeps=substeps, drive=Drive(current_hz=bandwidth))
    lag = 1.0 / (2.0 * np.pi * bandwidth)
    t = result.time
    mean = 3.0 * (1.0 - lag / period * (np.exp(-t / lag) - np.exp(-(t + period) / lag)))
    np.testing.assert_allclose(result.torque[0, :, 0], mean, rtol=1e-12)


def test_on_a_falling_torque_speed_curve_a_mass_speeds_up_as_the_exponential(arm):
    drive = Drive(corner_speed=1.0, no_load_speed=3.0)
    result, _ = run(arm, lambda t: 100.0, 3.0, substeps=10, drive=drive, effort_limit=4.0)
    t, v = result.time, result.v[0, :, 0]
    reached = 1.0 / (4.0 / MASS)
    curved = 3.0 - 2.0 * np.exp(-(4.0 / MASS) * (t - reached) / 2.0)
    np.testing.assert_allclose(v, np.where(t < reached, 4.0 / MASS * t, curved), atol=2e-4)
    assert v.max() < 3.0


def test_speed_bounds_never_weaken_braking(arm):
    drive = Drive(corner_speed=1.0, no_load_speed=3.0, velocity_limit=3.5)
    result, _ = run(arm, lambda t: -4.0, 0.5, drive=drive, effort_limit=4.0, v0=3.4)
    np.testing.assert_allclose(result.torque, -4.0, rtol=1e-14)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_velocity_limit_is_approached_and_not_passed(arm, sign):
    result, _ = run(arm, lambda t: sign * 20.0, 2.0, drive=Drive(velocity_limit=1.5))
    v = sign * result.v[0, :, 0]
    assert v.max() <= 1.5
    assert v[-1] > 0.999 * 1.5
    free = 20.0 / MASS * result.time
    np.testing.assert_allclose(v[free < 0.95 * 1.5], free[free < 0.95 * 1.5], rtol=1e-12)


def test_the_rotor_behind_the_gear_resists_with_the_ratio_squared(arm):
    result, _ = run(arm, lambda t: 6.0, 0.1, drive=Drive(gear=50.0, rotor_inertia=4e-4))
    np.testing.assert_allclose(result.v[0, :, 0], 6.0 / (MASS + 2500.0 * 4e-4) * result.time, rtol=1e-12)


# Elastic joints


def test_an_elastic_joint_swings_at_the_frequency_of_its_two_masses(arm):
    drive = Drive(gear=10.0, rotor_inertia=0.01, stiffness=800.0)
    result, _ = run(arm, lambda t: 0.0, 2.0, substeps=4, drive=drive, v0=0.3)
    # Rotor (1 kg) and link start together; a push at the motor sets them swinging about their centre.
    pushed, _ = run(arm, lambda t: 5.0, 2.0, substeps=4, drive=drive)
    np.testing.assert_allclose(result.v[0, :, 0], 0.3, rtol=1e-12)
    rate = np.sqrt(800.0 * (1.0 / MASS + 1.0 / 1.0))
    t = pushed.time
    centre = 0.5 * (5.0 / 3.0) * t**2
    # Relative motion δ = θ − q: δ̈ + ω² δ = F/J, so q = centre − δ·J/(J + m).
    bend = 5.0 / rate**2 * (1.0 - np.cos(rate * t))
    np.testing.assert_allclose(pushed.q[0, :, 0], centre - bend * 1.0 / 3.0, atol=2e-5)


def test_a_stiff_gear_comes_to_the_rigid_joint(arm):
    rigid, _ = run(arm, lambda t: 5.0 * np.sin(9 * t), 0.5, drive=Drive(gear=10.0, rotor_inertia=0.01))
    gaps = []
    for stiffness in (1e3, 1e4, 1e5):
        drive = Drive(gear=10.0, rotor_inertia=0.01, stiffness=stiffness, damping=2e-3 * stiffness)
        soft, _ = run(arm, lambda t: 5.0 * np.sin(9 * t), 0.5, substeps=20, drive=drive)
        gaps.append(np.abs(soft.q - rigid.q).max())
    assert gaps[1] < 0.15 * gaps[0]
    assert gaps[2] < 0.15 * gaps[1]


def test_within_its_play_the_motor_turns_and_the_link_stands_still(arm):
    drive = Drive(gear=1.0, rotor_inertia=0.5, stiffness=2e3, damping=5.0, backlash=0.02)
    result, _ = run(arm, lambda t: 1.0, 0.5, substeps=4, drive=drive)
    crossing = np.sqrt(2.0 * 0.01 / (1.0 / 0.5))  # half the play, from its middle
    q = result.q[0, :, 0]
    assert np.all(q[result.time < crossing] == 0.0)
    assert np.all(q[result.time > crossing + 2e-3] > 0.0)


def gear_torque(drive, bend, rate):
    """What a gear carries at a bend and its rate, from the formula's own code."""
    links = SimpleNamespace(free=SimpleNamespace(nv=1))
    gears = ElasticMechanics(links, drive, SimpleNamespace(none=True))
    return gears.gear_torque(np.array([[0.3, 0.3 + bend]]), np.array([[-0.2, -0.2 + rate]]))[0, 0]


def test_a_gear_carries_its_stiffness_times_the_bend_and_its_damping_times_the_rate():
    drive = Drive(gear=1.0, rotor_inertia=0.5, stiffness=2e3, damping=5.0)
    assert gear_torque(drive, 0.01, 0.7) == pytest.approx(2e3 * 0.01 + 5.0 * 0.7, rel=1e-12)
    # Without play it pulls as well as it pushes.
    assert gear_torque(drive, 0.0, -0.7) == pytest.approx(-5.0 * 0.7, rel=1e-12)


def test_of_several_arms_that_swings_fastest_whose_link_is_lightest():
    drive = Drive(gear=10.0, rotor_inertia=0.01, stiffness=800.0)
    masses = np.array([3.0, 0.5, 2.0])
    links = SimpleNamespace(free=SimpleNamespace(nv=1), mass_matrix=lambda q: masses[:, None, None])
    gears = ElasticMechanics(links, drive, SimpleNamespace(none=True))
    # A rotor of 1 kg m² behind its gear, against each link: ω² = k (1/m + 1/J).
    assert gears.fastest(np.zeros((3, 1))) == pytest.approx(np.sqrt(800.0 * (1.0 / 0.5 + 1.0)), rel=1e-12)


def test_through_its_play_a_gear_neither_pushes_nor_pulls():
    drive = Drive(gear=1.0, rotor_inertia=0.5, stiffness=2e3, damping=5.0, backlash=0.02)
    for bend in (-0.0099, 0.0, 0.0099):
        for rate in (-50.0, 0.0, 50.0):
            assert gear_torque(drive, bend, rate) == 0.0
    # Beyond it by 1 mrad the spring pushes with 2 N·m; teeth that part fast leave without a pull.
    assert gear_torque(drive, 0.011, 0.1) == pytest.approx(2.0 + 0.5, rel=1e-9)
    assert gear_torque(drive, 0.011, -0.1) == pytest.approx(2.0 - 0.5, rel=1e-9)
    assert gear_torque(drive, 0.011, -0.5) == 0.0
    assert gear_torque(drive, -0.011, -0.1) == pytest.approx(-2.0 - 0.5, rel=1e-9)
    assert gear_torque(drive, -0.011, 0.5) == 0.0


def test_with_play_the_holding_start_rests_on_the_loaded_side(tmp_path):
    arm = slider(tmp_path, MASS, slope=0.5)
    drive = Drive(gear=1.0, rotor_inertia=0.5, stiffness=2e3, backlash=0.02)
    weight = arm.gravity(np.zeros(1))[0]
    law = OpenLoop(lambda t: weight, 1e-3)
    result = rollout(Plant(arm, substeps=4, drive=drive, friction=Friction()), law, Still(np.zeros(1)), 1.0)
    np.testing.assert_allclose(result.q, 0.0, atol=1e-12)


@pytest.mark.parametrize("where", ["joint", "motor"])
def test_friction_of_an_elastic_joint_sits_where_it_is_put(arm, where):
    drive = Drive(gear=1.0, rotor_inertia=0.5, stiffness=500.0, damping=20.0, friction=where)
    plant = Plant(arm, substeps=4, drive=drive, friction=Friction(3.0), start="relaxed")
    stuck = rollout(plant, OpenLoop(lambda t: min(2.9 * t, 2.9), 1e-3), Still(np.zeros(1)), 2.0)
    assert np.all(stuck.q == 0.0)
    loose = rollout(plant, OpenLoop(lambda t: 3.5, 1e-3), Still(np.zeros(1)), 3.0)
    speed = 0.5 / (MASS + 0.5) * 3.0
    assert loose.v[0, -1, 0] == pytest.approx(speed, rel=0.05)


# What cannot be


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"delay": -1.0}, "at least 0"),
        ({"corner_speed": 1.0}, "no_load_speed: is missing"),
        ({"corner_speed": 2.0, "no_load_speed": 1.0}, "above corner_speed"),
        ({"backlash": 0.1}, "give its stiffness"),
        ({"stiffness": 1e3}, "needs an inertia|inertia of its own"),
        ({"current_hz": 0.0}, "above 0"),
    ],
)
def test_a_drive_that_cannot_be_is_refused(options, said):
    with pytest.raises(ParameterError, match=said):
        Drive(**options)


def test_a_drive_that_does_not_fit_the_arm_or_the_step_is_refused():
    arm = load_arm("two_link")
    with pytest.raises(ParameterError, match=r"drive.current_hz: 3 values"):
        Plant(arm, drive=Drive(current_hz=[1.0, 2.0, 3.0]))
    with pytest.raises(ParameterError, match="no torque limit to fall from"):
        Plant(arm, effort_limit=np.inf, drive=Drive(corner_speed=1.0, no_load_speed=2.0))
    soft = Plant(arm, drive=Drive(rotor_inertia=1e-3, stiffness=1e6))
    with pytest.raises(ParameterError, match=r"at least \d+ substeps"):
        soft.begin(np.zeros((1, 2)), np.zeros((1, 2)), 1e-3)


def test_friction_at_the_motor_is_the_same_friction_with_every_scheme(arm):
    drive = Drive(gear=1.0, rotor_inertia=0.5, stiffness=500.0, damping=20.0, friction="motor")
    ends = []
    for integrator in ("semi_implicit", "midpoint", "rk4"):
        plant = Plant(arm, substeps=4, drive=drive, friction=Friction(0.3, 0.5), integrator=integrator, start="relaxed")
        ends.append(rollout(plant, OpenLoop(lambda t: 3.5, 1e-3), Still(np.zeros(1)), 0.05, v0=[0.2]).q[0, -1, 0])
    np.testing.assert_allclose(ends, ends[2], rtol=5e-3)


def test_nobody_changes_a_drive_under_a_plant():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Drive(gear=2.0).gear = 3.0
