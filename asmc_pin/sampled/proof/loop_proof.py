"""What is proven of the plain sampled loop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from asmc_pin.condition.certificate.container import numbers
from asmc_pin.condition.certificate.writing import Proof, write
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.errors import ResultError
from asmc_pin.sampled.proof.gravity_proof import GravityForms
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.words.shown import Shown
from asmc_pin.words.text import counted, exact, printable, rounded_down, rounded_up

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class LoopProof(Shown):
    """What is proven of the plain loop, frozen at every configuration of a joint box, without friction.

    Attributes:
        about: The arm, its payload, armature, locked joints, and the box.
        loop: Gains and timing.
        verdict: Without gravity. ``stable``: proven. ``unstable``: a configuration contradicts. ``undecided``: neither.
        gravity: Its linearisation about rest under gravity of this magnitude, in any direction, is proven stable at
            every configuration too, m/s²; None where it is not proven.
        stable_between: Eigenvalues of M⁻¹M̄ between which the loop is stable, both ends excluded.
        seen_between: The least and the largest eigenvalue of M⁻¹M̄ that a search found.
        boxes: Leaves of the proof.
        seconds: Wall time.
        reason: Why it is undecided; empty where it is not.
        no_gravity: Where it is stable without gravity: why nothing is proven about rest under gravity; else empty.
        cases: The arms that it speaks of.
        seen_at: Where the search found them, as a certificate has it.
        proofs: What `save` writes.
        pieces: What it writes about gravity.
    """

    about: Premises
    loop: SampledLoop
    verdict: Literal["stable", "unstable", "undecided"]
    gravity: float | None
    stable_between: tuple[float, float]
    seen_between: tuple[float, float]
    boxes: int
    seconds: float
    reason: str
    no_gravity: str
    seen_at: tuple[dict[str, Any], dict[str, Any]]
    cases: tuple[Case, ...]
    proofs: tuple[Proof, ...]
    pieces: GravityForms | None

    def lines(self) -> list[str]:
        """What is proven, and what is not, a line each."""
        low, high = self.stable_between
        said = {
            "stable": f"proven: the loop frozen at every q of the box, without gravity, is stable "
            f"({counted(self.boxes, 'box', 'boxes')}, {self.seconds:.1f} s)",
            "unstable": "refuted: the loop frozen at a q of the box, without gravity, is not stable",
            "undecided": f"not proven: whether the loop frozen at every q of the box is stable ({self.reason})",
        }[self.verdict]
        return [
            said,
            f"without gravity it is stable exactly where {rounded_up(low)} < λ(M⁻¹M̄) < {rounded_down(high)}; found: "
            f"{rounded_down(self.seen_between[0])} to {rounded_up(self.seen_between[1])}",
            *(self._beyond() if self.verdict == "stable" else []),
        ]

    def _beyond(self) -> list[str]:
        if self.gravity is None:
            return [f"of the moving arm and of gravity nothing is proven (of gravity because: {self.no_gravity})"]
        return [
            f"proven: so is the loop about rest at every q under gravity of up to {exact(self.gravity)} m/s² in any "
            "direction",
            "of the moving arm nothing is proven",
        ]

    def save(self, path: str | Path) -> Path:
        """Write the proof to a file that ``asmc-pin check`` replays.

        Args:
            path: The file; an existing one is replaced.

        Returns:
            The path.

        Raises:
            ResultError: Nothing is proven and no counter-example known, or the file cannot be written.
        """
        target = Path(path)
        if self.verdict == "undecided":
            raise ResultError(target, f"nothing is proven about {printable(self.about.arm)} ({self.reason})")
        figures = {
            "about": "sampled loop",
            "mbar": numbers(self.loop.mbar),
            "ks": float(self.loop.ks[0]).hex(),
            "beta": float(self.loop.beta[0]).hex(),
            "period": float(self.loop.period).hex(),
            "verdict": self.verdict,
            "gravity": None
            if self.pieces is None or self.gravity is None
            else {
                "magnitude": self.gravity.hex(),
                "pieces": {
                    "ends": numbers(self.pieces.ends),
                    "forms": numbers(self.pieces.forms.reshape(-1, 9)[:, [0, 1, 2, 4, 5, 8]]),
                },
            },
            "least": self.seen_at[0],
            "largest": self.seen_at[1],
        }
        return write(target, figures, self.cases, self.proofs)

    def to_json_dict(self) -> dict[str, Any]:
        """The figures by name."""
        return {
            "about": "the loop frozen at every q of the box, without gravity",
            "verdict": self.verdict,
            "reason": self.reason or None,
            "gravity": self.gravity,
            "no_gravity": self.no_gravity or None,
            "stable_between": list(self.stable_between),
            "seen_between": list(self.seen_between),
            "boxes": self.boxes,
            "seconds": self.seconds,
        }
