"""What verifying M̄ says."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.condition.judged import Judged
from asmc_pin.condition.premises import worst_keys
from asmc_pin.words.joint_units import column_cells, column_head
from asmc_pin.words.shown import Cells
from asmc_pin.words.text import counted, printable, rounded_down, rounded_up

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition.search.what_would_help import WhatWouldHelp

Verdict = Literal["violated", "holds", "unrefuted", "undecided"]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ConditionReport(Judged):
    """Whether M̄ satisfies a condition on an arm, and what that rests on.

    Attributes:
        hypotheses: What the verdict is about: arm, M̄, condition, armature, payload, locked joints, box.
        verdict: ``violated``: `worst_q` is a counter-example. ``holds``: proven over the box. ``unrefuted``: sampled
            and searched only, which can refute and never prove. ``undecided``: neither within the budget.
        kind: ``sampled`` or ``certified``.
        lower: Largest value seen of the condition's norm: ‖I − M⁻¹M̄‖₂, or max|1 − λ(M⁻¹M̄)|.
        upper: A proven bound of it; None where only sampled.
        worst_q: Configuration of `lower`, shape (nv,), rad (m where prismatic).
        configurations: How many configurations were evaluated.
        seconds: Wall time.
        notes: What a reader has to know, in plain words.
        smallest: Smallest norm among the samples.
        subject: The arm that `lower` belongs to, with its payload and locks, but for the armature.
        worst_case: Which end of the ranges (payload, locks) `lower` belongs to; empty without ranges.
        worst_armature: Armature there, shape (nv,), kg·m².
        samples: The norm at every sample, for distributions.
        times: Along a motion: times, shape (T,), s; else None.
        norms: Along a motion: the norm at each time, shape (T,); the largest over the ranges.
        motion: Along a motion, not in a tube: the configurations, shape (T, nv).
        worst_time: Along a motion: time of `lower`, s.
        tde_error: Along recorded data with torque: the TDE error that M̄ would have made; see `tde_error`.
        scale_proven: The condition is proven for M̄ times this; None unless asked for.
        scale_refuted: A counter-example was found for M̄ times this; None unless asked for.
        reason: Why the proof stopped where it did; empty where none was asked for.
        method: How `lower` and `upper` were obtained, one sentence each.
        remedy: Of a violation that a search found: the joint to blame, and what multiple of M̄ would do.
    """

    hypotheses: Hypotheses
    verdict: Verdict
    kind: Literal["sampled", "certified"]
    lower: float
    upper: float | None
    worst_q: Array
    configurations: int
    seconds: float
    smallest: float
    worst_armature: Array
    samples: Array = field(repr=False)
    subject: Arm = field(repr=False)
    notes: tuple[str, ...] = ()
    worst_case: str = ""
    times: Array | None = field(default=None, repr=False)
    norms: Array | None = field(default=None, repr=False)
    motion: Array | None = field(default=None, repr=False)
    worst_time: float | None = None
    tde_error: Array | None = field(default=None, repr=False)
    scale_proven: float | None = None
    scale_refuted: float | None = None
    reason: str = ""
    method: tuple[str, ...] = ()
    remedy: WhatWouldHelp | None = None

    @property
    def box(self) -> tuple[Array, Array]:
        """Joint box, lower and upper ends, each (nv,); where it was along a motion, the range of the motion."""
        lower, upper = np.array(list(self.hypotheses.box.values())).T
        return lower, upper

    def headline(self) -> str:
        """The verdict, and what it is about."""
        tried = counted(self.configurations, "configuration")
        return f"{self.hypotheses.title}: {self.verdict}  ({self.kind}, {tried}, {self.seconds:.1f} s)"

    def lines(self) -> list[str]:
        """What the verdict is about, the verdict, and what was found; a line per finding."""
        largest = f"largest norm found {self.lower:.6g}"
        if self.worst_time is not None:
            largest += f", at t = {self.worst_time:.4g} s"
        return [
            *self.hypotheses.lines(),
            self.headline(),
            f"{largest}; smallest {self.smallest:.6g}",
            *scale_lines(self.scale_proven, self.scale_refuted),
            *bound_lines(self.upper),
            *stop_lines(self.reason),
            *([f"worst case: {self.worst_case}"] if self.worst_case else []),
            *(self.remedy.lines() if self.remedy is not None else []),
        ]

    def table(self) -> Cells:
        """M̄ and the worst configuration, joint by joint; angles in degrees too."""
        slides = self.hypotheses.slides
        mbar = column_cells([f"{m:.6g}" for m in self.mbar], "inertia", slides)
        armature = column_cells([f"{a:.6g}" for a in self.worst_armature], "inertia", slides)
        worst = column_cells([f"{q:+.6f}" for q in self.worst_q], "place", slides)
        degrees = ["" if slide else f"{np.degrees(q):+.2f}" for slide, q in zip(slides, self.worst_q, strict=True)]
        head = [column_head("m̄", "inertia", slides), "armature there", column_head("worst q", "place", slides), "deg"]
        rows = zip(map(printable, self.joints), mbar, armature, worst, degrees, strict=True)
        return ["joint", *head], [list(row) for row in rows]

    def to_json_dict(self) -> dict[str, Any]:
        """The object that ``asmc-pin verify --json`` prints; undefined figures are None."""
        content: dict[str, Any] = {
            **self.hypotheses.to_json_dict(),
            "verdict": self.verdict,
            "kind": self.kind,
            "lower": self.lower,
            "upper": self.upper,
            "worst_q": self.worst_q.tolist(),
            **worst_keys(self.hypotheses, self.subject, self.worst_armature),
            "configurations": self.configurations,
            "seconds": self.seconds,
        }
        if self.worst_case:
            content["worst_case"] = self.worst_case  # without it, `worst_q` would be half a counter-example
        if self.kind == "certified":
            content |= {"scale_proven": self.scale_proven, "scale_refuted": self.scale_refuted, "reason": self.reason}
        return content


def scale_lines(proven: float | None, refuted: float | None) -> list[str]:
    """For which multiples of M̄ the condition is proven, and for which there is a counter-example."""
    if refuted is None:
        return []
    if refuted <= 0.0:
        return ["there are counter-examples for every positive multiple of M̄"]
    gap = 1.0 - (proven or 0.0) / refuted
    # Rounded so that what is printed is no more than what is proven.
    holds, breaks = rounded_down(proven or 0.0), rounded_up(refuted)
    return [f"proven for M̄ times {holds}, counter-example for M̄ times {breaks} (gap {gap:.2%})"]


def bound_lines(upper: float | None) -> list[str]:
    """The proven bound of the norm."""
    if upper is None:
        return []
    bound = f"at most {rounded_up(upper)}" if upper < 1.0 else "below 1"
    return [f"the norm is proven to be {bound} over the box"]


def stop_lines(reason: str) -> list[str]:
    """Why a proof went no further."""
    return [f"the proof stopped because: {reason}"] if reason else []
