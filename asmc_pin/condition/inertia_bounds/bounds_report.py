"""What is known of the size of M(q) over a joint box."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.container import numbers
from asmc_pin.condition.certificate.writing import Proof, write
from asmc_pin.condition.hypotheses import Premises, scaling_words
from asmc_pin.errors import ResultError
from asmc_pin.words.shown import UNDEFINED, Cells, Shown
from asmc_pin.words.text import counted, printable, rounded_down, rounded_up

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case


@dataclass(frozen=True, eq=False)
class Bound:
    """A proven bound, and the value that a search found.

    Attributes:
        proven: No configuration of the box is beyond it; None where nothing is proven.
        found: Some configuration has this value, up to rounding.
        q: That configuration, shape (nv,), rad (m where prismatic).
    """

    proven: float | None
    found: float
    q: Array

    def to_list(self) -> list[float | None]:
        """``[proven, found]``."""
        return [self.proven, self.found]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class BoundsReport(Shown):
    """Bounds of M(q), of its condition number and of the velocity forces over a joint box.

    With S the diagonal scaling of the joints: m₁ I ⪯ S M(q) S ⪯ m₂ I, λ_max/λ_min of S M S ≤ κ, and
    ‖S C(q, Sx) Sx‖ ≤ c ‖x‖². With S = I these are bounds of M, and of C(q, q̇) q̇ by ‖q̇‖².

    Attributes:
        about: The arm, its payload, armature, locked joints, and the box.
        scaling: Diagonal of S, shape (nv,): the size of a joint's velocity that counts as one.
        lower: m₁, kg·m².
        upper: m₂, kg·m².
        condition_number: κ.
        coriolis: c, kg·m².
        boxes: Leaves of the proofs of m₁ and m₂.
        tests: Boxes tested and configurations searched on the way.
        seconds: Wall time.
        reasons: Why the proofs of m₁ and of m₂ stopped where they did.
        notes: What a reader has to know.
        seen_at: Where the least and the largest eigenvalue were found, as a certificate has it.
        cases: The arms that it speaks of.
        proofs: What `save` writes.
    """

    about: Premises
    scaling: Array
    lower: Bound
    upper: Bound
    condition_number: Bound
    coriolis: Bound
    boxes: int
    tests: int
    seconds: float
    reasons: tuple[str, str]
    notes: tuple[str, ...]
    seen_at: tuple[dict[str, Any], dict[str, Any]] = field(repr=False)
    cases: tuple[Case, ...] = field(repr=False)
    proofs: tuple[Proof, ...] = field(repr=False)

    @property
    def arm(self) -> str:
        """Name of the arm."""
        return self.about.arm

    @property
    def joints(self) -> tuple[str, ...]:
        """Its moving joints, base first."""
        return self.about.joints

    @property
    def verdict(self) -> Literal["holds", "undecided"]:
        """``holds`` where both m₁ and m₂ are proven."""
        return "undecided" if self.lower.proven is None or self.upper.proven is None else "holds"

    def headline(self) -> str:
        """The bounds, and what they are about."""
        matrix = "M(q)" if np.all(self.scaling == 1.0) else "S M(q) S"
        low = UNDEFINED if self.lower.proven is None else f"{rounded_down(self.lower.proven)} I"
        high = UNDEFINED if self.upper.proven is None else f"{rounded_up(self.upper.proven)} I"
        boxes = counted(self.boxes, "box", "boxes")
        return f"{self.about.title}: {low} ≺ {matrix} ≺ {high}  (certified, {boxes}, {self.seconds:.1f} s)"

    def lines(self) -> list[str]:
        """What it is about, the bounds, and why the proofs stopped."""
        return [
            *self.about.lines(),
            f"Scaling: {scaling_words(self.scaling.tolist())}",
            self.headline(),
            f"the proof of m₁ stopped because: {self.reasons[0]}; of m₂: {self.reasons[1]}",
        ]

    def table(self) -> Cells:
        """Each bound, the value found beside it, and how far they are apart."""
        rows = [
            ("least eigenvalue, m₁ kg·m²", self.lower, rounded_down),
            ("largest eigenvalue, m₂ kg·m²", self.upper, rounded_up),
            ("condition number λ_max/λ_min", self.condition_number, rounded_up),
            ("velocity forces, c kg·m²", self.coriolis, rounded_up),
        ]
        return ["over the box", "proven", "found", "apart"], [
            [
                name,
                UNDEFINED if bound.proven is None else rounded(bound.proven),
                f"{bound.found:.6g}",
                UNDEFINED if bound.proven is None else _apart(bound.proven, bound.found),
            ]
            for name, bound, rounded in rows
        ]

    def remarks(self) -> list[str]:
        """What a reader has to know."""
        return [f"note: {line}" for line in self.notes]

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
        if not self.proofs:
            raise ResultError(target, f"nothing is proven about {printable(self.arm)}, so there is nothing to write")
        figures = {
            "about": "bounds",
            "scaling": numbers(self.scaling),
            "mbar": numbers(1.0 / self.scaling**2),
            "lower": self.lower.to_list(),
            "upper": self.upper.to_list(),
            "coriolis": self.coriolis.proven,
            "least": self.seen_at[0],
            "largest": self.seen_at[1],
        }
        return write(target, figures, self.cases, self.proofs)

    def to_json_dict(self) -> dict[str, Any]:
        """The object that ``asmc-pin bounds --json`` prints: each bound as [proven, found], None where undefined."""
        return {
            **self.about.to_json_dict(),
            "scaling": self.scaling.tolist(),
            "verdict": self.verdict,
            "kind": "certified",
            "lower": self.lower.to_list(),
            "upper": self.upper.to_list(),
            "coriolis": self.coriolis.to_list(),
            "condition_number": self.condition_number.to_list(),
            "lower_q": self.lower.q.tolist(),
            "upper_q": self.upper.q.tolist(),
            "coriolis_q": self.coriolis.q.tolist(),
            "condition_number_q": self.condition_number.q.tolist(),
            "boxes": self.boxes,
            "configurations": self.tests,
            "seconds": self.seconds,
            "reasons": list(self.reasons),
        }


def _apart(proven: float, found: float) -> str:
    ratio = max(proven, found) / max(min(proven, found), 1e-300)
    return f"{100.0 * (ratio - 1.0):.2g} %" if ratio < 2.0 else f"a factor of {ratio:.2g}"
