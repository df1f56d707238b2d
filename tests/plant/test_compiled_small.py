"""The compiled engine on an arm of three joints, in runs so short that its code can also be run as Python.

What a run is compared with is computed by Pinocchio and numpy, tick by tick, in code of its own.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from plant_cases import Waving

from asmc_pin.arms import Arm, load_arm
from asmc_pin.controllers import Baek2016, Ppc
from asmc_pin.engine import Rollout, rollout
from asmc_pin.plant import Disturbance, Drive, EndStops, Friction, PayloadChange, Plant, Sensor, Spread
from asmc_pin.plant.compiled_run.coverage import not_compiled
from asmc_pin.plant.compiled_run.held_dynamics import TOLERANCE, difference_from_pinocchio
from asmc_pin.plant.compiled_run.run_state import TRIALS_PER_THREAD
from asmc_pin.plant.compiled_run.run_ticks import run_law
from asmc_pin.rigid_body.dynamics import bodies_of
from asmc_pin.study.stacked_settings import Stacked

SHARED = {"mbar": [0.3, 0.08, 0.6], "ks": 8.0, "beta": 8.0, "period": 1e-3}
LAWS = {"ppc": Ppc(**SHARED), "baek2016": Baek2016(**SHARED, phi=800.0, alpha=0.03, epsilon=0.01)}
START = np.array([0.3, -0.4, 0.1])
LEVELS = np.array([2.0, 1.5, 3.0])
VISCOUS = np.array([0.4, 0.3, 2.0])
COUNTS = [1e-4, 1e-4, 1e-5]
SLIDING = Friction(LEVELS, VISCOUS)
PLANTS: dict[str, dict[str, Any]] = {
    "frictionless": {"friction": Friction()},
    "viscous alone": {"friction": Friction(0.0, VISCOUS)},
    "friction": {"friction": SLIDING},
    "friction of motion backwards alone": {"friction": Friction(0.0, VISCOUS, coulomb_backward=[0.8, 0.5, 0.9])},
    "friction on one joint": {"friction": Friction([0.0, 1.5, 0.0], VISCOUS)},
    "midpoint": {"friction": SLIDING, "integrator": "midpoint"},
    "midpoint without friction": {"friction": Friction(), "integrator": "midpoint", "substeps": 2},
    "rk4": {"friction": SLIDING, "integrator": "rk4"},
    "rk4 without friction": {"friction": Friction(), "integrator": "rk4"},
    "rk4 with what is smooth": {"friction": Friction(0.0, VISCOUS), "integrator": "rk4"},
    "substeps": {"friction": SLIDING, "substeps": 3},
    "weak drives": {"friction": SLIDING, "effort_limit": [14.0, 12.0, 25.0]},
    "Stribeck, both ways": {
        "friction": Friction(LEVELS, 1.0, breakaway=1.4 * LEVELS, coulomb_backward=0.5 * LEVELS),
    },
    "Stribeck, rk4": {"friction": Friction(LEVELS, 1.0, breakaway=1.4 * LEVELS), "integrator": "rk4"},
    "presliding": {
        "friction": Friction(LEVELS, VISCOUS, presliding=[1e3, 2e3, 3e4], presliding_damping=1.0),
    },
    "presliding on one joint": {"friction": Friction([2.0, 0.0, 0.0], VISCOUS, presliding=[1e3, 0.0, 0.0])},
    "drive": {
        "friction": SLIDING,
        "substeps": 2,
        "drive": Drive(delay=2.3, current_hz=400.0, velocity_limit=1.0, corner_speed=0.1, no_load_speed=0.8),
    },
    "sensor": {
        "friction": SLIDING,
        "sensor": Sensor(resolution=COUNTS, position_noise=1e-6, velocity="filter", torque_noise=0.01, delay=1.25),
    },
    "exact velocity": {"friction": SLIDING, "sensor": Sensor(resolution=COUNTS, velocity="exact", velocity_noise=1e-4)},
    "end stops": {"friction": SLIDING, "end_stops": EndStops(stiffness=1e3)},
    "disturbances": {
        "friction": Friction(0.0, VISCOUS),
        "substeps": 2,
        "disturbances": [
            Disturbance(profile="sine", torque=5.0, frequency=7.0),
            Disturbance(profile="noise", torque=2.0, frequency=20.0),
            Disturbance(profile="pulse", torque=3.0, start=0.0105, duration=0.01),
        ],
    },
    "payload": {"friction": SLIDING, "payload_changes": [PayloadChange(time=0.02, payload=1.0)]},
    "spread": {"friction": SLIDING, "spread": Spread(mass=0.1, com=0.01, inertia=0.05, friction=0.2)},
}
HISTORIES = (
    *("q", "v", "torque", "friction_torque", "s", "gain"),
    *("q_measured", "v_measured", "torque_measured", "external_torque"),
)
SIZES = {"torque": 1e-7, "friction_torque": 1e-7, "gain": 1e-7, "torque_measured": 1e-7}
"""By how much rounding may part what is divided by a period or a small s; 1e-11 for all else."""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    """A turn about z, one about a slanted axis, and a slide, each link with its mass beside the axis."""
    skew = np.array([[0.03, 0.004, -0.006], [0.004, 0.05, 0.008], [-0.006, 0.008, 0.04]])
    limit = '<limit lower="-0.5" upper="0.5" effort="400" velocity="3"/>'
    text = robot(
        link("base"),
        link("first", inertial(2.0, com="0.05 -0.02 0.1", inertia=skew)),
        link("second", inertial(1.5, com="0.12 0.03 -0.04", inertia=0.6 * skew, rpy="0.3 0.2 -0.5")),
        link("third", inertial(0.8, com="-0.02 0.06 0.05", inertia=0.3 * skew)),
        joint("turn", "base", "first", axis="0 0 1", rpy="0.4 -0.2 0.1", extra=limit),
        joint("swing", "first", "second", axis="0.36 0.48 0.8", xyz="0.2 0.1 0.15", rpy="-0.3 0.5 0.2", extra=limit),
        joint("slide", "second", "third", kind="prismatic", axis="0.6 0 0.8", xyz="0.25 -0.05 0.1", extra=limit),
    )
    return load_arm(write(tmp_path_factory.mktemp("small"), text))


BEGINS = ((0.5, 0.2, 0.1), (-1.5, -1.2, -0.6))
"""Velocities with which two trials begin: one joins the motion, the other has to turn round."""


def run(arm: Arm, law: Any, *, ticks: int = 36, batch: int = 2, reference: Any = None, **plant: Any) -> Rollout:
    moving = Waving(START, amplitude=0.3, rate=25.0) if reference is None else reference
    return rollout(Plant(arm, **plant), law, moving, 1e-3 * ticks, batch=batch, v0=BEGINS)


def test_the_dynamics_are_pinocchio_s(arm: Arm) -> None:
    assert difference_from_pinocchio(arm, bodies_of(arm.tree)) < TOLERANCE


def test_the_dynamics_of_an_arm_on_a_slanted_wall_are_pinocchio_s(arm: Arm) -> None:
    leaning = arm.replace(gravity=(3.0, -7.0, 5.0))
    assert difference_from_pinocchio(leaning, bodies_of(leaning.tree)) < TOLERANCE


def test_an_arm_that_nothing_pulls_is_not_refused(arm: Arm) -> None:
    """Without gravity its turning alone is what a bias is measured by."""
    assert difference_from_pinocchio(arm.replace(gravity=(0.0, 0.0, 0.0)), bodies_of(arm.tree)) > 0.1
    floating = arm.replace(gravity=(0.0, 0.0, 0.0))
    assert difference_from_pinocchio(floating, bodies_of(floating.tree)) < TOLERANCE


@pytest.mark.parametrize(
    ("law", "plant"),
    [*(("ppc", plant) for plant in PLANTS), *(("baek2016", plant) for plant in ("friction", "drive", "disturbances"))],
)
def test_a_run_of_a_small_arm_is_the_one_that_pinocchio_computes(arm: Arm, plant: str, law: str) -> None:
    compiled, other = (run(arm, LAWS[law], engine=engine, **PLANTS[plant]) for engine in ("compiled", "pinocchio"))
    assert not_compiled(Plant(arm, **PLANTS[plant])) is None
    assert compiled.status == other.status == ("ok", "ok")
    np.testing.assert_array_equal(compiled.v == 0.0, other.v == 0.0)
    for name in HISTORIES:
        size = max(1.0, np.abs(getattr(other, name)).max())
        np.testing.assert_allclose(
            getattr(compiled, name), getattr(other, name), rtol=0.0, atol=SIZES.get(name, 1e-11) * size, err_msg=name
        )


@pytest.mark.parametrize("ticks", [1, 2, 3, 7])
@pytest.mark.parametrize("plant", ["sensor", "exact velocity", "disturbances"])
def test_a_short_run_is_the_beginning_of_a_long_one_noise_and_all(arm: Arm, plant: str, ticks: int) -> None:
    short, long = (run(arm, LAWS["ppc"], ticks=count, **PLANTS[plant]) for count in (ticks, 20))
    for name in HISTORIES:
        np.testing.assert_array_equal(getattr(short, name), getattr(long, name)[:, : ticks + 1], err_msg=name)


class InNumpy(Ppc):
    """PPC that is asked in Python at every tick."""

    def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
        torque, _, state = self.pole_placement(state, sample, setpoint)
        return torque, state


@pytest.mark.parametrize(
    "plant", ["frictionless", "friction", "substeps", "drive", "sensor", "disturbances", "payload"]
)
def test_a_law_that_is_asked_at_every_tick_runs_to_the_last_bit_as_the_compiled_one(arm: Arm, plant: str) -> None:
    one, other = (run(arm, law(**SHARED), ticks=40, **PLANTS[plant]) for law in (InNumpy, Ppc))
    for name in HISTORIES:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


class Asked:
    """A law as a user's own: all that is known of it is that it can be asked."""

    def __init__(self, law: Any) -> None:
        self.period, self.ks, self.init, self.step = law.period, law.ks, law.init, law.step


