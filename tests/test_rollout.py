"""Claims about a run: oracles of the closed loop, starts, limits, divergence, independence of trials, bad input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest
from plant_cases import Accelerating, OpenLoop, Still, Waving, slider

from asmc_pin.arms import load_arm
from asmc_pin.controllers import Baek2016, Ppc, Sample, sliding_variable
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Friction, Plant

Q0 = np.array([0.3, -1.0, 1.2, 0.4, 0.8, 0.2])
MBAR = [0.148, 0.167, 0.150, 0.081, 0.093, 0.017]


@pytest.fixture(scope="module")
def ur5():
    return load_arm("ur5")


def fields_of(result):
    return {name: getattr(result, name) for name in ("q", "v", "torque", "friction_torque", "s", "gain")}


def assert_same_bits(one, other):
    for name, array in fields_of(one).items():
        np.testing.assert_array_equal(array, fields_of(other)[name], err_msg=name)


def only(result, trials):
    """The histories of some trials."""
    return {name: array[trials] for name, array in fields_of(result).items()}


@dataclass
class Loaded:
    """A law under a load torque that only the plant feels: added after the law, and taken out of what it is told."""

    law: Any
    load: Any

    @property
    def period(self) -> float:
        return self.law.period

    def init(self, sample):
        self.tick = 0
        return self.law.init(sample)

    def step(self, state, sample, setpoint):
        felt = self.load((self.tick - 1) * self.period) if self.tick else 0.0
        torque, state = self.law.step(state, Sample(sample.q, sample.v, sample.torque - felt), setpoint)
        load = self.load(self.tick * self.period)
        self.tick += 1
        return torque + load, state


@dataclass(frozen=True)
class TdeOnly:
    """τ = τ(t−L) + m̄ (u − q̈(t−L)): time-delay estimation under a constant command u."""

    mbar: float
    command: float
    period: float = 1e-3

    def init(self, sample):
        return None

    def step(self, state, sample, setpoint):
        estimate = 0.0 * sample.v if state is None else (sample.v - state) / self.period
        return sample.torque + self.mbar * (self.command - estimate), sample.v


class Feedback(NamedTuple):
    """τ = gain·q; the state is what it was called with."""

    gain: float
    period: float = 1e-3

    def init(self, sample):
        return None

    def step(self, state, sample, setpoint):
        return self.gain * sample.q, state


# Oracles of the closed loop


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_drifting_load_leaves_ppc_the_steady_error_of_its_rate_over_mbar_beta_ks_times_the_period(tmp_path, substeps):
    drift, law = 30.0, Ppc(mbar=1.3, ks=12.0, beta=9.0, period=2e-3)
    arm = slider(tmp_path, 2.0)
    result = rollout(Plant(arm, substeps=substeps), Loaded(law, lambda t: drift * t), Still(np.zeros(1)), 6.0)
    # A load that pushes forwards leaves the joint ahead of its reference.
    expected = -law.period * drift / (1.3 * 9.0 * 12.0)
    error = result.q_ref - result.q[0]
    assert error[-1, 0] == pytest.approx(expected, rel=1e-7)


def test_viscous_drag_on_a_steadily_accelerating_joint_is_such_a_load(tmp_path):
    law, viscous, a = Ppc(mbar=1.3, ks=12.0, beta=9.0, period=2e-3), 3.0, 4.0
    plant = Plant(slider(tmp_path, 2.0), substeps=1, friction=Friction(0.0, viscous))
    result = rollout(plant, law, Accelerating(np.array([a])), 6.0)
    assert (result.q_ref - result.q[0])[-1, 0] == pytest.approx(2e-3 * viscous * a / (1.3 * 9.0 * 12.0), rel=1e-6)


@pytest.mark.parametrize("mbar", [0.4, 1.9, 3.0])
def test_tde_error_shrinks_by_one_minus_mbar_over_m(tmp_path, mbar):
    mass, command = 2.0, 1.5
    result = rollout(Plant(slider(tmp_path, mass)), TdeOnly(mbar, command), Still(np.zeros(1)), 0.012)
    error = command - np.diff(result.v[0, :, 0]) / result.period
    ratio = 1.0 - mbar / mass
    np.testing.assert_allclose(error, command * ratio ** np.arange(1, 13), rtol=1e-9, atol=1e-12)


def test_ppc_with_much_too_fast_gains_diverges_although_lemma_1_holds():
    # baek2016.md: M̄ = 0.01 I has a norm below 1 on this arm everywhere, but its estimate is too slow for β = k_s = 50.
    arm = load_arm("two_link")
    stable, unstable = (
        rollout(
            Plant(arm, friction=Friction(), speed_bound=100.0),
            Ppc(mbar=0.01, ks=gain, beta=gain, period=1e-3),
            Waving(np.array([-1.2, 0.2]), amplitude=0.05),
            6.0,
        )
        for gain in (15.0, 50.0)
    )
    assert stable.status == ("ok",)
    assert unstable.status == ("diverged",)
    assert 0.0 < unstable.end_time[0] < 6.0


# Starts and limits


def test_an_arm_under_ppc_that_starts_holding_stays_at_rest_to_rounding(ur5):
    law = Ppc(mbar=MBAR, ks=10.0, beta=10.0, period=1e-3)
    result = rollout(Plant(ur5, friction=Friction()), law, Still(Q0), 1.0)
    np.testing.assert_allclose(result.q[0], np.tile(Q0, (1001, 1)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.torque[0], np.tile(ur5.gravity(Q0), (1001, 1)), rtol=0, atol=1e-9)


def test_an_arm_that_starts_relaxed_falls_until_the_law_has_caught_it(ur5):
    law = Ppc(mbar=MBAR, ks=10.0, beta=10.0, period=1e-3)
    result = rollout(Plant(ur5, friction=Friction(), start="relaxed"), law, Still(Q0), 3.0)
    sag = np.abs(result.q[0] - Q0).max(axis=1)
    assert sag.max() > 1e-3
    assert sag[-1] < 0.02 * sag.max()


def test_the_first_sample_reports_the_torque_that_holds_within_the_limits(ur5):
    gravity = ur5.gravity(Q0)
    limit = np.full(6, 5.0)
    for start, expected in (("holding", np.clip(gravity, -5.0, 5.0)), ("relaxed", np.zeros(6))):
        law = OpenLoop(lambda t: np.zeros(6), 1e-3)
        rollout(Plant(ur5, effort_limit=limit, start=start), law, Still(Q0), 0.01)
        np.testing.assert_allclose(law.seen[0].torque[0], expected, rtol=1e-12)
    assert np.any(np.abs(gravity) > 5.0)


def test_the_law_is_told_the_torque_after_the_limits_and_the_plant_feels_no_more(tmp_path):
    law = OpenLoop(lambda t: 100.0 * np.cos(50.0 * t), 1e-3)
    result = rollout(Plant(slider(tmp_path, 2.0), effort_limit=[30.0], substeps=3), law, Still(np.zeros(1)), 0.2)
    asked = 100.0 * np.cos(50.0 * result.time)
    np.testing.assert_array_equal(result.torque[0, :, 0], np.clip(asked, -30.0, 30.0))
    told = np.array([sample.torque[0, 0] for sample in law.seen])
    np.testing.assert_array_equal(told[1:], result.torque[0, :-1, 0])
    np.testing.assert_allclose(np.diff(result.v[0, :, 0]), 1e-3 * result.torque[0, :-1, 0] / 2.0, rtol=0, atol=1e-13)


def test_the_urdf_s_torque_limits_apply_unless_others_are_given(ur5):
    law = OpenLoop(lambda t: np.full(6, 1e6), 1e-3)
    # Of the last tick, as the arm soon spins beyond all bounds.
    assert np.array_equal(rollout(Plant(ur5), law, Still(Q0), 0.002).torque[0, 0], ur5.effort_limit)
    free = Plant(ur5, effort_limit=np.full(6, np.inf))
    assert np.array_equal(rollout(free, law, Still(Q0), 0.002).torque[0, 0], np.full(6, 1e6))


def test_leaving_joint_limits_is_reported_with_time_and_extent_and_not_prevented(tmp_path):
    arm = slider(tmp_path, 1.0)
    result = rollout(Plant(arm), OpenLoop(lambda t: 8.0, 0.01), Still(np.array([998.0])), 1.0, batch=2)
    assert result.status == ("ok", "ok")
    assert [(found.trial, found.joint) for found in result.limit_violations] == [(0, "slide"), (1, "slide")]
    # 998 + 4 t² passes 1000 at 0.7071 s and ends at 1002.
    assert result.limit_violations[0].time == pytest.approx(0.71)
    assert result.limit_violations[0].excess == pytest.approx(2.0)
    (line,) = result.warnings
    assert "'slide'" in line
    assert "2 of 2 trials" in line
    assert "0.71 s" in line
    assert "2 above its upper limit" in line
    assert not rollout(Plant(arm), OpenLoop(lambda t: 8.0, 0.01), Still(np.zeros(1)), 1.0).warnings


# Divergence


def test_a_trial_that_runs_away_is_stopped_and_leaves_the_others_as_they_were(tmp_path):
    plant = Plant(slider(tmp_path, 1.0), effort_limit=np.inf, speed_bound=10.0)
    law = Feedback(400.0)  # τ = 400 q on 1 kg: q grows with cosh(20 t); at 0 it stays
    together = rollout(plant, law, Still(np.zeros(1)), 1.0, batch=3, q0=[[1e-9], [1e-3], [-1e-9]])
    alone = rollout(plant, law, Still(np.zeros(1)), 1.0, batch=2, q0=[[1e-9], [-1e-9]])
    assert together.status == ("ok", "diverged", "ok")
    for name, array in only(together, [0, 2]).items():
        np.testing.assert_array_equal(array, fields_of(alone)[name])
    # |v| = 20e-3 sinh(20 t) passes 10 rad/s at t = asinh(500)/20.
    assert together.end_time == pytest.approx([1.0, np.arcsinh(500.0) / 20.0, 1.0], abs=5e-3)
    stopped = round(together.end_time[1] / together.period)
    for array in (together.q, together.v, together.torque, together.friction_torque):
        assert np.isfinite(array[1, :stopped]).all()
        assert np.isnan(array[1, stopped:]).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_torque_that_is_not_finite_stops_its_own_trial(tmp_path, bad):
    def torque(t):
        return np.array([[1.0], [bad if t > 0.0495 else 1.0]])

    plant = Plant(slider(tmp_path, 1.0))
    result = rollout(plant, OpenLoop(torque, 1e-3), Still(np.zeros(1)), 0.1, batch=2)
    assert result.status == ("ok", "diverged")
    assert result.end_time[1] == pytest.approx(0.05)
    alone = rollout(plant, OpenLoop(lambda t: 1.0, 1e-3), Still(np.zeros(1)), 0.1)
    for name, array in only(result, [0]).items():
        np.testing.assert_array_equal(array, fields_of(alone)[name])


def test_a_state_that_overflows_is_a_divergence_without_a_warning(tmp_path, recwarn):
    plant = Plant(slider(tmp_path, 1.0), effort_limit=np.inf)
    result = rollout(plant, OpenLoop(lambda t: 1e300 * np.exp(1e4 * t), 1e-3), Still(np.zeros(1)), 0.1)
    assert result.status == ("diverged",)
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]


def test_a_run_whose_every_trial_diverged_ends_there(tmp_path):
    law = OpenLoop(lambda t: np.nan, 1e-3)
    seen = []
    result = rollout(Plant(slider(tmp_path, 1.0)), law, Still(np.zeros(1)), 5.0, progress=lambda *at: seen.append(at))
    assert len(law.seen) == 1
    assert result.q.shape == (1, 5001, 1)
    assert np.isnan(result.q).all()
    assert seen[-1] == (5001, 5001)


def test_far_from_the_reference_counts_as_diverged(tmp_path):
    plant = Plant(slider(tmp_path, 1.0), error_bound=0.5001)
    result = rollout(plant, OpenLoop(lambda t: 1.0, 1e-2), Still(np.zeros(1)), 2.0)
    assert result.status == ("diverged",)
    assert result.end_time[0] == pytest.approx(1.01)  # ½ t² > 0.5001


# Independence of trials


@pytest.fixture(scope="module")
def crowd(ur5):
    """Five trials that differ in start, friction, limits and payload."""
    rng = np.random.default_rng(5)
    arms = [ur5.replace(payload=mass) if mass else ur5 for mass in (0.0, 2.0, 0.0, 1.0, 0.0)]
    arms[1] = arms[3] = arms[1]  # shared by two trials that are no neighbours
    return {
        "arm": arms,
        "friction": Friction(rng.uniform(0.0, 6.0, (5, 6)), rng.uniform(0.0, 1.0, (5, 6))),
        "effort_limit": rng.uniform(30.0, 90.0, (5, 6)),
        "q0": Q0 + rng.uniform(-0.05, 0.05, (5, 6)),
        "v0": rng.uniform(-0.1, 0.1, (5, 6)),
    }


def play(crowd, trials, duration=0.3, **more):
    plant = Plant(
        [crowd["arm"][i] for i in trials],
        friction=Friction(crowd["friction"].coulomb[trials], crowd["friction"].viscous[trials]),
        effort_limit=crowd["effort_limit"][trials],
        **more,
    )
    law = Baek2016(mbar=MBAR, ks=10.0, beta=10.0, period=1e-3, phi=200.0, alpha=0.6, epsilon=0.015)
    return rollout(plant, law, Waving(Q0), duration, batch=len(trials), q0=crowd["q0"][trials], v0=crowd["v0"][trials])


def test_splitting_a_batch_leaves_every_bit_as_it_was(crowd):
    together = play(crowd, [0, 1, 2, 3, 4])
    for trials in ([0], [1], [2, 3], [4, 0, 1]):
        part = play(crowd, trials)
        for name, array in only(together, trials).items():
            np.testing.assert_array_equal(array, fields_of(part)[name], err_msg=f"{name} of {trials}")
    assert not np.array_equal(together.q[0], together.q[2]), "the trials do differ"


def test_threads_change_no_bit(crowd):
    trials = [0, 2, 4] * 8
    assert_same_bits(play(crowd, trials, 0.02), play(crowd, trials, 0.02, threads=2))


def test_a_payload_per_trial_is_felt(ur5):
    heavy = ur5.replace(payload=5.0)
    law = OpenLoop(lambda t: np.zeros(6), 1e-3)
    result = rollout(Plant([ur5, heavy], effort_limit=np.inf), law, Still(Q0), 0.01, batch=2)
    expected = [arm.forward_dynamics(Q0, np.zeros(6), np.zeros(6)) for arm in (ur5, heavy)]
    np.testing.assert_allclose(result.v[:, 1] / 1e-3, expected, rtol=0.02, atol=0.02)
    np.testing.assert_allclose(law.seen[0].torque, [ur5.gravity(Q0), heavy.gravity(Q0)])


# What is logged


def test_s_and_gain_are_those_of_the_law_and_nan_where_it_has_none(ur5):
    law = Baek2016(mbar=MBAR, ks=[1, 2, 3, 4, 5, 6], beta=10.0, period=1e-3, phi=200.0, alpha=0.6, epsilon=0.015)
    result = rollout(Plant(ur5), law, Waving(Q0), 0.1)
    reference = Waving(Q0).evaluate(result.time)
    expected = sliding_variable(law.ks, Sample(result.q[0], result.v[0], result.torque[0]), reference)
    np.testing.assert_array_equal(result.s[0], expected)
    gain = np.zeros((1, 6))
    for k in range(len(result.time)):
        gain = law.adapt(gain, result.s[:, k])
        np.testing.assert_array_equal(result.gain[:, k], gain)
    plain = rollout(Plant(ur5), OpenLoop(lambda t: np.zeros(6), 1e-3), Still(Q0), 0.01)
    assert np.isnan(plain.s).all()
    assert np.isnan(plain.gain).all()


def test_time_is_counted_in_whole_periods_and_the_histories_are_read_only(tmp_path):
    result = rollout(Plant(slider(tmp_path, 1.0)), OpenLoop(lambda t: 0.0, 4e-3), Still(np.zeros(1)), 1.0)
    np.testing.assert_array_equal(result.time, np.arange(251) * 4e-3)
    assert result.period == 4e-3
    for array in (result.time, result.q, result.torque, result.q_ref, result.s):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0.0


def test_progress_runs_up_to_the_number_of_ticks(tmp_path):
    seen = []
    rollout(
        Plant(slider(tmp_path, 1.0)), OpenLoop(lambda t: 0.0, 1e-3), Still(np.zeros(1)), 0.1,
        progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    done, totals = zip(*seen, strict=True)
    assert list(done) == sorted(set(done))
    assert set(totals) == {101}
    assert done[-1] == 101


@pytest.mark.parametrize("engine", ["compiled", "pinocchio"])
def test_progress_of_a_law_that_is_asked_tick_by_tick_is_told_on_the_way(tmp_path, engine):
    seen = []
    plant = Plant(slider(tmp_path, 1.0), engine=engine)
    rollout(plant, OpenLoop(lambda t: 0.0, 1e-3), Still(np.zeros(1)), 0.1, progress=lambda *at: seen.append(at[0]))
    assert len(seen) >= 3
    assert max(np.diff([0, *seen])) <= 50  # at least twice in a tenth of a second


def test_a_law_cannot_reach_into_the_plant_through_what_it_is_given(tmp_path):
    class Meddling(OpenLoop):
        def step(self, state, sample, setpoint):
            (setpoint if state else sample).q[:] = 1.0
            return super().step(state, sample, setpoint)

    with pytest.raises(ValueError, match="read-only"):
        rollout(Plant(slider(tmp_path, 1.0)), Meddling(lambda t: 0.0, 1e-3), Still(np.zeros(1)), 0.1)


def test_an_exception_in_a_law_is_raised(tmp_path):
    class Broken(OpenLoop):
        def step(self, state, sample, setpoint):
            raise KeyError("my own mistake")

    with pytest.raises(KeyError, match="my own mistake"):
        rollout(Plant(slider(tmp_path, 1.0)), Broken(lambda t: 0.0, 1e-3), Still(np.zeros(1)), 0.1)


# Bad input


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"substeps": 0}, "at least 1"),
        ({"substeps": 1.5}, "whole number"),
        ({"start": "falling"}, "'holding' or 'relaxed'"),
        ({"integrator": "euler"}, "semi_implicit"),
        ({"speed_bound": -1.0}, "positive"),
        ({"error_bound": np.nan}, "positive"),
        ({"threads": 0}, "at least 1"),
        ({"effort_limit": [1.0, 2.0]}, "for 6 joints"),
        ({"effort_limit": [1.0, 2.0, 3.0, 4.0, 5.0, -6.0]}, "positive"),
        ({"effort_limit": np.nan}, "positive"),
        ({"friction": Friction([1.0, 2.0])}, "for 6 joints"),
    ],
)
def test_a_plant_that_cannot_be_is_refused(ur5, arguments, said):
    with pytest.raises(ParameterError, match=said):
        Plant(ur5, **arguments)


def test_arms_with_other_joints_do_not_make_one_batch(ur5):
    with pytest.raises(ParameterError, match="trial 1 has the joints"):
        Plant([ur5, load_arm("two_link")])
    with pytest.raises(ParameterError, match="expected an Arm"):
        Plant("ur5")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"duration": 0.0}, "positive"),
        ({"duration": np.nan}, "positive"),
        ({"duration": 1e-4}, "less than one control period"),
        ({"period": 2e-3}, "leave it out"),
        ({"period": -1e-3}, "positive"),
        ({"batch": 0}, "at least 1"),
        ({"batch": 1.5}, "whole number"),
        ({"q0": np.zeros(5)}, "for 6 joints"),
        ({"q0": np.full(6, np.nan)}, "finite"),
        ({"v0": np.zeros((3, 6))}, "3 trials"),
        ({"reference": Still(np.zeros(2))}, "shape"),
        ({"reference": Still(np.full(6, np.nan))}, "not finite at t = 0"),
        ({"controller": Ppc(mbar=[0.1, 0.2], ks=1.0, beta=1.0, period=1e-3)}, "2 values but the arm has 6"),
        ({"controller": OpenLoop(lambda t: np.zeros(6), None)}, "no period of its own"),
    ],
)
def test_a_run_that_cannot_be_is_refused(ur5, arguments, said):
    wanted = {
        "controller": OpenLoop(lambda t: np.zeros(6), 1e-3),
        "reference": Still(Q0),
        "duration": 0.1,
    } | arguments
    with pytest.raises(ParameterError, match=said):
        rollout(Plant(ur5), wanted.pop("controller"), wanted.pop("reference"), wanted.pop("duration"), **wanted)


def test_friction_or_arms_for_another_number_of_trials_are_refused(ur5):
    law = OpenLoop(lambda t: np.zeros(6), 1e-3)
    with pytest.raises(ParameterError, match="given for 3 trials, but the batch has 2"):
        rollout(Plant(ur5, friction=Friction(np.ones((3, 6)))), law, Still(Q0), 0.1, batch=2)
    with pytest.raises(ParameterError, match="2 arms given for a batch of 1"):
        rollout(Plant([ur5, ur5]), law, Still(Q0), 0.1)


@pytest.mark.parametrize("torque", [np.zeros(6), np.zeros((1, 5)), 0.0, "none"])
def test_a_law_that_returns_something_else_than_a_torque_per_joint_is_told_so(ur5, torque):
    class Wrong(OpenLoop):
        def step(self, state, sample, setpoint):
            return torque, state

    with pytest.raises(ParameterError, match=r"Wrong.step returned .*\(1, 6\)"):
        rollout(Plant(ur5), Wrong(None, 1e-3), Still(Q0), 0.1)
