"""The URDF that goes along with a result, in place of a xacro file that would have to be run again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asmc_pin.words.provisos import EXPANDED_XACRO, Proviso


@dataclass(frozen=True)
class CarriedUrdf:
    """What a result says of an arm that came from a xacro file.

    Attributes:
        path: The URDF that was computed with.
        sha256: Hex digest of the xacro file as it was then.
        provisos: In what the arm was not as its file said.
    """

    path: Path
    sha256: str
    provisos: tuple[Proviso, ...]


def carried_urdf(path: Path, told: Mapping[str, Any]) -> CarriedUrdf | None:
    """The URDF beside a result, if its arm came from a xacro file.

    Args:
        path: Where it lies.
        told: What the result's provenance says of the arm, its form checked.
    """
    provisos = tuple(Proviso(each["kind"], each["text"]) for each in told.get("provisos", ()))
    if not any(proviso.kind == EXPANDED_XACRO for proviso in provisos) or not path.is_file():
        return None
    return CarriedUrdf(path, str(told.get("sha256", "")), provisos)
