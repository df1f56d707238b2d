"""What every statement about an arm has to carry along: in what the arm is not as its file says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from asmc_pin.words.text import visible

EXPANDED_XACRO = "expanded xacro"
"""Of an arm that came from a xacro file."""

CONVERTED_MJCF = "converted MJCF"
"""Of an arm that came from a MuJoCo model."""

PUBLISHED_ARMATURE_USED = "published armature"
"""Of an arm with reflected inertias from the list of published ones."""

SIMULATED_ARMATURE_USED = "simulated armature"
"""Of an arm with reflected inertias that stand in a simulation model alone."""

_QUIET = (EXPANDED_XACRO, CONVERTED_MJCF, PUBLISHED_ARMATURE_USED)


class Proviso(NamedTuple):
    """One such thing; it stands in every report, page, certificate and provenance.

    Attributes:
        kind: A few words for a headline, such as "estimated inertia".
        text: What was done, with figures, as one sentence without a full stop.
    """

    kind: str
    text: str

    @property
    def headline(self) -> bool:
        """Whether the arm is another one for it, so that no headline goes without it."""
        return self.kind not in _QUIET


def provisos_json(provisos: Sequence[Proviso]) -> list[dict[str, str]]:
    """The same as ``--json`` and provenance have it."""
    return [{"kind": visible(kind), "text": visible(text)} for kind, text in provisos]
