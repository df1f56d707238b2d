"""What a proof came to."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.container import numbers
from asmc_pin.condition.certificate.writing import Proof, seen, write
from asmc_pin.condition.condition_report import bound_lines, scale_lines, stop_lines
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.condition.judged import Judged
from asmc_pin.condition.premises import worst_keys
from asmc_pin.errors import ResultError
from asmc_pin.words.text import counted

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case

Verdict = Literal["holds", "violated", "undecided"]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CertificateResult(Judged):
    """What is proven and what is refuted about M̄ over a joint box.

    Attributes:
        hypotheses: What it is about: arm, M̄, condition, armature, payload, locked joints, and the joint box, or the
            tube, whose time slices are cases.
        level: γ of the verdict; 1 is the condition itself.
        verdict: ``holds``: proven for M̄ itself. ``violated``: `worst_q` is a counter-example. ``undecided``: neither.
        lower: Largest norm seen, at `worst_q`.
        upper: Proven bound of the norm; 1 where just the condition is proven, None where nothing is.
        scale_proven: The condition is proven for M̄ times this, and for every smaller factor; 0 if for none.
        scale_refuted: A counter-example was found for M̄ times this.
        worst_q: Configuration of `lower`, shape (nv,), rad (m where prismatic).
        worst_armature: Armature there, shape (nv,), kg·m².
        worst_case: Which payload end or locked joint it belongs to; empty without ranges.
        worst_index: The same as an index of `cases`.
        refuted_q: Configuration of `scale_refuted`, shape (nv,).
        refuted_armature: Armature there, shape (nv,), kg·m².
        refuted_index: Index of its case.
        boxes: Leaves of the proof of `scale_proven` (of `upper` with a level).
        tests: Boxes tested on the way.
        seconds: Wall time.
        history: (seconds since the beginning, scale proven by then), increasing.
        reason: Why it stopped where it did, in words.
        notes: What a reader has to know.
        cases: The arms that the statement speaks of.
        proofs: What `save` writes.
    """

    hypotheses: Hypotheses
    level: float
    verdict: Verdict
    lower: float
    upper: float | None
    scale_proven: float
    scale_refuted: float
    worst_q: Array
    worst_armature: Array
    worst_case: str
    worst_index: int
    refuted_q: Array
    refuted_armature: Array
    refuted_index: int
    boxes: int
    tests: int
    seconds: float
    history: tuple[tuple[float, float], ...]
    reason: str
    notes: tuple[str, ...]
    cases: tuple[Case, ...] = field(repr=False)
    proofs: tuple[Proof, ...] = field(repr=False)

    @property
    def gap(self) -> float:
        """Relative distance of the two scales, (refuted − proven) / refuted; 1 where nothing is proven."""
        return (self.scale_refuted - self.scale_proven) / self.scale_refuted if self.scale_refuted > 0.0 else 1.0

    def headline(self) -> str:
        """The verdict, and what it is about."""
        boxes = counted(self.boxes, "box", "boxes")
        return f"{self.hypotheses.title}: {self.verdict}  (certified, {boxes}, {self.seconds:.1f} s)"

    def lines(self) -> list[str]:
        """What the verdict is about, the verdict, and what is proven; a line per finding."""
        return [
            *self.hypotheses.lines(),
            self.headline(),
            f"largest norm found {self.lower:.6g}",
            *scale_lines(self.scale_proven, self.scale_refuted),
            *bound_lines(self.upper),
            *stop_lines(self.reason),
        ]

    def save(self, path: str | Path) -> Path:
        """Write the proofs to a file that ``asmc-pin check`` replays.

        Args:
            path: The file; an existing one is replaced.

        Returns:
            The path.

        Raises:
            ResultError: Nothing is proven, or the file cannot be written.
        """
        target = Path(path)
        if not self.proofs and self.verdict != "violated":
            raise ResultError(
                target, f"nothing is proven about {self.arm} ({self.reason}), so there is nothing to write"
            )
        figures = {
            "condition": self.condition,
            "mbar": numbers(self.mbar),
            "verdict": self.verdict,
            "level": self.level,
            "upper": self.upper,
            "scale_proven": self.scale_proven,
            "scale_refuted": self.scale_refuted,
            "lower": self.lower,
            "worst": seen(self.worst_q, self.worst_armature, self.worst_index),
            "refuted": seen(self.refuted_q, self.refuted_armature, self.refuted_index),
        }
        return write(target, figures, self.cases, self.proofs)

    def to_json_dict(self) -> dict[str, Any]:
        """The figures, in the names of ``asmc-pin verify --json --certify``; undefined ones are None."""
        return {
            **self.hypotheses.to_json_dict(),
            "verdict": self.verdict,
            "kind": "certified",
            "lower": self.lower,
            "upper": self.upper,
            "worst_q": self.worst_q.tolist(),
            **worst_keys(self.hypotheses, self.cases[self.worst_index].domain.arm, self.worst_armature),
            "configurations": self.tests,
            "seconds": self.seconds,
            "scale_proven": self.scale_proven,
            "scale_refuted": self.scale_refuted,
            "reason": self.reason,
        }
