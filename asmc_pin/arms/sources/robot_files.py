"""Where the files lie that a robot's description names: ROS packages, and meshes."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from asmc_pin.words.text import printable

MESH_SUFFIXES = (".stl", ".dae", ".obj", ".ply", ".glb", ".gltf", ".off", ".3mf")

_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
_DEEPEST = 5  # folders below an entry of ROS_PACKAGE_PATH
_MOST_FOLDERS = 20_000
_ABOVE = 3  # folders above the description in which a mesh's last names are tried


@dataclass(frozen=True)
class RobotFiles:
    """Finds packages and meshes for one description.

    A package is looked for where the user says, then in the description's folder and all above it, then in
    AMENT_PREFIX_PATH, in ROS_PACKAGE_PATH, and last in `further`.

    Attributes:
        folder: The description's own folder, where relative names start.
        given: Package to folder, as the user says.
        further: Folders that hold packages under their names.
    """

    folder: Path
    given: Mapping[str, Path] = field(default_factory=dict)
    further: Sequence[Path] = ()

    def package(self, name: str) -> Path | None:
        """Folder of a package, None where it lies nowhere that was looked at."""
        if name in self.given:
            return self.given[name]
        if not name or name != Path(name).name or name in (".", ".."):
            return None
        for folder in self._packages(name):
            return folder
        return None

    def mesh(self, filename: str) -> Path:
        """The file that a URDF's mesh name means.

        A URDF may come from anywhere: only what is named like a mesh is looked for. Where it is not at the place that
        is named, the last parts of its name are tried beside the description and a few folders above it: files are
        often moved without their package.

        Raises:
            FileNotFoundError: It lies nowhere that was looked at; the message says what may help.
            ValueError: It is named like no mesh.
        """
        shown = printable(filename)
        if Path(filename).suffix.lower() not in MESH_SUFFIXES:
            raise ValueError(f"'{shown}' is no mesh file that is read ({', '.join(MESH_SUFFIXES)})")
        scheme, _, rest = filename.rpartition("://")
        named = scheme in ("package", "model")
        if named:
            package, _, inside = rest.partition("/")
            places = [self.given[package]] if package in self.given else list(self._packages(package))
            candidates = [place / inside for place in places]
        else:
            candidates = [self.folder / rest]
        for candidate in (*candidates, *self._by_suffix(rest)):
            if candidate.is_file():
                return candidate
        package = printable(rest.partition("/")[0])
        help_ = f" (say where the package lies: --package {package}=DIR)" if named else ""
        raise FileNotFoundError(f"{shown} not found{help_}")

    def _packages(self, name: str) -> Iterator[Path]:
        """Every folder that may be the package, the nearest first."""
        for above in (self.folder, *self.folder.parents):
            if above.name == name or declared_package(above) == name:
                yield above
            if (above / name).is_dir():
                yield above / name
        for prefix in _search_path("AMENT_PREFIX_PATH"):
            if (prefix / "share" / name).is_dir():
                yield prefix / "share" / name
        for entry in _search_path("ROS_PACKAGE_PATH"):
            found = _crawled(entry).get(name)
            if found is not None:
                yield found
        for folder in self.further:
            if folder.name == name:
                yield folder
            if (folder / name).is_dir():
                yield folder / name

    def _by_suffix(self, rest: str) -> Iterator[Path]:
        parts = [part for part in Path(rest).parts if part not in ("/", "..", ".")]
        for start in range(len(parts)):
            for folder in (self.folder, *self.folder.parents)[: 1 + _ABOVE]:
                yield folder.joinpath(*parts[start:])


def declared_package(folder: Path) -> str | None:
    """The name in a folder's package.xml, None where there is none."""
    try:
        with open(folder / "package.xml", "rb") as file:
            match = _NAME.search(file.read(100_000))
    except OSError:
        return None
    return match[1].decode("utf-8", "replace") if match else None


def _search_path(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


@lru_cache(maxsize=16)
def _crawled(entry: Path) -> Mapping[str, Path]:
    """The packages at and below a folder, by the names that their package.xml gives and by their folders' names."""
    found: dict[str, Path] = {}
    by_folder: dict[str, Path] = {}
    for count, (folder, below, _files) in enumerate(os.walk(entry)):
        here = Path(folder)
        name = declared_package(here)
        if name is not None:  # a package holds no others
            found.setdefault(name, here)
            by_folder.setdefault(here.name, here)
            below.clear()
        below[:] = sorted(each for each in below if not each.startswith("."))
        if len(here.relative_to(entry).parts) >= _DEEPEST or count > _MOST_FOLDERS:
            below.clear()
    return {**by_folder, **found}