def test_the_gain_of_a_law_that_is_asked_at_every_tick_is_logged_as_the_compiled_one_s(arm: Arm) -> None:
    one, other = (run(arm, law, ticks=40, friction=SLIDING) for law in (Asked(LAWS["baek2016"]), LAWS["baek2016"]))
    assert np.ptp(other.gain) > 1.0
    np.testing.assert_array_equal(one.gain, other.gain)


@pytest.mark.parametrize("threads", [None, 2])
def test_trials_run_on_as_many_threads_at_a_time_as_are_asked_for_and_on_the_caller_s_alone_by_default(
    arm: Arm, threads: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    met = threading.Barrier(threads or 1)
    callers = set()

    def meeting(*given: Any) -> None:
        met.wait(timeout=10.0)  # each part waits for the others: one after the other, they would never meet
        callers.add(threading.get_ident())
        run_law(*given)

    monkeypatch.setattr("asmc_pin.plant.compiled_run.run_state.run_law", meeting)
    plant = Plant(arm, friction=Friction(), **({} if threads is None else {"threads": threads}))
    rollout(plant, LAWS["ppc"], Waving(START, amplitude=0.0), 1e-3, batch=2 * TRIALS_PER_THREAD)
    assert len(callers) == (threads or 1)
    assert (threading.get_ident() in callers) == (threads is None)


class Lost(InNumpy):
    """PPC that asks one of two trials for no number from the tenth tick on."""

    def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
        torque, after = super().step(state, sample, setpoint)
        return (torque * [[1.0], [np.nan]] if state.ticks >= 10 else torque), after


@pytest.mark.parametrize(
    ("law", "bound", "status"),
    [
        (Lost(**SHARED), {}, ("ok", "diverged")),
        (Ppc(**SHARED), {"speed_bound": 1.4}, ("ok", "diverged")),
        (InNumpy(**SHARED), {"error_bound": 0.012}, ("diverged", "diverged")),
    ],
)
def test_a_trial_that_is_lost_stops_at_the_same_tick_by_pinocchio(
    arm: Arm, law: Any, bound: dict[str, Any], status: tuple[str, str]
) -> None:
    still = Waving(START, amplitude=0.0)
    compiled, other = (
        run(arm, law, reference=still, friction=SLIDING, engine=engine, **bound) for engine in ("compiled", "pinocchio")
    )
    assert compiled.status == other.status == status
    np.testing.assert_array_equal(compiled.end_time, other.end_time)
    for name in ("q", "v", "torque", "friction_torque"):
        found, expected = getattr(compiled, name), getattr(other, name)
        np.testing.assert_array_equal(np.isnan(found), np.isnan(expected), err_msg=name)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=SIZES.get(name, 1e-11) * 50.0, err_msg=name)


