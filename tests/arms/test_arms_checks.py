"""The check of a URDF on loading: every fault is named in plain words, with its place and how to correct it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import LIMIT, inertial, joint, link, robot, two_joints, write

from asmc_pin.arms import load_arm
from asmc_pin.errors import ArmError

BASE, UPPER, LOWER = link("base"), link("upper", inertial(2.0)), link("lower", inertial())
SHOULDER, ELBOW = joint("shoulder", "base", "upper"), joint("elbow", "upper", "lower", axis="0 1 0")


def elbow(extra: str = LIMIT, **changes: str) -> str:
    return two_joints(second=joint("elbow", "upper", "lower", **{"axis": "0 1 0", **changes}, extra=extra))


def tip(mass: float = 1.0, diagonal: Sequence[float] = (0.01, 0.02, 0.015), **changes: str) -> str:
    return two_joints(tip=inertial(mass, inertia=np.diag(diagonal), **changes))


SKEWED = np.array([[0.01, 0.02, 0.0], [0.02, 0.01, 0.0], [0.0, 0.0, 0.01]])

# What is wrong, the URDF, and what the message must say: where, what, and the remedy.
FAULTS = {
    "malformed XML": ("<robot><link></robot>", ["line 1, column", "not well-formed XML", "Mend the file there"]),
    "empty file": ("", ["not well-formed XML", "no element found"]),
    "no link": ('<robot name="r"/>', ["<robot> holds no <link>"]),
    "other root": ("<html/>", ["the root element is <html>, a URDF has <robot>"]),
    "nothing movable": (
        robot(BASE, UPPER, joint("weld", "base", "upper", "fixed")),
        ["nothing movable", "needs a revolute, continuous or prismatic joint"],
    ),
    "nameless link": (robot(BASE, "<link/>"), ["a <link> in", "line 3", "has no name"]),
    "two links of one name": (
        robot(BASE, UPPER, UPPER, SHOULDER),
        ["2 links are named 'upper'", "lines 3, 4", "rename one"],
    ),
    "two joints of one name": (robot(BASE, UPPER, LOWER, SHOULDER, SHOULDER), ["2 joints are named 'shoulder'"]),
    "unknown parent": (
        robot(BASE, UPPER, joint("shoulder", "bas", "upper")),
        ["joint 'shoulder' in arm.urdf, line 4", "its parent link 'bas' does not exist", "did you mean 'base'?"],
    ),
    "unknown child": (
        robot(BASE, UPPER, joint("shoulder", "base", "uper")),
        ["its child link 'uper' does not exist", "'upper'"],
    ),
    "no parent": (
        two_joints(first='<joint name="shoulder" type="revolute"><child link="upper"/></joint>'),
        ["joint 'shoulder'", 'no <parent link="…"/>'],
    ),
    "unknown type": (elbow(kind="hinge"), ["joint 'elbow'", "its type is 'hinge'", "revolute, continuous, prismatic"]),
    "floating base": (
        robot(link("world"), BASE, UPPER, joint("free", "world", "base", "floating"), SHOULDER),
        ["joint 'free'", "a floating base", 'make the joint type="fixed"'],
    ),
    "planar joint": (elbow(kind="planar"), ["joint 'elbow'", "a planar joint", "two prismatic joints"]),
    "zero axis": (elbow(axis="0 0 0"), ["joint 'elbow'", "its axis is zero", "such as 0 0 1"]),
    "axis of two numbers": (elbow(axis="0 1"), ["joint 'elbow'", '<axis xyz="0 1">', "needs three numbers"]),
    "decimal comma": (elbow(xyz="0,1 0 0"), ["joint 'elbow'", '<origin xyz="0,1">', "is not a number"]),
    "NaN origin": (elbow(xyz="nan 0 0"), ["joint 'elbow'", '<origin xyz="nan">', "is not a finite number"]),
    "NaN mass": (tip(float("nan")), ["link 'lower' in arm.urdf, line 4", '<mass value="nan">', "not a finite number"]),
    "NaN inertia": (tip(diagonal=(0.01, float("nan"), 0.01)), ["link 'lower'", '<inertia iyy="nan">']),
    "NaN limit": (
        elbow('<limit lower="-1" upper="1" effort="nan" velocity="1"/>'),
        ["joint 'elbow'", '<limit effort="nan">'],
    ),
    "NaN friction": (elbow(LIMIT + '<dynamics friction="nan"/>'), ["joint 'elbow'", '<dynamics friction="nan">']),
    "negative friction": (
        elbow(LIMIT + '<dynamics friction="-1"/>'),
        ["joint 'elbow'", "its friction -1 is negative", "make it ≥ 0"],
    ),
    "limits swapped": (
        elbow('<limit lower="1" upper="-1" effort="1" velocity="1"/>'),
        ["joint 'elbow'", "its lower limit 1 is above its upper limit -1", "swap them"],
    ),
    "negative mass": (tip(-1.0), ["link 'lower' in arm.urdf, line 4", "its mass is -1 kg", "correct the sign"]),
    "mass zero": (tip(0.0, (0.0, 0.0, 0.0)), ["joint 'elbow'", "moves link 'lower', which carries no inertia"]),
    "mass zero with inertia": (tip(0.0), ["joint 'elbow'", "moves link 'lower'", "with a mass above zero"]),
    "moving link without inertia": (
        two_joints(tip=""),
        ["joint 'elbow' in arm.urdf, line 6", "moves link 'lower', which carries no inertia", "add <inertial>", "lock"],
    ),
    "moving links without inertia": (
        two_joints(tip="").replace("</robot>", link("hand") + joint("weld", "lower", "hand", "fixed") + "</robot>"),
        ["moves link 'lower', which carries no inertia, nor does anything fixed to it (hand)"],
    ),
    "mass missing": (
        two_joints(tip='<inertial><inertia ixx="1" iyy="1" izz="1"/></inertial>'),
        ["link 'lower'", "<inertial> has no <mass>"],
    ),
    "mass without value": (
        two_joints(tip='<inertial><mass/><inertia ixx="1" iyy="1" izz="1"/></inertial>'),
        ["link 'lower'", '<mass> lacks value="…"'],
    ),
    "inertia missing": (two_joints(tip='<inertial><mass value="1"/></inertial>'), ["<inertial> has no <inertia>"]),
    "negative inertia": (tip(diagonal=(-0.01, 0.02, 0.02)), ["link 'lower'", "not positive semidefinite", "-0.01"]),
    "products too large": (
        two_joints(tip=inertial(inertia=SKEWED)),
        ["link 'lower'", "not positive semidefinite", "about the centre of mass"],
    ),
    "triangle inequality": (
        tip(diagonal=(0.01, 0.02, 0.0301)),
        ["link 'lower'", "breaks the triangle inequality", "0.0301", "recompute it"],
    ),
    "closed loop": (
        robot(BASE, UPPER, LOWER, SHOULDER, ELBOW, joint("strut", "base", "lower")),
        ["joint 'strut'", "a closed loop", "link 'lower' already hangs on joint 'elbow'", "cut the loop"],
    ),
    "loop without base": (
        robot(UPPER, LOWER, ELBOW, joint("back", "lower", "upper")),
        ["a closed loop without a base", "cut it at one joint"],
    ),
    "loop beside the arm": (
        robot(
            BASE,
            UPPER,
            SHOULDER,
            link("a", inertial()),
            link("b", inertial()),
            joint("ab", "a", "b"),
            joint("ba", "b", "a"),
        ),
        ["a closed loop", "links a, b hang on each other", "not on the base 'base'"],
    ),
    "two bases": (robot(BASE, UPPER, LOWER, SHOULDER), ["2 links have no parent (base, lower)", "fixed joints"]),
    "mimic in a ring": (
        elbow(LIMIT + '<mimic joint="elbow" multiplier="2"/>'),
        ["joint 'elbow' in arm.urdf", "mimic each other in a ring, 'elbow' → 'elbow'", "--lock elbow=free"],
    ),
    "mimic of nothing": (
        elbow(LIMIT + '<mimic joint="sholder"/>'),
        ["joint 'elbow'", "mimics joint 'sholder', which does not exist", "did you mean 'shoulder'?"],
    ),
    "mimic without a joint": (elbow(LIMIT + "<mimic/>"), ["joint 'elbow'", "<mimic> names no joint"]),
    "nothing resists a joint": (
        two_joints(tip=inertial(com="0 0 0", inertia=np.zeros((3, 3)))),
        [
            "joint 'elbow' in arm.urdf",
            "not positive definite at q = ",
            "nothing resists this joint",
            "link 'lower'",
            "armature",
        ],
    ),
    "two joints do the same": (
        two_joints(
            first=joint("shoulder", "base", "upper"),
            second=joint("elbow", "upper", "lower", xyz="0 0 0"),
        ).replace(inertial(2.0), inertial(2.0, "0 0 0", np.zeros((3, 3)))),
        ["not positive definite", "another joint moves them just so"],
    ),
    "MuJoCo": (
        "<mujoco><worldbody/></mujoco>",
        ["nothing movable"],  # it is read: tests/arms/test_mjcf.py
    ),
    "Gazebo": ("<sdf version='1.7'/>", ["a Gazebo model (SDF)"]),
    "xacro, undeclared prefix": (
        '<robot name="r"><xacro:include filename="x"/></robot>',
        ["a prefix that nothing declares", "xmlns:xacro"],
    ),
    "xacro": (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="m" params=""/></robot>',
        ["this xacro file, expanded, holds no <link>", "Give the file that calls them"],
    ),
    "xacro value": (elbow(xyz="${reach} 0 0"), ["xacro cannot expand this file", "name 'reach' is not defined"]),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_named_with_its_place_and_remedy(fault: str, tmp_path: Path) -> None:
    text, expected = FAULTS[fault]
    path = write(tmp_path, text)
    with pytest.raises(ArmError) as caught:
        load_arm(path)
    for part in expected:
        assert part in str(caught.value)
    assert "arm.urdf" in str(caught.value)
    assert caught.value.source == str(path)


def test_generated_urdf_that_still_declares_xacro_loads(tmp_path: Path) -> None:
    text = two_joints().replace('<robot name="r">', '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">')
    assert load_arm(write(tmp_path, text)).nv == 2


def test_urdf_in_a_namespace_of_its_tool_loads(tmp_path: Path) -> None:
    text = two_joints().replace('<robot name="r">', '<robot name="r" xmlns="http://drake.mit.edu">')
    assert load_arm(write(tmp_path, text)).joint_names == ("shoulder", "elbow")


def test_folder_and_unreadable_bytes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ArmError, match="is a folder, not a URDF file"):
        load_arm(tmp_path)
    (tmp_path / "noise.urdf").write_bytes(bytes(range(256)))
    with pytest.raises(ArmError, match="not well-formed XML"):
        load_arm(tmp_path / "noise.urdf")


ENTITIES = {
    "in an attribute": ('<!DOCTYPE robot [<!ENTITY reach "0.5 0 0">]>', "&reach;"),
    "of another file": ('<!DOCTYPE robot [<!ENTITY reach SYSTEM "secret.txt">]>', "0 0 0"),
    "growing without end": (
        '<!DOCTYPE robot [<!ENTITY a "0000000000"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">'
        '<!ENTITY reach "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]>',
        "&reach; 0 0",
    ),
    "of the DTD": ('<!DOCTYPE robot [<!ENTITY % reach SYSTEM "other.dtd"> %reach;]>', "0 0 0"),
}


@pytest.mark.parametrize("kind", ENTITIES)
def test_entities_are_refused_and_never_expanded(kind: str, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("0.123456 0 0", encoding="utf-8")
    head, value = ENTITIES[kind]
    path = write(tmp_path, head + elbow(xyz=value))
    with pytest.raises(ArmError, match=r"declares the entity '\w+'; entities are not expanded") as caught:
        load_arm(path)
    assert "0.123456" not in str(caught.value)


def test_entities_in_another_encoding_are_refused_too(tmp_path: Path) -> None:
    text = '<?xml version="1.0" encoding="utf-16"?><!DOCTYPE robot [<!ENTITY reach "0.5 0 0">]>' + elbow(xyz="&reach;")
    (tmp_path / "arm.urdf").write_bytes(text.encode("utf-16"))
    with pytest.raises(ArmError, match="declares the entity"):
        load_arm(tmp_path / "arm.urdf")


@pytest.mark.parametrize("excess", [0.0, 0.9e-9])
def test_inertia_at_the_edge_of_the_possible_loads(excess: float, tmp_path: Path) -> None:
    # A flat plate: the largest moment is the sum of the others, up to the digits an exporter prints.
    assert load_arm(write(tmp_path, tip(diagonal=(0.01, 0.02, 0.03 * (1.0 + excess))))).nv == 2


def test_inertia_just_beyond_the_edge_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ArmError, match="triangle inequality"):
        load_arm(write(tmp_path, tip(diagonal=(0.01, 0.02, 0.03 * (1.0 + 1e-8)))))


def test_point_mass_and_massless_links_behind_fixed_joints_load(tmp_path: Path) -> None:
    text = two_joints(tip=inertial(inertia=np.zeros((3, 3)))).replace(
        "</robot>", link("tool") + joint("weld", "lower", "tool", "fixed") + "</robot>"
    )
    assert load_arm(write(tmp_path, text)).link_names[-1] == "tool"


def test_moving_link_may_have_its_mass_in_a_link_fixed_to_it(tmp_path: Path) -> None:
    text = two_joints(tip="").replace(
        "</robot>", link("hand", inertial()) + joint("weld", "lower", "hand", "fixed") + "</robot>"
    )
    assert load_arm(write(tmp_path, text)).nv == 2


def test_armature_mends_a_joint_that_nothing_resists(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(tip=inertial(com="0 0 0", inertia=np.zeros((3, 3)))))
    assert load_arm(path, armature=0.01).nv == 2


def test_light_wrist_on_a_heavy_arm_is_not_taken_for_singular(tmp_path: Path) -> None:
    text = two_joints(tip=inertial(1e-3, "0 0 0", 1e-9 * np.eye(3))).replace(inertial(2.0), inertial(500.0, "1 0 0"))
    assert np.linalg.cond(load_arm(write(tmp_path, text)).mass_matrix(np.zeros(2))) > 1e10


NOTHING_DECLARED = ["", '<limit lower="0" upper="0" effort="0" velocity="0"/>', '<limit effort="0"/>']


@pytest.mark.parametrize("limit", NOTHING_DECLARED)
def test_zero_or_missing_limits_are_undeclared_with_a_warning(limit: str, tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, elbow(limit)))
    declared = [2.0, 50.0, 3.0]
    for values, first in zip((arm.upper, arm.effort_limit, arm.velocity_limit), declared, strict=True):
        assert values.tolist() == [first, np.inf]
    assert arm.lower.tolist() == [-2.0, -np.inf]
    assert arm.box[0].tolist() == [-2.0, -np.pi]
    for what in ("position", "effort", "velocity"):
        assert any(
            f"zero, missing or endless {what} limits for elbow in arm.urdf" in warning for warning in arm.warnings
        )


def test_declared_limits_give_no_warning(tmp_path: Path) -> None:
    assert load_arm(write(tmp_path, two_joints())).warnings == ()


def test_continuous_joint_owes_no_position_limits(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, elbow('<limit effort="1" velocity="1"/>', kind="continuous")))
    assert arm.warnings == ()
    assert arm.continuous.tolist() == [False, True]


def test_joint_without_range_is_said(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, elbow('<limit lower="1" upper="1" effort="1" velocity="1"/>')))
    assert any("joint 'elbow' has no range, both its limits are 1" in warning for warning in arm.warnings)


def test_axis_of_any_length_gives_the_same_arm(tmp_path: Path) -> None:
    q = np.array([0.3, 0.7])
    short, long = (
        load_arm(write(tmp_path, elbow(axis=axis), f"{k}.urdf")) for k, axis in enumerate(("1 2 2", "10 20 20"))
    )
    assert long.mass_matrix(q) == pytest.approx(short.mass_matrix(q), rel=1e-14)
    assert np.linalg.norm(long.tree.axis, axis=1) == pytest.approx([1.0, 1.0])
