"""The checker's own bounds of boxes: each step is a lower bound, each term of a loss is needed, no false box passes.

Judged by exact fractions, by balls of 300 bits, or on trigonometric polynomials for which a bound is as good as exact.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from certificate_cases import question
from check_cases import (
    KINDS,
    exact,
    is_positive,
    plus,
    random_form,
    random_metric,
    two_joints,
)
from flint import arb, arb_mat, ctx

from asmc_pin._typing import Array
from asmc_pin.condition.checker.boxes import box_bounds as bounds
from asmc_pin.condition.checker.boxes.quadratic_form import Form, form_of
from asmc_pin.condition.checker.reading.header_parts import WrittenStatement
from asmc_pin.condition.checker.reading.link_chain import Chain, cross
from asmc_pin.rigid_body.mass_matrix import mass_matrices
from asmc_pin.rigid_body.tree import Tree

TOLERANCE = 1e-12

# Rounding -----------------------------------------------------------------------------------------------------------


def test_what_is_taken_off_for_rounding_is_the_tolerance_of_the_magnitudes() -> None:
    rng = np.random.default_rng(0)
    A, size = rng.normal(size=(5, 6, 6)), rng.uniform(1.0, 9.0, (5, 6))
    lowered = bounds._lowered(A, size)
    assert np.array_equal(lowered, np.swapaxes(lowered, 1, 2))
    taken = 0.5 * (A + np.swapaxes(A, 1, 2)) - lowered
    assert taken == pytest.approx(np.eye(6) * (TOLERANCE * size)[:, :, None], abs=1e-15)


def test_a_matrix_is_surely_positive_only_if_every_matrix_within_the_tolerance_is() -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        scale = 10.0 ** rng.uniform(-6.0, 6.0, 6)
        L = rng.normal(size=(6, 5))
        singular = L @ L.T
        size = np.diagonal(singular).copy()
        weight = size * scale**2
        # Less than the tolerance above a singular matrix, and at it: the true one may be singular.
        for share, sure in ((0.1, False), (0.5, False), (0.9, False), (1.5, False), (4.0, True)):
            raised = (singular + share * TOLERANCE * np.diag(size)) * scale[:, None] * scale
            assert bounds._surely(raised, weight) == sure


def test_an_indefinite_or_undefined_matrix_is_not_surely_positive() -> None:
    one = np.ones(2)
    for A in (-np.eye(2), np.zeros((2, 2)), np.diag([1.0, 0.0]), np.array([[1.0, 2.0], [2.0, 1.0]])):
        assert not bounds._surely(A, one)
    assert bounds._surely(np.eye(2), one)
    assert bounds._surely(np.array([[np.eye(2), -np.eye(2)]]), np.ones((1, 2, 2))).tolist() == [[True, False]]


# Elimination --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("p", "e"), [(1, 1), (2, 1), (2, 2)])
def test_elimination_is_below_the_minimum_over_the_joints_velocities(p: int, e: int) -> None:
    rng = np.random.default_rng(2)
    m, done = 6 * p, 0
    for _ in range(40):
        A = random_form(rng, m)
        columns = np.kron(rng.normal(size=(p, e)), np.eye(6)[:, [int(rng.choice([2, 5]))]])
        own = rng.normal(size=(e, e))
        own = own + own.T + 0.5 * np.abs(A).max() * np.eye(e)
        F, good = bounds._eliminated(A, columns, own, np.abs(own).sum(axis=1))
        pivot = columns.T @ A @ columns + own
        if not good:
            assert np.linalg.eigvalsh(pivot)[0] < 1e-8 * np.abs(pivot).max()
            continue
        done += 1
        # The minimum less F is positive where all of [[A − F, A c], [cᵀ A, cᵀ A c + own]] is, in exact numbers.
        a, c, o = exact(A), exact(columns), exact(own)
        ac = [[sum(x * c[k][j] for k, x in enumerate(row)) for j in range(e)] for row in a]
        cac = [[sum(c[k][i] * ac[k][j] for k in range(m)) + o[i][j] for j in range(e)] for i in range(e)]
        left = [[*row, *ac[i]] for i, row in enumerate(plus(A, F, -1))]
        left += [[*(ac[k][i] for k in range(m)), *cac[i]] for i in range(e)]
        assert is_positive(left)
        # And not by more than rounding asks for, where the pivot is no difference of larger numbers.
        if np.linalg.eigvalsh(pivot)[0] < 0.1 * np.abs(A).max():
            continue
        minimum = A - A @ columns @ np.linalg.solve(pivot, columns.T @ A)
        assert np.abs(minimum - F).max() < 1e-7 * np.abs(A).max()
    assert done > 15


def test_a_velocity_that_nothing_resists_has_no_minimum() -> None:
    columns, none = np.eye(6)[:, [2]], np.zeros((1, 1))
    for resists, good in ((1.0, True), (0.0, False), (-1e-3, False), (1e-10, False)):
        A = np.diag([1.0, 1.0, resists, 1.0, 1.0, 1.0])
        assert bounds._eliminated(A, columns, none, np.ones(1))[1] == good
    # Where the joint's own form is what is left of larger numbers, it may be nothing but their rounding.
    assert bounds._eliminated(np.zeros((6, 6)), columns, np.array([[1e-6]]), np.array([2e-6]))[1]
    assert not bounds._eliminated(np.zeros((6, 6)), columns, np.array([[1e-6]]), np.array([1e6]))[1]


def test_the_share_of_the_magnitudes_is_taken_off_the_joints_own_form_too() -> None:
    columns = np.eye(6)[:, [2]]
    A = np.full((6, 6), 1.0) + np.eye(6)
    few, many = (bounds._eliminated(A, columns, np.ones((1, 1)), np.array([size]))[0] for size in (1.0, 1e6))
    # The pivot is 3; all entries of A beside it are 1, so that d(minimum) = d(pivot) / 9.
    assert few[0, 1] - many[0, 1] == pytest.approx(1e6 * TOLERANCE / 9.0, rel=0.01)


def test_elimination_takes_off_the_tolerance_of_all_that_took_part() -> None:
    rng = np.random.default_rng(10)
    for _ in range(20):
        A = rng.normal(size=(6, 6))
        A = A + A.T
        columns, own = rng.normal(size=(6, 1)), np.array([[50.0]])
        F, good = bounds._eliminated(A, columns, own, np.array([50.0]))
        assert good
        row, pivot = (A @ columns)[:, 0], float((columns.T @ A @ columns)[0, 0]) + 50.0
        taken = np.diag(A - np.outer(row, row) / pivot - F)
        sizes = np.abs(A).sum(axis=1) + np.abs(row) * np.abs(row).sum() / pivot
        assert np.all(taken >= TOLERANCE * sizes * 0.99)


# Harmonics ----------------------------------------------------------------------------------------------------------


def _exactly_turned(form: Form, q: arb, F: Array) -> arb_mat:
    """X(q)ᵀ F X(q) in balls, from the definition of a screw motion and not from the checker's `transform`."""
    chain = form.chain
    a, place = chain.axis[1], chain.place[1]
    K = arb_mat([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    R, o = arb_mat(place[:3, :3].tolist()), arb_mat(3, 1, place[:3, 3].tolist())
    if chain.slides[1]:
        o = o + R * arb_mat(3, 1, a.tolist()) * q
    else:
        R = R * (arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, 1]]) + K * q.sin() + K * K * (1 - q.cos()))
    x, y, z = o[0, 0], o[1, 0], o[2, 0]
    back = R.transpose()
    moment = back * arb_mat([[0, z, -y], [-z, 0, x], [y, -x, 0]])
    p = form.pairing.shape[0]
    X = arb_mat(6 * p, 6 * p)
    for b in range(p):
        for i in range(3):
            for j in range(3):
                X[6 * b + i, 6 * b + j] = X[6 * b + 3 + i, 6 * b + 3 + j] = back[i, j]
                X[6 * b + 3 + i, 6 * b + j] = moment[i, j]
    return X.transpose() * arb_mat(F.tolist()) * X


