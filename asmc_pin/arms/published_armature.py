"""Reflected rotor inertias of the named arms that somebody has published, each with its source and how sure it is.

Only numbers with a source stand here. What stands in a simulation model alone is listed as such: often it is one round
number at every joint, and nobody says that it is the rotor's. It can be asked for, and is never proposed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

PUBLISHED = "published"
"""The word that stands for these values in place of numbers."""

HOW_TO_MEASURE = (
    "It is the rotor's inertia times the gear ratio squared, if the maker names both. To measure it, hold all other "
    "joints, pass one angle at one speed with two accelerations, and divide the difference of the joint's torque by "
    "that of the accelerations; that, less M_jj(q) of the URDF, is the joint's"
)

_AT_UR = (
    ". A UR controller that has get_mass_matrix(q, include_rotors_inertia) gives it directly: the diagonal of the "
    "difference between True and False"
)


@dataclass(frozen=True)
class PublishedArmature:
    """What is published of one arm.

    Attributes:
        armature: Reflected rotor inertia by joint, kg·m².
        source: Who says so, and where.
        certainty: How far it can be relied on.
        simulated: Whether it stands in a simulation model alone, so that nobody says that it is the rotors'.
    """

    armature: Mapping[str, float]
    source: str
    certainty: str
    simulated: bool = False


_SIMULATED = "from a simulation model, not measured: "


def _simulated(armature: Mapping[str, float], source: str, certainty: str) -> PublishedArmature:
    return PublishedArmature(MappingProxyType(dict(armature)), source, _SIMULATED + certainty, simulated=True)


def _servos(joints: tuple[str, ...], certainty: str) -> PublishedArmature:
    return PublishedArmature(
        MappingProxyType(dict.fromkeys(joints, 0.028)),
        "TheRobotStudio/SO-ARM100, Simulation/SO101/so101_new_calib.xml: armature of the class sts3215",
        certainty,
    )


_SO = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
_UR = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
_FRANKA = (0.605721456, 0.605721456, 0.462474144, 0.462474144, 0.205544064, 0.205544064, 0.205544064)

PUBLISHED_ARMATURE: Mapping[str, PublishedArmature] = MappingProxyType(
    {
        "panda": PublishedArmature(
            MappingProxyType({f"panda_joint{k + 1}": value for k, value in enumerate(_FRANKA)}),
            "RobotLocomotion/drake, manipulation/models/franka_description/README.md: Franka's own values for the FR3, "
            "used there for the Panda",
            "the maker's, but for the Panda's successor; MuJoCo Menagerie's FR3 has 0.195 (joints 1 to 4) and 0.074 "
            "(5 to 7), a third of it, without saying from where",
        ),
        "so100": _servos(
            _SO,
            "in the makers' simulation model of the SO-101, which has the same servo (STS3215); how it was found is "
            "not said",
        ),
        "so101": _servos(_SO, "in the makers' own simulation model; how it was found is not said"),
        **{
            name: _simulated(
                dict.fromkeys(_UR, 0.1),
                f"google-deepmind/mujoco_menagerie, universal_robots_{name}e/{name}e.xml: armature of its classes",
                f"one round number at every joint, of the {name.upper()}e, without saying from where",
            )
            for name in ("ur5", "ur10")
        },
        "kinova": _simulated(
            {f"j2s6s200_joint_{k + 1}": value for k, value in enumerate((4.0, 4.0, 4.0, 2.0, 2.0, 2.0))},
            "google-deepmind/dm_control, dm_control/third_party/kinova/jaco_arm.xml: armature of the classes "
            "large_joint and small_joint",
            "one round number for each size of joint, of a Jaco with another wrist, without saying from where; it is "
            "more than all links together",
        ),
        "xarm7": _simulated(
            {f"joint{k + 1}": 0.1 for k in range(7)},
            "google-deepmind/mujoco_menagerie, ufactory_xarm7/xarm7.xml: armature of the class xarm7",
            "one round number at every joint, without saying from where",
        ),
    }
)


def how_to_measure(arm: str) -> str:
    """What to do where nothing is published; ends without a full stop."""
    return HOW_TO_MEASURE + (_AT_UR if arm.startswith("ur") else "")
