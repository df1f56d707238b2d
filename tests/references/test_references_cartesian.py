"""Claims about Cartesian paths: the tool is on the line to the stated residual, with the derivatives to go with it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from asmc_pin.arms import load_arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.references import CartesianPath

UR5 = [0.3, -1.3, 1.6, -1.2, -1.4, 0.2]
PANDA = [0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8]


def path_of(name, start, steps, **options):
    arm = load_arm(name)
    link = options.pop("link")
    first = FrameKinematics(arm, link).poses(np.array(start))
    points = first[:3, 3] + np.cumsum(steps, axis=0)
    return arm, CartesianPath(link=link, start=start, points=points.tolist(), move=options.pop("move", 1.0), **options)


@pytest.mark.parametrize("orientation", ["keep", "free", "given"])
@pytest.mark.parametrize(("name", "start", "link"), [("ur5", UR5, "tool0"), ("panda", PANDA, "panda_link8")])
def test_the_tool_goes_along_the_lines_to_the_stated_residual(name, start, link, orientation):
    rpy = [[0.2, 0.1, -0.3], [0.0, 0.3, 0.5]] if orientation == "given" else None
    if rpy is not None:
        arm = load_arm(name)
        here = Rotation.from_matrix(FrameKinematics(arm, link).poses(np.array(start))[:3, :3])
        rpy = [(here * Rotation.from_euler("xyz", turn)).as_euler("xyz").tolist() for turn in rpy]
    arm, path = path_of(
        name, start, [[0.1, 0.05, -0.08], [-0.12, 0.1, 0.02]], link=link, orientation=orientation, rpy=rpy
    )
    solved = path.on(arm)
    assert solved.residual_position < 1e-6
    t = np.linspace(0.0, solved.duration, 777)
    poses = FrameKinematics(arm, link).poses(solved.evaluate(t).q)
    first = poses[0]
    corners = np.vstack([first[:3, 3], path.points])
    for i in (0, 1):
        on = (t >= i) & (t <= i + 1)
        along = corners[i + 1] - corners[i]
        away = np.cross(poses[on, :3, 3] - corners[i], along / np.linalg.norm(along))
        assert np.linalg.norm(away, axis=1).max() < 2e-6
    np.testing.assert_allclose(poses[-1, :3, 3], corners[-1], atol=1e-9)
    if orientation == "keep":
        np.testing.assert_allclose(poses[:, :3, :3], np.broadcast_to(first[:3, :3], (777, 3, 3)), atol=2e-6)
    if orientation == "given":
        np.testing.assert_allclose(poses[-1, :3, :3], Rotation.from_euler("xyz", rpy[-1]).as_matrix(), atol=1e-8)


def test_velocity_and_acceleration_are_the_derivatives_and_it_rests_at_the_ends():
    arm, path = path_of("ur5", UR5, [[0.15, 0.1, -0.1]], link="tool0", move=1.5)
    solved = path.on(arm)
    t, h = np.linspace(0.1, 1.4, 50), 1e-5
    before, now, after = (solved.evaluate(t + dt) for dt in (-h, 0.0, h))
    np.testing.assert_allclose((after.q - before.q) / (2 * h), now.v, atol=1e-7)
    np.testing.assert_allclose((after.v - before.v) / (2 * h), now.a, atol=1e-5)
    ends = solved.evaluate(np.array([0.0, 1.5, 2.0]))
    np.testing.assert_allclose(ends.q[0], UR5, atol=1e-12)
    np.testing.assert_allclose(np.stack([ends.v, ends.a]), 0.0, atol=1e-7)
    np.testing.assert_array_equal(ends.q[1], ends.q[2])


def test_the_tool_moves_at_the_quintics_pace():
    arm, path = path_of("ur5", UR5, [[0.2, 0.0, 0.0]], link="tool0", move=2.0)
    solved = path.on(arm)
    now = solved.evaluate(np.array([1.0]))
    speed = FrameKinematics(arm, "tool0").jacobians(now.q)[0] @ now.v[0]
    np.testing.assert_allclose(speed, [1.875 * 0.2 / 2.0, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-5)


def test_what_is_out_of_reach_is_answered_with_time_and_place():
    arm, path = path_of("ur5", UR5, [[2.0, 0.0, 0.0]], link="tool0")
    with pytest.raises(ParameterError, match=r"does not get to .* at t = 0\.\d+ s"):
        path.on(arm)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"points": [[1.0, 2.0]]}, "x, y, z"),
        ({"move": [1.0, 2.0]}, "2 values for 1 points"),
        ({"orientation": "given"}, "roll, pitch, yaw"),
        ({"rpy": [0.0, 0.0, 0.0]}, "orientation = 'given'"),
        ({"orientation": "given", "rpy": [0.0, 0.0]}, "roll, pitch, yaw for each"),
    ],
)
def test_a_path_that_cannot_be_is_refused(options, said):
    with pytest.raises(ParameterError, match=said):
        CartesianPath(**{"link": "tool0", "start": UR5, "points": [[0.3, 0.3, 0.3]], "move": 1.0} | options)


def test_a_path_for_another_arm_is_refused():
    path = CartesianPath(link="tool0", start=UR5, points=[[0.3, 0.3, 0.3]], move=1.0)
    with pytest.raises(ParameterError, match="6 values but two_link has 2 joints"):
        path.on(load_arm("two_link"))
    with pytest.raises(ParameterError, match=r"reference.on\(arm\)"):
        path.evaluate(np.zeros(1))
    with pytest.raises(ParameterError, match="link: no link 'hand'"):
        CartesianPath(link="hand", start=UR5, points=[[0.3, 0.3, 0.3]], move=1.0).on(load_arm("ur5"))


def test_an_experiment_follows_a_cartesian_path():
    data = {
        "name": "line",
        "arm": "ur5",
        "period": 0.002,
        "duration": 1.0,
        "reference": {"kind": "cartesian", "link": "tool0", "start": UR5, "points": [0.3, 0.2, 0.4], "move": 1.0},
        "controllers": {"PPC": {"law": "ppc", "mbar": 0.1, "ks": 5.0, "beta": 5.0}},
    }
    experiment = Experiment.from_dict(data)
    reference = experiment.build_reference()
    assert "inverse kinematics to" in str(reference)
    poses = FrameKinematics(experiment.build_arm(), "tool0").poses(experiment.setpoints()[1].q)
    np.testing.assert_allclose(poses[-1, :3, 3], [0.3, 0.2, 0.4], atol=1e-9)
    with pytest.raises(ExperimentError, match=r"reference.link: no link 'hand'"):
        Experiment.from_dict({**data, "reference": {**data["reference"], "link": "hand"}}).build_reference()
