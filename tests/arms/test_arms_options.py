"""Payload, armature, locks and mounting: what an option does is what the same change of the URDF would do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, trees, two_joints, write
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from asmc_pin.arms import Arm, Payload, load_arm
from asmc_pin.errors import ArmError, ParameterError


def assert_same_dynamics(one: Arm, other: Arm) -> None:
    q, v = np.random.default_rng(11).uniform(-2.0, 2.0, (2, 5, one.nv))
    for a, b in ((one.mass_matrix(q), other.mass_matrix(q)), (one.bias(q, v), other.bias(q, v))):
        assert a == pytest.approx(b, abs=1e-12 * max(1.0, np.abs(b).max()))


# --- payload


def test_payload_equals_a_link_welded_on(tmp_path: Path) -> None:
    inertia = np.array([[0.02, 0.003, 0.001], [0.003, 0.03, -0.002], [0.001, -0.002, 0.025]])
    load = Payload(1.7, (0.1, -0.2, 0.05), (0.02, 0.003, 0.001, 0.03, -0.002, 0.025), "upper")
    body = inertial(1.7, "0.1 -0.2 0.05", inertia)
    welded = two_joints().replace(
        "</robot>", link("load", body) + joint("weld", "upper", "load", "fixed", xyz="0 0 0") + "</robot>"
    )
    assert_same_dynamics(
        load_arm(write(tmp_path, two_joints()), payload=load), load_arm(write(tmp_path, welded, "welded.urdf"))
    )


def test_bare_mass_is_a_point_at_the_last_moving_links_frame() -> None:
    arm = load_arm("ur5", payload=2.0)
    assert arm.payload == Payload(2.0, link="wrist_3_link")
    q = np.linspace(-0.5, 0.5, 6)
    lifted = arm.gravity(q) - load_arm("ur5").gravity(q)
    # The torque of a weight is the gradient of its height times m g.
    step, wrist = 1e-6, arm.link_names.index("wrist_3_link")
    height = [
        (arm.link_poses(q + step * e)[wrist, 2, 3] - arm.link_poses(q - step * e)[wrist, 2, 3]) / (2.0 * step)
        for e in np.eye(6)
    ]
    assert lifted == pytest.approx(2.0 * 9.81 * np.array(height), abs=1e-7)


def test_payload_may_sit_on_a_link_behind_a_fixed_joint() -> None:
    flange = load_arm("panda", payload={"mass": 1.0, "link": "panda_hand_tcp"})
    wrist = load_arm("panda", payload={"mass": 1.0, "com": (0.0, 0.0, 0.2104), "link": "panda_link7"})
    assert_same_dynamics(flange, wrist)


@pytest.mark.parametrize(
    ("payload", "message"),
    [
        (-1.0, r"payload: its mass is -1 kg"),
        (float("nan"), r"payload.mass: nan given, one finite number expected"),
        ("heavy", r"payload.mass: 'heavy' given, numbers expected"),
        ({"com": (0, 0, 1)}, r"payload.mass: missing"),
        ({"mass": 1.0, "centre": (0, 0, 1)}, r"payload.centre: unknown; a payload has mass, com, inertia, link"),
        ({"mass": 1.0, "com": (0, 1)}, r"payload.com: \(0, 1\) given, 3 finite numbers expected"),
        ({"mass": 1.0, "inertia": (1, 0, 0, 1, 0, 3)}, r"payload: its inertia breaks the triangle inequality"),
        ({"mass": 1.0, "inertia": (1, 2, 0, 1, 0, 1)}, r"payload: its inertia is not positive semidefinite"),
        ({"mass": 0.0, "inertia": (1, 0, 0, 1, 0, 1)}, r"payload: it has a rotational inertia but no mass"),
        ({"mass": 1.0, "link": "wrist_3"}, r"payload.link: no link 'wrist_3' in .*did you mean 'wrist_3_link'"),
        ({"mass": 1.0, "link": "base_link"}, r"payload.link: link 'base_link' does not move"),
    ],
)
def test_impossible_payload_is_refused(payload: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        load_arm("ur5", payload=payload)


def test_mass_at_a_link_is_a_point_at_its_frame() -> None:
    arm = load_arm("ur5", payload="2@tool0")
    assert arm.payload == Payload(2.0, link="tool0")
    assert_same_dynamics(arm, load_arm("ur5", payload={"mass": 2.0, "link": "tool0"}))
    faults = {"two@tool0": "'two' given, a number expected, kg: 2@tool0", "2@tool": "did you mean 'tool0'"}
    for text, message in faults.items():
        with pytest.raises(ParameterError, match=message):
            load_arm("ur5", payload=text)


@pytest.mark.parametrize(
    ("payload", "says"),
    [
        ({"mass": 2.0}, ["a point on the axis of joints 'wrist_2_joint', 'wrist_3_joint', which it does not load"]),
        ({"mass": 2.0, "com": (0.0, 1e-8, 0.0)}, ["a point on the axis of joints 'wrist_2_joint', 'wrist_3_joint'"]),
        ({"mass": 2.0, "com": (0.0, 0.1, 0.0)}, ["a point on the axis of joint 'wrist_3_joint'"]),
        ({"mass": 2.0, "com": (0.01, 0.0, 0.0)}, []),
        ({"mass": 2.0, "inertia": (1e-3, 0.0, 0.0, 1e-3, 0.0, 1e-3)}, []),
        (
            {"mass": 2.0, "link": "wrist_1_link", "com": (0.1, 0.1, 0.1)},
            ["on link 'wrist_1_link' and does not load joints 'wrist_2_joint', 'wrist_3_joint' beyond it"],
        ),
        ({"mass": 0.0}, []),
    ],
)
def test_joints_that_a_payload_cannot_load_are_named(payload: dict[str, Any], says: list[str]) -> None:
    arm = load_arm("ur5", payload=payload)
    told = [line for line in arm.warnings if "payload" in line]
    assert len(told) == len(says)
    assert all(part in line for part, line in zip(says, told, strict=True))
    # What is said is so: the joint's own inertia does not change.
    bare, q = load_arm("ur5"), np.linspace(-1.0, 1.0, 6)
    added = np.diag(arm.mass_matrix(q) - bare.mass_matrix(q))
    named = [any(f"'{name}'" in line for line in told) for name in arm.joint_names]
    if payload["mass"]:
        assert (added < 1e-11).tolist() == named


def test_arm_with_two_ends_asks_which_one_carries(tmp_path: Path) -> None:
    text = two_joints().replace("</robot>", link("left", inertial()) + joint("fork", "upper", "left") + "</robot>")
    path = write(tmp_path, text)
    with pytest.raises(ParameterError, match=r"payload.link: the arm has 2 ends \(lower, left\)"):
        load_arm(path, payload=1.0)
    assert load_arm(path, payload={"mass": 1.0, "link": "left"}).payload.link == "left"


# --- armature


def test_armature_sets_what_the_entry_has_and_a_mapping_leaves_the_rest() -> None:
    assert load_arm("rv4fd", armature=0.1).armature.tolist() == [0.1, 0.1]
    assert load_arm("rv4fd", armature=[0.1, 0.2]).armature.tolist() == [0.1, 0.2]
    assert load_arm("rv4fd", armature={"joint_2": 0.5}).armature.tolist() == [0.24, 0.5]


def test_armature_adds_to_the_diagonal_of_mass_only() -> None:
    bare, geared = load_arm("ur5"), load_arm("ur5", armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
    q = np.linspace(-1.0, 1.0, 6)
    assert geared.mass_matrix(q) - bare.mass_matrix(q) == pytest.approx(np.diag(geared.armature), abs=1e-15)
    assert np.array_equal(geared.bias(q, q), bare.bias(q, q))


@pytest.mark.parametrize(
    ("armature", "message"),
    [
        ([0.1, 0.2], r"armature: 2 values given, 1 or 6 expected \(shoulder_pan_joint"),
        (-0.1, r"armature: .*zero or more expected"),
        (float("nan"), r"armature: .*finite values"),
        ("much", r"armature: 'much' given, numbers in kg·m² or 'published' expected"),
        ({"elbow": 0.1}, r"armature: no moving joint 'elbow'; did you mean 'elbow_joint'"),
        ({"elbow_joint": [1, 2]}, r"armature.elbow_joint: \[1, 2\] given, one number expected"),
    ],
)
def test_impossible_armature_is_refused(armature: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        load_arm("ur5", armature=armature)


# --- locks


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=trees(5), data=st.data())
def test_locked_joint_is_a_constraint_on_the_whole_arm(text: str, data: st.DataObject, tmp_path: Path) -> None:
    whole = load_arm(write(tmp_path, text))
    names = data.draw(st.lists(st.sampled_from(whole.joint_names), unique=True, max_size=whole.nv - 1))
    lock = {name: data.draw(st.floats(-2.0, 2.0)) for name in names}
    part = load_arm(whole.source, lock=lock)
    free = [whole.joint_names.index(name) for name in part.joint_names]
    q = np.array([lock.get(name, 0.3 + 0.1 * k) for k, name in enumerate(whole.joint_names)])
    v = np.array([0.0 if name in lock else 1.0 - 0.3 * k for k, name in enumerate(whole.joint_names)])
    mass, bias = whole.mass_matrix(q)[np.ix_(free, free)], whole.bias(q, v)[free]
    assert part.mass_matrix(q[free]) == pytest.approx(mass, abs=1e-11 * max(1.0, np.abs(mass).max()))
    assert part.bias(q[free], v[free]) == pytest.approx(bias, abs=1e-11 * max(1.0, np.abs(bias).max()))
    poses = dict(zip(whole.link_names, whole.link_poses(q), strict=True))
    assert set(part.link_names) == set(poses)
    for name, pose in zip(part.link_names, part.link_poses(q[free]), strict=True):
        assert pose == pytest.approx(poses[name], abs=1e-12)


def test_lock_drops_the_joint_and_keeps_its_links() -> None:
    arm = load_arm("ur5", lock={"elbow_joint": 0.7}, armature=0.1)
    assert "elbow_joint" not in arm.joint_names
    assert dict(arm.locked) == {"elbow_joint": 0.7}
    assert (arm.nv, arm.effort_limit.size, arm.armature.size, arm.tree.nv) == (5, 5, 5, 5)
    assert arm.link_names == load_arm("ur5").link_names


def test_joint_and_link_may_share_a_name(tmp_path: Path) -> None:
    # so100 has a joint 'gripper' that moves the link behind a link 'gripper'.
    text = two_joints().replace('joint name="elbow"', 'joint name="lower"')
    arm = load_arm(write(tmp_path, text), lock={"lower": 0.4})
    assert arm.joint_names == ("shoulder",)
    assert arm.link_names == ("base", "upper", "lower")


def test_lock_adds_to_the_grippers_and_free_takes_a_default_away() -> None:
    assert dict(load_arm("z1", lock={"joint6": 0.1}).locked) == {"jointGripper": 0.0, "joint6": 0.1}
    for free in (None, "free"):
        assert load_arm("z1", lock={"jointGripper": free}).joint_names[-1] == "jointGripper"


def test_mimicking_finger_follows_its_locked_twin() -> None:
    arm = load_arm("panda", lock={"panda_finger_joint1": 0.03})
    assert dict(arm.locked) == {"panda_finger_joint1": 0.03, "panda_finger_joint2": 0.03}
    fingers = [arm.link_names.index(f"panda_{side}finger") for side in ("left", "right")]
    left, right = arm.link_poses(np.zeros(7))[fingers, :3, 3]
    assert np.linalg.norm(left - right) == pytest.approx(0.06)


def test_freed_finger_takes_its_twin_along_until_that_is_freed_too() -> None:
    coupled = load_arm("panda", lock={"panda_finger_joint1": "free"})
    assert coupled.joint_names[-1] == "panda_finger_joint1"
    assert list(coupled.mimics) == ["panda_finger_joint2"]
    arm = load_arm("panda", lock={"panda_finger_joint1": "free", "panda_finger_joint2": "free"})
    assert arm.joint_kinds[-2:] == ("prismatic", "prismatic")
    assert any("motor of its own" in warning for warning in arm.warnings)


@pytest.mark.parametrize(
    ("lock", "message"),
    [
        ({"elbow": 0.0}, r"lock: no joint 'elbow' in ur5_robot.urdf; did you mean 'elbow_joint'"),
        ({"ee_fixed_joint": 0.0}, r"lock: joint 'ee_fixed_joint' is fixed in ur5_robot.urdf already"),
        ({"elbow_joint": float("inf")}, r"lock: joint 'elbow_joint': inf given, a number in rad"),
        ({"elbow_joint": "bent"}, r"lock: joint 'elbow_joint': 'bent' given"),
    ],
)
def test_impossible_lock_is_refused(lock: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        load_arm("ur5", lock=lock)


def test_arm_locked_whole_is_refused() -> None:
    with pytest.raises(ArmError, match="nothing movable, every joint is locked"):
        load_arm("two_link", lock={"joint_1": 0.0, "joint_2": 0.0})


def test_lock_outside_the_limits_is_said() -> None:
    assert any("outside its limits" in warning for warning in load_arm("ur5", lock={"elbow_joint": 4.0}).warnings)


# --- mounting


def test_ceiling_turns_the_sign_of_gravity() -> None:
    floor, ceiling = load_arm("ur5"), load_arm("ur5", gravity=(0.0, 0.0, 9.81))
    q = np.linspace(-1.0, 1.0, 6)
    assert ceiling.gravity(q) == pytest.approx(-floor.gravity(q), abs=1e-13)
    assert np.array_equal(ceiling.mass_matrix(q), floor.mass_matrix(q))
    assert np.all(load_arm("ur5", gravity=(0.0, 0.0, 0.0)).gravity(q) == 0.0)


def test_wall_equals_a_base_turned_in_the_urdf(tmp_path: Path) -> None:
    # +90° about y lays the arm's z axis along the world's x: gravity, seen from the base, is then +x.
    turned = two_joints().replace(
        link("base"),
        link("world") + link("base") + joint("wall", "world", "base", "fixed", xyz="0 0 0", rpy=f"0 {np.pi / 2!r} 0"),
    )
    wall = load_arm(write(tmp_path, two_joints()), gravity=(9.81, 0.0, 0.0))
    assert_same_dynamics(wall, load_arm(write(tmp_path, turned, "turned.urdf")))


@pytest.mark.parametrize("gravity", [9.81, (0.0, 9.81), (0.0, 0.0, float("nan")), "down"])
def test_impossible_gravity_is_refused(gravity: Any) -> None:
    with pytest.raises(ParameterError, match=r"gravity: .*expected"):
        load_arm("ur5", gravity=gravity)


# --- variants


def test_replace_keeps_what_is_not_named_and_none_takes_away() -> None:
    arm = load_arm("rv4fd", payload=1.0, armature=0.5, gravity=(0.0, 0.0, 9.81))
    other = arm.replace(payload=3.0)
    assert other.payload == Payload(3.0, link="forearm")
    assert other.armature.tolist() == [0.5, 0.5]
    assert other.gravity_vector.tolist() == [0.0, 0.0, 9.81]
    assert arm.payload.mass == 1.0
    bare = arm.replace(payload=None, armature=None, gravity=None)
    assert bare.payload is None
    assert bare.armature.tolist() == [0.24, 0.24]
    assert_same_dynamics(bare, load_arm("rv4fd"))


def test_replaced_lock_leaves_payload_and_armature_where_they_were() -> None:
    arm = load_arm("ur5", payload=2.0, armature=[0.6, 0.5, 0.4, 0.3, 0.2, 0.1]).replace(lock={"wrist_3_joint": 0.2})
    assert arm.payload.link == "wrist_3_link"
    assert arm.armature.tolist() == [0.6, 0.5, 0.4, 0.3, 0.2]


def test_changing_the_arrays_given_does_not_change_the_arm() -> None:
    armature, lock = np.full(2, 0.5), {"joint_2": 0.3}
    one, two = load_arm("rv4fd", armature=armature), load_arm("rv4fd", lock=lock)
    armature[:], lock["joint_2"] = 9.0, 9.0
    assert one.replace(payload=1.0).armature.tolist() == [0.5, 0.5]
    assert dict(two.replace(payload=1.0).locked) == {"joint_2": 0.3}


# --- prismatic joints


def test_sliding_mass_has_its_mass_and_weight_as_inertia_and_gravity(tmp_path: Path) -> None:
    lift = joint("lift", "base", "cart", "prismatic", "0 0 2")
    arm = load_arm(write(tmp_path, robot(link("base"), link("cart", inertial(3.0)), lift)))
    assert arm.joint_kinds == ("prismatic",)
    assert arm.mass_matrix(np.array([0.4])) == pytest.approx(np.array([[3.0]]))
    assert arm.gravity(np.array([0.4])) == pytest.approx([3.0 * 9.81])
    assert arm.link_poses(np.array([0.4]))[1, :3, 3] == pytest.approx([0.1, 0.0, 0.7])
    assert any("prismatic: lift; m, m/s, N and kg" in warning for warning in arm.warnings)
    assert arm.box[0].tolist() == [-2.0]


def test_slide_without_limits_asks_for_its_box(tmp_path: Path) -> None:
    slide = joint("lift", "base", "cart", "prismatic", extra="")
    arm = load_arm(write(tmp_path, robot(link("base"), link("cart", inertial()), slide)))
    with pytest.raises(ArmError, match=r"joint 'lift' of arm slides .* --box lift=lo:hi"):
        _ = arm.box
