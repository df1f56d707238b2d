"""A URDF file as text: read within bounds, parsed without expanding entities, and recognised for what it is."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.parsers import expat

from lxml import etree

from asmc_pin.arms.urdf.xml_encoding import decode_xml, without_declared_encoding
from asmc_pin.disk.reading import read_file, shown
from asmc_pin.errors import ArmError
from asmc_pin.words.provisos import Proviso
from asmc_pin.words.text import printable

LARGEST = 20_000_000
"""Bytes of a URDF file at most; the largest of real robots, meshes apart, have some hundred thousand."""

_MOST_ELEMENTS = 200_000
_MOST_ATTRIBUTES = 1_000  # of one element
_DEEPEST = 100  # elements in one another; a URDF's own go to five


@dataclass(frozen=True)
class Document:
    """One URDF file.

    Attributes:
        path: Where it lies.
        text: The file as it stands.
        sha256: Hex digest of its bytes.
        root: The ``<robot>`` element, without comments and processing instructions.
        provisos: In what `text` and `root` are not as the file that was read.
    """

    path: Path
    text: str
    sha256: str
    root: Any
    provisos: tuple[Proviso, ...] = ()


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


def _is_xacro(path: Path, data: bytes, root: Any | None) -> bool:
    if root is None:
        return path.suffix == ".xacro" or b"<xacro:" in data
    # A generated URDF often keeps the namespace declaration; only what still has to be expanded counts.
    for element in root.iter():
        if isinstance(element.tag, str) and "xacro" in element.tag.partition("}")[0]:
            return True
        if any("${" in value or "$(" in value for value in element.attrib.values()):
            return True
    return False


def _drop_namespace(root: Any) -> None:
    """Some tools put the whole URDF into a namespace of theirs (``<robot xmlns="…">``); take it off."""
    space = root.nsmap.get(None)
    if space and str(root.tag).startswith(f"{{{space}}}"):
        for element in root.iter():
            if isinstance(element.tag, str):
                element.tag = element.tag.removeprefix(f"{{{space}}}")


def _recognise(path: Path, root: Any) -> None:
    """Say what a file is that is not a URDF, and how to turn it into one."""
    if root.tag == "robot":
        if root.find("link") is None:
            raise ArmError(
                path,
                f"{shown(path)}: <robot> holds no <link>; a URDF needs at least two links and a joint between them",
            )
        return
    if root.tag in ("mujoco", "mujocoinclude"):
        raise ArmError(
            path,
            f"{shown(path)}: this is a MuJoCo model (MJCF), not a URDF. Use the URDF that its maker publishes, or "
            "convert it: pip install mjcf-urdf-simple-converter, then in Python: "
            "from mjcf_urdf_simple_converter import convert; "
            f"convert('{path.name}', '{path.stem}.urdf'). Check masses, joint axes and limits afterwards",
        )
    if root.tag in ("sdf", "gazebo"):
        raise ArmError(
            path, f"{shown(path)}: this is a Gazebo model (SDF), not a URDF; use the URDF that its maker publishes"
        )
    raise ArmError(path, f"{shown(path)}: the root element is <{printable(str(root.tag))}>, a URDF has <robot>")


def read_document(path: Path) -> Document:
    """Read a URDF file.

    Args:
        path: The file.

    Returns:
        Its text and its parsed tree.

    Raises:
        ArmError: The file cannot be read, is too large or not well-formed, declares entities, or is xacro, MJCF or SDF.
    """
    return document_from(path, read_file(path, LARGEST, "a URDF", lambda text: ArmError(path, text)))


def document_from(path: Path, content: bytes) -> Document:
    """The same of what stands in a file already; see `read_document`."""
    text = decode_xml(path, content)
    # Both parsers see the same bytes: what one reads otherwise than the other is a way past the first.
    data = without_declared_encoding(text).encode("utf-8")
    _scan(path, data)
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        remove_comments=True,
        remove_pis=True,
    )
    root: Any | None
    try:
        root = etree.fromstring(data, parser)
        problem = ""
    except etree.XMLSyntaxError as error:
        root, problem = None, printable(str(error))
    if _is_xacro(path, data, root):
        stem = path.name.removesuffix(".xacro").removesuffix(".urdf")
        if path.name == f"{stem}.urdf":  # the shell empties the target before xacro reads it
            stem += "_expanded"
        raise ArmError(
            path,
            f"{shown(path)}: this is a xacro file, a template for a URDF. Expand it first: "
            f"xacro {path.name} > {stem}.urdf (ROS brings xacro, and so does pip install xacro)",
        )
    if root is None:
        raise ArmError(path, f"{shown(path)}: not well-formed XML ({problem})")
    _drop_namespace(root)
    _recognise(path, root)
    return Document(path=path, text=text, sha256=hashlib.sha256(content).hexdigest(), root=root)
