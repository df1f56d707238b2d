"""Claims about what acts on the arm, what it picks up, and how trials differ."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plant_cases import OpenLoop, Still, slider

from asmc_pin.arms import load_arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.arms.urdf.rigid_inertia import inertia_problem
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Disturbance, Drive, EndStops, Friction, PayloadChange, Plant, Sensor, Spread, moving_arms
from asmc_pin.plant.world.end_stops import StopForces
from asmc_pin.plant.world.spread import vary_links

L = 1e-3
MASS = 2.0


@pytest.fixture
def arm(tmp_path):
    return slider(tmp_path, MASS)


def run(arm, duration=0.5, batch=1, torque=0.0, trials=None, v0=0.0, q0=0.0, substeps=2, **options):
    plant = Plant(arm, start="relaxed", friction=Friction(), substeps=substeps, **options)
    law = OpenLoop(lambda t: torque, L)
    return rollout(plant, law, Still(np.zeros(1)), duration, batch=batch, trials=trials, v0=[v0], q0=[q0])


# Disturbances


@pytest.mark.parametrize("substeps", [1, 3])
def test_a_step_and_a_pulse_give_their_impulse_wherever_they_begin_and_end(arm, substeps):
    step = Disturbance(profile="step", torque=3.0, start=0.10037)
    pulse = Disturbance(profile="pulse", torque=-8.0, start=0.2003, duration=0.00141)
    result = run(arm, disturbances=[step, pulse], substeps=substeps)
    t = result.time
    impulse = 3.0 * np.maximum(t - 0.10037, 0.0) - 8.0 * np.clip(t - 0.2003, 0.0, 0.00141)
    np.testing.assert_allclose(result.v[0, :, 0], impulse / MASS, atol=1e-12)
    np.testing.assert_allclose(L * np.cumsum(result.external_torque[0, :-1, 0]), impulse[1:], atol=1e-12)


def test_a_sine_starts_at_its_start_and_ends_after_its_duration(arm):
    sine = Disturbance(profile="sine", torque=3.0, start=0.1, frequency=7.0, duration=0.3)
    result = run(arm, disturbances=[sine])
    w = 2 * np.pi * 7.0
    on = np.clip(result.time - 0.1, 0.0, 0.3)
    np.testing.assert_allclose(result.v[0, :, 0], 3.0 / (w * MASS) * (1.0 - np.cos(w * on)), atol=1e-12)


def test_noise_has_its_size_and_colour(arm):
    noise = Disturbance(profile="noise", torque=2.0, frequency=20.0)
    result = run(arm, duration=8.0, batch=12, disturbances=[noise], seed=1, error_bound=1e6)
    torque = result.external_torque[:, :, 0]
    assert torque.std() == pytest.approx(2.0, rel=0.05)
    for lag in (1, 8):
        correlation = np.mean(torque[:, lag:] * torque[:, :-lag]) / np.mean(torque**2)
        assert correlation == pytest.approx(np.exp(-2 * np.pi * 20.0 * lag * L), abs=0.03)
    assert abs(np.corrcoef(torque)[0, 1]) < 0.3, "trials have noise of their own"


def test_noise_belongs_to_the_trial_and_not_to_the_step_of_the_integration(arm):
    noise = [
        Disturbance(profile="noise", torque=2.0, frequency=20.0),
        Disturbance(profile="noise", torque=1.0, frequency=5.0),
    ]
    together = run(arm, batch=4, disturbances=noise)
    alone = run(arm, trials=[2], disturbances=noise)
    fine = run(arm, batch=4, disturbances=noise, substeps=6)
    np.testing.assert_array_equal(together.q[2], alone.q[0])
    np.testing.assert_allclose(together.external_torque, fine.external_torque, rtol=1e-12)


@pytest.mark.parametrize("axes", ["base", "link"])
@pytest.mark.parametrize("name", ["ur5", "panda", "two_link"])
def test_a_wrench_at_a_link_does_the_work_of_its_force_and_moment(name, axes):
    arm = load_arm(name)
    rng = np.random.default_rng(6)
    link = arm.link_names[-1]
    q, v = rng.uniform(-1.0, 1.0, (2, 5, arm.nv))
    force, moment = rng.normal(0.0, 5.0, (2, 5, 3))
    frame = FrameKinematics(arm, link)
    torque = frame.joint_torques(q, force, moment, local=axes == "link")
    model, data = arm.model, arm.model.createData()
    index = model.getFrameId(link, pin.FrameType.BODY)
    for k in range(5):
        pin.forwardKinematics(model, data, q[k], v[k])
        pin.updateFramePlacements(model, data)
        kind = pin.LOCAL if axes == "link" else pin.LOCAL_WORLD_ALIGNED
        twist = pin.getFrameVelocity(model, data, index, kind)
        assert torque[k] @ v[k] == pytest.approx(force[k] @ twist.linear + moment[k] @ twist.angular, rel=1e-9)
    np.testing.assert_allclose(frame.poses(q), arm.link_poses(q)[:, arm.link_names.index(link)], atol=1e-13)


@pytest.mark.parametrize("axes", ["base", "link"])
def test_a_push_at_a_link_is_felt_as_pinocchio_says(axes):
    arm = load_arm("ur5")
    q = np.array([[0.3, -1.0, 1.2, 0.4, 0.8, 0.2]])
    wrench = np.array([[10.0, -5.0, 3.0], [0.0, 1.0, 0.0]])
    link = arm.link_names[-1]
    push = Disturbance(profile="step", link=link, axes=axes, force=wrench[0], moment=wrench[1])
    plant = Plant(arm, disturbances=[push], friction=Friction(), substeps=1)
    motion = plant.begin(q, 0.0 * q, 1e-6)
    motion.advance()
    jacobian = FrameKinematics(arm, push.link).jacobians(q)[0]
    if axes == "link":
        wrench = wrench @ arm.link_poses(q)[0, arm.link_names.index(link), :3, :3].T
    expected = np.linalg.solve(arm.mass_matrix(q[0]), jacobian.T @ wrench.ravel())
    np.testing.assert_allclose(motion.v[0] / 1e-6, expected, rtol=1e-4, atol=1e-4)


# Payload


def test_what_is_picked_up_is_felt_from_that_tick_on_and_put_down_again(arm):
    changes = [PayloadChange(time=0.4, payload=None), PayloadChange(time=0.2, payload=3.0)]
    result = run(arm, duration=0.6, torque=6.0, payload_changes=changes)
    t = result.time
    speed = 6.0 / 2.0 * np.minimum(t, 0.2) + 6.0 / 5.0 * np.clip(t - 0.2, 0, 0.2) + 6.0 / 2.0 * np.maximum(t - 0.4, 0)
    np.testing.assert_allclose(result.v[0, :, 0], speed, rtol=1e-11, atol=1e-13)


def test_an_arm_that_carries_already_carries_the_new_payload_instead():
    arm = load_arm("ur5", payload=4.0)
    plant = Plant(arm, payload_changes=[PayloadChange(time=0.1, payload={"mass": 1.0, "com": [0, 0, 0.1]})])
    (after,) = plant.arms_at(0.1, L)
    assert plant.arms_at(0.099, L)[0].payload.mass == 4.0
    assert after.payload.mass == 1.0
    total = [sum(body.mass for body in list(item.model.inertias)[1:]) for item in (arm, after)]
    assert total[0] - total[1] == pytest.approx(3.0)


# Scatter


@st.composite
def scattered(draw):
    seed, name = draw(st.integers(0, 2**32 - 1)), draw(st.sampled_from(["ur5", "two_link", "kinova"]))
    return seed, name, draw(st.floats(0.0, 1.5)), draw(st.floats(0.0, 0.2)), draw(st.floats(0.0, 1.5))


@settings(max_examples=25, deadline=None)
@given(scattered())
def test_every_scattered_arm_is_a_possible_one(case):
    seed, name, mass, com, inertia = case
    arm = load_arm(name)
    (varied,) = Spread(mass=mass, com=com, inertia=inertia).arms([arm], seed, [0])
    for body in list(varied.model.inertias)[1:]:
        assert body.mass > 0.0
        assert inertia_problem(body.mass, body.inertia) == ""
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (3, arm.nv))
    assert np.linalg.eigvalsh(varied.mass_matrix(q)).min() > 0.0


def test_scatter_has_its_size_and_nothing_else_changes():
    arm = load_arm("ur5", payload=2.0, armature=0.1)
    arms = Spread(mass=0.1, com=0.01).arms([arm], 3, range(60))
    bare = arm.replace(payload=None)
    factor = np.array(
        [
            [v.replace(payload=None).model.inertias[i + 1].mass / bare.model.inertias[i + 1].mass for i in range(6)]
            for v in arms
        ]
    )
    assert np.log(factor).std() == pytest.approx(0.1, rel=0.1)
    shift = np.array([v.replace(payload=None).model.inertias[2].lever - bare.model.inertias[2].lever for v in arms])
    assert shift.std() == pytest.approx(0.01, rel=0.2)
    assert all(v.payload.mass == 2.0 and np.all(v.armature == 0.1) for v in arms)
    np.testing.assert_array_equal(arms[0].tree.mass[:5], [body.mass for body in list(arms[0].model.inertias)[1:6]])


def test_a_link_of_twice_the_mass_and_the_same_form_has_twice_the_inertia():
    arm = load_arm("ur5")
    heavy = vary_links(arm, np.full(arm.nv, 2.0), np.zeros((arm.nv, 3)), np.ones((arm.nv, 3)))
    q = np.random.default_rng(0).uniform(-2, 2, (4, arm.nv))
    rotors = np.diag(np.broadcast_to(arm.armature, arm.nv))
    np.testing.assert_allclose(
        heavy.mass_matrix(q) - rotors, 2.0 * (arm.mass_matrix(q) - rotors), rtol=1e-11, atol=1e-13
    )
    for before, after in zip(list(arm.model.inertias)[1:], list(heavy.model.inertias)[1:], strict=True):
        np.testing.assert_allclose(after.inertia, 2.0 * before.inertia, rtol=1e-12, atol=1e-15)


def test_a_link_stretched_along_an_axis_is_as_long_there_as_asked():
    arm = load_arm("ur5")
    stretch = np.array([1.0, 3.0, 1.0])
    longer = vary_links(arm, np.ones(arm.nv), np.zeros((arm.nv, 3)), np.tile(stretch, (arm.nv, 1)))
    for before, after in zip(list(arm.model.inertias)[1:], list(longer.model.inertias)[1:], strict=True):
        np.testing.assert_allclose(after.lever, stretch * before.lever, rtol=1e-12, atol=1e-15)
        # Second moments ∫ r_i r_j dm about the centre grow with both their axes.
        moments = [0.5 * np.trace(each.inertia) * np.eye(3) - each.inertia for each in (before, after)]
        np.testing.assert_allclose(moments[1], np.outer(stretch, stretch) * moments[0], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("com", [0.02, 0.2])
def test_the_ends_of_the_scatter_draw_centres_straight_in_or_out_and_in_no_further_than_to_the_origin(com):
    arm = load_arm("ur5")
    centre = np.array([arm.model.inertias[i + 1].lever for i in range(arm.nv)])
    far = np.linalg.norm(centre, axis=1, keepdims=True)
    outward = np.divide(centre, far, out=np.zeros_like(centre), where=far > 0.0)
    assert (far.max() > 2.0 * com) == (com == 0.02)
    for end, sign in zip(Spread(com=com, inertia=0.1).ends(arm), (-1.0, 1.0), strict=True):
        size = np.exp(0.2 * sign)  # two standard deviations
        expected = size * centre + np.maximum(2.0 * com * sign, -size * far) * outward
        levers = np.array([end.model.inertias[i + 1].lever for i in range(arm.nv)])
        np.testing.assert_allclose(levers, expected, atol=1e-12)


def test_without_scatter_a_varied_arm_is_the_arm():
    arm = load_arm("kinova", payload=1.0)
    same = vary_links(arm, np.ones(arm.nv), np.zeros((arm.nv, 3)), np.ones((arm.nv, 3)))
    q = np.random.default_rng(0).uniform(-2, 2, (4, arm.nv))
    np.testing.assert_allclose(same.mass_matrix(q), arm.mass_matrix(q), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(same.bias(q, q), arm.bias(q, q), rtol=1e-10, atol=1e-12)


def test_a_varied_arm_survives_its_way_to_another_process_and_a_change_of_payload():
    arm = load_arm("ur5")
    (varied,) = Spread(mass=0.2, inertia=0.2).arms([arm], 3, [5])
    q = np.ones((1, 6))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(varied)).mass_matrix(q), varied.mass_matrix(q))
    loaded = varied.replace(payload=2.0)
    added = loaded.mass_matrix(q) - varied.mass_matrix(q)
    np.testing.assert_allclose(added, arm.replace(payload=2.0).mass_matrix(q) - arm.mass_matrix(q), atol=1e-12)


def test_a_trial_scatters_the_same_in_any_batch():
    plant = Plant(
        load_arm("two_link"), spread=Spread(mass=0.2, com=0.01, friction=0.3), friction=Friction(0.5, 0.1), seed=9
    )

    def play(trials):
        law = OpenLoop(lambda t: np.array([1.0, -0.5]) * np.sin(9 * t), L)
        return rollout(plant, law, Still(np.zeros(2)), 0.2, batch=len(trials), trials=trials)

    together = play(range(4))
    for trials in ([3], [2, 1]):
        part = play(trials)
        np.testing.assert_array_equal(part.q, together.q[trials])
        np.testing.assert_array_equal(part.friction_torque, together.friction_torque[trials])
    assert np.ptp(together.q[:, -1, 0]) > 1e-4


# End stops


def test_joints_without_limits_have_no_stops_and_ask_for_no_short_steps():
    arm = load_arm("two_link")
    assert not np.isfinite([arm.lower, arm.upper]).any()
    law = OpenLoop(lambda t: np.array([3.0, 1.0]), L)
    with_stops, without = (
        rollout(Plant(arm, end_stops=stops), law, Still(np.zeros(2)), 0.1) for stops in (EndStops(stiffness=1e8), None)
    )
    np.testing.assert_array_equal(with_stops.q, without.q)


def test_a_mass_that_meets_a_stop_without_damping_comes_back_as_fast(arm):
    stops = EndStops(stiffness=2e4, damping=0.0)
    result = run(arm, v0=2.0, q0=999.5, end_stops=stops, substeps=8, error_bound=1e6)
    assert result.q.max() == pytest.approx(1000.0 + 2.0 * np.sqrt(MASS / 2e4), rel=1e-3)
    assert result.v[0, -1, 0] == pytest.approx(-2.0, rel=1e-4)


def test_damped_stops_take_energy_and_never_pull(arm):
    result = run(arm, v0=2.0, q0=999.5, end_stops=EndStops(stiffness=2e4, damping=0.3), substeps=8, error_bound=1e6)
    v, past = result.v[0, :, 0], result.q[0, :, 0] > 1000.0
    assert -2.0 < v[-1] < -0.5
    assert np.all(np.diff(v)[past[:-1] & past[1:]] <= 1e-12)


def test_an_arm_falls_onto_its_stops_and_lies_there():
    arm = load_arm("ur5", lock={"wrist_1_joint": 0.0, "wrist_2_joint": 0.0, "wrist_3_joint": 0.0})
    low = arm.lower[1]
    plant = Plant(arm, end_stops=EndStops(stiffness=3e4, damping=0.5), friction=Friction(0.0, 20.0), substeps=4)
    law = OpenLoop(lambda t: np.array([0.0, -60.0, 0.0]), L)
    result = rollout(plant, law, Still(np.array([0.0, low + 0.05, 0.0])), 2.0)
    assert result.q[0, :, 1].min() > low - 0.1
    assert result.q[0, -1, 1] < low
    free = rollout(Plant(arm, friction=Friction(0.0, 20.0)), law, Still(np.array([0.0, low + 0.05, 0.0])), 2.0)
    assert free.q[0, -1, 1] < low - 0.2


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"profile": "step"}, "either torque"),
        ({"profile": "step", "torque": 1.0, "link": "x"}, "either torque"),
        ({"profile": "pulse", "torque": 1.0}, "duration"),
        ({"profile": "sine", "torque": 1.0}, "frequency"),
        ({"profile": "step", "torque": 1.0, "duration": 2.0}, "a pulse ends"),
        ({"profile": "wave", "torque": 1.0}, "one of"),
        ({"profile": "step", "link": "x", "force": [1.0, 2.0]}, "3 numbers"),
    ],
)
def test_a_disturbance_that_cannot_be_is_refused(options, said):
    with pytest.raises(ParameterError, match=said):
        Disturbance(**options)


def test_a_world_that_does_not_fit_the_arm_is_refused(arm):
    with pytest.raises(ParameterError, match=r"disturbances.link: no link 'hand'"):
        Plant(arm, disturbances=[Disturbance(profile="step", link="hand", force=[1.0, 0.0, 0.0])])
    with pytest.raises(ParameterError, match=r"disturbances.torque: 2 values"):
        Plant(arm, disturbances=[Disturbance(profile="step", torque=[1.0, 2.0])])
    with pytest.raises(ParameterError, match=r"at least \d+ substeps"):
        run(arm, end_stops=EndStops(stiffness=1e8))


def test_as_many_substeps_as_are_named_resolve_the_stops_and_one_less_does_not(arm):
    with pytest.raises(ParameterError) as refused:
        run(arm, end_stops=EndStops(stiffness=1e8))
    least = int(re.search(r"at least (\d+) substeps", str(refused.value))[1])
    start = np.zeros((1, arm.nv))
    Plant(arm, end_stops=EndStops(stiffness=1e8), substeps=least).begin(start, start, 1e-3)
    with pytest.raises(ParameterError, match=f"at least {least} substeps"):
        Plant(arm, end_stops=EndStops(stiffness=1e8), substeps=least - 1).begin(start, start, 1e-3)


def test_arms_under_way_are_told_apart_by_when_they_begin(arm):
    changes = [PayloadChange(time=0.5, payload=1.0), PayloadChange(time=0.8)]
    found = moving_arms(Plant(arm, payload_changes=changes), 1e-3, 1.0)
    assert [each.when for each in found] == ["until 0.5 s", "from 0.5 to 0.8 s", "from 0.8 s on"]
    assert [each.words for each in found] == [
        "until 0.5 s, carrying nothing",
        "from 0.5 to 0.8 s",
        "from 0.8 s on, carrying nothing",
    ]
    (always,) = moving_arms(Plant(arm), 1e-3, 1.0)
    assert (always.when, always.words) == ("", "")


def test_nobody_changes_the_torque_limits_under_a_plant(arm):
    given = np.full(arm.nv, 30.0)
    plant = Plant(arm, effort_limit=given)
    given[0] = 1.0
    assert plant.effort_limit[0] == 30.0
    with pytest.raises(ValueError, match="read-only"):
        plant.effort_limit[0] = 1.0


ALIKE = [
    *(EndStops, Drive, Sensor),
    lambda: Disturbance(profile="sine", torque=1.0, frequency=2.0),
    lambda: PayloadChange(time=0.1, payload=1.0),
]


@pytest.mark.parametrize("made", ALIKE)
def test_parameters_of_a_plant_are_one_object_each_however_alike(made):
    # They hold arrays, of which `==` says no yes or no.
    one, other = made(), made()
    assert len({one, other, one}) == 2
    assert one != other


def test_stops_are_damped_where_nobody_says_otherwise():
    assert float(EndStops().damping) == 0.5


def test_a_varied_arm_shows_itself_as_arms_do_and_not_by_its_arrays():
    arm = load_arm("two_link")
    (varied,) = Spread(mass=0.1).arms([arm], 0, [0])
    assert "array" not in repr(varied)
    assert len(repr(varied)) < 500


@pytest.mark.parametrize("engine", ["compiled", "pinocchio"])
@pytest.mark.parametrize("viscous", [10.0, 1e5])
def test_viscous_friction_is_that_of_the_velocity_after_the_step_so_that_none_overshoots(tmp_path, viscous, engine):
    arm = slider(tmp_path, 2.0)
    plant = Plant(
        arm,
        friction=Friction(0.0, viscous),
        substeps=1,
        integrator="semi_implicit",
        start="relaxed",
        engine=engine,
    )
    run = rollout(plant, OpenLoop(lambda t: 0.0, 1e-3), Still(np.zeros(1)), 0.005, v0=[1.0])
    np.testing.assert_allclose(run.v[0, :, 0], (1.0 + 1e-3 * viscous / 2.0) ** -np.arange(6.0), rtol=1e-9, atol=1e-14)


def test_stops_store_the_energy_of_springs_on_either_side():
    stops = StopForces(EndStops(stiffness=200.0), np.array([-2.0, -np.inf]), np.array([1.0, 3.0]))
    energy = stops.energy(np.array([[-2.5, 0.0], [0.0, -9.0], [1.5, 3.5], [-1.0, 2.0]]))
    np.testing.assert_allclose(energy, [25.0, 0.0, 50.0, 0.0])


def test_a_stop_may_be_as_soft_as_a_feather():
    stops = StopForces(EndStops(stiffness=0.5, damping=0.0), np.array([-2.0]), np.array([1.0]))
    np.testing.assert_allclose(stops.torque(np.array([[1.2]]), np.array([[3.0]])), [[-0.1]])
    np.testing.assert_allclose(stops.torque(np.array([[-2.2]]), np.array([[3.0]])), [[0.1]])


def test_a_drive_without_a_rotor_leaves_the_arm_as_it_is(arm):
    assert Plant(arm, drive=Drive()).arms[0] is arm


@pytest.mark.parametrize("what", ["mass", "com", "inertia", "friction"])
def test_a_scatter_beyond_all_arms_is_refused_by_name(what: str) -> None:
    """A standard deviation of 1 is a factor of e already; one of 1e8 is of no number."""
    with pytest.raises(ParameterError, match=what):
        Spread(**{what: 1e8})


@pytest.mark.parametrize(("what", "most"), [("mass", 2.0), ("com", 10.0), ("inertia", 2.0), ("friction", 2.0)])
def test_a_scatter_is_a_size_up_to_a_factor_of_e_squared_or_ten_metres(what: str, most: float) -> None:
    assert getattr(Spread(**{what: most}), what) == most
    for beyond in (-0.1, 1.01 * most):
        with pytest.raises(ParameterError, match=what):
            Spread(**{what: beyond})
