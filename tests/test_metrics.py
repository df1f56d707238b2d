"""Metrics against signals whose figures are known in closed form."""

import dataclasses

import numpy as np
import pytest
from paths import DOCS

from asmc_pin.engine import Rollout
from asmc_pin.errors import ParameterError
from asmc_pin.metrics import METRICS, QUANTITIES, MetricSettings, TripLimits, evaluate, first_trip
from asmc_pin.words.media import for_cell

PAGE = DOCS / "metrics.md"
L = 0.001


def run(ticks=1001, batch=1, nv=1, period=L, status=None, **signals):
    """A rollout of given signals, (T,), (T, nv) or (batch, T, nv); what is not given is 0, the gain NaN."""
    time = np.arange(ticks) * period

    def shaped(name, default, shape):
        value = np.asarray(signals.pop(name, default), dtype=float)
        value = value[:, None] if value.ndim == 1 else value
        return np.broadcast_to(value, shape).copy()

    full, shared = (batch, ticks, nv), (ticks, nv)
    arrays = {name: shaped(name, 0.0, full) for name in ("q", "v", "torque", "friction_torque", "s")}
    arrays |= {"gain": shaped("gain", np.nan, full)}
    arrays |= {name: shaped(name, 0.0, shared) for name in ("q_ref", "v_ref", "a_ref")}
    assert not signals
    status = status or ("ok",) * batch
    return Rollout(
        time=time,
        status=status,
        end_time=np.full(batch, time[-1]),
        joint_names=tuple(f"j{i}" for i in range(nv)),
        period=period,
        limit_violations=(),
        **arrays,
    )


def figure(name, rollout, **settings):
    values = METRICS[name](rollout, MetricSettings(**settings))
    assert values.shape == (rollout.q.shape[0], rollout.q.shape[2])
    return values[0, 0]


def test_rms_of_a_sine_error_over_whole_periods_is_its_amplitude_over_root_two():
    t = np.arange(1000) * L
    assert figure("rms_error", run(1000, q=0.3 * np.sin(2 * np.pi * 5 * t))) == pytest.approx(
        0.3 / np.sqrt(2), rel=1e-12
    )


def test_errors_are_taken_between_reference_and_position():
    rollout = run(11, q=np.linspace(0.0, 1.0, 11), q_ref=np.linspace(0.0, 3.0, 11))
    assert figure("max_error", rollout) == pytest.approx(2.0)
    assert figure("final_error", rollout) == pytest.approx(2.0)
    rollout = run(11, q=np.linspace(1.0, 0.25, 11))
    assert figure("max_error", rollout) == pytest.approx(1.0)
    assert figure("final_error", rollout) == pytest.approx(0.25)


def test_a_decaying_error_settles_when_its_exponential_enters_the_band():
    t = np.arange(1001) * L
    rollout = run(q=np.exp(-10.0 * t))
    exact = np.log(1.0 / 0.01) / 10.0
    assert exact <= figure("settling_time", rollout, settling_band=0.01) <= exact + L


def test_an_error_that_was_never_outside_settles_at_zero_and_one_that_ends_outside_never_does():
    assert figure("settling_time", run(q=np.full(1001, 0.001)), settling_band=0.001) == 0.0
    late = np.zeros(1001)
    late[-1] = 0.2
    assert np.isnan(figure("settling_time", run(q=late), settling_band=0.1))
    late[-1], late[-2] = 0.0, -0.2
    assert figure("settling_time", run(q=late), settling_band=0.1) == pytest.approx(1.0)


def test_the_settling_band_may_differ_from_joint_to_joint():
    rollout = run(101, nv=2, q=np.tile([[0.05, 0.05]], (101, 1)))
    values = METRICS["settling_time"](rollout, MetricSettings(settling_band=np.array([0.1, 0.01])))
    assert values[0, 0] == 0.0
    assert np.isnan(values[0, 1])


def test_torque_figures_see_only_what_was_held_within_the_run():
    # +2 and -2 by turns over ten periods; the torque of the last tick acts after the end.
    torque = np.append(np.tile([2.0, -2.0], 5), 1e6)
    rollout = run(11, torque=torque)
    assert figure("torque_rms", rollout) == pytest.approx(2.0)
    assert figure("torque_max", rollout) == 2.0
    assert figure("torque_variation", rollout) == pytest.approx(9 * 4.0 / (10 * L))
    assert figure("saturation_share", rollout, effort_limit=2.5) == 0.0


def test_variation_of_a_sine_is_four_amplitudes_a_period():
    t = np.arange(2001) * L
    rollout = run(2001, torque=3.0 * np.sin(2 * np.pi * 2.5 * t))
    assert figure("torque_variation", rollout) == pytest.approx(4 * 3.0 * 2.5, rel=1e-3)


