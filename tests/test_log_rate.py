"""Claims about a run that logs one tick in so many: the same run, with fewer rows, that says what it cannot tell."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from plant_cases import Still, Waving, slider

from asmc_pin.arms import load_arm
from asmc_pin.controllers import AdaptiveState, Baek2016, Ppc
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.metrics import METRICS, TripLimits, evaluate, first_trip
from asmc_pin.monitors import monitor
from asmc_pin.plant import Disturbance, Drive, Friction, PayloadChange, Plant, Sensor
from asmc_pin.plant.compiled_run import asked_run
from asmc_pin.plant.energy import energy_balance, stored_energy
from asmc_pin.tool_error import tool_error
from asmc_pin.tool_path import tool_path

TICKS = 60
BY_TRIAL = ("q", "v", "torque", "friction_torque", "s", "gain")
BY_TRIAL += ("q_measured", "v_measured", "torque_measured", "external_torque")
SHARED = ("time", "q_ref", "v_ref", "a_ref")
START = np.array([0.3, 0.2])


class InNumpyPpc(Ppc):
    """PPC that is asked tick by tick."""

    def step(self, state, sample, setpoint):
        torque, _, state = self.pole_placement(state, sample, setpoint)
        return torque, state


class InNumpy(Baek2016):
    """A law with a gain to log that is asked tick by tick."""

    def step(self, state, sample, setpoint):
        torque, s, tde = self.pole_placement(state.tde, sample, setpoint)
        gain = state.gain + np.abs(s)
        return torque + self.mbar * gain * np.sign(s), AdaptiveState(tde, gain)


LAW = {"mbar": [0.05, 0.02], "ks": 8.0, "beta": 8.0, "period": 1e-3, "phi": 400.0, "alpha": 0.1, "epsilon": 0.01}
WAYS = {
    "compiled": (Baek2016(**LAW), "compiled"),
    "asked tick by tick": (InNumpy(**LAW), "compiled"),
    "by Pinocchio": (Baek2016(**LAW), "pinocchio"),
}
PLANTS = {
    "ideal": {"friction": Friction([2.0, 1.0])},
    "nothing ideal": {
        "friction": Friction([2.0, 1.0], breakaway=[2.5, 1.2]),
        "drive": Drive(delay=1.4, current_hz=300.0),
        "sensor": Sensor(bits=20, position_noise=1e-7, velocity="filter", torque_noise=0.01, delay=0.25),
        "disturbances": [Disturbance(profile="sine", torque=[2.0, 1.0], frequency=7.0)],
        "payload_changes": [PayloadChange(time=0.0235, payload=0.5)],
    },
}


@pytest.fixture(scope="module")
def arm():
    return load_arm("two_link", armature=0.05)


def run(arm, way, *, log_every=1, **plant):
    """Three trials, of which the last begins fast."""
    law, engine = WAYS[way]
    v0 = np.array([[0.0, 0.0], [0.1, -0.2], [1.5, 0.0]])
    world = Plant(arm, engine=engine, **{**PLANTS["ideal"], **plant})
    return rollout(world, law, Waving(START), 1e-3 * TICKS, batch=3, v0=v0, log_every=log_every)


def assert_every_nth(thin, whole, n):
    assert thin.log_every == n
    assert len(thin.time) == len(range(0, TICKS + 1, n))
    for name in BY_TRIAL:
        np.testing.assert_array_equal(getattr(thin, name), getattr(whole, name)[:, ::n], err_msg=name)
        assert not getattr(thin, name).flags.writeable
    for name in SHARED:
        np.testing.assert_array_equal(getattr(thin, name), getattr(whole, name)[::n], err_msg=name)
        assert not getattr(thin, name).flags.writeable
    for name in ("status", "period", "joint_names", "limit_violations", "ideal_sensor"):
        assert getattr(thin, name) == getattr(whole, name), name
    np.testing.assert_array_equal(thin.end_time, whole.end_time)
    np.testing.assert_array_equal(thin.held_torque, whole.held_torque)


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("way", WAYS)
def test_a_thinned_log_is_every_nth_row_of_the_whole_one_to_the_last_bit(arm, way, plant, monkeypatch):
    whole = run(arm, way, **PLANTS[plant])
    assert whole.status[0] == "ok"
    # Chunks of ticks and of the log that N does not divide.
    monkeypatch.setattr("asmc_pin.plant.following.JOINT_TICKS", 3 * 2 * 11)
    monkeypatch.setattr(asked_run, "LOG_NUMBERS", 1)
    for n in (1, 7, TICKS):
        assert_every_nth(run(arm, way, log_every=n, **PLANTS[plant]), whole, n)


@pytest.mark.parametrize("way", WAYS)
def test_a_trial_that_breaks_off_between_two_logged_ticks_has_its_end_and_nan_from_the_next_one_on(arm, way):
    whole = run(arm, way, error_bound=0.015)
    assert whole.status == ("ok", "ok", "diverged")
    stopped = round(whole.end_time[2] / whole.period)
    assert 5 < stopped < TICKS
    for n in (2, 3, 5, stopped):
        thin = run(arm, way, log_every=n, error_bound=0.015)
        assert_every_nth(thin, whole, n)
        np.testing.assert_array_equal(np.isnan(thin.q[2, :, 0]), np.arange(0, TICKS + 1, n) >= stopped)


@pytest.mark.parametrize("way", WAYS)
def test_a_joint_that_is_outside_its_limits_between_two_logged_ticks_alone_is_named_all_the_same(tmp_path, way):
    """It flies out over the upper end at 1000 m, and is far back when the next tick is logged."""
    kind = InNumpyPpc if way == "asked tick by tick" else Ppc
    law = kind(mbar=2.0, ks=8.0, beta=8.0, period=1e-3)
    far = {"engine": WAYS[way][1], "speed_bound": 1e9, "error_bound": 1e9}
    plant = Plant(slider(tmp_path, 2.0), friction=Friction(), start="relaxed", **far)
    start = {"q0": [[999.95], [0.0]], "v0": [[100.0], [0.0]], "batch": 2}
    whole, thin = (rollout(plant, law, Still(np.zeros(1)), 0.1, log_every=n, **start) for n in (1, 100))
    assert (np.abs(thin.q) < 1000.0).all()
    (found,) = thin.limit_violations
    assert whole.limit_violations == (found,)
    assert (found.trial, found.joint) == (0, "slide")
    outside = whole.q[0, :, 0] > 1000.0
    assert found.time == whole.time[np.argmax(outside)] > 0.0
    assert found.excess == whole.q.max() - 1000.0 > 0.01


def test_a_log_of_one_tick_in_ten_needs_a_tenth_of_the_memory(arm):
    whole, thin = (run(arm, "compiled", log_every=n, **PLANTS["nothing ideal"]) for n in (1, 10))
    for name in BY_TRIAL:
        assert getattr(thin, name).nbytes * 61 == getattr(whole, name).nbytes * 7, name


def test_it_says_that_ticks_are_missing_and_refuses_what_is_computed_from_each(arm):
    thin = run(arm, "compiled", log_every=7)
    assert thin.lines()[0].startswith("3 trials up to 0.056 s in periods of 0.001 s, one tick in 7 logged")
    assert thin.table()[0][1:] == ["largest logged |e| rad (m)", "largest logged |τ| N·m (N)"]
    plant = Plant(arm, **PLANTS["ideal"])
    asked = {
        "metrics are": [lambda name=name: METRICS[name](thin) for name in METRICS] + [lambda: evaluate(thin)],
        "trips are": [lambda: first_trip(thin, TripLimits(torque=1.0))],
        "monitors are": [lambda: monitor(thin, plant, WAYS["compiled"][0])],
        "energy is": [lambda: energy_balance(plant, thin), lambda: stored_energy(plant, thin)],
        "error is": [lambda: tool_error(arm, thin, "link_2")],
        "path is": [lambda: tool_path(arm, thin, "link_2")],
    }
    for what, calls in asked.items():
        for call in calls:
            with pytest.raises(ParameterError, match=f"log_every: this run has logged one tick in 7, and .*{what} "):
                call()


def test_nothing_is_made_up_for_the_torque_that_was_told_at_a_tick_whose_last_one_is_missing(arm):
    thin = dataclasses.replace(run(arm, "compiled", log_every=7), torque_measured=None)
    assert np.isnan(thin.torque_measured).all()


@pytest.mark.parametrize("given", [0, -1, 1.5, 2.0, True, "2", None, TICKS + 1])
def test_a_rate_that_is_no_whole_number_of_the_run_s_ticks_is_refused(arm, given):
    with pytest.raises(
        ParameterError, match=rf"log_every: {given!r} given; expected a whole number .* at most {TICKS}"
    ):
        run(arm, "compiled", log_every=given)
