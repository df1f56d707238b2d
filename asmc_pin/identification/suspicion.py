"""A suspicion about a log or a URDF that was confirmed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, eq=False)
class Suspicion:
    """A suspicion that was confirmed.

    Attributes:
        text: What is wrong, and what to do.
        score: With it put right.
        before: Without.
        options: Words of the command line that put it right; empty where it takes other columns, or another URDF.
    """

    text: str
    score: float
    before: float
    options: tuple[str, ...] = ()
