"""What was repaired in a URDF, as the repaired text itself says: so that it says so wherever it goes.

The text holds ``<asmc_pin_repair sha256="…">`` with a ``<tensor link="…" ixx="…" …/>`` for each link, the six numbers
as they were before. Readers of URDF pass such elements over.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from lxml import etree

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.urdf_document import Document
from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError
from asmc_pin.words.provisos import Proviso
from asmc_pin.words.text import as_number, quoted

ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Attributes of ``<inertia>``, in the order in which six numbers stand for a tensor."""

_TAG, _PART = "asmc_pin_repair", "tensor"
_SHA256 = re.compile(r"[0-9a-f]{64}")


def write_repair(root: Any, sha256: str, tensors: dict[str, Array]) -> None:
    """Put new tensors into a URDF's tree, and what was there before into its record.

    Args:
        root: Its ``<robot>`` element; changed.
        sha256: Hash of the URDF before.
        tensors: New tensors by link, in the axes in which the old ones are written, shape (3, 3), kg·m².
    """
    record = etree.SubElement(root, _TAG, sha256=sha256)
    for link in root.findall("link"):
        new = tensors.get(link.get("name"))
        if new is None:
            continue
        written = link.find("inertial/inertia")
        before = {entry: written.get(entry, "0") for entry in ENTRIES}
        etree.SubElement(record, _PART, link=link.get("name"), **before)
        for entry, value in zip(ENTRIES, new[np.triu_indices(3)].tolist(), strict=True):
            written.set(entry, repr(value))


def read_repair(document: Document) -> tuple[Proviso, ...]:
    """What a URDF's text says of its own repair, a proviso for each link.

    Raises:
        ArmError: The record is not one of ours.
    """
    records = document.root.findall(_TAG)
    if not records:
        return ()
    links = {link.get("name"): link for link in document.root.findall("link")}
    try:
        parts = [(part, _digest(record)) for record in records for part in record.findall(_PART) or [record]]
        return tuple(_changed(part, links[part.get("link")].find("inertial/inertia"), sha) for part, sha in parts)
    except (KeyError, ValueError, AttributeError):
        raise ArmError(
            document.path,
            f"{shown(document.path)}: line {records[0].sourceline}: <{_TAG}> does not say what was repaired; remove it",
        ) from None


def _changed(part: Any, written: Any, digest: str) -> Proviso:
    before, after = _six(part), _six(written)
    change, size = _frobenius(np.subtract(after, before).tolist()), _frobenius(before)
    share = f", {100.0 * change / size:.2g} % of it" if size > 0.0 else ""
    link = quoted(part.get("link"))
    return Proviso(
        "repaired inertia",
        f"tensor of {link} changed by {change:.3g} kg·m²{share}, to the nearest possible one (URDF before: "
        f"{digest[:16]}…)",
    )


def _digest(record: Any) -> str:
    digest: str = record.attrib["sha256"]
    if not _SHA256.fullmatch(digest):
        raise ValueError(digest)
    return digest


def _six(element: Any) -> list[float]:
    return [as_number(element.get(entry, "0")) for entry in ENTRIES]


def _frobenius(six: list[float]) -> float:
    xx, xy, xz, yy, yz, zz = six
    return math.hypot(xx, yy, zz, *(math.sqrt(2.0) * product for product in (xy, xz, yz)))
