"""How far the tool is from where it should be, against angles and chords computed by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write

from asmc_pin import load_arm
from asmc_pin.arms import Arm
from asmc_pin.engine import Rollout
from asmc_pin.errors import ParameterError
from asmc_pin.tool_error import ToolError, tool_error

REACH = 0.8


def turning(folder: Path, axis: str, reach: str) -> Arm:
    """A joint about an axis that carries a tool at some reach from it."""
    element = joint("j", "base", "arm", kind="continuous", axis=axis, xyz="0 0 0", extra="")
    tool = joint("mount", "arm", "tool", kind="fixed", xyz=reach, extra="")
    return load_arm(write(folder, robot(link("base"), link("arm", inertial(1.0)), link("tool"), element, tool)))


def off_by(angles: list[float], at: float) -> Rollout:
    """A run of one joint that should stand at an angle and is off by others, tick by tick."""
    q = at + np.array(angles)[None, :, None]
    nothing, ticks = np.zeros(q.shape), len(angles)
    return Rollout(
        time=1e-3 * np.arange(ticks),
        status=("ok",),
        end_time=np.array([1e-3 * (ticks - 1)]),
        joint_names=("j",),
        period=1e-3,
        limit_violations=(),
        q=q,
        q_ref=np.full((ticks, 1), at),
        **dict.fromkeys(("v", "torque", "friction_torque", "s", "gain"), nothing),
        **dict.fromkeys(("v_ref", "a_ref"), nothing[0]),
    )


@pytest.mark.parametrize(
    ("axis", "reach"),
    [("1 0 0", f"0 {REACH} 0"), ("0 1 0", f"0 0 {REACH}"), ("0 0 1", f"{REACH} 0 0")],
    ids=["x", "y", "z"],
)
@pytest.mark.parametrize("at", [0.0, 0.7])
def test_a_joint_that_is_off_turns_the_tool_by_as_much_and_moves_it_by_the_chord(
    tmp_path: Path, axis: str, reach: str, at: float
) -> None:
    angles = [0.0, 1e-9, -0.3, 1.2, np.pi - 1e-6, -2.0]
    found = tool_error(turning(tmp_path, axis, reach), off_by(angles, at), "tool")
    np.testing.assert_allclose(found.rotation[0], np.abs(angles), rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found.position[0], 2.0 * REACH * np.sin(0.5 * np.abs(angles)), rtol=1e-6, atol=1e-15)


def test_figures_are_the_root_of_the_mean_square_and_the_largest_and_nan_where_a_trial_diverged() -> None:
    distance, angle = np.array([[0.0, 3e-3, 4e-3, 0.0], [1e-3, np.nan, np.nan, np.nan]]), np.full((2, 4), 0.2)
    figures = ToolError("tool", distance, angle).figures()
    assert figures["rms_position"][0] == pytest.approx(2.5e-3)
    assert figures["max_position"][0] == 4e-3
    assert np.isnan([figures["rms_position"][1], figures["max_position"][1]]).all()
    assert figures["rms_rotation"].tolist() == figures["max_rotation"].tolist() == [pytest.approx(0.2)] * 2


def test_a_frame_that_there_is_not_is_named(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"^tool: .*'hand'"):
        tool_error(turning(tmp_path, "0 0 1", f"{REACH} 0 0"), off_by([0.0], 0.0), "hand")
