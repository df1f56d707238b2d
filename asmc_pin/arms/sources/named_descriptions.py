"""Robots named as in the package robot_descriptions, where that is installed; it fetches a robot on first use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from asmc_pin.errors import ArmError
from asmc_pin.words.text import printable

_PACKAGE = "robot_descriptions"
_ENDING = "_description"


@dataclass(frozen=True)
class NamedDescription:
    """What robot_descriptions says of a robot.

    Attributes:
        path: Its URDF or xacro file.
        xacro: Arguments that the xacro file is meant to be expanded with.
    """

    path: Path
    xacro: Mapping[str, str]


def described(name: str) -> NamedDescription | None:
    """The description of that name, None where the package is not installed or has none.

    Raises:
        ArmError: It is there and cannot be had (it is fetched from the network), or is no URDF.
    """
    if not name.endswith(_ENDING) or not name.isidentifier() or find_spec(_PACKAGE) is None:
        return None
    if find_spec(f"{_PACKAGE}.{name}") is None:
        return None
    try:
        module = import_module(f"{_PACKAGE}.{name}")
    except Exception as error:  # it clones a repository as it is imported
        said = printable(" ".join(str(error).split())) or type(error).__name__
        raise ArmError(name, f"'{name}': robot_descriptions has it, and could not fetch it: {said}") from None
    for attribute in ("URDF_PATH", "XACRO_PATH"):
        if hasattr(module, attribute):
            arguments = getattr(module, "XACRO_ARGS", {}) if attribute == "XACRO_PATH" else {}
            return NamedDescription(
                Path(getattr(module, attribute)), {str(key): str(value) for key, value in arguments.items()}
            )
    raise ArmError(name, f"'{name}': robot_descriptions has no URDF of it; take one of another name, or a URDF's path")


def hint(name: str) -> str:
    """What to add to the message that a name is unknown."""
    if not name.endswith(_ENDING):
        return ""
    if find_spec(_PACKAGE) is None:
        return ". It looks like a name of robot_descriptions: pip install robot_descriptions"
    return ". robot_descriptions, which is installed, has none of that name either"
