"""Claims about the sensors: what the law is told, and that a trial's noise is its own."""

from __future__ import annotations

import numpy as np
import pytest
from plant_cases import OpenLoop, Still, Waving, slider
from scipy.signal import lfilter

from asmc_pin.arms import load_arm
from asmc_pin.controllers import Ppc
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Drive, Friction, Plant, Sensor

L = 1e-3
MASS = 2.0


@pytest.fixture
def arm(tmp_path):
    return slider(tmp_path, MASS)


def run(arm, sensor, torque=lambda t: 4.0 * np.cos(20.0 * t), duration=0.3, v0=0.05, batch=1, **options):
    law = OpenLoop(torque, L)
    plant = Plant(arm, start="relaxed", friction=Friction(), sensor=sensor, **options)
    return rollout(plant, law, Still(np.zeros(1)), duration, v0=[v0], batch=batch), law


def test_ideal_sensors_tell_the_truth_and_the_run_says_so(arm):
    result, law = run(arm, None)
    assert result.ideal_sensor
    assert result.q_measured is result.q
    assert result.v_measured is result.v
    told = np.array([sample.torque[0] for sample in law.seen])
    np.testing.assert_array_equal(result.torque_measured[0], told)


def test_the_run_records_what_the_law_was_told(arm):
    sensor = Sensor(resolution=1e-4, position_noise=1e-4, torque_noise=0.1, delay=0.5)
    result, law = run(arm, sensor, batch=2)
    for name in ("q", "v", "torque"):
        told = np.array([getattr(sample, name) for sample in law.seen]).swapaxes(0, 1)
        np.testing.assert_array_equal(getattr(result, f"{name}_measured"), told)
    assert not result.ideal_sensor
    assert not np.array_equal(result.q, result.q_measured)


def test_s_is_that_of_the_measured_state(arm):
    plant = Plant(arm, sensor=Sensor(resolution=1e-3), friction=Friction())
    result = rollout(plant, Ppc(mbar=1.0, ks=5.0, beta=5.0, period=L), Waving(np.zeros(1)), 0.2)
    s = result.v_ref - result.v_measured + 5.0 * (result.q_ref - result.q_measured)
    np.testing.assert_allclose(result.s, s, rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "drive", "count"),
    [
        ({"resolution": 2e-5}, None, 2e-5),
        ({"bits": 12.0, "side": "motor"}, Drive(gear=500.0), 2 * np.pi / 4096 / 500.0),
    ],
)
def test_readings_are_whole_counts_and_off_by_no_more_than_half_a_count(arm, options, drive, count):
    result, _ = run(arm, Sensor(**options), drive=drive)
    counts = result.q_measured / count
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)
    assert np.abs(result.q_measured - result.q).max() <= 0.5 * count * (1 + 1e-9)
    assert np.abs(result.q_measured - result.q).max() > 0.4 * count


def test_an_encoder_of_a_turning_joint_divides_the_turn():
    arm = load_arm("two_link")
    plant = Plant(arm, sensor=Sensor(bits=10), friction=Friction())
    result = rollout(plant, OpenLoop(lambda t: np.zeros(2), L), Still(np.zeros(2)), 0.2)
    step = np.diff(np.unique(result.q_measured[0, :, 1]))
    np.testing.assert_allclose(step, 2 * np.pi / 1024, rtol=1e-9)


def test_velocity_is_the_difference_of_readings_from_the_first_tick_on(arm):
    result, _ = run(arm, Sensor(), torque=lambda t: 0.0)
    np.testing.assert_allclose(result.v_measured, 0.05, rtol=1e-9)
    result, _ = run(arm, Sensor(resolution=1e-6))
    difference = np.diff(result.q_measured[0, :, 0]) / L
    np.testing.assert_allclose(result.v_measured[0, 1:, 0], difference, rtol=1e-12)


