"""Joints that mimic others: their inertia, friction and limits are those of the joint that they follow."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from arm_urdf import LIMIT, inertial, joint, link, robot, write
from coupled_urdf import WIDE, coupled_tree, gripper, mimic, parallelogram

from asmc_pin.arms import load_arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.arms.urdf.urdf_reading import Mimic
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.rigid_body.mass_matrix import mass_matrices


def geared(extra: str, first: str = LIMIT) -> str:
    """A joint, and a second one beside it on the base; both axes upright."""
    return robot(
        link("base"),
        link("a", inertial(2.0, "0.1 0 0", np.diag([0.01, 0.01, 0.02]))),
        link("b", inertial(1.0, "0.2 0 0", np.diag([0.02, 0.02, 0.03]))),
        joint("master", "base", "a", extra=first),
        joint("slave", "base", "b", xyz="1 0 0", extra=extra),
    )


def test_a_geared_body_counts_with_the_square_of_the_ratio(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, geared(mimic("master", -3.0, 0.7))))
    assert arm.joint_names == ("master",)
    assert arm.mass_matrix([0.4])[0, 0] == pytest.approx(0.02 + 2.0 * 0.1**2 + 9.0 * (0.03 + 0.2**2), rel=1e-14)
    assert arm.mimics["slave"] == Mimic("master", -3.0, 0.7)


def test_what_a_parallelogram_keeps_from_turning_has_no_inertia_of_turning(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, parallelogram(0.4, 3.0, 2.0, 0.05)))
    q = np.linspace(-1.5, 1.5, 7)[:, None]
    assert arm.mass_matrix(q)[:, 0, 0] == pytest.approx(0.05 + (3.0 + 2.0) * 0.4**2, rel=1e-13)
    assert arm.gravity(q)[:, 0] == pytest.approx(-(3.0 + 2.0) * 0.4 * 9.81 * np.cos(q[:, 0]), abs=1e-12)
    assert arm.bias(q, 3.0 + q) == pytest.approx(arm.gravity(q), abs=1e-12)
    fore = arm.link_poses(q)[:, arm.link_names.index("fore")]
    assert fore[:, :3, :3] == pytest.approx(np.broadcast_to(np.eye(3), (7, 3, 3)), abs=1e-15)


@pytest.mark.parametrize("seed", range(6))
def test_projected_terms_equal_those_of_pinocchios_own_mimic_joint(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    # It builds no joint that mimics one further out or on another branch.
    text = coupled_tree(rng, joints=int(rng.integers(3, 8)), followers=2, serial=True)
    arm = load_arm(write(tmp_path, text))
    model = pin.buildModelFromXML(text, mimic=True)
    assert model.nv == arm.nv
    for q, v in rng.uniform(-1.5, 1.5, (4, 2, arm.nv)):
        upper = np.triu(pin.crba(model, model.createData(), q))  # which adds to what an earlier call left
        mass = upper + np.triu(upper, 1).T
        assert arm.mass_matrix(q) == pytest.approx(mass, abs=1e-12 * np.abs(mass).max())
        bias = pin.rnea(model, model.createData(), q, v, np.zeros(arm.nv))
        assert arm.bias(q, v) == pytest.approx(bias, abs=1e-12 * np.abs(bias).max())
        ours = arm.link_poses(q)[-1]
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        theirs = data.oMf[model.getFrameId(arm.link_names[-1])].homogeneous
        assert ours == pytest.approx(theirs, abs=1e-13)


@pytest.mark.parametrize("seed", range(6))
def test_terms_of_a_coupled_arm_belong_together(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    arm = load_arm(write(tmp_path, coupled_tree(rng, joints=7, followers=3, chained=True)), armature=0.2)
    q, v, torque = rng.uniform(-1.5, 1.5, (3, 5, arm.nv))
    mass = arm.mass_matrix(q)
    assert np.array_equal(mass, mass.swapaxes(1, 2))
    compiled = mass_matrices(arm.tree, q)
    assert np.array_equal(compiled, compiled.swapaxes(1, 2))
    assert compiled == pytest.approx(mass, abs=1e-12 * np.abs(mass).max())
    coriolis = arm.coriolis(q, v)
    assert np.einsum("bij,bj->bi", coriolis, v) + arm.gravity(q) == pytest.approx(arm.bias(q, v), abs=1e-10)
    step = 1e-6
    change = (arm.mass_matrix(q + step * v) - arm.mass_matrix(q - step * v)) / (2.0 * step)
    odd = change - 2.0 * coriolis
    assert odd + odd.swapaxes(1, 2) == pytest.approx(np.zeros_like(odd), abs=1e-6 * np.abs(mass).max())
    acceleration = arm.forward_dynamics(q, v, torque)
    assert np.einsum("bij,bj->bi", mass, acceleration) + arm.bias(q, v) == pytest.approx(torque, abs=1e-9)
    # Gravity is the gradient of the potential energy, by the heights of the bodies.
    joints = arm.tree.coupling.joints
    data = arm.model.createData()
    for i, unit in enumerate(np.eye(arm.nv)):
        ends = [pin.computePotentialEnergy(arm.model, data, joints(q[0] + s * step * unit)) for s in (1.0, -1.0)]
        assert arm.gravity(q[0])[i] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), abs=1e-5)


def test_jacobian_of_a_frame_counts_what_follows(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, coupled_tree(np.random.default_rng(8), joints=6, followers=3)))
    frame = FrameKinematics(arm, "l6")
    q, step = np.array([0.3, -0.4, 0.6]), 1e-6
    assert frame.poses(q) == pytest.approx(arm.link_poses(q)[arm.link_names.index("l6")], abs=1e-14)
    for i, unit in enumerate(np.eye(3)):
        ahead, behind = frame.poses(q + step * unit), frame.poses(q - step * unit)
        assert frame.jacobians(q)[:3, i] == pytest.approx((ahead - behind)[:3, 3] / (2.0 * step), abs=1e-7)


def test_a_follower_of_a_follower_follows_the_driven_joint(tmp_path: Path) -> None:
    text = (
        parallelogram().replace("</robot>", "")
        + link("tip", inertial())
        + joint("third", "fore", "tip", axis="0 0 1", extra=mimic("level", 0.5, 0.3))
        + "</robot>"
    )
    arm = load_arm(write(tmp_path, text))
    assert arm.joint_names == ("lift",)
    assert arm.mimics["third"] == Mimic("lift", -0.5, 0.3)
    # A freed joint leads: the ones that follow it still do.
    freed = load_arm(write(tmp_path, text), lock={"level": "free"})
    assert freed.joint_names == ("lift", "level")
    assert (freed.mimics["third"].joint, freed.mimics["third"].multiplier) == ("level", 0.5)
    assert dict(load_arm(write(tmp_path, text), lock={"level": 0.2}).locked) == {"level": 0.2, "third": 0.4}


def test_a_slide_may_follow_a_turning_joint(tmp_path: Path) -> None:
    text = gripper().replace('mimic joint="left_finger" multiplier="1.0"', 'mimic joint="roll" multiplier="0.01"')
    arm = load_arm(write(tmp_path, text.replace('lower="0" upper="0.04"', 'lower="-1" upper="1"')))
    assert arm.joint_names == ("lift", "roll", "left_finger")
    hand, right = arm.link_names.index("hand"), arm.link_names.index("right")
    poses = arm.link_poses([[0.0, 0.0, 0.0], [0.0, 1.5, 0.0]])
    apart = np.linalg.norm(poses[:, right, :3, 3] - poses[:, hand, :3, 3], axis=1)
    assert apart == pytest.approx([0.1, np.hypot(0.1, 0.015)], abs=1e-12)


def test_friction_and_rotors_of_a_follower_are_felt_through_its_ratio(tmp_path: Path) -> None:
    first, second = ('<dynamics damping="0.1" friction="0.5"/>', '<dynamics damping="0.2" friction="0.4"/>')
    text = geared(mimic("master", -3.0, before=WIDE + second), LIMIT + first)
    arm = load_arm(write(tmp_path, text), armature={"master": 0.01, "slave": 0.02})
    assert arm.friction == pytest.approx([0.5 + 3.0 * 0.4])
    assert arm.damping == pytest.approx([0.1 + 9.0 * 0.2])
    assert arm.armature == pytest.approx([0.01 + 9.0 * 0.02])
    bare = load_arm(write(tmp_path, text))
    assert arm.mass_matrix([0.0]) - bare.mass_matrix([0.0]) == pytest.approx(np.array([[0.19]]))
    # Set for all driven joints, it is the whole: a follower has none besides.
    assert load_arm(write(tmp_path, text), armature=0.3).armature == pytest.approx([0.3])
    assert arm.replace(lock={}).armature == pytest.approx(arm.armature)
    with pytest.raises(ParameterError, match=r"armature: no moving joint 'slve'"):
        load_arm(write(tmp_path, text), armature={"slve": 0.1})


def test_limits_of_a_follower_are_limits_of_its_master(tmp_path: Path) -> None:
    text = geared(mimic("master", -2.0, 0.5, '<limit lower="-1" upper="2" effort="7" velocity="4"/>'))
    arm = load_arm(write(tmp_path, text))
    assert (arm.lower, arm.upper) == (pytest.approx([-0.75]), pytest.approx([0.75]))
    assert arm.velocity_limit == pytest.approx([2.0])
    assert arm.effort_limit == pytest.approx([50.0])  # the motor is the master's
    assert any(
        "'slave' mimics 'master', and its limits -1 … 2 narrow those of 'master' to -0.75 … 0.75" in w
        for w in arm.warnings
    )
    # Zero to a turn, copied, for a joint that goes back: nobody means that.
    back = mimic("master", -1.0, 0.0, '<limit lower="0" upper="6.28"/>')
    copied = load_arm(write(tmp_path, geared(back, LIMIT.replace("-2", "0"))))
    assert (copied.lower, copied.upper) == (pytest.approx([0.0]), pytest.approx([2.0]))
    assert any("leave 'master' no range within 0 … 2: not regarded, mend them" in line for line in copied.warnings)


def test_a_turn_is_the_box_only_where_followers_come_back_too(tmp_path: Path) -> None:
    endless = '<limit effort="50" velocity="3"/>'
    twice = load_arm(write(tmp_path, geared(mimic("master", 2.0, before=endless), endless)))
    assert twice.box[1] == pytest.approx([np.pi])
    half = load_arm(write(tmp_path, geared(mimic("master", 0.5, before=endless), endless)))
    with pytest.raises(ArmError, match=r"joint 'master' of arm declares no limits.*--box master=lo:hi"):
        _ = half.box


def test_joints_in_a_ring_are_refused_until_one_leads(tmp_path: Path) -> None:
    text = geared(mimic("master"), LIMIT + '<mimic joint="slave"/>')
    with pytest.raises(ArmError, match=r"mimic each other in a ring, 'master' → 'slave' → 'master'.*free one by name"):
        load_arm(write(tmp_path, text))
    assert load_arm(write(tmp_path, text), lock={"master": "free"}).joint_names == ("master",)
    with pytest.raises(ArmError, match=r"ring, 'slave' → 'slave'"):
        load_arm(write(tmp_path, geared(mimic("slave"))))
    with pytest.raises(ArmError, match=r"ratios from 1e-06 to 1e\+06 are computed with"):
        load_arm(write(tmp_path, geared(mimic("master", 1e9))))


def test_what_follows_nothing_that_moves_is_locked(tmp_path: Path) -> None:
    for extra, value in ((mimic("master", 0.0, 0.3), 0.3), (mimic("weld", 2.0, 0.4), 0.4)):
        text = geared(extra).replace("</robot>", "")
        text += link("c") + joint("weld", "b", "c", "fixed", extra="") + "</robot>"
        arm = load_arm(write(tmp_path, text))
        assert dict(arm.locked) == {"slave": value}
        assert not any("slave" in warning for warning in arm.warnings)


def test_a_coupled_arm_travels_between_processes(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()), payload={"mass": 0.2, "link": "hand"})
    twin = pickle.loads(pickle.dumps(arm))
    assert np.array_equal(twin.mass_matrix([0.1, 0.2, 0.03]), arm.mass_matrix([0.1, 0.2, 0.03]))
    assert "mimics: right_finger = 1 · left_finger" in arm.lines()


def test_a_follower_may_move_nothing_where_its_master_moves_something(tmp_path: Path) -> None:
    text = geared(mimic("master")).replace(link("b", inertial(1.0, "0.2 0 0", np.diag([0.02, 0.02, 0.03]))), link("b"))
    text = text.replace("</robot>", link("c") + joint("more", "b", "c", extra=mimic("master", 2.0)) + "</robot>")
    arm = load_arm(write(tmp_path, text))
    assert arm.mass_matrix([0.3])[0, 0] == pytest.approx(0.04, rel=1e-13)
    assert mass_matrices(arm.tree, np.array([0.3]))[0, 0] == pytest.approx(0.04, rel=1e-13)
    with pytest.raises(ArmError, match="moves link 'b', which carries no inertia"):
        load_arm(write(tmp_path, text), lock={"slave": "free", "more": 0.0})


def test_only_where_joints_follow_are_their_values_others_than_the_coordinates(tmp_path: Path) -> None:
    assert load_arm(write(tmp_path, geared(mimic("master", -3.0, 0.7)))).tree.coupling.follows
    free = load_arm("two_link").tree.coupling
    assert not free.follows
    # Handed on as they are, down to the sign of a zero.
    assert np.signbit(free.joints(np.array([-0.0, 0.0]))).tolist() == [True, False]
