"""Bounds of eigenvalues from proven statements and from two configurations: exact, rounded to the safe side, held."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from check_cases import arm, case, header, hexed, statement
from flint import arb

from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.rayleigh import eigenvalues_seen
from asmc_pin.condition.checker.bounds_conclusion import BoundsConclusion, conclude_bounds
from asmc_pin.condition.checker.reading.certificate_schema import BoundsContents, contents
from asmc_pin.condition.checker.reading.header_parts import Malformed
from asmc_pin.condition.checker.spectrum import EndsSeen, float_above, float_below, spectrum

W, S = (1.0, 3.0), (2.0, 1.0)
"""M against W: an M of W's own shape, m W, has S M S = m diag(4, 3)."""

ABOVE = statement(2, "weighted", scale=0.5)  # M ≻ W / 4
BELOW = statement(2, "bounded", scale=1.0, level=0.5)  # M ≺ 2 W
SEEN = EndsSeen(1.0, 6.0)


def _told(*statements: dict[str, Any], n: int = 2, **changes: Any) -> BoundsContents:
    whole = header(n, mbar=hexed(W), cases=[case(n)], statements=list(statements))
    seen = whole["worst"]
    dropped = ("condition", "verdict", "level", "upper", "scale_proven", "scale_refuted", "lower", "worst", "refuted")
    for key in dropped:
        del whole[key]
    claims = {"lower": [None, 1.0], "upper": [None, 6.0], "coriolis": 9.0, "scaling": hexed(S)}
    made = contents({**whole, "about": "bounds", "least": seen, "largest": seen, **claims, **changes})
    assert isinstance(made, BoundsContents)
    return made


def _concluded(*statements: dict[str, Any], **changes: Any) -> tuple[BoundsConclusion, list[str]]:
    return conclude_bounds(_told(*statements, **changes), SEEN, lambda largest: 9.0)


# What statements prove ----------------------------------------------------------------------------------------------


def test_the_nearest_floats_on_either_side_of_a_number_enclose_it_and_nothing_lies_between() -> None:
    rng = np.random.default_rng(0)
    for _ in range(300):
        number = Fraction(float(rng.random())) * Fraction(3, 7) ** int(rng.integers(-700, 700))
        low, high = float_below(number), float_above(number)
        assert Fraction(low) <= number
        assert high == math.inf or number <= Fraction(high)
        assert high in (low, math.nextafter(low, math.inf))
    assert float_below(Fraction(3, 4)) == float_above(Fraction(3, 4)) == 0.75
    far = Fraction(10) ** 400
    assert (float_below(far), float_above(far)) == (np.finfo(float).max, math.inf)


def test_of_each_case_the_best_statement_counts_and_of_all_cases_the_worst() -> None:
    two = {"cases": [case(2), case(2, lower=[-2.0, -1.0])]}
    other = {"case": 1}
    said = [ABOVE, {**ABOVE, "scale": 0.4}, {**ABOVE, **other, "scale": 0.3}, {**ABOVE, **other, "scale": 0.2}]
    said += [BELOW, {**BELOW, "scale": 1.5}, {**BELOW, **other, "scale": 3.0}, {**BELOW, **other, "scale": 4.0}]
    found = spectrum(_told(*said, **two))
    assert (found.above, found.below) == (Fraction(0.3) / 2, Fraction(6))
    # A level below one proves more of the least eigenvalue: M ≻ f/(1 + γ) W.
    assert spectrum(_told({**ABOVE, "level": 0.25})).above == Fraction(2, 5)
    for missing in (0, 1):
        rest = [each for each in said if each["case"] == missing]
        assert spectrum(_told(*rest, **two)) == spectrum(_told())


def test_a_bound_counts_only_where_it_covers_the_range_of_the_armature() -> None:
    ends = {"cases": [case(2, armature_lower=[0.1, 0.2], armature_upper=[0.3, 0.4])]}
    at = {low: {"armature": hexed(end)} for low, end in ((True, [0.1, 0.2]), (False, [0.3, 0.4]))}
    found = spectrum(_told({**ABOVE, **at[True]}, {**BELOW, **at[False]}, **ends))
    assert (found.above, found.below) == (Fraction(1, 4), Fraction(2))
    found = spectrum(_told({**ABOVE, **at[False]}, {**BELOW, **at[True]}, **ends))
    assert (found.above, found.below) == (None, None)


def test_the_bounds_are_those_of_the_least_and_the_largest_m_that_the_statements_leave() -> None:
    found, said = _concluded(ABOVE, BELOW, lower=[0.75, 1.0], upper=[8.0, 6.0])
    assert said == []
    # S (W/4) S = diag(1, 3/4) and S (2 W) S = diag(8, 6).
    assert (found.verdict, found.lower, found.upper) == ("holds", (0.75, 1.0), (8.0, 6.0))
    assert found.condition_number == float_above(Fraction(32, 3))
    half, said = _concluded(ABOVE)
    assert (half.verdict, half.lower, half.upper, half.condition_number, said) == (
        "undecided",
        (0.75, 1.0),
        (None, 6.0),
        None,
        [],
    )
    assert found.to_json_dict()["condition_number"] == [found.condition_number, None]
    assert found.to_json_dict()["coriolis"] == [9.0, None]


