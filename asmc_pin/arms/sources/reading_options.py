"""How a file is read: what a xacro file is expanded with, where packages lie, what stands for missing inertia."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.disk.reading import user_path
from asmc_pin.errors import ParameterError
from asmc_pin.words.text import printable

XacroArguments = Mapping[str, "str | float | bool"]
Packages = Mapping[str, "str | Path"]


@dataclass(frozen=True)
class Reading:
    """The options of `load_arm` that say how its file is read, checked.

    Attributes:
        files: Where packages and meshes are looked for.
        xacro: Values of a xacro file's arguments.
        run_xacro: Whether a xacro file may be expanded, which runs what it says.
    """

    files: RobotFiles
    xacro: Mapping[str, str] = field(default_factory=dict)
    run_xacro: bool = True


def read_packages(package: Packages | None) -> dict[str, Path]:
    """Check where the user says that packages lie.

    Raises:
        ParameterError: A folder that is none.
    """
    found: dict[str, Path] = {}
    for name, folder in (package or {}).items():
        path = user_path(folder)
        if not path.is_dir():
            raise ParameterError("package", f"{printable(str(name))}: {printable(str(folder))} is no folder")
        found[str(name)] = path.resolve()
    return found


def read_xacro(xacro: XacroArguments | None) -> dict[str, str]:
    """The arguments of a xacro file as it takes them: text; a truth value is ``true`` or ``false``.

    Raises:
        ParameterError: A value that is neither text nor a number nor a truth value.
    """
    return {str(name): _text(str(name), value) for name, value in (xacro or {}).items()}


def _text(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float | str):
        return str(value)
    raise ParameterError("xacro", f"{printable(name)}: {value!r} given, text or a number expected")
