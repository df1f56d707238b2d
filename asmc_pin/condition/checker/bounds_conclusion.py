"""What a certificate of bounds of the inertia matrix comes to, and whether it claims more than that."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from asmc_pin.condition.checker.reading.certificate_schema import BoundsContents
from asmc_pin.condition.checker.spectrum import EndsSeen, float_above, float_below, spectrum
from asmc_pin.condition.hypotheses import scaling_words
from asmc_pin.words.text import rounded_down, rounded_up

_NEAR = 1e-6
"""How far a value that the header gives may be from the one that is found at the same configuration."""


@dataclass(frozen=True)
class BoundsConclusion:
    """What is shown of S M(q) S over every case.

    Attributes:
        verdict: ``holds`` where both ends are proven.
        scaling: Diagonal of S.
        lower: m₁ I ≺ S M S, None where nothing is proven; and an eigenvalue that is not above this was shown.
        upper: S M S ≺ m₂ I, likewise.
        coriolis: ‖S C(q, Sx) Sx‖ ≤ c ‖x‖²; None where joints follow others, of which no bound is shown.
    """

    verdict: Literal["holds", "undecided"]
    scaling: tuple[float, ...]
    lower: tuple[float | None, float]
    upper: tuple[float | None, float]
    coriolis: float | None

    @property
    def condition_number(self) -> float | None:
        """No λ_max/λ_min of S M S is above this."""
        low, high = self.lower[0], self.upper[0]
        return None if low is None or high is None else float_above(Fraction(high) / Fraction(low))

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``check --json``; what is not shown is None."""
        return {
            "about": "bounds",
            "scaling": list(self.scaling),
            "verdict": self.verdict,
            "lower": list(self.lower),
            "upper": list(self.upper),
            "coriolis": [self.coriolis, None],
            "condition_number": [self.condition_number, None],
        }

    def lines(self) -> list[str]:
        """For a person to read, a line each."""
        plain = all(s == 1.0 for s in self.scaling)
        matrix, forces = ("M(q)", "C(q, q̇)q̇") if plain else ("S M(q) S", "S C(q, Sx) Sx")
        size = "q̇" if plain else "x"
        low, high, most = self.lower[0], self.upper[0], self.condition_number
        said = [] if low is None else [f"{rounded_down(low)} I ≺ {matrix}"]
        said += [] if high is None else [f"{matrix} ≺ {rounded_up(high)} I"]
        said += [] if most is None else [f"λ_max/λ_min ≤ {rounded_up(most)}"]
        seen = f"at most {rounded_up(self.lower[1])} and one of at least {rounded_down(self.upper[1])}"
        return [
            f"{self.verdict}: over every q of the box {', '.join(said) or 'nothing is proven of its eigenvalues'}",
            f"nothing is shown of ‖{forces}‖, where joints mimic others"
            if self.coriolis is None
            else f"‖{forces}‖ ≤ {rounded_up(self.coriolis)} ‖{size}‖², from masses and reaches",
            f"shown at configurations: an eigenvalue of {seen}",
            f"Scaling: {scaling_words(self.scaling)}",
        ]


def conclude_bounds(
    told: BoundsContents, shown: EndsSeen, forces: Callable[[float | None], float | None]
) -> tuple[BoundsConclusion, list[str]]:
    """What follows from the statements, if all of them are true, and what the header claims beyond it.

    Args:
        told: The header.
        shown: What its two configurations show, with S^(−2) for W.
        forces: The bound c of the velocity forces, with a bound m₂ of S M S or without; None where there is none.

    Returns:
        The conclusion, and a sentence for each claim that does not follow.
    """
    found = spectrum(told)
    # S W S, exactly: its ends turn a bound against W into one of S M S against I.
    sizes = [Fraction(w) * Fraction(s) ** 2 for w, s in zip(told.mbar, told.scaling, strict=True)]
    low = None if found.above is None else float_below(found.above * min(sizes))
    high = None if found.below is None else float_above(found.below * max(sizes))
    conclusion = BoundsConclusion(
        "undecided" if low is None or high is None else "holds",
        told.scaling,
        (low, shown.least),
        (high, shown.largest),
        forces(high),
    )
    said = []
    if told.lower[0] is not None and (low is None or told.lower[0] > low):
        said.append(f"nothing in the file proves that no eigenvalue is below {told.lower[0]:.9g}")
    if told.upper[0] is not None and (high is None or told.upper[0] < high):
        said.append(f"nothing in the file proves that no eigenvalue is above {told.upper[0]:.9g}")
    most, claimed_most = conclusion.coriolis, told.coriolis
    if most is None and claimed_most is not None:
        said.append("nothing in the file bounds the velocity forces of joints that follow others")
    elif most is not None and (claimed_most is None or not (math.isfinite(most) and claimed_most >= most)):
        said.append(f"the velocity forces are bounded by {most:.9g}, not by {claimed_most}")
    for claimed, value in ((told.lower[1], shown.least), (told.upper[1], shown.largest)):
        if not abs(claimed - value) <= _NEAR * value:
            said.append(f"at its configuration the eigenvalue is {value:.9g}, not {claimed:.9g}")
    if (low is not None and low >= shown.least) or (high is not None and high <= shown.largest):
        said.append("an eigenvalue is shown beyond the bound that is proven, which cannot both be: please report it")
    if not told.statements:
        said.append("it proves nothing")
    return conclusion, said
