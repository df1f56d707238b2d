"""What a certificate of a sampled loop comes to, derived from its gains, its period and the proven statements.

The plain loop (7) with K_s = k_s I, velocity estimate, no filter and no delay, frozen at q and without gravity, is
asymptotically stable exactly when a_lo < λ(M⁻¹M̄) < a_hi for every eigenvalue, with 1/a_hi = ½ + (β + k_s)L/4 and
1/a_lo = ½ + (β + k_s)/(β k_s L): Jury's criterion of its one mode (docs/stability.md).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from asmc_pin.condition.checker.reading.certificate_schema import GravityClaim, LoopContents
from asmc_pin.condition.checker.spectrum import EndsSeen, Spectrum, float_above, float_below, spectrum
from asmc_pin.words.text import exact, rounded_down, rounded_up

_SAID = {
    "stable": "the loop frozen at every q of the box, without gravity, is stable",
    "unstable": "the loop frozen at a q of the box, without gravity, is not stable",
    "undecided": "whether the loop frozen at every q of the box is stable is neither proven nor refuted",
}


@dataclass(frozen=True)
class LoopConclusion:
    """What the statements of a certificate show about the sampled loop.

    Attributes:
        verdict: ``stable``, ``unstable`` or ``undecided``.
        mbar: Diagonal of M̄, kg·m².
        ks: k_s of K_s = k_s I, 1/s.
        beta: β, 1/s.
        period: L, s.
        stable_between: The open interval of eigenvalues of M⁻¹M̄ in which the loop is stable, rounded inward.
        proven_between: All of them lie between these over the box; None where nothing is proven.
        shown: Eigenvalues of at most, and of at least, these are shown.
        gravity: Its linearisation about rest under gravity of this magnitude and any direction is stable too, m/s²;
            None where that is not shown.
    """

    verdict: Literal["stable", "unstable", "undecided"]
    mbar: tuple[float, ...]
    ks: float
    beta: float
    period: float
    stable_between: tuple[float, float]
    proven_between: tuple[float | None, float | None]
    shown: tuple[float, float]
    gravity: float | None

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``check --json``."""
        return {
            "about": "sampled loop",
            "mbar": list(self.mbar),
            "ks": self.ks,
            "beta": self.beta,
            "period": self.period,
            "verdict": self.verdict,
            "stable_between": list(self.stable_between),
            "proven_between": list(self.proven_between),
            "shown": list(self.shown),
            "gravity": self.gravity,
        }

    def lines(self) -> list[str]:
        """For a person to read, a line each."""
        low, high = self.stable_between
        least, most = self.proven_between
        proven = [] if least is None else [f"{rounded_down(least)} < λ"]
        proven += [] if most is None else [f"λ < {rounded_up(most)}"]
        return [
            f"{self.verdict}: {_SAID[self.verdict]}",
            f"the plain loop (7): K_s = {exact(self.ks)} I 1/s, β = {exact(self.beta)} 1/s, L = {exact(self.period)} "
            "s, velocity estimate, no filter, no delay, no friction",
            f"M̄: diag({', '.join(exact(m) for m in self.mbar)})",
            f"it is stable where {rounded_up(low)} < λ(M⁻¹M̄) < {rounded_down(high)}; "
            f"{'proven over the box: ' + ', '.join(proven) if proven else 'nothing is proven of λ'}; "
            f"shown: {rounded_up(self.shown[0])} and {rounded_down(self.shown[1])}",
            f"so is the loop about rest at every q under gravity of up to {exact(self.gravity)} m/s² in any direction"
            if self.gravity is not None
            else "of the loop under gravity it proves nothing",
            "of the moving arm, whose inertia changes and whose velocity forces are quadratic, it proves nothing",
        ]


def ends_of_stability(ks: float, beta: float, period: float) -> tuple[Fraction, Fraction]:
    """1/a_hi and 1/a_lo, exactly."""
    k, b, length = Fraction(ks), Fraction(beta), Fraction(period)
    return Fraction(1, 2) + (b + k) * length / 4, Fraction(1, 2) + (b + k) / (b * k * length)


def conclude_loop(
    told: LoopContents, shown: EndsSeen, resists: Callable[[GravityClaim], bool]
) -> tuple[LoopConclusion, list[str]]:
    """What follows from the statements, if all of them are true, and what the header claims beyond it.

    Args:
        told: The header.
        shown: What its two configurations show.
        resists: Whether gravity's spring is below the small gain that the forms of a claim prove.

    Returns:
        The conclusion, and a sentence for each claim that does not follow.
    """
    found = spectrum(told)
    above, below = ends_of_stability(told.ks, told.beta, told.period)
    verdict: Literal["stable", "unstable", "undecided"] = "undecided"
    # M̄ = W: an eigenvalue of M against W is one of M⁻¹M̄, inverted.
    if Fraction(shown.least) <= above or Fraction(shown.largest) >= below:
        verdict = "unstable"
    if found.above is not None and found.below is not None and found.above >= above and found.below <= below:
        contradicted = verdict == "unstable"
        verdict = "stable"
    else:
        contradicted = False
    conclusion = LoopConclusion(
        verdict,
        told.mbar,
        told.ks,
        told.beta,
        told.period,
        (float_above(1 / below), float_below(1 / above)),
        (
            None if found.below is None else float_below(1 / found.below),
            None if found.above is None else float_above(1 / found.above),
        ),
        (float_above(1 / Fraction(shown.largest)), float_below(1 / Fraction(shown.least))),
        _gravity(told, found, resists) if verdict == "stable" else None,
    )
    said = []
    if told.gravity is not None and conclusion.gravity is None:
        said.append("nothing in the file proves it about rest under gravity")
    if told.verdict != verdict:
        said.append(f"it says '{told.verdict}', and what is in it shows '{verdict}'")
    if contradicted:
        said.append("it is proven stable and shown unstable, which cannot both be: please report it")
    if not told.statements and verdict != "unstable":
        said.append("it proves nothing and shows no instability")
    return conclusion, said


def _gravity(told: LoopContents, found: Spectrum, resists: Callable[[GravityClaim], bool]) -> float | None:
    """The magnitude that is claimed, where the pieces hold all eigenvalues that there can be and the forms prove it."""
    claim = told.gravity
    if claim is None or found.above is None or found.below is None:
        return None
    ends = claim.pieces.ends
    all_there = Fraction(ends[0]) * found.below <= 1 <= Fraction(ends[-1]) * found.above
    return claim.magnitude if all_there and resists(claim) else None
