"""A mass on a slope, against the analytic solution."""

from __future__ import annotations

import numpy as np
import pytest
from plant_cases import G, OpenLoop, Still, slider

from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant

MASS, SLOPE = 3.0, 0.5
WEIGHT = MASS * G * np.sin(SLOPE)  # along the rail, downwards


@pytest.fixture
def arm(tmp_path):
    return slider(tmp_path, MASS, SLOPE)


def run(arm, coulomb, torque, duration, period=1e-3, substeps=2, v0=0.0, viscous=0.0):
    plant = Plant(arm, substeps=substeps, friction=Friction(coulomb, viscous), start="relaxed")
    return rollout(plant, OpenLoop(torque, period), Still(np.zeros(1)), duration, v0=[v0])


@pytest.mark.parametrize("share", [0.5, 0.999999])
def test_it_sticks_to_the_last_bit_below_breakaway_and_friction_carries_the_weight(arm, share):
    result = run(arm, WEIGHT / share, lambda t: 0.0, 0.5)
    assert np.all(result.q == 0.0)
    assert np.all(result.v == 0.0)
    np.testing.assert_allclose(result.friction_torque, WEIGHT, rtol=1e-13)


@pytest.mark.parametrize("period", [1e-3, 1e-2])
@pytest.mark.parametrize("push", [0.0, 60.0])
def test_above_breakaway_it_slides_with_the_analytic_acceleration_at_any_step_size(arm, period, push):
    coulomb = 5.0
    result = run(arm, coulomb, lambda t: push, 1.0, period=period)
    drive = push - WEIGHT
    a = (drive - np.sign(drive) * coulomb) / MASS
    np.testing.assert_allclose(result.v[0, :, 0], a * result.time, rtol=1e-11)
    np.testing.assert_allclose(result.q[0, :, 0], 0.5 * a * result.time**2, rtol=1e-11)
    np.testing.assert_allclose(result.friction_torque, -np.sign(drive) * coulomb, rtol=1e-12)


@pytest.mark.parametrize(("coulomb", "returns"), [(20.0, False), (8.0, True)])
def test_thrown_upwards_it_stops_at_the_analytic_time_and_stays_or_slides_back(arm, coulomb, returns):
    v0, period = 1.0, 1e-3
    result = run(arm, coulomb, lambda t: 0.0, 0.6, period=period, substeps=1, v0=v0)
    braking = (WEIGHT + coulomb) / MASS
    stop, height = v0 / braking, 0.5 * v0**2 / braking
    q, v = result.q[0, :, 0], result.v[0, :, 0]
    before = result.time < stop
    np.testing.assert_allclose(v[before], v0 - braking * result.time[before], rtol=1e-11, atol=1e-13)
    after = np.flatnonzero(~before)
    assert abs(q[after[0]] - height) <= 0.5 * braking * period**2
    if not returns:
        assert np.all(v[after] == 0.0)
        assert np.all(q[after] == q[after[0]])
        np.testing.assert_allclose(result.friction_torque[0, after, 0], WEIGHT, rtol=1e-13)
    else:
        back = (WEIGHT - coulomb) / MASS
        np.testing.assert_allclose(v[after], -back * (result.time[after] - stop), atol=(back + braking) * period)


def test_a_rising_pull_breaks_it_loose_at_the_analytic_time_and_then_moves_it_along_the_cubic(arm):
    coulomb, rate, period = 20.0, 100.0, 1e-3
    result = run(arm, coulomb, lambda t: rate * t, 1.0, period=period)
    breakaway = (WEIGHT + coulomb) / rate
    q = result.q[0, :, 0]

    def exact(t):
        return rate * np.maximum(t - breakaway, 0.0) ** 3 / (6.0 * MASS)

    assert np.all(q[result.time <= breakaway] == 0.0)
    assert exact(result.time[-1]) > 0.5
    # The torque is held over a period, so it lags by 0 to L behind the ramp, and so does the motion.
    assert np.all(q <= exact(result.time) * (1 + 1e-12))
    assert np.all(q >= exact(result.time - period) * (1 - 1e-12))


def test_viscous_friction_leads_to_the_analytic_terminal_speed(arm):
    result = run(arm, 2.0, lambda t: 0.0, 10.0, period=1e-2, viscous=4.0)
    assert result.v[0, -1, 0] == pytest.approx(-(WEIGHT - 2.0) / 4.0, rel=1e-5)


@pytest.mark.parametrize(("period", "substeps"), [(0.1, 1), (1e-2, 3), (2e-3, 1)])
@pytest.mark.parametrize("name", ["slope", "ur5"])
def test_nothing_creeps_in_60_s_just_below_breakaway(arm, name, period, substeps):
    arm, q = (
        (arm, np.zeros((1, 1))) if name == "slope" else (load_arm("ur5"), np.array([[0.3, -1.0, 1.2, 0.4, 0.8, 0.2]]))
    )
    load = np.abs(arm.gravity(q))
    plant = Plant(arm, substeps=substeps, friction=Friction(1.000001 * load + 1e-9), start="relaxed")
    motion = plant.begin(q.copy(), np.zeros_like(q), period)
    for _ in range(round(60.0 / period)):
        friction = motion.advance()
    np.testing.assert_array_equal(motion.q, q)
    np.testing.assert_array_equal(motion.v, 0.0)
    np.testing.assert_allclose(friction, arm.gravity(q), atol=1e-11 * load.max())

    falling = Plant(arm, substeps=substeps, friction=Friction(0.999 * load), start="relaxed").begin(q, 0.0 * q, period)
    falling.advance()
    assert np.any(falling.v != 0.0)


def test_a_free_joint_drags_on_a_stuck_one_and_moves_as_if_that_one_were_fixed():
    arm = load_arm("two_link", gravity=(0.0, 0.0, 0.0))
    q = np.array([[0.0, 0.7]])
    m = arm.mass_matrix(q)[0]
    pull = 0.3
    reaction = m[0, 1] / m[1, 1] * pull
    for level, sticks in ((1.0001 * reaction, True), (0.9999 * reaction, False)):
        motion = Plant(arm, substeps=1, friction=Friction([level, 0.0]), start="relaxed").begin(q.copy(), 0.0 * q, 1e-3)
        motion.apply(np.array([[0.0, pull]]))
        friction = motion.advance()[0]
        assert bool(motion.v[0, 0] == 0.0) is sticks
        if sticks:
            assert motion.v[0, 1] == pytest.approx(1e-3 * pull / m[1, 1], rel=1e-12)
            assert friction == pytest.approx([reaction, 0.0], rel=1e-12)
        else:
            assert motion.v[0, 0] < 0.0
            assert friction[0] == pytest.approx(level, rel=1e-12)
