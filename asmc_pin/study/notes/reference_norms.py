"""Lemma 1's norm along the reference of a comparison, for the M̄ of every law and every arm of the run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.condition.norm.two_conditions import lemma1_norm
from asmc_pin.condition.premises import hypotheses_on, premises_along
from asmc_pin.controllers import Controller, Setpoint
from asmc_pin.plant import MovingArm


@dataclass(frozen=True, slots=True, eq=False)
class Lemma1Part:
    """‖I − M⁻¹M̄‖₂ of one of the arms of a run, at the configurations of the reference while it moves.

    Attributes:
        hypotheses: What it is about: the arm with its rotors, its payload and its locked joints, and M̄.
        moving: The arm, when it moves, and how its links are scattered.
        lower: Smallest value.
        upper: Largest value; below 1 at these configurations does not prove it between them, nor off the reference.
        worst_time: When the largest is reached, s.
    """

    hypotheses: Hypotheses
    moving: MovingArm
    lower: float
    upper: float
    worst_time: float

    @property
    def verdict(self) -> str:
        """``"violated"``, or ``"unrefuted"``: a sample can refute, never prove."""
        return "unrefuted" if self.upper < 1.0 else "violated"

    @property
    def about(self) -> str:
        """The arm with all that is supposed, when it moves, and with which links."""
        words = self.moving.words
        return self.hypotheses.title + (f" ({words})" if words else "")

    def to_json_dict(self) -> dict[str, Any]:
        """For ``compare --json``; the end of the last phase is null."""
        start, end = self.moving.span
        return {
            "span": [start, None if math.isinf(end) else end],
            "links": self.moving.links,
            "norm": [self.lower, self.upper],
            "worst_time": self.worst_time,
            "verdict": self.verdict,
            "hypotheses": self.hypotheses.to_json_dict(),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Lemma1Range:
    """‖I − M⁻¹M̄‖₂ along a reference, in every phase of the payload and at both ends of the scatter.

    Attributes:
        parts: Arm by arm, in order of time; see `asmc_pin.plant.moving_arms`.
    """

    parts: tuple[Lemma1Part, ...]

    @property
    def worst(self) -> Lemma1Part:
        """The part with the largest norm."""
        return max(self.parts, key=lambda part: part.upper)

    @property
    def hypotheses(self) -> Hypotheses:
        """What the worst part is about."""
        return self.worst.hypotheses

    @property
    def lower(self) -> float:
        """Smallest value of all parts."""
        return min(part.lower for part in self.parts)

    @property
    def upper(self) -> float:
        """Largest value of all parts."""
        return self.worst.upper

    @property
    def worst_time(self) -> float:
        """When the largest is reached, s."""
        return self.worst.worst_time

    @property
    def verdict(self) -> str:
        """That of the worst part."""
        return self.worst.verdict


def lemma1_along(
    moving: Sequence[MovingArm], time: np.ndarray, setpoint: Setpoint, laws: Mapping[str, Controller]
) -> dict[str, Lemma1Range]:
    """Lemma 1's norm along the reference, for the M̄ of every law that has one.

    Args:
        moving: Every arm of the run.
        time: Shape (T,), s.
        setpoint: Reference there, fields of shape (T, nv).
        laws: Controllers by label.

    Returns:
        By label; one and the same object for all laws with one M̄.
    """
    nv = moving[0].arm.nv
    along = [
        (premises_along(item.arm, setpoint.q[item.ticks]), item.arm.mass_matrix(setpoint.q[item.ticks]))
        for item in moving
    ]
    found: dict[str, Lemma1Range] = {}
    known: dict[bytes, Lemma1Range] = {}
    for label, law in laws.items():
        mbar = getattr(law, "mbar", None)
        if mbar is None:
            continue
        diagonal = np.broadcast_to(np.asarray(mbar, dtype=np.float64), (nv,)).copy()
        key = diagonal.tobytes()
        if key not in known:
            parts = []
            for item, (about, mass) in zip(moving, along, strict=True):
                norm = lemma1_norm(mass, diagonal)
                worst = int(np.argmax(norm))
                hypotheses = hypotheses_on(about, diagonal, "lemma1")
                when = float(time[item.start + worst])
                parts.append(Lemma1Part(hypotheses, item, float(np.min(norm)), float(norm[worst]), when))
            known[key] = Lemma1Range(tuple(parts))
        found[label] = known[key]
    return found


def lemma1_lines(lemma1: Mapping[str, Lemma1Range]) -> list[str]:
    """The ranges in words, one line for each M̄."""
    groups: dict[Lemma1Range, list[str]] = {}
    for label, item in lemma1.items():
        groups.setdefault(item, []).append(label)
    return [_range_line(item, ", ".join(labels)) for item, labels in groups.items()]


def _range_line(item: Lemma1Range, labels: str) -> str:
    mbar = f"M̄ = {_diagonal(item.hypotheses)} kg·m² of {labels}"
    if len(item.parts) == 1:
        (part,) = item.parts
        return (
            f"Lemma 1 along the reference on {part.about}, with {mbar}: {_norms(part)} (sampled at the control ticks)"
        )
    return (
        f"Lemma 1 along the reference, with {mbar}, is {item.verdict} (sampled at the control ticks); worst on "
        f"{item.worst.about} at t = {item.worst_time:.3f} s. "
        + "; ".join(f"On {part.about}: {_norms(part)}" for part in item.parts)
    )


def _norms(part: Lemma1Part) -> str:
    return f"‖I − M⁻¹M̄‖₂ = {part.lower:.4f} … {part.upper:.4f}, {part.verdict}"


def _diagonal(hypotheses: Hypotheses) -> str:
    return f"diag({', '.join(f'{m:.6g}' for m in hypotheses.mbar)})"
