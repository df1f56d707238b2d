"""MuJoCo models: MuJoCo reads them, and M(q) is MuJoCo's own to 1e-12, or they are refused."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from asmc_pin import load_arm
from asmc_pin.arms.urdf import mjcf_conversion, urdf_document
from asmc_pin.errors import ArmError

INERTIAL = '<inertial mass="2" pos="0.1 0.02 -0.03" quat="0.9 0.1 0.3 -0.2" diaginertia="0.03 0.02 0.015"/>'
ARM = f"""
<mujoco model="mine">
  <compiler angle="degree" autolimits="true"/>
  <default><joint armature="0.1" damping="2" frictionloss="0.3"/></default>
  <worldbody>
    <body name="base" pos="0 0 0.2" euler="0 90 20">
      <body name="a" pos="0 0.1 0.3" quat="1 1 0 0">
        {INERTIAL}
        <joint name="one" axis="0 0.6 0.8" pos="0.02 0 0.01" ref="20" range="-90 90"/>
        <geom type="mesh" mesh="absent"/>
        <body name="b" pos="0.2 0 0" euler="10 20 30">
          <joint name="two" type="slide" axis="0 0 1" ref="0.1" range="0 0.4" armature="0.5"/>
          <geom type="capsule" size="0.04 0.2" pos="0 0 0.1"/>
          <body name="tool" pos="0 0 0.2"><geom size="0.03"/>
            <body name="c">
              <joint name="three" axis="1 0 0"/>
              <geom type="box" size="0.05 0.02 0.1" pos="0 0.1 0"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <asset><mesh name="absent" file="absent.stl"/></asset>
  <actuator><motor joint="one" gear="2" forcerange="-15 10"/></actuator>
</mujoco>"""


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.xml"
    path.write_text(text)
    return path


def test_a_mujoco_model_has_mujocos_inertia_matrix_limits_and_losses(tmp_path: Path) -> None:
    arm = load_arm(written(tmp_path, ARM))
    assert arm.name == "mine"
    assert arm.joint_names == ("one", "two", "three")
    assert arm.joint_kinds == ("revolute", "prismatic", "revolute")
    assert arm.armature.tolist() == [0.1, 0.5, 0.1]
    np.testing.assert_allclose(arm.lower, [-np.pi / 2, 0.0, -np.inf])
    assert arm.effort_limit.tolist() == [30.0, np.inf, np.inf]
    assert (arm.damping.tolist(), arm.friction.tolist()) == ([2.0] * 3, [0.3] * 3)
    shown = '<geom type="mesh" mesh="absent"/>', '<asset><mesh name="absent" file="absent.stl"/></asset>'
    model = mujoco.MjModel.from_xml_string(ARM.replace(shown[0], "").replace(shown[1], ""))
    data = mujoco.MjData(model)
    for q in np.random.default_rng(3).uniform(-2.0, 2.0, (5, 3)):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        mass = np.empty((3, 3))
        for row, unit in zip(mass, np.eye(3), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        np.testing.assert_allclose(arm.mass_matrix(q), mass, rtol=0, atol=1e-12 * mass.max())
        np.testing.assert_allclose(arm.gravity(q), data.qfrc_bias, rtol=0, atol=1e-12 * np.abs(data.qfrc_bias).max())


def test_a_difference_from_mujoco_refuses_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = mjcf_conversion._roll_pitch_yaw
    monkeypatch.setattr(mjcf_conversion, "_roll_pitch_yaw", lambda turn: real(turn) + 1e-9)
    with pytest.raises(ArmError, match=r"its M\(q\) differs from MuJoCo's by .*e-\d\d of the largest entry"):
        load_arm(written(tmp_path, ARM))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('<joint name="one"', '<joint name="zero"/><joint name="one"'), "body 'a' has 2 joints"),
        (('<joint name="three" axis="1 0 0"/>', '<joint name="three" type="ball"/>'), "'three' is a free or a ball"),
        (
            ("<actuator>", '<equality><connect body1="b" body2="c" anchor="0 0 0"/></equality><actuator>'),
            "an equality that is no joint following another in proportion",
        ),
        (('<geom type="capsule" size="0.04 0.2" pos="0 0 0.1"/>', '<geom type="mesh" mesh="absent"/>'), "absent.stl"),
        (("<worldbody>", "<worldbodi>"), "not well-formed XML"),
    ],
)
def test_what_is_no_arm_is_refused_by_name(change: tuple[str, str], said: str, tmp_path: Path) -> None:
    with pytest.raises(ArmError, match=said):
        load_arm(written(tmp_path, ARM.replace(*change)))


def test_a_joint_that_follows_another_is_a_mimic(tmp_path: Path) -> None:
    equality = '<equality><joint joint1="three" joint2="one" polycoef="0.1 0.5 0 0 0"/></equality><actuator>'
    arm = load_arm(written(tmp_path, ARM.replace("<actuator>", equality)), lock={"one": 0.4})
    # MuJoCo: q₃ − q₃⁰ = 0.1 + 0.5 (q₁ − q₁⁰), with q₁⁰ = 20°.
    assert arm.locked["three"] == pytest.approx(0.1 + 0.5 * (0.4 - np.radians(20.0)))


def test_without_mujoco_the_message_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(urdf_document, "can_convert", lambda: False)
    with pytest.raises(ArmError, match=r"a MuJoCo model \(MJCF\), not a URDF, .* pip install 'asmc-pin\[agree\]'"):
        load_arm(written(tmp_path, ARM))