def test_settings_that_are_asked_together_at_every_tick_run_as_each_alone(arm: Arm) -> None:
    settings = [InNumpy(**{**SHARED, "ks": ks}) for ks in (8.0, 5.0)]
    together = run(arm, Stacked(settings, 3), ticks=20, **PLANTS["friction"])
    for trial, law in enumerate(settings):
        alone = run(arm, law, ticks=20, **PLANTS["friction"])
        np.testing.assert_array_equal(together.q[trial], alone.q[trial])
        np.testing.assert_array_equal(together.torque[trial], alone.torque[trial])


@pytest.mark.parametrize("bound", [{"speed_bound": 1.5}, {"error_bound": 0.01}])
def test_a_law_that_is_asked_at_every_tick_stops_where_the_compiled_one_does(arm: Arm, bound: dict[str, Any]) -> None:
    one, other = (run(arm, law(**SHARED), ticks=40, **PLANTS["weak drives"], **bound) for law in (InNumpy, Ppc))
    assert one.status == other.status == ("diverged", "diverged")
    assert 0.0 < one.end_time[0] < one.time[-1]
    np.testing.assert_array_equal(one.end_time, other.end_time)
    for name in HISTORIES:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


@pytest.mark.parametrize("plant", ["sensor", "disturbances", "payload"])
def test_in_how_many_pieces_a_run_is_computed_changes_no_bit_of_it(
    arm: Arm, plant: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = run(arm, LAWS["baek2016"], ticks=30, **PLANTS[plant])
    monkeypatch.setattr("asmc_pin.plant.following.JOINT_TICKS", 2 * 3 * 7)  # two trials, three joints, seven ticks
    pieces = run(arm, LAWS["baek2016"], ticks=30, **PLANTS[plant])
    for name in HISTORIES:
        np.testing.assert_array_equal(getattr(whole, name), getattr(pieces, name), err_msg=name)


def test_a_reference_may_go_farther_than_a_trial_may_be_from_it(arm: Arm) -> None:
    """The bound on the error is about where the reference is at a tick, not where it ends."""
    away = Waving(START, amplitude=0.4, rate=10.0)
    went = run(arm, LAWS["ppc"], ticks=120, reference=away, friction=Friction(), error_bound=0.15)
    assert np.abs(went.q_ref[-1] - went.q_ref[0]).max() > 0.15
    assert went.status == ("ok", "ok")
