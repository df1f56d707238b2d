"""What follows for a sampled loop from bounds of its eigenvalues, against the spectral radius of its whole map."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from check_cases import case, header, hexed, statement

from asmc_pin.condition.checker.loop_conclusion import LoopConclusion, conclude_loop, ends_of_stability
from asmc_pin.condition.checker.reading.certificate_schema import LoopContents, contents
from asmc_pin.condition.checker.spectrum import EndsSeen
from asmc_pin.sampled import SampledLoop, spectral_radius

KS, BETA, PERIOD = 20.0, 12.0, 0.01


def _told(low: float | None, high: float | None, verdict: str, gravity: Any = None) -> LoopContents:
    """A header whose statements bound λ(M⁻¹M̄) from below and from above; by floats that say no more than that."""
    said = []
    if high is not None:  # M ≻ f/2 W
        said.append(statement(2, "weighted", scale=2.0 / high))
    if low is not None:  # M ≺ 2 f W
        said.append(statement(2, "bounded", scale=0.5 / low, level=0.5))
    whole = header(2, cases=[case(2)], statements=said)
    seen = whole["worst"]
    for key in ("condition", "level", "upper", "scale_proven", "scale_refuted", "lower", "worst", "refuted"):
        del whole[key]
    gains = {"ks": hexed(KS), "beta": hexed(BETA), "period": hexed(PERIOD), "verdict": verdict, "gravity": gravity}
    made = contents({**whole, "about": "sampled loop", "least": seen, "largest": seen, **gains})
    assert isinstance(made, LoopContents)
    return made


def _concluded(
    low: float | None, high: float | None, shown: tuple[float, float], verdict: str = "undecided"
) -> tuple[LoopConclusion, list[str]]:
    """From a proven range of λ(M⁻¹M̄), and from two that are shown: those of M against M̄ are their inverses."""
    return conclude_loop(_told(low, high, verdict), EndsSeen(1.0 / shown[1], 1.0 / shown[0]), lambda claim: True)


def _largest_radius(low: float, high: float) -> float:
    """Over joints whose inertia is so many times smaller than their M̄ = 1."""
    loop = SampledLoop(np.ones(1), KS, BETA, PERIOD)
    return max(float(spectral_radius(np.array([[1.0 / a]]), loop)) for a in np.linspace(low, high, 9))


def test_a_loop_is_called_stable_only_where_its_whole_map_contracts_over_all_that_is_proven() -> None:
    ends = tuple(float(1 / end) for end in reversed(ends_of_stability(KS, BETA, PERIOD)))
    seen = set()
    for inside_low, inside_high in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        low, high = ends[0] * (1.0 + 1e-3 * inside_low), ends[1] * (1.0 - 1e-3 * inside_high)
        stable = _largest_radius(low, high) < 1.0
        assert stable == (inside_low == inside_high == 1)
        # Nothing is shown but what contracts: what is not proven is open, and no more.
        verdict = "stable" if stable else "undecided"
        found, said = _concluded(low, high, (0.9, 1.1), verdict)
        assert (found.verdict, said) == (verdict, [])
        assert found.proven_between == pytest.approx((low, high), rel=1e-12)
        assert found.stable_between == pytest.approx(ends, rel=1e-12)
        assert found.shown == pytest.approx((0.9, 1.1), rel=1e-12)
        # And what is shown to grow is unstable.
        found, said = _concluded(low, high, (low, high), "stable" if stable else "unstable")
        assert (found.verdict, said) == ("stable" if stable else "unstable", [])
        seen.add(found.verdict)
    assert seen == {"stable", "unstable"}


def test_one_end_alone_proves_no_loop_stable() -> None:
    for low, high in ((0.5, None), (None, 1.5), (None, None)):
        found, said = _concluded(low, high, (0.9, 1.1), "stable")
        assert found.verdict == "undecided"
        assert any("shows 'undecided'" in problem for problem in said)


def test_what_is_proven_and_shown_of_the_eigenvalues_is_printed_rounded_to_the_safe_side() -> None:
    def said(low: float | None, high: float | None) -> str:
        (line,) = [x for x in _concluded(low, high, (0.9, 1.1))[0].lines() if "it is stable where" in x]
        return line

    low, high = 0.6 + 1e-7, 1.4 - 1e-7
    both = re.search(r"proven over the box: (\S+) < λ, λ < (\S+); shown: (\S+) and (\S+)$", said(low, high))
    assert both is not None
    least, most, first, last = map(float, both.groups())
    assert low * 0.999 < least <= low
    assert high <= most < high * 1.001
    assert (first, last) == pytest.approx((0.9, 1.1), rel=1e-3)
    assert re.search(r"proven over the box: \S+ < λ; shown", said(low, None))
    assert re.search(r"proven over the box: λ < \S+; shown", said(None, high))
    assert "; nothing is proven of λ; shown" in said(None, None)


@pytest.mark.parametrize(
    ("low", "high", "ends", "resists", "shown"),
    [
        (0.8, 1.2, (0.8, 1.2), True, True),
        (0.8, 1.2, (0.5, 1.0, 2.0), True, True),
        (0.8, 1.2, (0.8, 1.2), False, False),
        # Eigenvalues that there may be, and no piece for them.
        (0.8, 1.2, (0.81, 1.2), True, False),
        (0.8, 1.2, (0.8, 1.19), True, False),
    ],
)
def test_gravity_is_withstood_only_where_the_pieces_hold_all_eigenvalues_that_there_may_be(
    low: float, high: float, ends: tuple[float, ...], resists: bool, shown: bool
) -> None:
    forms = [hexed([1.0] * 6)] * (len(ends) - 1)
    claim = {"magnitude": hexed(9.81), "pieces": {"ends": hexed([*ends]), "forms": forms}}
    inside = low * (1.0 + 1e-12), high * (1.0 - 1e-12)
    told = _told(*inside, "stable", claim)
    found, said = conclude_loop(told, EndsSeen(1.0, 1.0), lambda claim: resists)
    assert found.verdict == "stable"
    assert found.gravity == (9.81 if shown else None)
    assert any("under gravity" in problem for problem in said) is not shown
    assert any("up to 9.81 m/s² in any direction" in line for line in found.lines()) is shown
