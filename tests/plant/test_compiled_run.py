"""Claims about the compiled engine: its dynamics are Pinocchio's, its runs are those that Pinocchio itself computes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, trees, write
from hypothesis import HealthCheck, given, settings
from plant_cases import Waving

from asmc_pin.arms import arm_names, load_arm
from asmc_pin.controllers import Baek2016, Bsmc, Plestan2010, Ppc, sliding_variable
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import (
    INTEGRATORS,
    Disturbance,
    Drive,
    EndStops,
    Friction,
    PayloadChange,
    Plant,
    Sensor,
    Spread,
)
from asmc_pin.plant.compiled_run import held_dynamics
from asmc_pin.plant.compiled_run.coverage import not_compiled
from asmc_pin.plant.compiled_run.held_dynamics import TOLERANCE, difference_from_pinocchio
from asmc_pin.plant.following import JOINT_TICKS
from asmc_pin.rigid_body.dynamics import bodies_of
from asmc_pin.study.stacked_settings import Stacked

SHARED = {"mbar": [0.62, 0.88, 0.65, 0.26, 0.21, 0.02], "ks": 8.0, "beta": 8.0, "period": 1e-3}
LAWS = {
    "ppc": Ppc(**SHARED),
    "bsmc": Bsmc(**SHARED, gain=4.0, boundary=0.05),
    "plestan2010": Plestan2010(**SHARED, rate=50.0, epsilon="4KL", floor=0.1),
    "baek2016": Baek2016(**SHARED, phi=800.0, alpha=0.03, epsilon=0.01),
    "by position, filtered": Ppc(**SHARED, acceleration="position", filter_hz=200.0),
}
LEVELS = np.array([8.0, 8.0, 5.0, 2.0, 2.0, 1.0])
FRICTION = Friction(LEVELS, 0.1 * LEVELS)
START = np.array([0.0, -1.3, 1.6, -1.2, -1.4, 0.0])
PLANTS = {
    "frictionless": {"friction": Friction()},
    "friction": {"friction": FRICTION},
    "midpoint": {"friction": FRICTION, "integrator": "midpoint"},
    "rk4": {"friction": FRICTION, "integrator": "rk4"},
    "Stribeck, both ways": {"friction": Friction(LEVELS, 1.0, breakaway=1.4 * LEVELS, coulomb_backward=0.5 * LEVELS)},
    "presliding": {"friction": Friction(LEVELS, 1.0, presliding=1e4, presliding_damping=1.0)},
    "drive": {
        "friction": FRICTION,
        "drive": Drive(delay=2.3, current_hz=400.0, velocity_limit=4.0, corner_speed=0.1, no_load_speed=2.0),
    },
    "sensor": {
        "friction": FRICTION,
        "sensor": Sensor(bits=20, position_noise=1e-7, velocity="filter", torque_noise=0.01, delay=1.25),
    },
    "exact velocity": {"friction": FRICTION, "sensor": Sensor(bits=18, velocity="exact", velocity_noise=1e-4)},
    "end stops": {"friction": FRICTION, "end_stops": EndStops(stiffness=1e3)},
    "disturbances": {
        "friction": Friction(0.0, LEVELS),
        "disturbances": [
            Disturbance(profile="sine", torque=5.0, frequency=7.0),
            Disturbance(profile="noise", torque=2.0, frequency=20.0),
            Disturbance(profile="pulse", torque=3.0, start=0.0505, duration=0.03),
        ],
    },
    "payload": {
        "friction": FRICTION,
        "payload_changes": [PayloadChange(time=0.05, payload=4.0), PayloadChange(time=0.1)],
    },
    "spread": {"friction": FRICTION, "spread": Spread(mass=0.1, com=0.01, inertia=0.05, friction=0.2)},
}
HISTORIES = (
    *("q", "v", "torque", "friction_torque", "s", "gain"),
    *("q_measured", "v_measured", "torque_measured", "external_torque"),
)


@pytest.fixture(scope="module")
def ur5():
    return load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])


def run(arm, law, *, batch=2, ticks=200, trials=None, v0=None, **plant):
    return rollout(Plant(arm, **plant), law, Waving(START), 1e-3 * ticks, batch=batch, trials=trials, v0=v0)


def assert_same_bits(one, other, rows=slice(None)):
    for name in HISTORIES:
        np.testing.assert_array_equal(getattr(one, name)[rows], getattr(other, name), err_msg=name)


# The recursion


@pytest.mark.parametrize("name", arm_names())
def test_the_compiled_dynamics_of_every_arm_are_pinocchio_s(name):
    arm = load_arm(name, armature=0.03)
    assert difference_from_pinocchio(arm, bodies_of(arm.tree)) < TOLERANCE


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=trees())
def test_the_compiled_dynamics_of_random_trees_are_pinocchio_s(text, tmp_path: Path):
    arm = load_arm(write(tmp_path, text))
    assert difference_from_pinocchio(arm, bodies_of(arm.tree)) < TOLERANCE


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("loaded", [False, True], ids=["without gravity", "gravity along the axis"])
def test_a_joint_whose_bias_is_rounding_alone_is_not_refused(tmp_path, kind, loaded):
    """Neither velocity nor gravity loads it, or gravity only where it has no arm: what is left says nothing."""
    rng = np.random.default_rng(3)
    for axis in rng.normal(size=(8, 3)):
        axis /= np.linalg.norm(axis)
        element = joint("j", "base", "l", kind=kind, axis=" ".join(map(repr, axis.tolist())))
        file = write(tmp_path, robot(link("base"), link("l", inertial(2.0)), element))
        Plant(load_arm(file, gravity=tuple(9.81 * axis) if loaded else (0.0, 0.0, 0.0)))


def test_a_plant_whose_compiled_dynamics_are_not_pinocchio_s_is_refused(ur5, monkeypatch):
    right = held_dynamics.bodies_of

    def heavier(tree):
        bodies = right(tree)
        bodies.body[5, 33] *= 1.0 + 1e-9  # the mass of the last link
        return bodies

    monkeypatch.setattr(held_dynamics, "bodies_of", heavier)
    arm = ur5.replace(payload=1.0)
    with pytest.raises(ParameterError, match=r"engine: 'compiled' .* away from Pinocchio's.*take 'pinocchio'"):
        Plant(arm)
    Plant(arm, engine="pinocchio")


# Runs


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("law", ["ppc", "baek2016"])
def test_a_run_is_the_one_that_pinocchio_computes(ur5, plant, law):
    compiled, other = (run(ur5, LAWS[law], engine=engine, **PLANTS[plant]) for engine in ("compiled", "pinocchio"))
    assert not_compiled(Plant(ur5, **PLANTS[plant])) is None
    assert compiled.status == other.status == ("ok", "ok")
    np.testing.assert_array_equal(compiled.v == 0.0, other.v == 0.0)
    chatters = plant == "disturbances" and law == "baek2016"  # its 1/|s| makes 1e-5 of rounding there
    for name in ("q", "v", "q_measured", "v_measured", "s", "external_torque"):
        close = {"rtol": 0.0, "atol": 1e-5 if chatters else 1e-11}
        np.testing.assert_allclose(getattr(compiled, name), getattr(other, name), err_msg=name, **close)
    np.testing.assert_allclose(compiled.gain, other.gain, rtol=1e-2 if chatters else 1e-8, atol=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_every_law_and_its_stacked_settings_run_as_by_pinocchio(ur5, law):
    for controller in (LAWS[law], Stacked([LAWS[law], LAWS[law]], 6)):
        compiled, other = (
            run(ur5, controller, engine=engine, ticks=100, friction=FRICTION) for engine in ("compiled", "pinocchio")
        )
        np.testing.assert_allclose(compiled.q, other.q, rtol=0.0, atol=1e-11)
        np.testing.assert_allclose(compiled.v, other.v, rtol=0.0, atol=1e-11)


def test_joints_that_rest_stick_in_both_engines_and_keep_their_angle_to_the_last_bit(ur5):
    still = Waving(START, amplitude=0.0)
    for engine in ("compiled", "pinocchio"):
        held = rollout(Plant(ur5, friction=FRICTION, engine=engine), LAWS["ppc"], still, 0.1)
        assert not held.v.any()
        np.testing.assert_array_equal(held.q[0], np.tile(START, (101, 1)))


@pytest.mark.parametrize("plant", ["friction", "drive", "sensor", "disturbances", "spread"])
def test_a_trial_is_the_same_to_the_last_bit_in_any_batch_chunk_and_thread(ur5, plant, monkeypatch):
    law, moving = LAWS["baek2016"], 0.1 * np.ones(6)
    together = run(ur5, law, batch=17, ticks=40, v0=moving, **PLANTS[plant])
    assert_same_bits(together, run(ur5, law, batch=17, ticks=40, v0=moving, threads=2, **PLANTS[plant]))
    assert_same_bits(together, run(ur5, law, batch=2, ticks=40, trials=[3, 11], v0=moving, **PLANTS[plant]), [3, 11])
    monkeypatch.setattr("asmc_pin.plant.following.JOINT_TICKS", 17 * 7 * 6)
    assert JOINT_TICKS > 17 * 40 * 6
    assert_same_bits(together, run(ur5, law, batch=17, ticks=40, v0=moving, **PLANTS[plant]))


class InNumpy(Ppc):
    """PPC that is asked tick by tick."""

    def step(self, state, sample, setpoint):
        torque, s, state = self.pole_placement(state, sample, setpoint)
        np.testing.assert_array_equal(s, sliding_variable(self.ks, sample, setpoint))
        return torque, state


@pytest.mark.parametrize("plant", ["friction", "drive", "sensor", "disturbances", "payload"])
def test_a_law_that_has_its_step_in_numpy_runs_as_the_compiled_one(ur5, plant):
    one, other = (run(ur5, law(**SHARED), **PLANTS[plant]) for law in (InNumpy, Ppc))
    assert InNumpy.trial_step is None
    assert_same_bits(one, other)


def test_a_law_in_numpy_gives_a_trial_the_same_bits_in_any_batch_and_on_threads(ur5):
    law, moving = InNumpy(**SHARED), 0.1 * np.ones(6)
    together = run(ur5, law, batch=17, ticks=40, v0=moving, **PLANTS["sensor"])
    assert_same_bits(together, run(ur5, law, batch=17, ticks=40, v0=moving, threads=2, **PLANTS["sensor"]))
    alone = run(ur5, law, batch=2, ticks=40, trials=[3, 11], v0=moving, **PLANTS["sensor"])
    assert_same_bits(together, alone, [3, 11])


def test_a_law_in_numpy_that_diverges_leaves_what_the_compiled_one_leaves(ur5):
    one, other = (run(ur5, law(**SHARED), friction=FRICTION, speed_bound=0.3) for law in (InNumpy, Ppc))
    assert one.status == ("diverged", "diverged")
    np.testing.assert_array_equal(one.end_time, other.end_time)
    assert_same_bits(one, other)


@pytest.mark.parametrize("ticks", [2, 15, 16, 17, 33])
def test_every_tick_of_a_law_in_numpy_is_written_however_many_there_are(ur5, ticks):
    one, other = (run(ur5, law(**SHARED), ticks=ticks, friction=FRICTION) for law in (InNumpy, Ppc))
    assert_same_bits(one, other)


def test_a_trial_that_diverges_does_so_at_the_same_tick_in_both_engines_and_leaves_nan(ur5):
    one, other = (
        run(ur5, LAWS["ppc"], engine=engine, friction=FRICTION, speed_bound=0.3) for engine in ("compiled", "pinocchio")
    )
    assert one.status == other.status == ("diverged", "diverged")
    np.testing.assert_array_equal(one.end_time, other.end_time)
    stopped = round(one.end_time[0] / one.period)
    for name in ("q", "v", "torque", "friction_torque", "s", "torque_measured"):
        assert np.isfinite(getattr(one, name)[:, :stopped]).all(), name
        assert np.isnan(getattr(one, name)[:, stopped:]).all(), name


# What is not compiled


@pytest.mark.parametrize(
    ("plant", "reason"),
    [
        ({"drive": Drive(stiffness=1e4, rotor_inertia=1e-4, gear=100.0)}, "elastic"),
        ({"disturbances": [Disturbance(profile="step", link="tool0", force=[0.0, 0.0, 5.0])]}, "wrench"),
    ],
)
def test_what_compiled_code_does_not_have_is_run_by_pinocchio_and_named(ur5, plant, reason):
    assert reason in (not_compiled(Plant(ur5, **plant)) or "")
    one, other = (run(ur5, LAWS["ppc"], engine=engine, ticks=50, **plant) for engine in ("compiled", "pinocchio"))
    np.testing.assert_allclose(one.q, other.q, rtol=0.0, atol=1e-11)


def test_an_integrator_that_is_registered_later_is_run_as_it_is_written(ur5, monkeypatch):
    monkeypatch.setitem(INTEGRATORS, "semi_implicit", INTEGRATORS["midpoint"])
    assert "integrator" in (not_compiled(Plant(ur5)) or "")


def test_an_engine_that_there_is_not_is_refused(ur5):
    with pytest.raises(ParameterError, match="engine: 'mujoco' given; expected 'compiled' or 'pinocchio'"):
        Plant(ur5, engine="mujoco")