def test_integrals_of_a_ramp_error_are_those_of_the_textbook():
    # e = 2t over 1 s: ∫|e| = 1, ∫e² = 4/3, ∫t|e| = 2/3; the sign does not count.
    rollout = run(q=2.0 * np.arange(1001) * L)
    assert figure("iae", rollout) == pytest.approx(1.0, rel=1e-12)
    assert figure("ise", rollout) == pytest.approx(4 / 3, rel=1e-6)
    assert figure("itae", rollout) == pytest.approx(2 / 3, rel=1e-6)


def test_the_time_in_itae_begins_with_the_run_and_an_error_at_once_hardly_counts():
    early, late = np.zeros(1001), np.zeros(1001)
    early[:10], late[-10:] = 1.0, 1.0
    assert figure("iae", run(q=early)) == pytest.approx(figure("iae", run(q=late)))
    assert figure("itae", run(q=early)) < 0.01 * figure("itae", run(q=late))


def test_energy_counts_work_done_and_work_absorbed_and_losses_follow_the_torque_squared():
    # +3 N·m while the joint goes from 0 to 1 rad and back: 3 J done, 3 J absorbed; the last torque acts after the end.
    q = np.concatenate([np.linspace(0.0, 1.0, 501), np.linspace(1.0, 0.0, 501)[1:]])
    rollout = run(q=q, torque=np.append(np.full(1000, 3.0), 1e6))
    assert figure("energy", rollout) == pytest.approx(6.0, rel=1e-12)
    assert figure("copper_loss_proxy", rollout) == pytest.approx(9.0, rel=1e-12)
    # A joint that is held against gravity does no work and heats its motor all the same.
    held = run(torque=np.full(1001, 5.0))
    assert figure("energy", held) == 0.0
    assert figure("copper_loss_proxy", held) == pytest.approx(25.0)


def test_the_largest_step_and_the_ticks_over_a_rate_are_counted_within_the_run():
    # Steps 0.5, 1.0, -2.0, 0.1 N·m in 1 ms: 500, 1000, 2000 and 100 N·m/s; then one that acts after the end.
    rollout = run(6, torque=np.array([0.0, 0.5, 1.5, -0.5, -0.4, 1e6]))
    assert figure("torque_step", rollout) == 2.0
    assert figure("torque_rate_ticks", rollout) == 1.0  # 1000 N·m/s itself is within a limit of 1000
    assert figure("torque_rate_ticks", rollout, torque_rate_limit=400.0) == 3.0
    assert figure("torque_rate_ticks", rollout, torque_rate_limit=np.inf) == 0.0
    assert (figure("torque_step", run(2)), figure("torque_rate_ticks", run(2))) == (0.0, 0.0)


def test_steps_as_fast_as_the_limit_are_within_it_however_they_are_rounded():
    torque = np.append(np.arange(200) * 0.1, 0.0)  # 100 N·m/s; a third of the differences is rounded to above 0.1
    assert figure("torque_rate_ticks", run(201, torque=torque), torque_rate_limit=100.0) == 0.0
    assert figure("torque_rate_ticks", run(201, torque=torque), torque_rate_limit=99.9) == 199.0


ROBOT = TripLimits(torque=np.array([5.0, 5.0]), torque_rate=np.array([2000.0, np.inf]), velocity=1.0)


def trips(**signals):
    """What would have stopped a robot of two joints, its time and the metric's, in a run of 6 ticks of 1 ms."""
    rollout = run(6, nv=2, **{"torque": np.zeros((6, 2)), "v": np.zeros((6, 2)), **signals})
    return METRICS["trip_time"](rollout, MetricSettings(trips=ROBOT)), first_trip(rollout, ROBOT)


def at(tick, joint, value):
    signal = np.zeros((6, 2))
    signal[tick:, joint] = value
    return signal


def test_a_robot_trips_at_the_first_tick_that_is_beyond_what_it_takes_and_says_by_what():
    times, trip = trips(v=at(3, 1, -1.5))
    assert np.isnan(times[0, 0])
    assert times[0, 1] == pytest.approx(0.003)
    assert (trip.quantity, trip.joint, trip.value, trip.limit, trip.trial) == ("velocity", 1, 1.5, 1.0, 0)
    assert trip.time == times[0, 1]
    # 5.5 N·m at once: 5500 N·m/s, which joint 0 does not take and of joint 1 is not published.
    times, trip = trips(torque=at(2, 0, 5.5))
    assert (trip.quantity, trip.time, trip.limit) == ("torque_rate", pytest.approx(0.002), 2000.0)
    assert trip.value == pytest.approx(5500.0)
    times, trip = trips(torque=at(2, 1, 5.5))
    assert (trip.quantity, trip.value, trip.time) == ("torque", 5.5, pytest.approx(0.002))
    # What is as large as the limit is within it, and the torque of the last tick acts after the end.
    assert trips(torque=at(1, 1, 5.0), v=at(1, 0, 1.0))[1] is None
    assert trips(torque=at(5, 1, 100.0))[1] is None


