"""What follows from statements: each guard that a theorem's hypothesis rests on, and what no one sentence can say."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from check_cases import arm, case, condition_of, header, hexed, statement, told
from condition_cases import chain_urdf

from asmc_pin.condition import lemma1_norm, weighted_norm
from asmc_pin.condition.checker.balls.witness import witness
from asmc_pin.condition.checker.conclusions import Conclusion, Witness, armature_words, conclude, disagreements
from asmc_pin.condition.checker.outcome import CheckedStatement, CheckResult
from asmc_pin.condition.checker.reading.certificate_schema import Contents
from asmc_pin.condition.checker.reading.header_parts import Malformed
from asmc_pin.condition.checker.reading.subject import Subject, subject
from asmc_pin.condition.checker.reading.urdf_text import description
from asmc_pin.condition.checker.spot_checks import Spots

NOTHING = Witness(0.0, False, False)


def _of(condition: str, *statements: dict[str, Any], **changes: Any) -> Contents:
    return told(2, condition=condition, statements=list(statements), **changes)


def _scale(condition: str, *statements: dict[str, Any], **changes: Any) -> float:
    return conclude(_of(condition, *statements, **changes), NOTHING).scale_proven


def _upper(condition: str, *statements: dict[str, Any], **changes: Any) -> float | None:
    return conclude(_of(condition, *statements, **changes), NOTHING).upper


def _range(low: list[float], high: list[float]) -> dict[str, Any]:
    return {"cases": [case(2, armature_lower=low, armature_upper=high)]}


# Scales -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["weighted", "lemma1"])
def test_a_scale_is_proven_by_the_largest_statement_at_no_more_than_the_least_armature(kind: str) -> None:
    ends = _range([0.1, 0.2], [0.3, 0.2])
    condition = condition_of(kind)
    for armature, proven in (
        ([0.0, 0.0], True),
        ([0.1, 0.2], True),
        ([0.05, 0.2], True),
        ([0.1000001, 0.2], False),
        ([0.1, 0.2000001], False),
        ([0.3, 0.2], False),
        ([0.0, 0.3], False),
    ):
        said = statement(2, kind, scale=0.7, armature=armature)
        assert _scale(condition, said, **ends) == (0.7 if proven else 0.0)
        weaker = statement(2, kind, scale=0.4)
        assert _scale(condition, said, weaker, **ends) == (0.7 if proven else 0.4)


def test_another_kind_or_a_level_proves_no_scale() -> None:
    assert _scale("weighted", statement(2, "bounded", scale=3.0, level=0.5)) == 0.0
    assert _scale("lemma1", statement(2, "level", scale=3.0, level=0.5)) == 0.0
    assert _scale("weighted", statement(2, "weighted", scale=3.0, level=0.9)) == 0.0
    assert _scale("weighted") == 0.0
    assert conclude(_of("weighted"), NOTHING).upper is None


def test_one_case_without_a_proof_leaves_nothing_proven() -> None:
    two = {"cases": [case(2, lower=[-1, -1]), case(2, lower=[-2, -2])]}
    first, second = statement(2, scale=1.5), statement(2, scale=1.2, case=1)
    assert _scale("weighted", first, **two) == 0.0
    assert _upper("weighted", first, **two) is None
    assert _scale("weighted", first, second, **two) == 1.2
    assert _upper("weighted", first, second, **two) == 1.0
    # A statement is about its own case, whatever that of another says.
    assert _scale("weighted", second, second, **two) == 0.0


def test_the_condition_itself_is_proven_at_the_scale_one_and_not_below() -> None:
    below = 1.0 - 2.0**-53
    assert _upper("weighted", statement(2, scale=1.0)) == 1.0
    assert _upper("weighted", statement(2, scale=below)) is None
    assert _upper("lemma1", statement(2, "lemma1", scale=1.7)) == 1.0
    assert _upper("lemma1", statement(2, "lemma1", scale=below)) is None


# Levels -------------------------------------------------------------------------------------------------------------


def test_a_weighted_level_needs_both_halves_at_the_scale_one() -> None:
    above, below = statement(2, "weighted", level=0.5), statement(2, "bounded", level=0.5)
    assert _upper("weighted", above, below) == 0.5
    assert _upper("weighted", above) is None
    assert _upper("weighted", below) is None
    for scale in (0.999, 1.001):
        assert _upper("weighted", {**above, "scale": scale}, below) is None
        assert _upper("weighted", above, {**below, "scale": scale}) is None
    # The weaker half counts, and a stronger one does not matter.
    assert _upper("weighted", {**above, "level": 0.3}, {**below, "level": 0.6}) == 0.6
    assert _upper("weighted", {**above, "level": 0.6}, {**below, "level": 0.3}) == 0.6
    # The condition itself is no half of a level below one.
    assert _upper("weighted", {**above, "level": 1.0}, below) == 1.0


def test_a_weighted_level_is_proven_at_the_least_armature_above_and_at_the_largest_below() -> None:
    ends = _range([0.1, 0.0], [0.3, 0.2])
    above = statement(2, "weighted", level=0.5, armature=[0.1, 0.0])
    below = statement(2, "bounded", level=0.5, armature=[0.3, 0.2])
    assert _upper("weighted", above, below, **ends) == 0.5
    for short in ([0.1, 0.0], [0.3, 0.19999], [0.29999, 0.2]):
        assert _upper("weighted", above, {**below, "armature": hexed(short)}, **ends) is None
        slack = [0.3 - short[0], 0.2 - short[1]]
        assert _upper("weighted", above, {**below, "armature": hexed(short), "slack": hexed(slack)}, **ends) == 0.5
        less = [max(0.0, x - 1e-9) for x in slack]
        assert _upper("weighted", above, {**below, "armature": hexed(short), "slack": hexed(less)}, **ends) is None
    assert _upper("weighted", {**above, "armature": hexed([0.1, 0.1])}, below, **ends) is None


def test_a_level_of_lemma_1_needs_all_corners_or_one_statement_with_slack() -> None:
    low, high = [0.1, 0.0], [0.3, 0.2]
    ends = _range(low, high)
    corners = [
        statement(2, "level", level=0.5, armature=list(corner)) for corner in product(*zip(low, high, strict=True))
    ]
    assert _upper("lemma1", *corners, **ends) == 0.5
    for missing in range(4):
        rest = corners[:missing] + corners[missing + 1 :]
        assert _upper("lemma1", *rest, **ends) is None
        assert _upper("lemma1", *rest, statement(2, "level", level=0.5, armature=[0.2, 0.1]), **ends) is None
        # A corner at a weaker level holds all of them back.
        weaker = {**corners[missing], "level": 0.8}
        assert _upper("lemma1", *rest, weaker, **ends) == 0.8
        elsewhere = {**corners[missing], "scale": 1.1}
        assert _upper("lemma1", *rest, elsewhere, **ends) is None
    whole = statement(2, "level", level=0.5, armature=low, slack=[0.2, 0.2])
    assert _upper("lemma1", whole, **ends) == 0.5
    # Other statements beside it take nothing away.
    assert _upper("lemma1", corners[0], whole, corners[3], **ends) == 0.5
    for changed in ({"slack": [0.2, 0.1]}, {"slack": [0.0, 0.2]}, {"armature": [0.05, 0.0]}, {"armature": [0.1, 0.1]}):
        assert (
            _upper(
                "lemma1", statement(2, "level", level=0.5, **{"armature": low, "slack": [0.2, 0.2], **changed}), **ends
            )
            is None
        )
    # The norm is not monotone in armature: a lower one proves nothing.
    assert _upper("lemma1", statement(2, "level", level=0.5), **_range([0.1, 0.1], [0.1, 0.1])) is None


def test_the_rounding_of_a_range_is_inside_its_slack_and_no_more() -> None:
    rng = np.random.default_rng(0)
    rounded = 0
    for _ in range(200):
        low, high = sorted(10.0 ** rng.uniform(-3.0, 1.0, 2))
        slack = high - low
        rounded += low + slack < high
        said = statement(1, "level", level=0.5, armature=[low], slack=[slack])
        for end, proven in ((high, 0.5), (high * (1.0 + 1e-14), None)):
            ends = {"cases": [case(1, armature_lower=[low], armature_upper=[end])]}
            assert conclude(told(1, condition="lemma1", statements=[said], **ends), NOTHING).upper == proven
    assert rounded > 0


def test_a_range_of_one_value_has_one_corner() -> None:
    assert (
        _upper("lemma1", statement(2, "level", level=0.5, armature=[0.1, 0.2]), **_range([0.1, 0.2], [0.1, 0.2])) == 0.5
    )
    half = [statement(2, "level", level=0.5, armature=[0.1, a]) for a in (0.2, 0.4)]
    assert _upper("lemma1", *half, **_range([0.1, 0.2], [0.1, 0.4])) == 0.5
    assert _upper("lemma1", half[0], **_range([0.1, 0.2], [0.1, 0.4])) is None
    assert _upper("lemma1", half[1], **_range([0.1, 0.2], [0.1, 0.4])) is None


def test_of_several_levels_the_least_that_is_covered_is_proven() -> None:
    statements = [statement(2, "level", level=0.3 + 0.1 * k, armature=[0.0, 0.1 * (k % 2)]) for k in range(6)]
    assert _upper("lemma1", *statements, **_range([0.0, 0.0], [0.0, 0.1])) == pytest.approx(0.4)
    assert _upper("lemma1", *reversed(statements), **_range([0.0, 0.0], [0.0, 0.1])) == pytest.approx(0.4)
    # A level at one and the condition at a larger scale: the better counts.
    both = (statement(2, "lemma1", scale=1.5), statement(2, "level", level=0.7))
    assert _upper("lemma1", *both) == 0.7


def test_the_bound_of_all_cases_is_the_worst_of_theirs() -> None:
    three = {"cases": [case(2, lower=[-k, -k]) for k in (1, 2, 3)]}
    levels = [statement(2, "level", level=level, case=k) for k, level in enumerate((0.5, 0.9, 0.7))]
    assert _upper("lemma1", *levels, **three) == 0.9
    assert _upper("lemma1", *levels[:2], statement(2, "lemma1", scale=1.0, case=2), **three) == 1.0
    assert _upper("lemma1", *levels[:2], **three) is None


def test_a_negative_slack_or_armature_is_no_statement() -> None:
    for key in ("slack", "armature"):
        with pytest.raises(Malformed, match="0 or more"):
            _of("lemma1", statement(2, "level", **{key: [0.0, -1e-9]}))
    for kind in ("weighted", "lemma1"):
        with pytest.raises(Malformed, match="no slack"):
            _of(condition_of(kind), statement(2, kind, slack=[0.0, 0.1]))


def test_ten_thousand_statements_or_cases_are_weighed_in_a_moment() -> None:
    many = [statement(2, "level", level=0.5 + 4e-5 * k, armature=[0.1, 0.0]) for k in range(10_000)]
    assert _upper("lemma1", *many, **_range([0.0, 0.0], [0.1, 0.1])) is None
    cases = {"cases": [case(2, lower=[-1.0 - k, -1.0]) for k in range(3000)]}
    assert _scale("weighted", *(statement(2, case=k) for k in range(3000)), **cases) == 1.0


# The verdict --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("level", "upper", "witness", "refuted", "verdict"),
    [
        (1.0, 1.0, NOTHING, 2.0, "holds"),
        (1.0, None, NOTHING, 2.0, "undecided"),
        (0.5, 1.0, NOTHING, 2.0, "undecided"),
        (0.5, 0.5, NOTHING, 2.0, "holds"),
        (0.5, 0.6, NOTHING, 2.0, "undecided"),
        (1.0, None, Witness(1.2, True, False), 2.0, "violated"),
        (0.5, None, Witness(0.7, True, False), 2.0, "violated"),
        (1.0, None, Witness(0.7, False, True), 0.9, "violated"),
        (1.0, None, Witness(0.7, False, True), 1.0, "violated"),
        (1.0, None, Witness(0.7, False, True), 1.0000001, "undecided"),
        (1.0, None, Witness(0.7, False, False), 0.9, "undecided"),
        (0.5, None, Witness(0.4, False, True), 0.9, "undecided"),
    ],
)
def test_the_verdict_is_what_is_shown_at_the_level_that_is_asked(
    level: float, upper: float | None, witness: Witness, refuted: float, verdict: str
) -> None:
    statements = []
    if upper is not None:
        statements = [statement(2, "level" if upper < 1.0 else "lemma1", level=upper)]
    found = conclude(_of("lemma1", *statements, level=level, scale_refuted=refuted), witness)
    assert (found.verdict, found.upper, found.lower) == (verdict, upper, witness.lower)
    assert found.scale_refuted == (refuted if witness.refuted else None)


def _said(found: Conclusion, *statements: dict[str, Any], **changes: Any) -> list[str]:
    claims = {
        "verdict": found.verdict,
        "scale_proven": found.scale_proven,
        "upper": found.upper,
        "lower": found.lower,
        "scale_refuted": 2.0 if found.scale_refuted is None else found.scale_refuted,
    }
    return disagreements(told(2, statements=list(statements), **{**claims, **changes}), found)


def test_a_header_that_says_no_more_than_what_follows_is_agreed_with() -> None:
    good = Conclusion("holds", 0.8, 0.9, 1.1, 1.5)
    one = statement(2)
    assert _said(good, one) == []
    assert _said(good, one, upper=None, scale_proven=0.5) == []
    assert _said(good, one, upper=0.95, scale_proven=0.0) == []


@pytest.mark.parametrize(
    ("found", "changes", "why"),
    [
        (Conclusion("undecided", 0.8, None, 0.9, 1.5), {"verdict": "holds"}, "shows 'undecided'"),
        (Conclusion("holds", 0.8, 0.9, 1.1, 1.5), {"scale_proven": 1.1000001}, "proves the scale"),
        (Conclusion("holds", 0.8, 0.9, 1.1, 1.5), {"upper": 0.8999999}, "norm is at most"),
        (Conclusion("undecided", 0.8, None, 0.9, 1.5), {"upper": 1.0}, "norm is at most"),
        (Conclusion("holds", 0.8, 0.9, 1.1, None), {}, "is none"),
        (Conclusion("holds", 0.8, 0.9, 1.1, 1.1), {}, "cannot both be"),
        (Conclusion("holds", 0.8, 0.9, 1.1, 1.05), {}, "cannot both be"),
        (Conclusion("undecided", 0.8, None, 0.6, 0.5), {}, "cannot both be"),
        # A level is the condition at the scale one too, also where no scale is proven by name.
        (Conclusion("holds", 0.8, 0.9, 0.0, 1.0), {}, "cannot both be"),
        (Conclusion("holds", 0.9, 0.9, 1.1, 1.5), {}, "cannot both be"),
        (Conclusion("violated", 1.2, 1.0, 1.1, 1.5), {}, "cannot both be"),
        (Conclusion("holds", 0.8, 0.9, 1.1, 1.5), {"lower": 0.80001}, "worst configuration"),
        (Conclusion("holds", 0.8, 0.9, 1.1, 1.5), {"lower": 0.79999}, "worst configuration"),
        (Conclusion("violated", 800.0, None, 0.0, 0.5), {"lower": 800.01}, "worst configuration"),
    ],
)
def test_a_claim_that_does_not_follow_and_two_that_contradict_each_other_are_said(
    found: Conclusion, changes: dict[str, Any], why: str
) -> None:
    said = _said(found, statement(2), **changes)
    assert len(said) == 1
    assert why in said[0]


def test_what_proves_nothing_and_shows_no_violation_is_no_certificate() -> None:
    assert "proves nothing" in _said(Conclusion("undecided", 0.8, None, 0.0, 1.5))[0]
    assert _said(Conclusion("violated", 1.2, None, 0.0, 0.5)) == []
    # What is refuted just above all that is proven contradicts nothing, and neither where nothing is.
    assert _said(Conclusion("holds", 0.8, 0.9, 0.0, 1.05), statement(2)) == []
    assert _said(Conclusion("violated", 1.2, None, 0.0, 0.05)) == []
    # No multiple at all is refuted by a scale of zero, and contradicts no scale that is not proven.
    assert _said(Conclusion("violated", 1.2, None, 0.0, 0.0)) == []


def test_the_norm_is_compared_as_closely_as_it_is_written() -> None:
    good = Conclusion("violated", 1000.0, None, 0.0, 0.5)
    assert _said(good, lower=1000.0009) == []
    assert _said(good, lower=1000.0011) != []
    small = Conclusion("violated", 1e-3, None, 0.0, 0.5)
    assert _said(small, lower=1e-3 + 0.9e-6) == []
    assert _said(small, lower=1e-3 + 1.1e-6) != []


# Which armature a statement is about ---------------------------------------------------------------------------------

RANGE = {"armature_lower": [0.1, 0.1], "armature_upper": [0.2, 0.3]}


def _words(kind: str, **changes: Any) -> str:
    made = told(2, condition=condition_of(kind), cases=[case(2, **RANGE)], statements=[statement(2, kind, **changes)])
    return armature_words(made, made.statements[0])


@pytest.mark.parametrize("kind", ["weighted", "lemma1"])
def test_what_gains_by_armature_is_stated_at_the_lower_end(kind: str) -> None:
    assert _words(kind, armature=[0.1, 0.1]) == ""
    assert _words(kind, armature=[0.1, 0.1], scale=1.3) == ""
    for armature in ([0.2, 0.1], [0.2, 0.3], [0.15, 0.1], [0.0, 0.1]):
        with pytest.raises(Malformed, match="another armature"):
            _words(kind, armature=armature)


@pytest.mark.parametrize("kind", ["bounded", "level"])
def test_what_loses_by_armature_is_stated_with_its_slack(kind: str) -> None:
    assert _words(kind, armature=[0.1, 0.1], slack=[0.1, 0.2]) == ""
    assert _words(kind, armature=[0.1, 0.1], slack=[0.2, 0.3]) == ""
    for armature, slack in (([0.1, 0.1], [0.1, 0.1]), ([0.15, 0.1], [0.1, 0.2]), ([0.2, 0.1], [0.1, 0.2])):
        with pytest.raises(Malformed, match="another armature"):
            _words(kind, armature=armature, slack=slack)
    with pytest.raises(Malformed, match="not about M̄ itself"):
        _words(kind, armature=[0.1, 0.1], slack=[0.1, 0.2], scale=1.1)


def test_only_a_level_may_be_stated_at_one_corner_of_the_range() -> None:
    for corner in ([0.1, 0.1], [0.2, 0.1], [0.1, 0.3], [0.2, 0.3]):
        assert _words("level", armature=corner) == f"armature {corner[0]!r}, {corner[1]!r} kg·m²"
        with pytest.raises(Malformed, match="another armature"):
            _words("bounded", armature=corner)
    with pytest.raises(Malformed, match="another armature"):
        _words("level", armature=[0.15, 0.1])


# Configurations -----------------------------------------------------------------------------------------------------


def _witness(condition: str = "weighted", **changes: Any) -> Witness:
    chain, balls = arm(0, 2)
    seen = {"case": 0, "q": hexed([0.3, 0.2]), "armature": hexed([0.0, 0.0])}
    fields = {"worst": seen, "refuted": dict(seen), **changes}
    return witness(told(2, condition=condition, statements=[], **fields), [balls], [chain])


def _seen(q: list[float], armature: list[float]) -> dict[str, Any]:
    return {"case": 0, "q": hexed(q), "armature": hexed(armature)}


@pytest.mark.parametrize("which", ["worst", "refuted"])
def test_a_configuration_outside_the_box_or_the_armatures_range_shows_nothing(which: str) -> None:
    ends = {"cases": [case(2, armature_lower=[0.1, 0.1], armature_upper=[0.2, 0.2])]}
    inside = {key: _seen([0.3, 0.2], [0.1, 0.2]) for key in ("worst", "refuted")}
    assert _witness(**ends, **inside).lower > 0.0
    # The first joint turns the whole arm, and does not matter.
    _witness(**ends, **{**inside, which: _seen([9.0, 1.0 + 1e-12], [0.1, 0.2 + 1e-12])})
    for q, armature in (
        ([0.0, 1.00001], [0.1, 0.1]),
        ([0.0, -1.00001], [0.1, 0.1]),
        ([0.0, 0.0], [0.09999, 0.1]),
        ([0.0, 0.0], [0.1, 0.20001]),
    ):
        with pytest.raises(Malformed, match="outside"):
            _witness(**ends, **{**inside, which: _seen(q, armature)})


def test_a_configuration_is_a_witness_of_the_norm_that_it_has() -> None:
    for condition in ("weighted", "lemma1"):
        found = _witness(condition)
        norm = found.lower
        assert norm > 0.0
        assert _witness(condition, level=min(1.0, norm * (1.0 - 1e-9))).at_level or norm > 1.0
        if norm < 1.0:
            assert not _witness(condition, level=norm * (1.0 + 1e-9)).at_level


@pytest.mark.parametrize("size", [1e-3, 1.0, 30.0, 1e3])
@pytest.mark.parametrize("condition", ["weighted", "lemma1"])
def test_a_witness_shows_the_whole_norm_whether_mbar_is_too_small_or_too_large(condition: str, size: float) -> None:
    chain, _ = arm(0, 2)
    mbar = np.array([1.0, 0.4]) * size
    M = chain.mass_matrix(np.array([0.3, 0.2]), np.zeros(2))
    norm = float((weighted_norm if condition == "weighted" else lemma1_norm)(M, mbar))
    assert _witness(condition, mbar=hexed(mbar)).lower == pytest.approx(norm, rel=1e-9)


def test_a_counter_example_is_one_at_its_scale_and_not_below() -> None:
    low, high = 1e-6, 1e6
    for _ in range(200):
        f = (low * high) ** 0.5
        low, high = (low, f) if _witness(scale_refuted=f).refuted else (f, high)
        if high / low < 1.0 + 1e-10:
            break
    assert _witness(scale_refuted=high * (1.0 + 1e-9)).refuted
    assert not _witness(scale_refuted=low * (1.0 - 1e-9)).refuted
    # No scale at all: nothing of the weighted condition, which a small M̄ always satisfies.
    assert not _witness(scale_refuted=0.0).refuted
    assert not _witness("lemma1", scale_refuted=0.0).refuted
    assert _witness("lemma1", scale_refuted=0.0, mbar=hexed([1e-6, 1e3])).refuted


# What it is about ---------------------------------------------------------------------------------------------------

LOAD = {"mass": "0x1p+0", "com": hexed([0.1, 0.0, 0.0]), "inertia": hexed([0.0] * 6), "link": "l1"}
EMPTY = {**LOAD, "mass": "0x0p+0"}
HEAVY = {**LOAD, "mass": "0x1p+1"}


def _subject(*cases: dict[str, Any], **changes: Any) -> Subject:
    text = chain_urdf(0, 2)
    return subject(told(2, cases=list(cases), statements=[], **changes), text, description(text), arm(0, 2)[0])


def test_the_hypotheses_are_what_the_cases_are() -> None:
    found = _subject(
        *(
            case(2, payload=load, locked={"k": angle, "m": 0.5}, armature_lower=[0.1, 0.0], armature_upper=[0.1, 0.2])
            for load, angle in product((EMPTY, LOAD), (0.25, -0.5))
        ),
        condition="lemma1",
        level=0.9,
        mbar=hexed([0.5, 0.25]),
    )
    about = found.hypotheses
    assert (about.arm, about.joints, about.condition, about.mbar) == ("chain", ("j0", "j1"), "lemma1", (0.5, 0.25))
    assert about.formula == "‖I − M⁻¹M̄‖₂ < 0.9"
    assert about.armature == (0.1, (0.0, 0.2))
    assert about.locked == {"k": (-0.5, 0.25), "m": 0.5}
    assert about.box == {"j0": (-1.0, 1.0), "j1": (-1.0, 1.0)}
    assert about.payload is not None
    assert (about.payload.mass, about.payload.link, about.payload.com) == ((0.0, 1.0), "l1", (0.1, 0.0, 0.0))
    assert (about.where, about.parts, about.slides) == ("box", 1, (False, False))
    assert found.labels == (
        "k locked at 0.25, payload 0.0 kg",
        "k locked at -0.5, payload 0.0 kg",
        "k locked at 0.25, payload 1.0 kg",
        "k locked at -0.5, payload 1.0 kg",
    )
    said = "\n".join(about.lines())
    for words in ("0 to 1 kg at (0.1, 0, 0) m on l1", "0 to 0.2", "k at -0.5 and at 0.25", "diag(0.5, 0.25)"):
        assert words in said


def test_boxes_are_named_as_such_and_not_as_their_hull() -> None:
    found = _subject(case(2, lower=[0, 0]), case(2, lower=[-3, -1], upper=[-2, 0]))
    about = found.hypotheses
    assert about.box == {"j0": (-3.0, 1.0), "j1": (-1.0, 1.0)}
    assert (about.where, about.parts) == ("boxes", 2)
    assert found.labels == ("box 2 of 2", "box 1 of 2")
    assert about.boxes == (((-3.0, -1.0), (-2.0, 0.0)), ((0.0, 0.0), (1.0, 1.0)))


def test_one_payload_or_none_is_no_range() -> None:
    assert _subject(case(2)).hypotheses.payload is None
    one = _subject(case(2, payload=LOAD)).hypotheses.payload
    assert one is not None
    assert (one.mass, one.inertia_lightest) == (1.0, None)
    two = _subject(case(2, payload=LOAD), case(2)).hypotheses.payload
    assert two is not None
    assert (two.mass, two.inertia_lightest) == ((0.0, 1.0), (0.0,) * 6)


MANY: dict[str, list[dict[str, Any]]] = {
    "payloads at two points": [case(2, payload=load) for load in (LOAD, {**HEAVY, "com": hexed([0.2, 0.0, 0.0])})],
    "payloads on two links": [case(2, payload=load) for load in (LOAD, {**HEAVY, "link": "l0"})],
    "three payloads": [case(2, payload=load) for load in (EMPTY, LOAD, HEAVY)],
    "two payloads of one mass": [
        case(2, payload=load) for load in (LOAD, {**LOAD, "inertia": hexed([0.1, 0, 0, 0.1, 0, 0.1])})
    ],
    "a case twice": [case(2), case(2)],
    "a case twice but for its label": [case(2), case(2, label="another")],
    "two ranges of the armature": [case(2), case(2, lower=[-2, -2], armature_upper=[0.1, 0.0])],
    "two lower ends of the armature": [
        case(2, armature_upper=[1, 1]),
        case(2, lower=[-2, -2], armature_lower=[0.5, 0], armature_upper=[1, 1]),
    ],
    "different joints locked": [case(2, locked={"a": 0.0}), case(2, locked={"b": 0.0})],
    "a joint locked and not": [case(2, locked={"a": 0.0}), case(2)],
    "a lock, a payload, and not both": [case(2, locked={"a": 0.0}), case(2, locked={"a": 1.0}, payload=LOAD)],
    "a box with one of two payloads": [
        case(2, payload=load, lower=[low, -1.0]) for load, low in ((LOAD, -1.0), (LOAD, -2.0), (EMPTY, -1.0))
    ],
    "as many as it has, one of them twice": [
        case(2, locked={"a": a, "b": b}) for a, b in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 0.0))
    ],
}


@pytest.mark.parametrize("what", MANY)
def test_cases_that_are_no_ranges_are_refused_and_no_sentence_made_of_them(what: str) -> None:
    with pytest.raises(Malformed):
        _subject(*MANY[what])


def test_whole_products_of_ranges_are_taken() -> None:
    whole = [
        case(2, locked={"a": a, "b": b}, payload=load, lower=[low, -1.0])
        for a, b, load, low in product((0.0, 1.0), (0.5, 0.6, 0.7), (None, LOAD), (-1.0, -2.0))
    ]
    assert _subject(*whole).hypotheses.parts == 2
    for left_out in (0, 7, 23):
        with pytest.raises(Malformed, match="ends of its ranges"):
            _subject(*(whole[:left_out] + whole[left_out + 1 :]))


def test_locks_of_which_not_every_combination_is_proven_are_said_to_go_together() -> None:
    every = list(product((0.0, 1.0), repeat=2))
    for chosen, together in ((every, False), (every[:3], True), ([(0.0, 0.0), (1.0, 1.0)], True)):
        about = _subject(*(case(2, locked={"a": a, "b": b}) for a, b in chosen)).hypotheses
        assert about.together is together
        # And not with another payload at each.
        cases = [case(2, locked={"a": a, "b": b}, payload=LOAD if a else None) for a, b in chosen]
        with pytest.raises(Malformed, match="ends of its ranges"):
            _subject(*cases)


def test_a_product_too_large_to_list_is_not_listed() -> None:
    cases = [case(2, locked={"a": float(k)}, lower=[-1.0 - k, -1.0]) for k in range(3000)]
    with pytest.raises(Malformed, match="ends of its ranges"):
        _subject(*cases)


def test_names_and_hashes_of_the_header_are_not_what_is_said() -> None:
    about = _subject(case(2, label="forged"), arm="ur5", sha256="0" * 64, source="ur5.urdf").hypotheses
    assert about.arm == "chain"
    assert about.sha256 != "0" * 64
    assert "ur5" not in "\n".join(about.lines())
    assert "forged" not in "\n".join(about.lines())
    assert header(2)["arm"] == ""


# What is shown ------------------------------------------------------------------------------------------------------


def _said_of(found: Conclusion) -> str:
    return " ".join(line.strip() for line in found.lines())


def test_no_scale_of_0_is_said_to_be_proven() -> None:
    nothing = _said_of(Conclusion("undecided", 0.5, None, 0.0, None))
    assert nothing == "undecided: the norm is at least 0.5 at the worst configuration known"
    much = _said_of(Conclusion("holds", 0.25, 0.75, 1.25, 1.5))
    assert much == (
        "holds: the condition is proven for M̄ × 1.25, broken for M̄ × 1.5, the norm is at least 0.25 at the worst "
        "configuration known, and proven to be below 0.75"
    )
    assert "broken for every multiple of M̄" in _said_of(Conclusion("violated", 2.0, None, 0.0, 0.0))
    less = _said_of(Conclusion("violated", 2.0, None, 0.0, 0.5))
    assert less.startswith("violated: broken for M̄ × 0.5, the norm")


def test_what_is_valid_is_shown_with_what_it_is_about_and_at_which_level() -> None:
    found = Conclusion("holds", 0.25, 0.75, 1.25, 1.5)
    for level, said in ((1.0, False), (0.9, True)):
        about = _subject(case(2), level=level, mbar=hexed([0.5, 0.25])).hypotheses
        shown = CheckResult("x.cert", True, (), about, found, (), 0.1).lines()
        assert [line for line in shown if line in found.lines()] == found.lines()
        assert [line for line in shown if line in about.lines()] == about.lines()
        assert any(f"the verdict is about {about.formula}" in line for line in shown) is said


@pytest.mark.parametrize(
    ("boxes", "proven", "said"),
    [
        (1, True, "1 box covers the joint box, proven again (3 halved further)"),
        (1, False, "1 box covers the joint box, not proven again (3 halved further)"),
        (2, True, "2 boxes cover the joint box, all proven again (3 halved further)"),
        (7, False, "7 boxes cover the joint box, not all proven again (3 halved further)"),
    ],
)
def test_a_statement_is_said_to_be_proven_again_only_where_it_is(boxes: int, proven: bool, said: str) -> None:
    checked = CheckedStatement("weighted", 1.5, 0.5, "", boxes, 3, proven, Spots())
    (line,) = [x for x in CheckResult("x.cert", proven, (), None, None, (checked,), 0.1).lines() if "halved" in x]
    assert line.endswith(said)
