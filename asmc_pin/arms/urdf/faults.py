"""What a robot is refused for although it can be read: said all at once, and shown all the same by `inspect`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError


@dataclass(frozen=True)
class Fault:
    """One such thing.

    Attributes:
        kind: What is wrong. Of a joint with its ``axis`` or its ``mimic`` M(q) is not known; of one with its
            ``limits`` or its ``friction`` it is.
        about: The joints.
        text: What was found, where, and how to mend it.
    """

    kind: Literal["axis", "mimic", "limits", "friction"]
    about: tuple[str, ...]
    text: str

    @property
    def hides_mass(self) -> bool:
        """Whether M(q) is not known."""
        return self.kind in ("axis", "mimic")


def refused(path: Path, problems: Sequence[str], what: str = "", last: str = "") -> ArmError:
    """The error of a robot with these problems, one or more; as lines where there are several.

    Args:
        path: The file.
        problems: A sentence each.
        what: What they are faults of, for the first line.
        last: What is to be said of several of them.
    """
    if len(problems) == 1:
        return ArmError(path, "; ".join([*problems, *([last] if last else [])]))
    lines = [f"{shown(path)}: {len(problems)} faults{what}:", *problems, *([f"Of each tensor: {last}"] if last else [])]
    return ArmError(path, "\n  ".join(lines))
