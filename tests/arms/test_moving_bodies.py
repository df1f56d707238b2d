"""Inertias are judged on what moves, with all that is fixed to it; what stands still may have any."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, two_joints, write

from asmc_pin import agree, certify, check, load_arm
from asmc_pin.arms.urdf.rigid_inertia import tensor_problem
from asmc_pin.errors import ArmError

IMPOSSIBLE = inertial(1e-8, inertia=np.diag([0.0, 0.0, 1e-8]))
SHOULDER, ELBOW = joint("shoulder", "base", "upper"), joint("elbow", "upper", "lower", axis="0 1 0")


def on(parent: str, body: str = IMPOSSIBLE) -> str:
    """The two-joint arm with a dummy fixed to one of its links."""
    dummy = link("dummy", body) + joint("weld", parent, "dummy", "fixed")
    return two_joints().replace("</robot>", dummy + "</robot>")


def test_the_base_may_have_any_inertia(tmp_path: Path) -> None:
    q = np.array([0.3, -0.7])
    plain = load_arm(write(tmp_path, two_joints())).mass_matrix(q)
    for k, body in enumerate((IMPOSSIBLE, inertial(-3.0), inertial(1.0, inertia=-np.eye(3)))):
        root = two_joints().replace(link("base"), link("base", body))
        for text in (root, on("base", body)):
            assert load_arm(write(tmp_path, text, f"{k}.urdf")).mass_matrix(q) == pytest.approx(plain, rel=1e-14)


def test_a_dummy_is_judged_with_the_link_that_it_is_fixed_to(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, on("lower")))
    assert arm.provisos == ()
    assert arm.warnings == ()
    with pytest.raises(ArmError, match="link 'dummy'"):
        load_arm(write(tmp_path, on("lower").replace('name="weld" type="fixed"', 'name="weld" type="revolute"')))


def test_a_dummy_behind_a_locked_joint_moves_with_what_the_joint_hangs_on(tmp_path: Path) -> None:
    path = write(tmp_path, on("lower").replace('name="weld" type="fixed"', 'name="weld" type="revolute"'))
    assert load_arm(path, lock={"weld": 0.3}).nv == 2
    assert load_arm(path, lock={"weld": 0.3, "elbow": 0.0}).nv == 1


def test_links_without_inertia_are_told_in_one_sentence_with_one_remedy(tmp_path: Path) -> None:
    bare = robot(
        *(link(name) for name in ("base", "upper", "lower")),
        joint("shoulder", "base", "upper"),
        joint("elbow", "upper", "lower"),
    )
    with pytest.raises(ArmError) as refusal:
        load_arm(write(tmp_path, bare))
    said = str(refusal.value)
    assert said.startswith("2 moving links in arm.urdf carry no inertia")
    assert "'upper' (on joint 'shoulder', line " in said
    assert "'lower' (on joint 'elbow', line " in said
    assert said.count("--estimate-inertia") == 1
    assert "\n" not in said


def test_an_impossible_dummy_that_outweighs_its_link_is_refused_with_both_named(tmp_path: Path) -> None:
    with pytest.raises(ArmError, match=r"link 'dummy'.*nor does what moves together with it \(lower\)"):
        load_arm(write(tmp_path, on("lower", inertial(0.1, inertia=np.diag([0.0, 0.0, 1.0])))))


def test_all_faults_are_told_at_once_with_their_lines(tmp_path: Path) -> None:
    text = robot(
        link("base", inertial(-1.0)),
        link("upper", inertial(2.0, inertia=np.diag([0.01, 0.01, 0.1]))),
        link("lower", inertial(-1.0)),
        link("hand"),
        SHOULDER,
        ELBOW,
        joint("wrist", "lower", "hand"),
    )
    with pytest.raises(ArmError) as caught:
        load_arm(write(tmp_path, text))
    first, *lines = str(caught.value).split("\n")
    assert "3 faults of what moves" in first
    assert "link 'upper' in arm.urdf, line 3: its inertia breaks the triangle inequality" in lines[0]
    assert "link 'lower' in arm.urdf, line 4: its mass is -1 kg" in lines[1]
    assert "joint 'wrist' in arm.urdf, line 8: moves link 'hand', which carries no inertia" in lines[2]
    assert "repair=True" in lines[3]
    assert "base" not in str(caught.value)


def test_a_zero_that_an_exporter_wrote_with_a_sign_is_a_zero() -> None:
    assert not tensor_problem(0.5, np.diag([-5e-20, 1e-20, 0.0]))
    assert tensor_problem(0.5, np.diag([-5e-12, 1e-20, 0.0]))
    assert tensor_problem(0.0, np.diag([-5e-20, 1e-20, 0.0]))


def test_a_certificate_speaks_of_the_merged_bodies_and_is_replayed(tmp_path: Path) -> None:
    text = on("lower").replace(link("base"), link("base", inertial(1.0, inertia=-np.eye(3))))
    arm = load_arm(write(tmp_path, text))
    found = certify(arm, 0.02, condition="weighted", gap=0.2, budget=60.0, levels=False)
    replayed = check(found.save(tmp_path / "merged.cert"))
    assert replayed.valid, replayed.problems


def test_mujoco_judges_links_alone_and_is_given_the_merged_body(tmp_path: Path) -> None:
    heavy = inertial(0.02, inertia=np.diag([0.0, 0.0, 4e-4]), rpy="0.4 0.2 -0.7")
    text = on("lower", heavy).replace(link("base"), link("base", inertial(1.0, inertia=-np.eye(3))))
    report = agree(load_arm(write(tmp_path, text)))
    assert report.verdict == "agrees"
    assert report.mass_error < 1e-12
