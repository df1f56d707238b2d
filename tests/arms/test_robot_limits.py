"""The table of robots' published limits: whole, of the right size, and never without a source."""

import numpy as np
import pytest

from asmc_pin.arms import arm_names, load_arm
from asmc_pin.arms.robot_limits import LIMITED_QUANTITIES, ROBOT_LIMITS


@pytest.mark.parametrize("name", ROBOT_LIMITS)
def test_every_limit_is_one_positive_figure_for_each_joint_with_a_source_in_words(name):
    robot = ROBOT_LIMITS[name]
    assert set(robot.published) <= set(LIMITED_QUANTITIES)
    for limit in robot.published.values():
        assert len(limit.values) == robot.joints
        assert all(np.isfinite(x) and x > 0.0 for x in limit.values)
        assert len(limit.source.split()) > 3


@pytest.mark.parametrize("name", [name for name in ROBOT_LIMITS if name in arm_names()])
def test_limits_fit_the_named_arm_of_the_same_name_and_speeds_are_of_a_size_with_those_that_its_urdf_declares(name):
    arm, robot = load_arm(name), ROBOT_LIMITS[name]
    assert robot.joints == arm.nv
    if robot.velocity is not None and name != "ur3":  # its URDF has the speeds and torques of a UR10
        assert np.abs(np.log(np.array(robot.velocity.values) / arm.velocity_limit)).max() < 0.1


def test_the_panda_has_the_figures_that_its_maker_prints():
    panda = ROBOT_LIMITS["panda"]
    assert panda.torque.values == (87.0,) * 4 + (12.0,) * 3
    assert panda.torque_rate.values == (1000.0,) * 7
    assert panda.velocity.values == (2.175,) * 4 + (2.61,) * 3
