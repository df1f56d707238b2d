"""MuJoCo reads the same URDF text and says the same: M, bias and motion, on every named arm and on random chains."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from arm_urdf import LIMIT, bodies, inertial, joint, link, robot, trees, two_joints, write
from coupled_urdf import coupled_tree, gripper, parallelogram
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from asmc_pin.agreement import AgreementReport, agree
from asmc_pin.agreement import mujoco_model as engine_module
from asmc_pin.agreement.agreement_report import TOLERANCE
from asmc_pin.arms import Arm, arm_names, load_arm
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.errors import MissingDependencyError, ParameterError
from asmc_pin.viewer.drawing.visuals import read_visuals

ROUND_OFF = 1e-10
RANDOM = settings(
    max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
BRICK = {"mass": 1.3, "com": (0.1, 0.02, -0.05), "inertia": (0.02, 0.003, -0.001, 0.03, 0.002, 0.025)}


def quick(arm: Arm) -> AgreementReport:
    return agree(arm, configurations=12, runs=2, duration=0.05)


def assert_same(report: AgreementReport) -> None:
    assert report.verdict == "agrees", report.lines()
    assert max(report.mass_error, report.bias_error, report.motion_error) < ROUND_OFF, report.lines()


@pytest.mark.parametrize("name", arm_names())
def test_every_named_arm_is_the_same_arm_in_mujoco(name: str) -> None:
    assert_same(agree(load_arm(name), configurations=50, runs=4, duration=0.1))


@pytest.mark.parametrize("name", ["ur5", "panda", "kinova"])
def test_payload_armature_and_mounting_are_set_in_both(name: str) -> None:
    assert_same(quick(load_arm(name, payload=BRICK, armature=0.07, gravity=(2.0, -5.0, 7.0))))
    assert_same(quick(load_arm(name, payload=2.0)))


@st.composite
def chains(draw: st.DrawFn) -> str:
    """A serial chain of up to seven joints of any kind about any axis, massless flanges in between."""
    triple = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
    text = triple.map(lambda x: " ".join(map(repr, x)))
    axes = triple.filter(lambda x: sum(c * c for c in x) > 1e-2).map(lambda x: " ".join(map(repr, x)))
    parts, last = [link("base")], "base"
    for k in range(draw(st.integers(1, 7))):
        kind = draw(st.sampled_from(["revolute", "continuous", "prismatic"]))
        parts += [
            link(f"link{k}", draw(bodies())),
            joint(f"joint{k}", last, f"link{k}", kind, draw(axes), draw(text), draw(text)),
        ]
        last = f"link{k}"
        if draw(st.booleans()):
            flange = joint(f"weld{k}", last, f"flange{k}", "fixed", "0 0 0", draw(text), draw(text), extra="")
            parts += [link(f"flange{k}"), flange]
            last = f"flange{k}"
    return robot(*parts)


@RANDOM
@given(text=chains())
def test_random_serial_chains_are_the_same_in_mujoco(text: str, tmp_path: Path) -> None:
    assert_same(quick(load_arm(write(tmp_path, text), payload={**BRICK, "link": "link0"}, armature=0.01)))


@RANDOM
@given(text=trees())
def test_random_trees_are_the_same_in_mujoco(text: str, tmp_path: Path) -> None:
    assert_same(quick(load_arm(write(tmp_path, text), armature=0.01)))


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_a_joint_is_locked_where_it_was_locked(kind: str, tmp_path: Path) -> None:
    text = robot(
        link("base"),
        *(link(name, inertial(2.0, "0.1 -0.2 0.3")) for name in ("one", "two", "three")),
        joint("a", "base", "one", axis="0 1 0"),
        joint("b", "one", "two", kind, axis="1 2 -0.5", xyz="0.3 0.1 -0.2", rpy="0.4 -1.0 2.0"),
        joint("c", "two", "three", axis="0 0.6 0.8"),
    )
    arm = load_arm(write(tmp_path, text), lock={"b": 0.83}, payload=0.5)
    assert arm.joint_names == ("a", "c")
    assert_same(quick(arm))
    elsewhere = load_arm(write(tmp_path, text), lock={"b": 0.80}, payload=0.5)
    assert np.abs(elsewhere.mass_matrix(np.ones(2)) - arm.mass_matrix(np.ones(2))).max() > 1e-3


def test_fingers_that_mimic_a_locked_one_follow_in_both() -> None:
    assert_same(quick(load_arm("panda", lock={"panda_finger_joint1": 0.03, "panda_joint5": -1.1})))


@pytest.mark.parametrize("seed", range(5))
def test_mimicking_joints_are_the_same_in_mujoco(seed: int, tmp_path: Path) -> None:
    text = coupled_tree(np.random.default_rng(seed), joints=7, followers=3, chained=True)
    arm = load_arm(write(tmp_path, text), armature=0.03, payload={**BRICK, "link": "l3"})
    report = agree(arm, configurations=40, runs=2, duration=0.05)
    assert max(report.mass_error, report.bias_error, report.motion_error) < 1e-11, report.lines()


def test_gripper_and_parallelogram_are_the_same_in_mujoco(tmp_path: Path) -> None:
    for text in (gripper(), parallelogram()):
        assert_same(quick(load_arm(write(tmp_path, text), armature=0.01)))
    assert_same(quick(load_arm("panda", lock={"panda_finger_joint1": "free"})))


def test_a_mimic_joint_is_mujocos_coupling_in_the_limit_of_its_stiffness(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, coupled_tree(np.random.default_rng(1), joints=5, followers=2)))
    names = list(arm.model.names)[1:]
    q, v, torque = np.random.default_rng(2).uniform(-1.0, 1.0, (3, arm.nv))
    ours = arm.forward_dynamics(q, v, torque)
    apart = []
    for stiffness in (0.9, 0.99, 0.999, 0.9999):
        spec = mujoco.MjSpec.from_string(engine_module.dynamics_only(arm.urdf_text))
        spec.option.gravity = arm.gravity_vector
        spec.option.tolerance = 0.0
        for name, mimic in arm.mimics.items():
            equality = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=name, name2=mimic.joint)
            equality.objtype = mujoco.mjtObj.mjOBJ_JOINT
            equality.data[:2] = mimic.offset, mimic.multiplier
            equality.solimp[:2] = stiffness
        model = spec.compile()
        data = mujoco.MjData(model)
        joints = [model.joint(name) for name in names]
        data.qpos[[joint.qposadr[0] for joint in joints]] = arm.tree.coupling.joints(q)
        data.qvel[[joint.dofadr[0] for joint in joints]] = arm.tree.coupling.rates(v)
        driven = [model.joint(name).dofadr[0] for name in arm.joint_names]
        data.qfrc_applied[driven] = torque
        mujoco.mj_forward(model, data)
        apart.append(np.abs(data.qacc[driven] - ours).max() / np.abs(ours).max())
    # What a soft constraint gives way falls in proportion to 1 - d.
    assert np.array(apart[:-1]) / np.array(apart[1:]) == pytest.approx([10.0] * 3, rel=0.2)
    assert apart[-1] < 1e-3


def test_another_arm_is_told_apart_and_the_place_is_named() -> None:
    arm = load_arm("ur5")
    heavier = arm.urdf_text.replace('<mass value="8.393"/>', '<mass value="8.3931"/>')
    assert heavier != arm.urdf_text
    report = agree(dataclasses.replace(arm, urdf_text=heavier))
    assert report.verdict == "disagrees"
    assert 1e-6 < report.mass_error < 1e-3
    assert "DISAGREES" in report.lines()[0]
    # The error is what it says it is, where it says it is.
    q = report.mass_worst_q
    mass, other = arm.mass_matrix(q), engine_module.Twin(dataclasses.replace(arm, urdf_text=heavier))
    theirs, _ = other.mass_and_bias(q, np.zeros(arm.nv))
    root = np.sqrt(np.diag(mass))
    assert np.max(np.abs(mass - theirs) / np.outer(root, root)) == pytest.approx(report.mass_error, rel=1e-9)
    # The forearm is beyond joint 2; what stands after it does not feel its mass.
    assert np.all(report.mass_by_joint[3:] < 1e-4)


def test_gravity_the_other_way_round_is_a_different_bias_and_the_same_mass() -> None:
    arm = load_arm("ur5")
    hanging = dataclasses.replace(load_arm("ur5", gravity=(0, 0, 9.81)), model=arm.model)
    report = quick(hanging)
    assert report.verdict == "disagrees"
    assert report.mass_error < ROUND_OFF
    assert report.bias_error > 0.1
    assert report.bias_by_joint[0] < ROUND_OFF  # a vertical axis does not feel it


def test_point_masses_are_compared_and_said_to_be_given_a_speck_of_inertia(tmp_path: Path) -> None:
    point = inertial(3.0, "0.2 0 0", np.zeros((3, 3)))
    text = robot(link("base"), link("one", point), link("two", point), *(joint(*ends, axis="0 1 0") for ends in ENDS))
    report = quick(load_arm(write(tmp_path, text)))
    assert_same(report)
    assert any("1e-14 (kg, kg·m²)" in note for note in report.notes)


ENDS = (("a", "base", "one"), ("b", "one", "two"))


def test_an_inertia_rounded_to_an_impossible_one_is_compared_within_that_rounding(tmp_path: Path) -> None:
    text = two_joints(tip=inertial(1.0, inertia=np.diag([1.0, 1.0, 2.0 + 1e-9])))
    report = quick(load_arm(write(tmp_path, text)))
    assert report.verdict == "agrees"
    assert any("link 'lower'" in note for note in report.notes)


def test_names_that_mean_something_to_mujoco_are_only_names(tmp_path: Path) -> None:
    text = two_joints().replace("upper", "world").replace("lower", "payload")
    assert_same(quick(load_arm(write(tmp_path, text), payload=1.0)))


def test_meshes_extensions_and_namespaces_are_not_needed(tmp_path: Path) -> None:
    mesh = '<visual><geometry><mesh filename="package://nowhere/none.dae"/></geometry></visual>'
    extra = '<transmission name="t"/><gazebo><plugin name="p" filename="x.so"/></gazebo>'
    text = two_joints(tip=inertial() + mesh + mesh.replace("visual", "collision")).replace(
        "</robot>", f"{extra}</robot>"
    )
    assert_same(quick(load_arm(write(tmp_path, text.replace("<robot ", '<robot xmlns="http://other" ')))))


def test_a_namespace_that_is_no_address_is_forgiven_wherever_the_text_is_read(tmp_path: Path) -> None:
    text = two_joints().replace('<origin xyz="0.1', '<origin xmlns:a="line break" xyz="0.1', 1)
    assert "line break" in text
    arm = load_arm(write(tmp_path, text))
    assert_same(quick(arm))
    ball = text.replace("</link>", '<visual><geometry><sphere radius="0.1"/></geometry></visual></link>')
    shown, problems = read_visuals(load_arm(write(tmp_path, ball)).urdf_text, RobotFiles(tmp_path))
    assert {"upper", "lower"} <= set(shown)
    assert not problems


def test_an_axis_that_is_left_out_is_x_in_both(tmp_path: Path) -> None:
    text = two_joints().replace('<axis xyz="0 0 1"/>', "")
    assert "axis" in text
    assert_same(quick(load_arm(write(tmp_path, text))))


def test_limits_hold_nobody_back(tmp_path: Path) -> None:
    text = two_joints().replace(LIMIT, '<limit lower="-0.001" upper="0.001" effort="0.1" velocity="0.1"/>')
    assert_same(quick(load_arm(write(tmp_path, text))))


def test_a_refusal_is_reported_with_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine_module, "dynamics_only", lambda text: two_joints(tip="").replace("lower", "link lower"))
    report = agree(load_arm("two_link"))
    assert report.verdict == "not compared"
    assert "refuses two_link" in report.notes[0]
    assert "NOT COMPARED" in report.lines()[0]
    assert json.loads(json.dumps(report.to_json_dict(), allow_nan=False))["mass_error"] is None


def test_a_motion_that_neither_engine_can_integrate_is_no_disagreement(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    # The shoulder's turning pulls a far elbow outwards: it swings at some 30 rad/s, too fast for steps of 0.1 s.
    far = two_joints(second=joint("elbow", "upper", "lower", axis="0 0 1", xyz="1e3 0 0.3"))
    monkeypatch.chdir(tmp_path)
    report = agree(load_arm(write(tmp_path, far)), configurations=12, runs=2, duration=2.0, step=0.1)
    assert report.verdict == "not compared"
    assert max(report.mass_error, report.bias_error) < TOLERANCE
    assert "too long" in report.notes[-1]
    assert not any("nan" in line or "DISAGREES" in line for line in report.lines())
    assert capfd.readouterr() == ("", "")
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()


def test_without_mujoco_the_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'asmc-pin\[agree\]'"):
        agree(load_arm("two_link"))


def test_mujoco_is_loaded_only_when_asked_for() -> None:
    code = "import sys, asmc_pin.agreement; print('mujoco' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "False"


def test_the_report_is_valid_json_and_repeatable() -> None:
    one, two = (quick(load_arm("two_dofs")).to_json_dict() for _ in range(2))
    assert json.loads(json.dumps(one, allow_nan=False))["verdict"] == "agrees"
    assert {**one, "seconds": 0} == {**two, "seconds": 0}


@pytest.mark.parametrize("option", [{"configurations": 0}, {"runs": 0}, {"step": 0.0}, {"step": 1.0}])
def test_nothing_to_compare_is_refused(option: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match=next(iter(option))):
        agree(load_arm("two_link"), **option)  # type: ignore[arg-type]