def test_of_two_limits_that_are_passed_at_once_the_one_that_is_passed_by_more_is_named_and_of_equal_ones_either():
    robot = TripLimits(torque=5.0, velocity=1.0)
    for torque, named in ((9.0, {"velocity"}), (11.0, {"torque"}), (10.0, {"torque", "velocity"})):
        trip = first_trip(run(6, nv=2, torque=at(2, 1, torque), v=at(2, 0, 2.0)), robot)
        assert trip.quantity in named
        assert trip.time == pytest.approx(0.002)


def test_of_several_limits_the_first_counts_and_without_a_robot_there_is_no_time():
    signals = {"torque": at(4, 1, 6.0), "v": at(2, 0, 2.0)}
    assert trips(**signals)[1].quantity == "velocity"
    assert np.isnan(METRICS["trip_time"](run(6, nv=2, **signals), MetricSettings())).all()


def test_a_trial_that_diverged_counts_as_tripped_when_it_did_at_the_latest():
    v = at(2, 0, 2.0)
    rollout = run(6, batch=2, nv=2, v=np.stack([v, np.zeros((6, 2))]), status=("diverged", "diverged"))
    rollout = dataclasses.replace(rollout, end_time=np.array([0.004, 0.004]))
    times = METRICS["trip_time"](rollout, MetricSettings(trips=ROBOT))
    np.testing.assert_allclose(times, [[0.002, 0.004], [0.004, 0.004]])
    assert np.isnan(METRICS["trip_time"](rollout, MetricSettings())).all()


def test_a_dent_of_one_tick_in_a_steady_torque_is_power_and_no_rounding():
    # Its spectrum is flat: above a cutoff lies the part of the frequencies that is above it.
    torque = np.full(2001, 10.0)
    torque[1000] -= 1e-9
    share = figure("torque_high_frequency_share", run(2001, torque=torque), cutoff_hz=100.0)
    assert share == pytest.approx(0.8, abs=0.01)


def test_a_steady_torque_has_no_chatter_however_large():
    rollout = run(torque=np.full(1001, 1e3 / 3.0))
    assert figure("torque_variation", rollout) == 0.0
    assert figure("torque_high_frequency_share", rollout) == 0.0


@pytest.mark.parametrize("high", [0.0, 1.0, 3.0])
def test_power_is_split_at_the_cutoff(high):
    t = np.arange(1001) * L
    torque = 7.0 + 2.0 * np.sin(2 * np.pi * 10 * t + 0.3) + high * np.sin(2 * np.pi * 200 * t)
    share = figure("torque_high_frequency_share", run(torque=torque), cutoff_hz=50.0)
    assert share == pytest.approx(high**2 / (high**2 + 4.0), abs=1e-6)


def test_of_what_lies_on_a_frequency_of_the_record_no_power_lies_two_lines_away():
    # The window has the record's own period, so that a line of the spectrum is three lines wide and no more.
    torque = 2.0 * np.sin(2 * np.pi * 10 * np.arange(1001) * L)
    assert figure("torque_high_frequency_share", run(torque=torque), cutoff_hz=11.5) < 1e-25
    assert figure("torque_high_frequency_share", run(torque=torque), cutoff_hz=10.5) == pytest.approx(1 / 6, rel=1e-9)


def test_power_at_the_cutoff_itself_is_not_above_it():
    # Of a line's power 1/6 is one line above it and 4/6 at it.
    torque = 2.0 * np.sin(2 * np.pi * 10 * np.arange(1001) * L)
    assert figure("torque_high_frequency_share", run(torque=torque), cutoff_hz=10.0) == pytest.approx(1 / 6, rel=1e-9)
    assert figure("torque_high_frequency_share", run(torque=torque), cutoff_hz=9.99) == pytest.approx(5 / 6, rel=1e-9)


def test_a_slow_ramp_has_hardly_any_power_above_the_cutoff():
    assert figure("torque_high_frequency_share", run(torque=np.linspace(-50, 50, 1001)), cutoff_hz=50.0) < 1e-6


def test_no_share_is_claimed_above_what_the_sampling_can_show():
    assert np.isnan(figure("torque_high_frequency_share", run(period=0.02), cutoff_hz=25.0))
    assert np.isnan(figure("torque_noise", run(period=0.02), cutoff_hz=25.0))


