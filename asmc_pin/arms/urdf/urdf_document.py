"""A URDF file as text: read within bounds, parsed without expanding entities, and recognised for what it is."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.parsers import expat

from lxml import etree

from asmc_pin.arms.sources.reading_options import Reading
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.mjcf_conversion import MjcfModel, can_convert, converted
from asmc_pin.arms.urdf.xacro_expansion import expand, name_meshes_by_package
from asmc_pin.arms.urdf.xml_encoding import decode_xml, with_known_version, without_declared_encoding
from asmc_pin.disk.reading import read_file, shown
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.words.provisos import CONVERTED_MJCF, Proviso
from asmc_pin.words.text import printable

LARGEST = 20_000_000
"""Bytes of a URDF file at most; the largest of real robots, meshes apart, have some hundred thousand."""

_MOST_ELEMENTS = 200_000
_MOST_ATTRIBUTES = 1_000  # of one element
_MJCF = ("mujoco", "mujocoinclude")
_DEEPEST = 100  # elements in one another; a URDF's own go to five


@dataclass(frozen=True)
class Document:
    """One URDF file.

    Attributes:
        path: Where it lies.
        text: A URDF that every reader takes as `root`: the file as it stands; or, where that is not enough (a xacro
            file, namespaces that are none of a URDF's, inertias put in), one written anew.
        sha256: Hex digest of the bytes that were read.
        root: The ``<robot>`` element, without comments and processing instructions.
        provisos: In what `text` and `root` are not as the file that was read.
        expanded: Whether it was a xacro file or MJCF, so that line numbers are none of its own.
        mjcf: What MuJoCo made of the file, where it was MJCF.
        densities: Of the links whose inertia was estimated, the density that this means, kg/m³.
    """

    path: Path
    text: str
    sha256: str
    root: Any
    provisos: tuple[Proviso, ...] = ()
    expanded: bool = False
    mjcf: MjcfModel | None = None
    densities: Mapping[str, float] = field(default_factory=dict)

    def rewritten(self, *provisos: Proviso) -> Document:
        """The same with `root` as the text, after a change to it that these provisos tell of."""
        etree.cleanup_namespaces(self.root)
        text = etree.tostring(self.root, encoding="unicode", with_tail=False) + "\n"
        return replace(self, text=text, provisos=(*self.provisos, *provisos))


class _Refused(Exception):
    """Not well formed within our bounds; the message says why."""


class _Scan:
    """What expat calls on its way through a file, to refuse what no URDF has before a tree of it is built."""

    def __init__(self) -> None:
        self.parser = expat.ParserCreate("utf-8")
        self.parser.EntityDeclHandler = self._entity
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self._elements = self._depth = 0

    def _entity(self, name: str, *_: object) -> None:
        raise _Refused(
            f"the XML declares the entity '{printable(name)}'; entities are not expanded here, because they can read "
            "other files or grow without end. Replace each &name; by its value and remove the <!ENTITY …> lines"
        )

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._elements += 1
        self._depth += 1
        line = self.parser.CurrentLineNumber
        if self._elements > _MOST_ELEMENTS:
            raise _Refused(f"more than {_MOST_ELEMENTS} elements; no robot has as many, so it is not read")
        if self._depth > _DEEPEST:
            raise _Refused(f"line {line}: elements in one another more than {_DEEPEST} deep; a URDF's go to five")
        if len(attributes) > _MOST_ATTRIBUTES:
            raise _Refused(f"line {line}: <{printable(tag)}> has {len(attributes)} attributes; a URDF's have six")

    def _end(self, _tag: str) -> None:
        self._depth -= 1


def _scan(path: Path, data: bytes) -> None:
    """Refuse malformed XML and any entity declaration, before a parser that would expand one sees the file.

    lxml can leave entities alone in text, but libxml2 still expands them in attribute values, where a URDF keeps its
    numbers.
    """
    parser = _Scan().parser
    try:
        parser.Parse(data, True)
    except _Refused as refused:
        raise ArmError(path, f"{shown(path)}: {refused}") from None
    except expat.ExpatError as error:
        raise ArmError(
            path,
            f"{shown(path)}: line {error.lineno}, column {error.offset + 1}: not well-formed XML "
            f"({expat.errors.messages[error.code]}). Mend the file there; `xmllint --noout FILE` shows the same place",
        ) from None


def _is_xacro(root: Any) -> bool:
    # A generated URDF often keeps the namespace declaration; only what still has to be expanded counts.
    for element in root.iter():
        if isinstance(element.tag, str) and "xacro" in element.tag.partition("}")[0]:
            return True
        if any("${" in value or "$(" in value for value in element.attrib.values()):
            return True
    return False


def _drop_namespaces(root: Any) -> bool:
    """Leave what Pinocchio's reader, which knows no namespaces, takes for a URDF's; say whether anything was another.

    A default namespace (``<robot xmlns="…">``) is an attribute like any other to it, and a name with a prefix is none
    of a URDF's elements.
    """
    changed = False
    for element in [each for each in root.iter() if isinstance(each.tag, str)]:
        _space, brace, local = element.tag.rpartition("}")
        if brace and element.prefix is None:
            element.tag = local
            changed = True
        elif ":" in local and element is not root:  # an undeclared prefix
            element.getparent().remove(element)
            changed = True
        for key in [key for key in element.attrib if ":" in key.rpartition("}")[2]]:
            del element.attrib[key]
            changed = True
    # A prefix that nobody uses may stand for anything, which the next reader of the tree would judge.
    etree.cleanup_namespaces(root)
    return changed


def _recognise(path: Path, root: Any, expanded: bool) -> None:
    """Say what a file is that is not a URDF, and how to turn it into one."""
    if root.tag == "robot":
        if root.find("link") is None and expanded:
            raise ArmError(
                path,
                f"{shown(path)}: this xacro file, expanded, holds no <link>: it only defines macros. Give the file "
                "that calls them, often named …urdf.xacro",
            )
        if root.find("link") is None:
            raise ArmError(
                path,
                f"{shown(path)}: <robot> holds no <link>; a URDF needs at least two links and a joint between them",
            )
        return
    if root.tag in _MJCF:
        raise ArmError(
            path,
            f"{shown(path)}: this is a MuJoCo model (MJCF), not a URDF, and MuJoCo, which would read it, is not "
            "installed: pip install 'asmc-pin[agree]'. Or use the URDF that its maker publishes, or "
            "convert it: pip install mjcf-urdf-simple-converter, then in Python: "
            "from mjcf_urdf_simple_converter import convert; "
            f"convert('{path.name}', '{path.stem}.urdf'). Check masses, joint axes and limits afterwards",
        )
    if root.tag in ("sdf", "gazebo"):
        raise ArmError(
            path, f"{shown(path)}: this is a Gazebo model (SDF), not a URDF; use the URDF that its maker publishes"
        )
    raise ArmError(path, f"{shown(path)}: the root element is <{printable(str(root.tag))}>, a URDF has <robot>")


def read_document(path: Path, reading: Reading | None = None) -> Document:
    """Read a URDF, or a xacro file, which is expanded.

    Args:
        path: The file.
        reading: How a xacro file is expanded; with no arguments when omitted.

    Returns:
        Its text and its parsed tree.

    Raises:
        ArmError: The file cannot be read, is too large or not well-formed, declares entities, is a xacro file that
            cannot be expanded, or is MJCF or SDF.
        ParameterError: Arguments for a xacro file that is none, or that it does not know.
    """
    content = read_file(path, LARGEST, "a URDF", lambda text: ArmError(path, text))
    sha256 = hashlib.sha256(content).hexdigest()
    text = decode_xml(path, content)
    root = _parsed(path, text)
    provisos: tuple[Proviso, ...] = ()
    expanded = _is_xacro(root)
    if expanded:
        reading = Reading(RobotFiles(path.resolve().parent)) if reading is None else reading
        if not reading.run_xacro:
            raise ArmError(
                path,
                f"{shown(path)}: a xacro file is a program, and where somebody else's file may name it, none is run. "
                "Expand it yourself (xacro FILE > FILE.urdf) and name the URDF",
            )
        text, proviso = expand(path, reading.xacro, reading.files)
        provisos = (proviso,)
        root = _parsed(path, text)
        name_meshes_by_package(root, reading.files)
        if _is_xacro(root):
            raise ArmError(path, f"{shown(path)}: something of xacro is left in it after it was expanded; correct it")
    elif reading is not None and reading.xacro:
        raise ParameterError("xacro", f"{printable(path.name)} is no xacro file and takes no arguments; leave them out")
    changed = _drop_namespaces(root)
    mjcf = converted(path) if root.tag in _MJCF and can_convert() else None
    if mjcf is not None:
        provisos = (*provisos, Proviso(CONVERTED_MJCF, f"{printable(path.name)}, as MuJoCo reads it"))
        text, expanded = mjcf.text, True
        root = _parsed(path, text)
    _recognise(path, root, expanded)
    document = Document(path=path, text=text, sha256=sha256, root=root, provisos=provisos, expanded=expanded, mjcf=mjcf)
    return document.rewritten() if changed or expanded or with_known_version(text) != text else document


def parsed_again(path: Path, text: str, sha256: str, provisos: tuple[Proviso, ...], mjcf: MjcfModel | None) -> Document:
    """The document that a text of `Document.text` belongs to."""
    root = _parsed(path, text)
    _drop_namespaces(root)
    return Document(path=path, text=text, sha256=sha256, root=root, provisos=provisos, mjcf=mjcf)


def read_again(urdf: str) -> Any:
    """The tree of an arm's `urdf_text`, which was read before; what the first reading forgave is forgiven here too."""
    return etree.fromstring(with_known_version(without_declared_encoding(urdf)).encode("utf-8"), _parser())


def _parser() -> Any:
    return etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        remove_comments=True,
        remove_pis=True,
        recover=True,
    )


def _parsed(path: Path, text: str) -> Any:
    """The tree of an XML text, with nothing expanded and nothing fetched."""
    # Both parsers see the same bytes: what one reads otherwise than the other is a way past the first.
    data = with_known_version(without_declared_encoding(text)).encode("utf-8")
    if len(data) > 2 * LARGEST:
        raise ArmError(path, f"{shown(path)}: expands to {len(data) / 1e6:.4g} MB; no robot has as much")
    _scan(path, data)
    parser = _parser()
    root = etree.fromstring(data, parser)
    # Well-formed but for prefixes that nobody declared, which Pinocchio does not mind.
    wrong = [entry for entry in parser.error_log if entry.domain_name != "NAMESPACE"]
    if root is None or wrong:
        said = wrong[0].message if wrong else "nothing in it"
        raise ArmError(path, f"{shown(path)}: not well-formed XML ({printable(said)})")
    return root