@pytest.mark.parametrize("p", [1, 2])
@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("far", [3.0, 1e3, 1e6])
def test_harmonics_give_the_turned_form_and_their_size_bounds_what_rounding_lost(
    p: int, slides: bool, far: float
) -> None:
    rng = np.random.default_rng(3)
    form, rows = two_joints(p, slides=slides), range(6 * p)
    # What stands here as an axis is no unit vector to the last digit, and a trigonometric polynomial all the same.
    for share in (0.0, *rng.uniform(-1.0, 1.0, 3)):
        F, c = random_form(rng, 6 * p), np.array([share * far])
        C, size = bounds._harmonics(form, 1, c, F[None, None])
        for at in (*rng.uniform(-3.0, 3.0, 3), 0.0):
            with ctx.workprec(300):
                d = arb(float(at))
                basis = [arb(1), d, d * d] if slides else [arb(1), d.cos(), d.sin(), (2 * d).cos(), (2 * d).sin()]
                G = _exactly_turned(form, arb(float(c[0])) + d, F)
                got = sum(
                    (b * arb_mat(k.tolist()) for b, k in zip(basis, C[:, 0, 0], strict=True)), arb_mat(6 * p, 6 * p)
                )
                lost = [sum(abs(float((got[i, j] - G[i, j]).mid())) for j in rows) for i in rows]
            # A hundredth of what is taken off for it.
            allowed = 0.01 * TOLERANCE * size[0, 0] * (1.0 + at * at if slides else 1.0)
            assert np.all(np.array(lost) <= allowed + 1e-300)


