"""The arms that are known by name, where they come from and on which terms."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from types import MappingProxyType
from typing import Any

from asmc_pin.arms.sources.named_descriptions import described, hint
from asmc_pin.disk.reading import user_path
from asmc_pin.disk.resources import shipped
from asmc_pin.errors import ArmError
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.text import printable


@dataclass(frozen=True)
class ArmEntry:
    """One arm known by name.

    Attributes:
        name: The name that `load_arm` takes.
        description: What it is, in one line.
        origin: Where its URDF comes from.
        licence: Licence of the URDF, as its origin states it.
        file: The URDF, relative to the folder that `shipped` says.
        shipped: Whether the URDF travels with this package; else it is in example-robot-data.
        locks: Joints locked unless the caller frees them, rad (m where prismatic).
        armature: Reflected rotor inertia that belongs to the arm, by joint, kg·m² (a URDF has no place for it).
        xacro: What its file is expanded with, where that is a xacro file.
    """

    name: str
    description: str
    origin: str
    licence: str
    file: str
    shipped: bool = False
    locks: Mapping[str, float] = field(default_factory=dict)
    armature: Mapping[str, float] = field(default_factory=dict)
    xacro: Mapping[str, str] = field(default_factory=dict)

    def path(self) -> Path:
        """The URDF file on this machine."""
        return (shipped("urdf") if self.shipped else _robots()) / self.file


def _share() -> Path:
    try:
        return Path(str(distribution("example-robot-data").locate_file("cmeel.prefix/share")))
    except PackageNotFoundError:
        raise ArmError(
            "example-robot-data",
            "the arms known by name lie in the package example-robot-data, which is not installed; "
            "pip install example-robot-data, or give the path of a URDF",
        ) from None


def _robots() -> Path:
    return _share() / "example-robot-data" / "robots"


_UR = "ros-industrial/universal_robot, kinetic-devel"
_SO = "TheRobotStudio/SO-ARM100"
_EXAMPLE_ROBOT_DATA = (
    ArmEntry("ur3", "Universal Robots UR3, six axes", _UR, "BSD", "ur_description/urdf/ur3_robot.urdf"),
    ArmEntry("ur5", "Universal Robots UR5, six axes", _UR, "BSD", "ur_description/urdf/ur5_robot.urdf"),
    ArmEntry("ur10", "Universal Robots UR10, six axes", _UR, "BSD", "ur_description/urdf/ur10_robot.urdf"),
    ArmEntry(
        "panda",
        "Franka Emika Panda, seven axes, hand with its fingers locked",
        "frankaemika/franka_ros, noetic-devel",
        "Apache-2.0",
        "panda_description/urdf/panda.urdf",
        locks={"panda_finger_joint1": 0.0},  # the other finger mimics it
    ),
    ArmEntry(
        "kinova",
        "Kinova Jaco j2s6s200, six axes of which three are continuous",
        "Kinovarobotics/kinova-ros, melodic-devel",
        "BSD",
        "kinova_description/robots/kinova.urdf",
    ),
    ArmEntry(
        "xarm7",
        "UFACTORY xArm7, seven axes",
        "xArm-Developer/xarm_ros2",
        "BSD-3-Clause",
        "xarm_description/urdf/xarm7.urdf",
    ),
    ArmEntry(
        "z1",
        "Unitree Z1, six axes, gripper locked",
        "unitreerobotics/unitree_ros, z1_description",
        "MPL-2.0",
        "z1_description/urdf/z1.urdf",
        locks={"jointGripper": 0.0},
    ),
    ArmEntry(
        "so100",
        "Standard Open Arm SO-100, five axes, gripper locked",
        _SO,
        "Apache-2.0",
        "so_arm_description/urdf/so100.urdf",
        locks={"gripper": 0.0},
    ),
    ArmEntry(
        "so101",
        "Standard Open Arm SO-101, five axes, gripper locked",
        _SO,
        "Apache-2.0",
        "so_arm_description/urdf/so101.urdf",
        locks={"gripper": 0.0},
    ),
    ArmEntry(
        "double_pendulum",
        "Planar double pendulum, two axes",
        "example-robot-data, original work",
        "BSD",
        "double_pendulum_description/urdf/double_pendulum.urdf",
    ),
    ArmEntry(
        "two_dofs",
        "qbmove two-joint arm, axes vertical",
        "qbrobotics/qbmove-ros, qb_move_description",
        "BSD-3-Clause",
        "asr_twodof_description/urdf/TwoDofs.urdf",
    ),
)


def _entry(source: Path) -> ArmEntry:
    values: dict[str, Any] = tomllib.loads(source.read_text(encoding="utf-8"))
    return ArmEntry(
        name=values["name"],
        description=values["description"],
        origin=values["origin"],
        licence=values["licence"],
        file=f"{source.parent.name}/{values['urdf']}",
        shipped=True,
        locks=values.get("locks", {}),
        armature=values.get("armature", {}),
    )


def _registry() -> Mapping[str, ArmEntry]:
    own = (_entry(source) for source in sorted(shipped("urdf").glob("*/SOURCE.toml")))
    return MappingProxyType({entry.name: entry for entry in (*own, *_EXAMPLE_ROBOT_DATA)})


ARMS: Mapping[str, ArmEntry] = _registry()


def arm_names() -> list[str]:
    """Names that `load_arm` takes, shipped arms first."""
    return list(ARMS)


def package_shares() -> tuple[Path, ...]:
    """Folders in which packages lie that a URDF's meshes may name: example-robot-data's, where it is installed."""
    try:
        return (_share(),)
    except ArmError:
        return ()


def find(source: str | Path) -> tuple[Path, ArmEntry | None]:
    """The URDF that a name or a path stands for.

    Args:
        source: Name of a known arm or of one of robot_descriptions, or path of a URDF or xacro file.
            A known arm's name wins over a file of that name; write ``./ur5`` for it.

    Returns:
        The path, and the registry's entry where it was a name.

    Raises:
        ArmError: Neither a known name nor an existing file; the message lists the nearest names.
    """
    if isinstance(source, str) and source in ARMS:
        entry = ARMS[source]
        return entry.path(), entry
    path, text = user_path(source), printable(str(source))
    try:
        there = path.exists()
    except OSError as error:
        raise ArmError(source, f"{text}: cannot be read ({error.strerror})") from None
    if there:
        return path, None
    if isinstance(source, str) and (description := described(source)) is not None:
        origin = "robot_descriptions"
        file = str(description.path.resolve())
        return Path(file), ArmEntry(source, origin, origin, "of its origin", file, xacro=description.xacro)
    if "/" in text or "\\" in text or path.suffix:
        raise ArmError(
            source, f"{text}: no such file. Give the path of a URDF, or the name of an arm ({', '.join(ARMS)})"
        )
    raise ArmError(
        source,
        f"'{text}' is neither an arm's name nor a file; {nearest(text, arm_names())} (`asmc-pin arms` lists them)"
        + hint(text),
    )