def test_torque_noise_is_the_rms_of_what_lies_above_the_cutoff():
    t = np.arange(1001) * L
    slow, fast = 7.0 + 2.0 * np.sin(2 * np.pi * 10 * t), 0.3 * np.sin(2 * np.pi * 200 * t)
    assert figure("torque_noise", run(torque=slow + fast), cutoff_hz=50.0) == pytest.approx(0.3 / np.sqrt(2), rel=1e-6)
    assert figure("torque_noise", run(torque=slow), cutoff_hz=50.0) < 1e-6


def test_of_white_torque_noise_the_share_of_the_band_above_the_cutoff_counts():
    white = 0.5 * np.random.default_rng(1).standard_normal((64, 1001, 1))
    found = METRICS["torque_noise"](run(batch=64, torque=white), MetricSettings(cutoff_hz=100.0))
    assert np.sqrt(np.mean(found**2)) == pytest.approx(0.5 * np.sqrt(0.8), rel=0.02)


def test_sign_changes_are_counted_with_zero_as_positive():
    s = np.array([1.0, 0.0, -1.0, -0.0, 2.0, -3.0, -1.0, 4.0])  # + + - + + - - +: four changes
    assert figure("s_sign_changes", run(8, s=s)) == pytest.approx(4 / (7 * L))
    # A zero between two positive values is no change, and between two negative ones it is two.
    assert figure("s_sign_changes", run(3, s=np.array([1.0, 0.0, 1.0]))) == 0.0
    assert figure("s_sign_changes", run(3, s=np.array([-1.0, 0.0, -1.0]))) == pytest.approx(2 / (2 * L))


def test_a_law_without_s_has_no_sign_changes_rather_than_zero():
    assert np.isnan(figure("s_sign_changes", run(s=np.full(1001, np.nan))))


def test_saturation_counts_both_signs_and_rounding_at_the_limit():
    torque = np.array([5.0, -5.0, 5.0 * (1 - 1e-12), 4.9, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert figure("saturation_share", run(9, torque=torque), effort_limit=5.0) == pytest.approx(3 / 8)


def test_gains_are_peak_and_last_and_absent_where_there_is_none():
    gain = np.array([0.0, 3.0, 9.0, 4.0])
    assert figure("peak_gain", run(4, gain=gain)) == 9.0
    assert figure("final_gain", run(4, gain=gain)) == 4.0
    assert np.isnan(figure("peak_gain", run(4)))


def test_a_diverged_trial_has_no_figures_and_leaves_its_neighbour_alone():
    q = np.zeros((2, 1001, 1))
    q[0] = 0.5
    q[1, 400:] = np.nan
    values = evaluate(run(batch=2, q=q, gain=np.zeros((2, 1001, 1)), status=("ok", "diverged")))
    assert set(values) == set(METRICS)
    assert all(np.isnan(item[1]).all() for item in values.values())
    undefined = {"settling_time", "trip_time"}  # it ends outside the band, and no robot is named
    assert all(np.isfinite(item[0]).all() for name, item in values.items() if name not in undefined)


def test_settings_refuse_what_has_no_meaning():
    with pytest.raises(ParameterError, match="cutoff_hz: must be positive"):
        MetricSettings(cutoff_hz=0.0)
    with pytest.raises(ParameterError, match="settling_band"):
        MetricSettings(settling_band=np.array([0.1, -0.1]))
    with pytest.raises(ParameterError, match="torque_rate_limit"):
        MetricSettings(torque_rate_limit=0.0)


@pytest.mark.parametrize("metric", METRICS.values(), ids=lambda metric: metric.name)
def test_every_metric_is_defined_in_the_docs_with_unit_and_source(metric):
    text = PAGE.read_text(encoding="utf-8")
    assert metric.quantity in QUANTITIES
    row = next(line for line in text.splitlines() if line.startswith(f"| `{metric.name}` |"))
    assert f"| {for_cell(metric.formula)} | {for_cell(metric.source)} |" in row
    assert f"| {metric.unit} |" in row


def test_what_is_high_begins_at_50_hz_where_nobody_says_otherwise():
    assert MetricSettings().cutoff_hz == 50.0


def test_when_a_run_begins_changes_no_figure():
    s = np.array([1.0, -1.0, -1.0, 2.0])
    rollout = run(4, s=s, torque=s, q=0.01 * s)
    later = dataclasses.replace(rollout, time=rollout.time + 5.0)
    before, after = evaluate(rollout), evaluate(later)
    for name, values in before.items():
        np.testing.assert_allclose(after[name], values, rtol=1e-9, err_msg=name)