def test_the_velocity_filter_is_a_first_order_low_pass(arm):
    result, _ = run(arm, Sensor(position_noise=1e-4, velocity="filter", filter_hz=40.0))
    difference = np.diff(result.q_measured[0, :, 0]) / L
    keep = np.exp(-2 * np.pi * 40.0 * L)
    first = result.v_measured[0, 0, 0]
    expected = lfilter([1.0 - keep], [1.0, -keep], difference, zi=[keep * first])[0]
    np.testing.assert_allclose(result.v_measured[0, 1:, 0], expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("delay", [0.3, 1.0, 2.75])
def test_a_delayed_reading_is_the_angle_of_that_long_ago(arm, delay):
    result, _ = run(arm, Sensor(delay=delay, velocity="exact"), torque=lambda t: 6.0, v0=0.0)
    then = np.maximum(result.time - delay * L, 0.0)
    late = result.time >= delay * L
    np.testing.assert_allclose(result.q_measured[0, late, 0], 0.5 * 3.0 * then[late] ** 2, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(result.v_measured[0, late, 0], 3.0 * then[late], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("delay", [0.3, 1.0, 2.75])
def test_before_the_run_the_joint_moved_as_fast_as_at_its_start(arm, delay):
    result, _ = run(arm, Sensor(delay=delay, velocity="exact"), torque=lambda t: 0.0, v0=0.7)
    expected = 0.7 * (result.time - delay * L)
    np.testing.assert_allclose(result.q_measured[0, :, 0], expected, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(result.v_measured[0, :, 0], 0.7, rtol=1e-9)


def test_noise_has_the_stated_size_and_is_white(arm):
    sensor = Sensor(position_noise=1e-3, velocity="exact", velocity_noise=0.02, torque_noise=0.3)
    result, _ = run(arm, sensor, duration=4.0, batch=4)
    for name, size in (("q", 1e-3), ("v", 0.02)):
        noise = getattr(result, f"{name}_measured") - getattr(result, name)
        assert noise.std() == pytest.approx(size, rel=0.03)
        flat = noise[:, :, 0]
        assert abs(np.mean(flat[:, 1:] * flat[:, :-1])) < 0.05 * size**2
    told = np.concatenate([result.held_torque[:, None], result.torque[:, :-1]], axis=1)
    assert (result.torque_measured - told).std() == pytest.approx(0.3, rel=0.03)


# Noise belongs to the trial


def noisy(batch, trials=None, seed=7, ks=8.0):
    arm = load_arm("two_link")
    plant = Plant(
        arm, sensor=Sensor(bits=16, position_noise=2e-5, torque_noise=0.05), seed=seed, friction=Friction(0.5)
    )
    law = Ppc(mbar=0.02, ks=ks, beta=8.0, period=L)
    return rollout(plant, law, Waving(np.array([-1.2, 0.3])), 0.15, batch=batch, trials=trials)


def test_a_trial_has_its_noise_whatever_the_batch_it_runs_in():
    together = noisy(5)
    for trials in ([3], [1, 2], [4, 0]):
        part = noisy(len(trials), trials)
        for name in ("q", "v", "torque", "q_measured", "v_measured", "torque_measured", "friction_torque", "s"):
            np.testing.assert_array_equal(getattr(together, name)[trials], getattr(part, name), err_msg=name)
    assert not np.array_equal(together.q[0], together.q[1])


def test_another_seed_is_another_noise_and_another_law_is_not(arm):
    sensor = Sensor(position_noise=1e-3)
    noise = [
        run(arm, sensor, torque=torque, seed=seed)[0]
        for seed, torque in ((1, lambda t: 1.0), (1, lambda t: -2.0), (2, lambda t: 1.0))
    ]
    noise = [result.q_measured - result.q for result in noise]
    np.testing.assert_allclose(noise[0], noise[1], rtol=0, atol=1e-15)
    assert np.abs(noise[0] - noise[2]).max() > 1e-3


def test_one_trial_that_diverges_leaves_the_noise_of_the_others(arm):
    def torque(t):
        return np.array([[1.0], [np.nan if t > 0.05 else 1.0]])

    plant = Plant(arm, friction=Friction(), sensor=Sensor(position_noise=1e-3))
    both = rollout(plant, OpenLoop(torque, L), Still(np.zeros(1)), 0.2, batch=2)
    alone = rollout(plant, OpenLoop(lambda t: 1.0, L), Still(np.zeros(1)), 0.2)
    assert both.status == ("ok", "diverged")
    np.testing.assert_array_equal(both.q_measured[:1], alone.q_measured)
    assert np.isnan(both.q_measured[1, -1]).all()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"bits": 12, "resolution": 1e-3}, "one of them"),
        ({"velocity_noise": 0.1}, "velocity = 'exact'"),
        ({"velocity": "guess"}, "difference"),
        ({"delay": -0.5}, "at least 0"),
        ({"bits": 15000}, "at most 64"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused(options, said):
    with pytest.raises(ParameterError, match=said):
        Sensor(**options)


def test_a_sensor_that_does_not_fit_the_arm_is_refused(arm):
    with pytest.raises(ParameterError, match="'slide' slides"):
        Plant(arm, sensor=Sensor(bits=12))
    with pytest.raises(ParameterError, match=r"sensor.position_noise: 2 values"):
        Plant(arm, sensor=Sensor(position_noise=[0.1, 0.2]))
    with pytest.raises(ParameterError, match="expected 2 whole numbers"):
        rollout(Plant(arm), OpenLoop(lambda t: 0.0, L), Still(np.zeros(1)), 0.1, batch=2, trials=[1])
