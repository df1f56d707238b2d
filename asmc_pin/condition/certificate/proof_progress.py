"""How far a proof is: what its caller is told, and when an attempt is given up because it will not be done in time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class ProofProgress:
    """How far a certificate is.

    Attributes:
        proven: Scale proven.
        refuted: Scale refuted.
        trying: What is being tried now, in words.
        volume: Share of the box that is proven of that.
        tests: Boxes tested so far.
        seconds: Since the beginning.
    """

    proven: float
    refuted: float
    trying: str
    volume: float
    tests: int
    seconds: float


class Refuted(Protocol):
    """What is refuted so far."""

    scale: float


class Watched(Protocol):
    """What is looked at of a prover."""

    began: float
    deadline: float
    scale: float
    tests: int
    progress: Callable[[ProofProgress], None] | None

    @property
    def worst(self) -> Refuted: ...  # noqa: D102


class WalkWatch:
    """Looks at a walk now and then: tells the caller, and stops what will not be done in time.

    Attributes:
        slow: Whether it stopped the walk.

    Args:
        prover: Whose walk it is.
        label: What is being tried, in words.
        patient: Whether all the time that is left may go into it.
        number: How many of its statements are done.
        statements: How many there are.
    """

    def __init__(self, prover: Watched, label: str, patient: bool, number: int, statements: int) -> None:
        self._prover, self._label, self._patient = prover, label, patient
        self._number, self._statements = number, statements
        self._began = time.monotonic()
        self._remaining = prover.deadline - self._began
        self._tests = prover.tests
        self.slow = False

    def __call__(self, tests: int, volume: float) -> bool:
        """Look at it; whether to stop it."""
        prover, now = self._prover, time.monotonic()
        if prover.progress is not None:
            done = (self._number + volume) / self._statements
            seconds = now - prover.began
            prover.progress(
                ProofProgress(prover.scale, prover.worst.scale, self._label, done, self._tests + tests, seconds)
            )
        spent = now - self._began
        late = spent * (1.0 - volume) > 1.5 * volume * (self._remaining - spent)
        self.slow = not self._patient and late and spent > 0.15 * self._remaining
        return self.slow
