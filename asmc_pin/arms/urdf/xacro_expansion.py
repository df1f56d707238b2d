"""Expanding a xacro file to a URDF, with no ROS: `xacro` expands it, and `xacrodoc` has it look for packages.

A xacro file is a program: it computes, and reads the files and variables that it names.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from asmc_pin.arms.sources.robot_files import RobotFiles, declared_package
from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.provisos import EXPANDED_XACRO, Proviso
from asmc_pin.words.text import printable

_MOST_PACKAGES = 100


class _Arguments(dict[str, str]):
    """Arguments that know which of them the files asked for."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def expand(path: Path, arguments: Mapping[str, str], files: RobotFiles) -> tuple[str, Proviso]:
    """Expand a xacro file.

    Args:
        path: The file.
        arguments: Values of its ``<xacro:arg>``.
        files: Finds the packages of ``$(find …)``.

    Returns:
        The URDF's text; and from what it was expanded.

    Raises:
        ArmError: It cannot be expanded; the message says why, and which argument or package is missing.
        ParameterError: An argument that none of its files knows.
    """
    import xacro
    from xacrodoc import packages

    declared: set[str] = set()
    with _package_search(packages, files), _bare_declarations(xacro, declared):
        for _ in range(_MOST_PACKAGES):
            given = _Arguments(arguments)
            already = len(xacro.all_includes)
            try:
                # What xacro has to say on the terminal is about how the file is written.
                with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                    dom = xacro.process_file(str(path), mappings=given)
            except Exception as error:  # xacro lets through whatever an expression raises
                cause = _cause(error)
                if not isinstance(cause, packages.PackageNotFoundError):
                    raise ArmError(path, _why(path, error, cause, xacro) + _arguments(given, arguments)) from None
                packages.update_package_cache({str(cause.args[0]): _package(path, str(cause.args[0]), files)})
                continue
            read = list(dict.fromkeys(xacro.all_includes[already:]))
            break
        else:
            raise ArmError(path, f"{shown(path)}: names more than {_MOST_PACKAGES} packages; no robot needs as many")
    unknown = [name for name in arguments if name not in given.asked | declared]
    if unknown:
        known = sorted((given.asked | declared) - set(unknown))
        told = f"no argument '{printable(unknown[0])}' in {printable(path.name)}; {nearest(unknown[0], known)}"
        raise ParameterError("xacro", told)
    text: str = dom.toxml()
    return text, Proviso(EXPANDED_XACRO, _provenance(path, arguments, read))


def name_meshes_by_package(root: Any, files: RobotFiles) -> None:
    """Name the meshes of an expanded file as they can be found elsewhere too, and without its user's folders.

    ``$(find …)`` leaves absolute paths; those inside a package become ``package://``, those beside the file relative.

    Args:
        root: The expanded tree, changed in place.
        files: Of the file that was expanded.
    """
    for mesh in root.iter("mesh"):
        scheme, _, rest = mesh.get("filename", "").rpartition("://")
        path = Path(rest)
        if scheme not in ("", "file") or not path.is_absolute():
            continue
        for above in path.parents:
            name = next((name for name, place in files.given.items() if place == above), declared_package(above))
            if name is not None:
                mesh.set("filename", f"package://{name}/{path.relative_to(above).as_posix()}")
                break
            if above == files.folder:
                mesh.set("filename", path.relative_to(above).as_posix())
                break


@contextlib.contextmanager
def _package_search(packages: Any, files: RobotFiles) -> Iterator[None]:
    """Xacrodoc keeps one search for the whole process; nothing of ours stays in it."""
    packages.reset()
    packages.update_package_cache(dict(files.given))
    try:
        yield
    finally:
        packages.reset()


@contextlib.contextmanager
def _bare_declarations(xacro: Any, declared: set[str]) -> Iterator[None]:
    """Let files declare an argument without a default, which xacro refuses: whoever asks for it has to be given it.

    Args:
        xacro: The module; its reader of files is another one in the block.
        declared: Gets the names of such arguments.
    """
    read = xacro.parse

    def parse(*given: Any, **named: Any) -> Any:
        tree = read(*given, **named)
        for element in list(tree.getElementsByTagName("xacro:arg")):
            if element.hasAttribute("name") and not element.hasAttribute("default"):
                declared.add(element.getAttribute("name"))
                element.parentNode.removeChild(element)
        return tree

    xacro.parse = parse
    try:
        yield
    finally:
        xacro.parse = read


def _package(path: Path, name: str, files: RobotFiles) -> Path:
    found = files.package(name)
    if found is None:
        raise ArmError(
            path,
            f"{shown(path)}: needs the package '{printable(name)}', which is neither above this file nor in "
            f"AMENT_PREFIX_PATH or ROS_PACKAGE_PATH; say where it lies: --package {printable(name)}=DIR "
            f"(package={{'{printable(name)}': DIR}} in Python)",
        )
    return found


def _cause(error: Exception) -> Exception:
    """What is wrong at the bottom of it: xacro wraps an error once for each expression that it is in."""
    while isinstance(inner := getattr(error, "exc", None), Exception):
        error = inner
    return error


def _why(path: Path, error: Exception, cause: Exception, xacro: Any) -> str:
    name = printable(str(cause.args[0])) if cause.args else ""
    if type(cause).__name__ == "ArgException":
        return (
            f"{shown(path)}: this xacro file needs the argument '{name}'; give it: --xacro {name}=VALUE "
            f"(xacro={{'{name}': VALUE}} in Python)"
        )
    if "unbound prefix" in str(error):
        return (
            f"{shown(path)}: xacro cannot expand this file: it uses a prefix that nothing declares; write "
            '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" …>'
        )
    inside = [str(each) for each in (xacro.filestack or [])[1:] if each]
    where = f", in {printable(inside[-1])}" if inside else ""
    said = printable(" ".join(str(error).split())) or type(error).__name__
    return f"{shown(path)}: xacro cannot expand this file{where}: {said}"


def _arguments(given: _Arguments, arguments: Mapping[str, str]) -> str:
    """What the file was asked with, where that may be what is wrong."""
    unasked = [printable(name) for name in arguments if name not in given.asked]
    taken = [f"{printable(name)}={printable(given[name])}" for name in sorted(given.asked) if name in given]
    said = f". Its arguments: {', '.join(taken)}" if taken else ""
    return said + (f"; it did not ask for {', '.join(unasked)}" if unasked else "")


def _provenance(path: Path, arguments: Mapping[str, str], read: list[str]) -> str:
    """The files with their hashes, and the arguments."""
    given = ", ".join(f"{printable(name)}={printable(value)}" for name, value in arguments.items())
    said = f"{printable(path.name)} with {given or 'no arguments'}"
    others = [f"{printable(Path(each).name)} (SHA-256 {_digest(Path(each))[:16]}…)" for each in read]
    return said + (f"; read with it: {', '.join(others)}" if others else "")


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