# Covering -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.parametrize("m", [6, 12])
def test_a_covering_is_positive_and_covers_in_exact_numbers(both: bool, m: int) -> None:
    rng = np.random.default_rng(4)
    none = [[Fraction(0)] * m] * m
    for _ in range(12):
        H = random_form(rng, m)
        root, inverse = random_metric(rng, m)
        P, good = bounds._covering(H[None], both, root[None], inverse[None], np.abs(H).sum(axis=1)[None])
        assert good.all()
        assert is_positive(plus(P[0], H))
        assert is_positive(plus(P[0], H, -1)) if both else is_positive(plus(P[0], none))


def test_a_covering_that_does_not_cover_is_not_called_one() -> None:
    rng = np.random.default_rng(5)
    H = random_form(rng, 6) + 10.0 * np.diag([1, -1, 1, -1, 1, -1])
    size = np.abs(H).sum(axis=1)
    # A wrong inverse of the metric: the guess is then too small by any factor.
    for both in (False, True):
        assert not bounds._covering(H, both, np.eye(6), 1e-3 * np.eye(6), size)[1]
    # Positive already, and covered by itself, but not from the other side.
    A = np.eye(6)
    assert not bounds._covering(A, True, np.eye(6), 1e-3 * np.eye(6), size)[1]
    assert bounds._covering(A, False, np.eye(6), 1e-3 * np.eye(6), np.ones(6))[1]


def test_a_covering_has_the_share_above_what_is_needed_that_rounding_may_take() -> None:
    H = np.diag([-2.0, 1.0, 0.5])
    P, good = bounds._covering(H, False, np.eye(3), np.eye(3), np.full(3, 100.0))
    assert good
    least = 1e-9 * 2.0 + 8.0 * TOLERANCE * 100.0
    assert np.diag(P) == pytest.approx([2.0 + least, least, least], rel=0.0, abs=1e-15)


# Losses of a cell ---------------------------------------------------------------------------------------------------


def _loss(C: Array, r: float, slides: bool, monkeypatch: pytest.MonkeyPatch, size: float = 1e-3) -> tuple[Array, Array]:
    """Ends of a cell in which the form is a given polynomial, and what was taken off; in a metric of length one."""
    m = C.shape[-1]
    monkeypatch.setattr(bounds, "_harmonics", lambda form, i, c, F: (C[:, None, None], np.full((1, 1, m), size)))
    one = np.eye(m)[None]
    ends, K, good = bounds._ends(
        two_joints(slides=slides), 1, np.zeros(1), np.array([r]), np.zeros((1, 1, m, m)), one, one
    )
    assert good.all()
    return ends[0, 0], K[0, 0]


def _polynomial(C: Array, at: float, slides: bool) -> Array:
    basis = (1.0, at, at * at) if slides else (1.0, np.cos(at), np.sin(at), np.cos(2 * at), np.sin(2 * at))
    return np.asarray(np.tensordot(np.array(basis), C, axes=1))


def _left(C: Array, ends: Array, at: float, r: float, slides: bool) -> float:
    """The least eigenvalue of the form at an angle less the mix of the ends."""
    if len(ends) == 1:
        mix = ends[0]
    else:
        share = at / r if slides else np.sin(at) / np.sin(r)
        assert abs(share) <= 1.0 + 1e-15
        mix = 0.5 * ((1.0 - share) * ends[0] + (1.0 + share) * ends[1])
    return float(np.linalg.eigvalsh(_polynomial(C, at, slides) - mix)[0])


CELLS = {
    "tiny": (1e-7, 1e-4, False),
    "narrow": (0.01, 0.1, False),
    "middling": (0.1, 1.4, False),
    "wide": (1.41, 3.3, False),
    "slide": (0.01, 1.5, True),
}


