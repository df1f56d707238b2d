"""What robots take before they stop: limits of torque, torque rate and velocity that somebody has published.

Only figures with a source stand here; what nobody published is None, and is not judged. An addition is one entry.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class PublishedLimit:
    """One limit of one robot.

    Attributes:
        values: Joint by joint, base first, positive: N·m, N·m/s or rad/s.
        source: The document that says so, by its title.
    """

    values: tuple[float, ...]
    source: str


@dataclass(frozen=True)
class RobotLimits:
    """What is published of one robot, whose joints all turn.

    Attributes:
        robot: Maker and model.
        torque: Largest torque, N·m; None where it is not published.
        torque_rate: Largest change of the torque, N·m/s; None where it is not published.
        velocity: Largest speed, rad/s; None where it is not published.
    """

    robot: str
    torque: PublishedLimit | None = None
    torque_rate: PublishedLimit | None = None
    velocity: PublishedLimit | None = None

    @property
    def published(self) -> Mapping[str, PublishedLimit]:
        """What there is, by the name of the quantity."""
        named = {name: getattr(self, name) for name in LIMITED_QUANTITIES}
        return {name: limit for name, limit in named.items() if limit is not None}

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(next(iter(self.published.values())).values)


LIMITED_QUANTITIES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {"torque": ("torque", "N·m"), "torque_rate": ("torque rate", "N·m/s"), "velocity": ("velocity", "rad/s")}
)
"""What a limit may be of: words and unit."""

_FCI = "Franka Control Interface documentation, 'Robot and interface specifications'"
_FR3 = f"{_FCI}, limits for Franka Research 3; franka_description, joint limits of the fr3"
_UR = "Universal Robots, support article 'Max. joint torques', as cited by the maker's ROS 2 description"
_IIWA7 = "KUKA LBR iiwa 7 R800, axis data, as in lbr_fri_ros2_stack, joint limits of the iiwa7"
_IIWA14 = "KUKA, 'LBR iiwa 7 R800, LBR iiwa 14 R820 Specification', axis data, as cited by Drake (iiwa_constants)"
_BROCHURE = "KUKA, brochure 'Sensitive robotics, LBR iiwa', axis data, as cited by Drake (iiwa_description)"
_GEN3 = "KINOVA Gen3 Ultra lightweight robot, user guide, actuator safety items: threshold of the error"
_SO = "TheRobotStudio/SO-ARM100, README, footnote on the STS3215: stall torque"
_G = 9.80665
"""m/s²: a servo's torque is printed in kg·cm."""


def _rad(degrees: Sequence[float]) -> tuple[float, ...]:
    return tuple(math.radians(x) for x in degrees)


def _ur(model: str, torque: Sequence[float], speed: Sequence[float]) -> RobotLimits:
    manual = f"Universal Robots, user manual of the {model}, as cited by the maker's ROS 2 description"
    return RobotLimits(
        f"Universal Robots {model}",
        torque=PublishedLimit(tuple(torque), _UR),
        velocity=PublishedLimit(_rad(speed), manual),
    )


def _so(model: str, kg_cm: float, volts: str, speed: PublishedLimit | None = None) -> RobotLimits:
    torque = PublishedLimit((kg_cm * _G / 100.0,) * 5, f"{_SO}, {kg_cm:g} kg·cm {volts}")
    return RobotLimits(f"{model}, servos STS3215 {volts}", torque=torque, velocity=speed)


_SMALL_UR = ((56.0, 56.0, 28.0, 12.0, 12.0, 12.0), (180.0, 180.0, 180.0, 360.0, 360.0, 360.0))
_MIDDLE_UR = ((150.0, 150.0, 150.0, 28.0, 28.0, 28.0), (180.0,) * 6)
_LARGE_UR = ((330.0, 330.0, 150.0, 56.0, 56.0, 56.0), (120.0, 120.0, 180.0, 180.0, 180.0, 180.0))
_SO_SPEED = PublishedLimit(
    (45.0 * 2.0 * math.pi / 60.0,) * 5, "Feetech STS3215, 12 V: no-load speed of 45 turns a minute, by its data sheet"
)

ROBOT_LIMITS: Mapping[str, RobotLimits] = MappingProxyType(
    {
        "panda": RobotLimits(
            "Franka Emika Panda (FER)",
            torque=PublishedLimit((87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0), f"{_FCI}, limits for Panda"),
            torque_rate=PublishedLimit((1000.0,) * 7, f"{_FCI}, limits for Panda"),
            velocity=PublishedLimit((2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61), f"{_FCI}, limits for Panda"),
        ),
        "fr3": RobotLimits(
            "Franka Research 3",
            torque=PublishedLimit((87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0), _FR3),
            torque_rate=PublishedLimit((1000.0,) * 7, _FR3),
            velocity=PublishedLimit((2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26), _FR3),
        ),
        "ur3": _ur("UR3 (CB3)", *_SMALL_UR),
        "ur5": _ur("UR5 (CB3)", *_MIDDLE_UR),
        "ur10": _ur("UR10 (CB3)", *_LARGE_UR),
        "ur3e": _ur("UR3e", *_SMALL_UR),
        "ur5e": _ur("UR5e", *_MIDDLE_UR),
        "ur10e": _ur("UR10e", *_LARGE_UR),
        "iiwa7": RobotLimits(
            "KUKA LBR iiwa 7 R800",
            velocity=PublishedLimit(_rad((98.0, 98.0, 100.0, 130.0, 140.0, 180.0, 180.0)), _IIWA7),
        ),
        "iiwa14": RobotLimits(
            "KUKA LBR iiwa 14 R820",
            torque=PublishedLimit((320.0, 320.0, 176.0, 176.0, 110.0, 40.0, 40.0), _BROCHURE),
            velocity=PublishedLimit(_rad((85.0, 85.0, 100.0, 75.0, 130.0, 135.0, 135.0)), _IIWA14),
        ),
        "gen3": RobotLimits(
            "Kinova Gen3, seven joints, as delivered",
            torque=PublishedLimit((104.5,) * 4 + (51.3,) * 3, _GEN3),
            velocity=PublishedLimit(_rad((120.0,) * 4 + (200.0,) * 3), _GEN3),
        ),
        "xarm7": RobotLimits(
            "UFACTORY xArm 7",
            velocity=PublishedLimit(
                _rad((180.0,) * 7), "UFACTORY, user manual, technical specifications: maximum joint speed"
            ),
        ),
        "so100": _so("SO-100", 16.5, "at 6 V"),
        "so101": _so("SO-101", 16.5, "at 6 V"),
        "so100_12v": _so("SO-100", 30.0, "at 12 V", _SO_SPEED),
        "so101_12v": _so("SO-101", 30.0, "at 12 V", _SO_SPEED),
    }
)