def test_velocity_forces_are_bounded_with_the_eigenvalue_that_is_proven_or_without() -> None:
    asked: list[float | None] = []
    for statements in ((ABOVE, BELOW), (ABOVE,)):
        conclude_bounds(_told(*statements), SEEN, lambda largest: (asked.append(largest), 9.0)[1])
    assert asked == [8.0, None]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"lower": [0.7500001, 1.0]}, "no eigenvalue is below"),
        ({"upper": [7.9999999, 6.0]}, "no eigenvalue is above"),
        ({"coriolis": 8.9999999}, "velocity forces are bounded by 9, not by 8.99"),
        ({"coriolis": None}, "velocity forces are bounded by 9, not by None"),
        ({"lower": [0.75, 1.00001]}, "the eigenvalue is 1, not 1.00001"),
        ({"lower": [0.75, 0.99999]}, "the eigenvalue is 1, not 0.99999"),
        ({"upper": [8.0, 6.0001]}, "the eigenvalue is 6, not 6.0001"),
    ],
)
def test_a_claim_of_a_bound_that_does_not_follow_is_said(changes: dict[str, Any], why: str) -> None:
    _, said = _concluded(ABOVE, BELOW, **changes)
    assert len(said) == 1
    assert why in said[0]


@pytest.mark.parametrize("name", ["lower", "upper"])
def test_a_bound_that_no_statement_proves_is_no_claim_to_make(name: str) -> None:
    claim = {"lower": [1e-9, 1.0], "upper": [1e9, 6.0]}
    _, said = _concluded(BELOW if name == "lower" else ABOVE, **{name: claim[name]})
    assert len(said) == 1
    assert "nothing in the file proves" in said[0]
    assert "it proves nothing" in _concluded()[1]


def test_an_eigenvalue_that_is_shown_at_or_beyond_a_proven_bound_is_a_contradiction() -> None:
    for seen, contradicted in (((0.7500001, 6.0), False), ((0.75, 6.0), True), ((1.0, 8.0), True), ((1.0, 7.9), False)):
        changes = {"lower": [None, seen[0]], "upper": [None, seen[1]]}
        _, said = conclude_bounds(_told(ABOVE, BELOW, **changes), EndsSeen(*seen), lambda largest: 9.0)
        assert any("cannot both be" in each for each in said) is contradicted
        assert len(said) == contradicted


def test_of_joints_that_follow_others_no_bound_of_velocity_forces_may_be_claimed() -> None:
    for claim, problems in ((9.0, 1), (None, 0)):
        found, said = conclude_bounds(_told(ABOVE, BELOW, coriolis=claim), SEEN, lambda largest: None)
        assert found.coriolis is None
        assert len(said) == problems
    assert any("nothing is shown of ‖S C(q, Sx) Sx‖" in line for line in found.lines())


def test_what_is_printed_of_a_bound_is_what_is_proven_or_weaker() -> None:
    third = {**ABOVE, "level": 0.5}  # M ≻ W/3, a bound of one
    text = "\n".join(_concluded(third, BELOW)[0].lines())
    assert "holds: over every q of the box 1 I ≺ S M(q) S, S M(q) S ≺ 8 I, λ_max/λ_min ≤ 8" in text
    assert "‖S C(q, Sx) Sx‖ ≤ 9 ‖x‖², from masses and reaches" in text
    assert "an eigenvalue of at most 1 and one of at least 6" in text
    half = "\n".join(_concluded(ABOVE)[0].lines())
    assert "undecided: over every q of the box 0.75 I ≺ S M(q) S\n" in half
    assert "nothing is proven of its eigenvalues" in "\n".join(_concluded()[0].lines())
    # A third is no float: neither it nor what is divided by it is said to be more than it is.
    plain = "\n".join(_concluded(third, BELOW, scaling=hexed([1.0, 1.0]))[0].lines())
    assert "box 0.333333 I ≺ M(q), M(q) ≺ 6 I, λ_max/λ_min ≤ 18.0001" in plain
    assert "‖C(q, q̇)q̇‖ ≤ 9 ‖q̇‖²" in plain


# What configurations show -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_the_eigenvalues_that_two_configurations_show_are_those_of_m_against_w_there(seed: int) -> None:
    chain, balls = arm(seed, 3)
    rng = np.random.default_rng(seed)
    weights, armature = 10.0 ** rng.uniform(-1.0, 1.0, 3), rng.uniform(0.0, 0.2, 3)
    q = rng.uniform(-1.0, 1.0, (2, 3))
    ends = {"cases": [case(3, armature_upper=[0.2] * 3)], "mbar": hexed([1.0] * 3), "scaling": hexed([1.0] * 3)}

    def shown(at: Array) -> EndsSeen:
        least, largest = ({"case": 0, "q": hexed(row), "armature": hexed(armature)} for row in at)
        made = _told(n=3, least=least, largest=largest, **ends)
        return eigenvalues_seen(made, [arb(float(w)) for w in weights], [balls], [chain])

    found, root = shown(q), np.sqrt(weights)
    values = np.linalg.eigvalsh(chain.mass_matrix(q, armature) / root / root[:, None])
    assert (found.least, found.largest) == pytest.approx((values[0, 0], values[1, -1]), rel=1e-10)
    outside = q.copy()
    outside[seed % 2, 2] = 1.00001
    with pytest.raises(Malformed, match="outside"):
        shown(outside)