@pytest.mark.parametrize("cell", CELLS)
def test_the_ends_less_their_loss_are_below_any_polynomial_in_the_cell(
    cell: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(6)
    low, high, slides = CELLS[cell]
    for number in range(60):
        C = np.stack([random_form(rng, 3) for _ in range(3 if slides else 5)])
        if number % 2:
            # Some harmonics alone.
            C[1:] *= rng.integers(0, 2, len(C) - 1)[:, None, None]
        r = rng.uniform(low, high)
        ends, _ = _loss(C, r, slides, monkeypatch, float(np.abs(C).sum(axis=(0, 2)).max()))
        least = min(_left(C, ends, at, r, slides) for at in np.linspace(-r, r, 81))
        assert least >= -1e-14 * np.abs(C).max(), number


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("p", [1, 2])
def test_the_ends_less_their_loss_are_below_the_turned_form_in_the_cell(cell: str, p: int) -> None:
    rng = np.random.default_rng(7)
    low, high, slides = CELLS[cell]
    form = two_joints(p, slides=slides)
    for _ in range(20):
        F, c, r = random_form(rng, 6 * p), rng.uniform(-3.0, 3.0, 1), rng.uniform(low, high)
        root, inverse = random_metric(rng, 6 * p)
        ends, _, good = bounds._ends(form, 1, c, np.array([r]), F[None, None], root[None], inverse[None])
        assert good.all()
        C = bounds._harmonics(form, 1, c, F[None, None])[0][:, 0, 0]
        for at in np.linspace(-r, r, 41):
            assert _left(C, ends[0, 0], at, r, slides) >= -1e-14 * np.abs(C).max()


H = np.diag([1.0, -1.0])
"""A harmonic that takes either sign."""

RADII = (0.3, 0.9, 1.39)


def _hardest(r: float) -> float:
    """Where (cos δ − cos r) sin δ is largest, by search."""
    at = np.linspace(0.0, r, 200_001)
    return float(at[np.argmax((np.cos(at) - np.cos(r)) * np.sin(at))])


def _only(harmonic: int, G: Array = H, count: int = 5) -> Array:
    C = np.zeros((count, 2, 2))
    C[harmonic] = G
    return C


# (name, polynomial, where it is lost most, how much above the need: 1e-9 of it twice, or once for a slide)
TIGHT = {
    "first, of the cosine": (lambda r: _only(1), lambda r: 0.0),
    "first, of the doubled cosine": (lambda r: _only(3, np.diag([-1.0, -2.0])), lambda r: 0.0),
    "second, of the doubled sine": (lambda r: _only(4), _hardest),
    "curved, of the doubled cosine": (
        # With the first harmonic the bracket begins at zero, and only its curvature is left.
        lambda r: _only(3, np.eye(2)) + _only(1, -(2.0 + 2.0 * np.cos(r)) * np.eye(2)),
        lambda r: float(np.arccos(0.5 * (1.0 + np.cos(r)))),
    ),
}


@pytest.mark.parametrize("name", TIGHT)
@pytest.mark.parametrize("r", RADII)
def test_every_term_of_a_loss_is_what_is_lost_and_a_billionth_more(
    name: str, r: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, where = TIGHT[name]
    C, at = made(r), where(r)
    ends, K = _loss(C, r, False, monkeypatch)
    lost = float(np.linalg.eigvalsh(K)[-1])
    assert lost > 1e-4
    # At the worst angle nearly nothing is left: any share less of the term would be too little.
    least = min(_left(C, ends, s * at, r, False) for s in (-1.0, 1.0))
    assert 1.5e-9 * lost < least < 3e-9 * lost


@pytest.mark.parametrize("r", [1e-6, 1e-4, 1e-2, 0.3, 1.0, 1.4])
def test_the_terms_keep_their_digits_in_narrow_cells(r: float, monkeypatch: pytest.MonkeyPatch) -> None:
    with ctx.workprec(300):
        cosine = arb(r).cos()
        x = (cosine + (cosine**2 + 8).sqrt()) / 4
        third = float(((x - cosine) * (1 - x * x).sqrt()).mid())
        kappa = float((1 - cosine).mid())
    first = np.linalg.eigvalsh(_loss(_only(1), r, False, monkeypatch)[1])[-1]
    assert first == pytest.approx(kappa * (1.0 + 2e-9), rel=1e-12)
    second = np.linalg.eigvalsh(_loss(_only(4), r, False, monkeypatch)[1])[-1]
    assert second == pytest.approx(2.0 * third * (1.0 + 2e-9), rel=1e-12)


@pytest.mark.parametrize("harmonic", [1, 2, 3, 4])
def test_a_cell_wider_than_that_is_below_its_mean_by_each_harmonic(
    harmonic: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    C = _only(harmonic) + _only(0, np.eye(2))
    ends, K = _loss(C, 2.0, False, monkeypatch)
    assert len(ends) == 1
    # A harmonic reaches its magnitude either way somewhere in a turn.
    least = min(_left(C, ends, at, 2.0, False) for at in np.linspace(-np.pi, np.pi, 721))
    assert 0.5e-9 < least < 2e-9 + 1e-4
    assert np.linalg.eigvalsh(K) == pytest.approx([1.0, 1.0], abs=2e-9)
    assert np.linalg.eigvalsh(ends[0]) == pytest.approx([0.0, 0.0], abs=2e-9)


@pytest.mark.parametrize(("r", "slides", "terms"), [(0.5, True, 1), (0.5, False, 3), (2.0, False, 4)])
def test_a_loss_is_sure_only_if_each_of_its_terms_is(
    r: float, slides: bool, terms: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    covering = bounds._covering
    form, one = two_joints(slides=slides), np.eye(6)[None]
    F = random_form(np.random.default_rng(11), 6)[None, None]
    for failing in range(terms + 1):
        calls: list[int] = []

        def some(*given: Any, failing: int = failing, calls: list[int] = calls) -> tuple[Array, Array]:
            P, good = covering(*given)
            calls.append(len(calls))
            return P, good & (calls[-1] != failing)

        monkeypatch.setattr(bounds, "_covering", some)
        good = bounds._ends(form, 1, np.zeros(1), np.array([r]), F, one, one)[2]
        assert len(calls) == terms
        assert bool(good.all()) == (failing == terms)


@pytest.mark.parametrize("r", RADII)
def test_a_slide_loses_the_square_of_its_width(r: float, monkeypatch: pytest.MonkeyPatch) -> None:
    C = _only(2, H, 3) + _only(1, np.array([[0.3, 0.2], [0.2, -0.1]]), 3) + _only(0, np.eye(2), 3)
    ends, K = _loss(C, r, True, monkeypatch)
    assert np.linalg.eigvalsh(K) == pytest.approx([1e-9 * r * r, r * r * (1.0 + 1e-9)], rel=1e-6)
    least = min(_left(C, ends, at, r, True) for at in np.linspace(-r, r, 41))
    # At the middle all of it is lost.
    assert 0.5e-9 * r * r < least <= _left(C, ends, 0.0, r, True) < 2e-9 * r * r


def test_the_two_ends_are_the_form_at_the_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(8)
    for slides in (False, True):
        C = np.stack([random_form(np.random.default_rng(k), 3) for k in range(3 if slides else 5)])
        r = rng.uniform(0.2, 1.3)
        ends, K = _loss(C, r, slides, monkeypatch)
        for end, at in zip(ends, (-r, r), strict=True):
            assert end + K == pytest.approx(_polynomial(C, at, slides), rel=1e-9)


def test_the_ends_have_the_rounding_of_all_that_took_part_taken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    C, r = _only(0, np.eye(2)), 0.5
    for slides, terms in ((False, C), (True, C[:3])):
        size = 1e6
        ends, K = _loss(terms, r, slides, monkeypatch, size)
        taken = np.diag(np.eye(2) - K - ends[0])
        assert np.all(taken >= TOLERANCE * size * (2.0 + r * r) * (1.0 - 1e-6))
        # A covering of nothing is the rounding that it covers.
        assert np.all(np.diag(K) > 0.0)


def test_the_loss_is_among_what_has_its_rounding_taken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    for slides, C in ((False, 1e6 * _only(1)), (True, 1e6 * _only(2, np.eye(2), 3))):
        r = 0.7
        ends, K = _loss(C, r, slides, monkeypatch)
        lost = np.abs(K).sum(axis=1)
        assert lost.max() > 1e5
        for end, at in zip(ends, (-r, r), strict=True):
            taken = np.diag(_polynomial(C, at, slides) - K - end)
            assert np.all((taken >= TOLERANCE * lost * (1.0 - 1e-2)) | (lost < 1e5))


def test_a_matrix_with_a_zero_on_its_diagonal_is_not_positive() -> None:
    for diagonal in ((1.0, 0.0), (0.0, 0.0), (0.0, -1.0), (1.0, -1e-300)):
        assert not bounds._surely(np.diag(diagonal)[None], np.zeros((1, 2)))[0]
    assert bounds._surely(np.diag((1.0, 1e-300))[None], np.zeros((1, 2)))[0]


def test_the_wide_bound_begins_where_the_narrow_one_may_not_be_used_any_more() -> None:
    # Beyond a right angle sin δ / sin r is no share of one.
    assert 1.0 < bounds.WIDE < 0.5 * np.pi
    rng = np.random.default_rng(9)
    form, root = two_joints(), np.eye(6)[None]
    F = random_form(rng, 6)[None, None]
    for r, ends in ((bounds.WIDE, 2), (np.nextafter(bounds.WIDE, 2.0), 1), (1.5, 1)):
        assert bounds._ends(form, 1, np.zeros(1), np.array([r]), F, root, root)[0].shape[2] == ends


# The second joint, followed -----------------------------------------------------------------------------------------


def _followed(
    C: Array,
    lower: float,
    upper: float,
    monkeypatch: pytest.MonkeyPatch,
    *,
    size: float = 0.0,
    own: Array | None = None,
    own_size: float = 0.0,
    A: float = 0.0,
    column: float = 1.0,
) -> bool:
    """Whether a polynomial of e × e coefficients passes as positive over a range."""
    e = C.shape[-1]
    # The base's own columns pick the first e entries of a twist.
    whole = np.zeros((5, 1, 1, 6, 6))
    whole[:, 0, 0, :e, :e] = C
    monkeypatch.setattr(bounds, "_harmonics", lambda form, i, c, F: (whole, np.full((1, 1, 6), size)))
    form = two_joints(
        own=np.zeros((2, e, e)) if own is None else np.stack((own, own)),
        own_size=np.full((2, e), own_size),
        exact=True,
        range_1=(lower, upper),
    )
    monkeypatch.setattr(Form, "columns", lambda self, i: column * np.eye(6)[:, :e])
    return bool(bounds._follow(form, A * np.eye(6)[None, None], np.zeros((1, 1, 6, 6)))[0, 0])


@pytest.mark.parametrize("frequency", [1, 2])
@pytest.mark.parametrize("phase", [0.0, 0.5 * np.pi, np.pi, -0.5 * np.pi])
def test_a_polynomial_that_dips_below_zero_between_two_points_of_the_grid_does_not_pass(
    frequency: int, phase: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    C, amplitude = np.zeros((5, 1, 1)), 100.0
    C[2 * frequency - 1], C[2 * frequency] = -amplitude * np.cos(phase), -amplitude * np.sin(phase)
    lowest = phase / frequency
    for cells, span in ((64, 3.0), (64, 0.7), (512, 1.3)):
        h = span / cells
        # The minimum lies in the middle between two points.
        lower = lowest - (cells // 2 - 0.5) * h
        upper = lower + span
        depth = 1e-3 * (frequency * h) ** 2
        C[0] = amplitude * (1.0 - depth)
        assert not _followed(C, lower, upper, monkeypatch)
        # And one that stays above by as little passes.
        C[0] = amplitude * (1.0 + depth)
        assert _followed(C, lower, upper, monkeypatch)


@pytest.mark.parametrize("index", [1, 255, 256, 257, 511, 513, 2049, 4095])
def test_no_point_of_a_fine_grid_is_left_out(index: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # So shallow a dip shows at this point alone, and no coarser grid decides.
    h = 3.0 / 4096
    C = np.zeros((5, 1, 1))
    lowest = 0.2 + index * h
    C[1], C[2] = -np.cos(lowest), -np.sin(lowest)
    C[0] = 1.0 - 0.1 * h**2
    assert not _followed(C, 0.2, 3.2, monkeypatch)


def test_a_dip_at_either_end_of_the_range_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # Zero at ±1 to first order, and positive between.
    C = np.zeros((5, 1, 1))
    C[0], C[1] = -np.cos(1.0), 1.0
    assert _followed(C, -0.999, 0.999, monkeypatch)
    assert not _followed(C, -0.999, 1.0 + 1e-9, monkeypatch)
    assert not _followed(C, -1.0 - 1e-9, 0.999, monkeypatch)
    # Outside the range it does not matter.
    assert not _followed(C, -3.0, 3.0, monkeypatch)


def test_a_matrix_is_followed_by_its_least_eigenvalue(monkeypatch: pytest.MonkeyPatch) -> None:
    flip = np.array([[0.0, 1.0], [1.0, 0.0]])
    for harmonic in (1, 2, 3, 4):
        C = np.zeros((5, 2, 2))
        C[0], C[harmonic] = 1.001 * np.eye(2), flip
        assert _followed(C, -3.2, 3.2, monkeypatch)
        C[0] = 0.999 * np.eye(2)
        assert not _followed(C, -3.2, 3.2, monkeypatch)


def test_what_is_within_rounding_of_zero_does_not_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    one = np.zeros((5, 1, 1))
    one[0] = 1.0
    for share, passes in ((1e-13, False), (1e-12, False), (5e-12, False), (1e-9, True)):
        small = share * one
        # By the magnitudes in the turned form, in the body, and in the joint's own form.
        assert _followed(small, -1.0, 1.0, monkeypatch, size=1.0) == passes
        below = share * one - one
        assert _followed(below, -1.0, 1.0, monkeypatch, A=1.0) == passes
        assert _followed(below, -1.0, 1.0, monkeypatch, own=np.eye(1), own_size=1.0) == passes
        assert _followed(small, -1.0, 1.0, monkeypatch, own_size=1.0) == passes
        # A velocity that counts tenfold in the twist counts a hundredfold in the form, and so does its rounding.
        assert _followed(small, -1.0, 1.0, monkeypatch, size=1.0, column=10.0) == passes


def test_the_base_body_and_its_own_form_belong_to_what_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    C = np.zeros((5, 1, 1))
    C[0], C[1] = 1.0, 0.5
    assert _followed(C, -3.2, 3.2, monkeypatch)
    assert not _followed(C, -3.2, 3.2, monkeypatch, A=-0.6)
    assert not _followed(C, -3.2, 3.2, monkeypatch, own=np.array([[-0.6]]))
    assert _followed(C - 0.6 * (np.arange(5) == 0)[:, None, None], -3.2, 3.2, monkeypatch, own=np.array([[0.6]]))


def test_far_from_zero_the_grid_is_as_coarse_as_floats_are(monkeypatch: pytest.MonkeyPatch) -> None:
    lower = 2.0**50
    gap = float(np.spacing(lower))
    middle = np.cos(0.5 * gap), np.sin(0.5 * gap)
    assert gap == 0.25
    # Lowest between two neighbouring floats, to which no grid gets closer.
    with ctx.workprec(300):
        turned = float(arb(lower).cos().mid()), float(arb(lower).sin().mid())
    low = turned[0] * middle[0] - turned[1] * middle[1], turned[1] * middle[0] + turned[0] * middle[1]
    C = np.zeros((5, 1, 1))
    C[0], C[1], C[2] = 1.0 - 1e-3, -low[0], -low[1]
    assert not _followed(C, lower, lower + gap, monkeypatch)


def test_only_forms_that_are_open_are_asked_of_a_finer_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, solve = [], np.linalg.eigvalsh

    def counted(A: Array) -> Array:
        asked.append(A.size)
        return np.asarray(solve(A))

    # 1 + a cos q: far above zero, below zero, and as close above it as takes a finer grid.
    lows, decided = np.array([0.5, 2.0, 0.9999]), []
    for chosen in (lows[:1], lows[1:2], lows[2:], lows):
        C = np.zeros((5, 1, chosen.size, 6, 6))
        C[0, 0, :, 0, 0], C[1, 0, :, 0, 0] = 1.0, chosen
        monkeypatch.setattr(bounds, "_harmonics", lambda form, i, c, F, C=C: (C, np.zeros(C.shape[1:4])))
        monkeypatch.setattr(Form, "columns", lambda self, i: np.eye(6)[:, :1])
        monkeypatch.setattr(np.linalg, "eigvalsh", counted)
        form, none = two_joints(exact=True, range_1=(0.0, 3.2)), np.zeros((1, chosen.size, 6, 6))
        done = bounds._follow(form, none, none)
        decided.append((done[0].tolist(), sum(asked)))
        asked.clear()
    (far, easy), (below, also), (close, hard), (together, work) = decided
    assert together == [*far, *below, *close] == [True, False, True]
    assert easy == also < hard
    assert work == easy + also + hard


# A box as a whole ---------------------------------------------------------------------------------------------------


def _spatial(mass: float, com: Array, about_com: Array) -> Array:
    """Spatial inertia at the frame's origin, of twists (angular, linear)."""
    c = cross(com)
    return np.block([[about_com + mass * c @ c.T, mass * c], [mass * c.T, mass * np.eye(3)]])


def _chain(tree: Tree) -> Chain:
    place = np.broadcast_to(np.eye(4), (tree.nv, 4, 4)).copy()
    place[:, :3, :3], place[:, :3, 3] = tree.rotation, tree.translation
    inertia = np.stack([_spatial(*body) for body in zip(tree.mass, tree.com, tree.inertia, strict=True)])
    return Chain(tree.parent, place, tree.axis, tree.prismatic, inertia)


@pytest.mark.parametrize("kind", KINDS)
def test_no_statement_that_a_configuration_contradicts_is_proven_of_a_box(kind: str) -> None:
    asked = [q for seed in range(14) if (q := question(seed, kind, largest=4)) is not None]  # type: ignore[arg-type]
    assert len(asked) > 5
    for q in asked:
        centre, half = 0.5 * (q.lower + q.upper), 0.5 * (q.upper - q.lower)
        wide = np.where(q.tree.parent < 0, 0.0, half)
        for share in (1.0 + 1e-6, 1.01, 1.3):
            if kind in ("bounded", "level") and share * q.worst >= 1.0:
                continue
            said = q.statement(share * q.worst)
            form = form_of(_chain(q.tree), q.mbar, _parsed(said), q.lower, q.upper)
            if form.exact:
                wide[1] = 0.0
            assert not bounds.holds(form, centre[None], wide[None])[0][0]


def _parsed(said: object) -> WrittenStatement:
    fields = {key: getattr(said, key) for key in ("kind", "scale", "level", "case")}
    rows = {key: tuple(getattr(said, key).tolist()) for key in ("armature", "slack")}
    return WrittenStatement.model_construct(**fields, **rows)


@pytest.mark.parametrize("kind", KINDS)
def test_at_one_configuration_a_proof_is_as_strong_as_the_truth(kind: str) -> None:
    for seed in range(12):
        q = question(seed, kind, largest=5, point=True)  # type: ignore[arg-type]
        if q is None:
            continue
        for share, proven in ((1.0 - 1e-6, True), (1.0 + 1e-6, False)):
            x = share * q.worst
            if kind in ("bounded", "level") and x >= 1.0:
                continue
            form = form_of(_chain(q.tree), q.mbar, _parsed(q.statement(x)), q.lower, q.upper)
            assert bool(bounds.holds(form, q.lower[None], 0.0 * q.lower[None])[0][0]) == proven, (seed, share)


@pytest.mark.parametrize("kind", KINDS)
def test_every_matrix_on_the_way_is_lowered_by_its_own_magnitudes_at_least(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lower_it, seen = bounds._lowered, []

    def watched(A: Array, size: Array) -> Array:
        seen.append(bool(np.all(size >= np.abs(A).sum(axis=-1) * (1.0 - 1e-6))))
        return lower_it(A, size)

    monkeypatch.setattr(bounds, "_lowered", watched)
    for seed in range(6):
        q = question(seed, kind, largest=4)  # type: ignore[arg-type]
        if q is None:
            continue
        form = form_of(_chain(q.tree), q.mbar, _parsed(q.statement(0.5 * q.worst)), q.lower, q.upper)
        still = np.where(q.tree.parent < 0, 0.0, 0.05)[None]
        bounds.holds(form, 0.5 * (q.lower + q.upper)[None], still)
    assert len(seen) > 10
    assert all(seen)


def test_boxes_together_are_judged_as_each_alone() -> None:
    q = question(3, "weighted", largest=4)
    assert q is not None
    rng = np.random.default_rng(0)
    form = form_of(_chain(q.tree), q.mbar, _parsed(q.statement(0.98 * q.worst)), q.lower, q.upper)
    c = rng.uniform(q.lower, q.upper, (12, q.tree.nv))
    r = np.where(q.tree.parent < 0, 0.0, rng.uniform(0.0, 1.0, (12, q.tree.nv)) ** 4)
    together = bounds.holds(form, c, r)[0]
    alone = [bool(bounds.holds(form, c[k : k + 1], r[k : k + 1])[0][0]) for k in range(12)]
    assert together.tolist() == alone
    assert 0 < sum(alone) < 12


def test_the_mass_matrix_of_the_tests_chains_is_the_trees() -> None:
    q = question(5, "weighted", largest=6)
    assert q is not None
    angles = np.random.default_rng(0).uniform(-3.0, 3.0, (8, q.tree.nv))
    ours = _chain(q.tree).mass_matrix(angles, q.tree.armature)
    assert ours == pytest.approx(mass_matrices(q.tree, angles), rel=1e-12, abs=1e-12)
