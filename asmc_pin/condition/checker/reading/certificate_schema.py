"""What a certificate may say, of each thing that it may be about.

Nothing here is believed. The figures and the verdict of the header are claims, which have to follow from what is
replayed; names of the arm, labels and hashes in it are not even read.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from asmc_pin.condition.checker.reading.header_parts import Figure, Header, Hex, Malformed, Part, Row, Seen
from asmc_pin.words.text import printable

_LONGEST = 10_000
"""Items of a list; also statements and cases."""

_DEEPEST = 20


class Contents(Header):
    """A header about a condition on M̄."""

    condition: Literal["lemma1", "weighted"]
    verdict: Literal["holds", "violated", "undecided"]
    level: Annotated[Figure, Field(gt=0.0, le=1.0)]
    upper: Annotated[Figure, Field(gt=0.0, le=1.0)] | None
    scale_proven: Annotated[Figure, Field(ge=0.0)]
    scale_refuted: Annotated[Figure, Field(ge=0.0)]
    lower: Annotated[Figure, Field(ge=0.0)]
    worst: Seen
    refuted: Seen

    @property
    def seen(self) -> tuple[Seen, Seen]:
        """The worst configuration, and the counter-example."""
        return self.worst, self.refuted

    @property
    def kinds(self) -> set[str]:
        """The statements that say something about the condition."""
        return {"weighted", "bounded"} if self.condition == "weighted" else {"lemma1", "level"}


class _SpectrumContents(Header):
    """A header about the eigenvalues of M against those of diag(mbar), with the configurations of both ends."""

    least: Seen
    largest: Seen

    @property
    def seen(self) -> tuple[Seen, Seen]:
        """Where the least and where the largest eigenvalue was seen."""
        return self.least, self.largest


class BoundsContents(_SpectrumContents):
    """A header about bounds of S M S, and of its velocity forces: each [proven, found]."""

    about: Literal["bounds"]
    scaling: Row
    lower: tuple[Annotated[Figure, Field(gt=0.0)] | None, Annotated[Figure, Field(gt=0.0)]]
    upper: tuple[Annotated[Figure, Field(gt=0.0)] | None, Annotated[Figure, Field(gt=0.0)]]
    coriolis: Annotated[Figure, Field(ge=0.0)] | None

    @model_validator(mode="after")
    def _scaled(self) -> BoundsContents:
        """One positive number a joint."""
        if len(self.scaling) != len(self.joints) or min(self.scaling) <= 0.0:
            raise ValueError("the scaling has not one positive number for each joint")
        return self


class Pieces(Part):
    """Forms of a mode, piece by piece of the eigenvalues of M⁻¹M̄: xx, xy, xz, yy, yz, zz of each."""

    ends: Annotated[tuple[Annotated[Hex, Field(gt=0.0)], ...], Field(min_length=2, max_length=1001)]
    forms: Annotated[tuple[tuple[Hex, Hex, Hex, Hex, Hex, Hex], ...], Field(min_length=1, max_length=1000)]

    @model_validator(mode="after")
    def _in_order(self) -> Pieces:
        """A form for each piece, and pieces that follow each other."""
        if len(self.ends) != len(self.forms) + 1 or any(a >= b for a, b in pairwise(self.ends)):
            raise ValueError("the pieces of its eigenvalues are not one after the other, with a form for each")
        return self


class GravityClaim(Part):
    """That it holds at rest under gravity of this magnitude, in m/s², too."""

    magnitude: Annotated[Hex, Field(gt=0.0)]
    pieces: Pieces


class LoopContents(_SpectrumContents):
    """A header about the plain sampled loop with K_s = k_s I, frozen at every configuration, without gravity."""

    about: Literal["sampled loop"]
    ks: Annotated[Hex, Field(gt=0.0)]
    beta: Annotated[Hex, Field(gt=0.0)]
    period: Annotated[Hex, Field(gt=0.0)]
    verdict: Literal["stable", "unstable", "undecided"]
    gravity: GravityClaim | None


def contents(header: dict[str, Any]) -> Header:
    """The header, checked.

    Raises:
        Malformed: It says something that no certificate says.
    """
    kinds: dict[str, type[Header]] = {"bounds": BoundsContents, "sampled loop": LoopContents}
    kind = kinds.get(str(header.get("about")), Contents)
    try:
        # Lists become tuples on the way, which strict types would not take from Python objects.
        return kind.model_validate(_frozen(header))
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        what = first["msg"].removeprefix("Value error, ")
        raise Malformed(
            f"the header is not a certificate's: {printable(f'{where}: ' if where else '')}{what}"
        ) from None


def _frozen(value: Any, depth: int = 0) -> Any:
    if isinstance(value, list | dict) and (len(value) > _LONGEST or depth > _DEEPEST):
        raise Malformed("the header is not a certificate's: it has lists that are longer or deeper than any needs")
    if isinstance(value, list):
        return tuple(_frozen(item, depth + 1) for item in value)
    if isinstance(value, dict):
        return {key: _frozen(item, depth + 1) for key, item in value.items()}
    return value
