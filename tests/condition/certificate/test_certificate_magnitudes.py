"""What a proof takes off for rounding: each step's magnitudes are sums of all that took part, by formulas of their own.

No run of a prover shows that such a sum has lost a term: rounding is a hundred times smaller than what is taken off.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled import cell_loss, first_joints, joint_steps

GUARD = 2e-14
SHAPES = ((1, 1), (2, 1), (2, 2))


def symmetric(rng: np.random.Generator, m: int) -> Array:
    """A symmetric matrix whose rows differ much in size."""
    A = rng.normal(size=(m, m)) * 10.0 ** rng.uniform(-1.0, 1.0, m)
    return np.tril(A + A.T) + np.tril(A + A.T, -1).T


def test_the_share_that_is_taken_off_is_the_one_that_these_tests_know() -> None:
    assert joint_steps.GUARD == GUARD


@pytest.mark.parametrize(("p", "e"), SHAPES)
@pytest.mark.parametrize("axis", [2, 5])
def test_an_elimination_is_the_schur_complement_and_knows_its_magnitudes(p: int, e: int, axis: int) -> None:
    rng = np.random.default_rng(0)
    m = 6 * p
    for _ in range(20):
        A = symmetric(rng, m)
        R, T = rng.normal(size=(p, e)), rng.normal(size=(e, e))
        T = T + T.T + 30.0 * np.abs(A).max() * np.eye(e)
        size = np.abs(A).sum(axis=1)
        before = size.copy()
        F, U, D, Ua, Da = np.empty((m, m)), np.empty((e, m)), np.empty((e, e)), np.empty((e, m)), np.empty((e, e))
        assert joint_steps.eliminate(A, size, axis, R, T, F, U, D, Ua, Da)
        columns = np.kron(R, np.eye(6)[:, [axis]])
        reach, magnitudes = columns.T @ A, np.abs(columns).T @ np.abs(A)
        own, own_size = columns.T @ A @ columns + T, magnitudes @ np.abs(columns) + np.abs(T)
        assert pytest.approx(reach, rel=1e-12, abs=1e-12) == U
        assert pytest.approx(own, rel=1e-12) == D
        # A little more of the joint's own form is taken off first.
        assert pytest.approx(A - reach.T @ np.linalg.inv(own) @ reach, rel=1e-9, abs=1e-9 * before.max()) == F
        assert np.all(F == F.T)
        if e == 1:
            expected = before + magnitudes[0] * (1.0 + magnitudes[0].sum() / own[0, 0])
        else:
            share = own_size[0, 1] / own[1, 1]
            left = own[0, 0] - own[0, 1] ** 2 / own[1, 1]
            first, second = magnitudes[0] + share * magnitudes[1], magnitudes[1]
            expected = before + second * (1.0 + second.sum() / own[1, 1]) + first * (1.0 + first.sum() / left)
        assert size == pytest.approx(expected, rel=1e-9)


def eliminated(D: Array, extra: float = 0.0, across: float = 0.0) -> bool:
    """Whether a joint with a given own form is eliminated; of it `extra` and −`extra` are parts that cancel."""
    e = len(D)
    A = np.zeros((12, 12))
    A[2, 2], A[8, 8] = extra, extra
    A[2, 8] = A[8, 2] = across
    T = D - np.array([[extra, across], [across, extra]])[:e, :e]
    scratch = [np.empty(s) for s in ((12, 12), (e, 12), (e, e), (e, 12), (e, e))]
    size = np.abs(A).sum(axis=1)
    return bool(joint_steps.eliminate(A, size, 2, np.eye(2)[:, :e].copy(), T, *scratch))


def test_what_is_left_of_an_own_form_by_cancellation_is_not_divided_by() -> None:
    # Parts of 1e6 each leave what rounding alone could have made.
    for small, sure in ((1e-8, False), (1e-5, False), (1e-3, True)):
        assert eliminated(np.array([[small]]), 1e6) == sure
        assert eliminated(np.diag([1e6, small]), 1e6) == sure
        assert eliminated(np.diag([small, 1e6]), 1e6) == sure
    # The second pivot, after the first: 1 − g², with the parts of g counted.
    for gap, sure in ((1e-13, False), (1e-3, True)):
        assert eliminated(np.array([[1.0, 1.0 - gap], [1.0 - gap, 1.0]])) == sure
        assert eliminated(np.array([[1.0, 0.0], [0.0, 1.0]]), across=1e2)
    assert not eliminated(np.array([[1e-6, 0.0], [0.0, 1.0]]), across=1e8)
    # It is a matter of proportion, not of size; and of each velocity's own.
    assert eliminated(np.array([[1.0, 1e7], [1e7, 1e16]]))
    assert eliminated(np.array([[1e16, 1e7], [1e7, 1.0]]))
    for scale in (1e-20, 1e20):
        assert eliminated(scale * np.eye(2))
        assert eliminated(scale * np.eye(1))


@pytest.mark.parametrize("m", [6, 12])
def test_what_is_shifted_to_the_parent_has_the_magnitudes_of_all_parts_taken_off(m: int) -> None:
    rng = np.random.default_rng(1)
    for _ in range(10):
        B, A, X = symmetric(rng, m), symmetric(rng, m), rng.normal(size=(6, 6))
        lifted = np.kron(np.eye(m // 6), X)
        exact = A + lifted.T @ B @ lifted
        out, size = A.copy(), np.empty(m)
        joint_steps.shift_onto(B, X, out, size, np.empty((m, m)), np.empty(m), np.empty(m))
        parts = np.abs(lifted).T @ np.abs(B) @ np.abs(lifted)
        assert size == pytest.approx(parts.sum(axis=1) + np.abs(exact).sum(axis=1), rel=1e-9)
        assert np.diag(exact - out) == pytest.approx(GUARD * size, rel=0.1)


@pytest.mark.parametrize("m", [6, 12])
@pytest.mark.parametrize("case", ["narrow", "wide", "slide"])
def test_a_form_of_nothing_loses_the_rounding_of_its_magnitudes_and_no_more(m: int, case: str) -> None:
    rng = np.random.default_rng(2)
    size = 10.0 ** rng.uniform(-2.0, 2.0, m)
    slack = GUARD * size
    r = {"narrow": 0.3, "wide": 2.0, "slide": 0.3}[case]
    if case == "slide":
        for a in range(0, m, 6):
            slack[a] += GUARD * size[a + 4]
            slack[a + 1] += GUARD * size[a + 3]
        weight = r * r
    elif case == "wide":
        weight = 4.0
    else:
        delta = np.linspace(0.0, r, 200_001)
        kappa = 1.0 - np.cos(r)
        weight = kappa + 2.0 * np.max((np.cos(delta) - np.cos(r)) * np.sin(delta)) + 0.5 * kappa**2
    K, work, one = np.empty((m, m)), np.empty((10, m, m)), np.eye(m)
    assert cell_loss.loss(np.zeros((m, m)), case == "slide", r, one, one, one, size, K, work)
    assert pytest.approx(np.diag(4.0 * weight * slack), rel=1e-6, abs=0.0) == K
    if case == "slide":
        # The square of r is rounded, and its weight is above it all the same.
        for half in (0.1, 0.3, 0.7, 1.1, 1.3):
            cell_loss.loss(np.zeros((m, m)), True, half, one, one, one, size, K, work)
            part = [Fraction(4.0 * x) for x in slack]
            assert all(Fraction(K[i, i]) > Fraction(half) ** 2 * part[i] for i in range(m))


@pytest.mark.parametrize(("p", "e"), SHAPES)
@pytest.mark.parametrize("axis", [2, 5])
def test_the_polynomial_of_the_second_joint_is_the_first_ones_own_form(p: int, e: int, axis: int) -> None:
    rng = np.random.default_rng(3)
    m = 6 * p
    for _ in range(10):
        A, F = symmetric(rng, m), symmetric(rng, m)
        R, T, X = rng.normal(size=(p, e)), symmetric(rng, e), rng.normal(size=(6, 6))
        size = 10.0 ** rng.uniform(-1.0, 1.0, m)
        C = np.empty((5, e, e))
        error = first_joints.base_polynomial(A, axis, R, T, X, F, size, C, np.empty((2, m)))
        own, moved = np.kron(R, np.eye(6)[:, [axis]]), np.kron(R, X[:, [axis]])
        for q in (-2.0, 0.0, 0.4, 1.9):
            c, s = np.cos(q), np.sin(q)
            Z = np.kron(np.eye(m // 3), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
            expected = own.T @ A @ own + moved.T @ Z @ F @ Z.T @ moved + T
            basis = np.array([1.0, c, s, np.cos(2 * q), np.sin(2 * q)])
            assert np.tensordot(basis, C, axes=1) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(F).max())
        fixed = np.abs(own).T @ np.abs(A) @ np.abs(own) + np.abs(T)
        thirds = size.reshape(-1, 3).sum(axis=1)
        turning = 8.0 * np.sum(thirds[:, None] * (moved**2).reshape(-1, 3, e).sum(axis=1))
        assert error == pytest.approx(4.0 * GUARD * (fixed.sum() + turning), rel=1e-9)


@pytest.mark.parametrize("e", [1, 2])
def test_the_least_value_of_a_polynomial_is_found_where_it_is_said_to_be(e: int) -> None:
    rng = np.random.default_rng(4)
    for _ in range(30):
        C = rng.normal(size=(5, e, e))
        C = C + C.swapaxes(1, 2)
        C[0] += 12.0 * np.eye(e)
        lower = rng.uniform(-3.0, 3.0)
        upper = lower + rng.uniform(0.1, 6.0)
        found, at = first_joints.least_over_range(C, lower, upper)
        q = np.linspace(lower, upper, 20_001)
        basis = np.stack((np.ones_like(q), np.cos(q), np.sin(q), np.cos(2 * q), np.sin(2 * q)))
        values = np.linalg.eigvalsh(np.tensordot(basis, C, axes=(0, 0)))[:, 0]
        assert lower <= at <= upper
        assert found == first_joints._least(C, at)
        assert found <= values.min() + 1e-9
        assert found == pytest.approx(values.min(), abs=1e-5)


def test_an_eigenvalue_that_is_not_positive_is_never_said_to_be_larger_than_it_is() -> None:
    C = np.zeros((5, 2, 2))
    for b in (-0.5, 0.5):
        C[0] = [[-1.0, b], [b, -2.0]]
        assert first_joints._least(C, 0.3) <= np.linalg.eigvalsh(C[0])[0]
    C[0] = [[3.0, -1.0], [-1.0, 2.0]]
    assert first_joints._least(C, 0.3) == pytest.approx(np.linalg.eigvalsh(C[0])[0], rel=1e-12)


def test_the_bounds_of_a_polynomial_are_attained_by_a_single_wave() -> None:
    for first, second in ((3.0, 4.0), (-3.0, 4.0)):
        one, two = np.zeros((5, 1, 1)), np.zeros((5, 1, 1))
        one[1], one[2] = first, second
        two[3], two[4] = first, second
        assert first_joints._bounds(one) == pytest.approx((5.0, 5.0), rel=1e-11)
        assert first_joints._bounds(two) == pytest.approx((5.0, 20.0), rel=1e-11)
        assert min(*first_joints._bounds(one)) >= 5.0


def test_no_polynomial_is_positive_by_less_than_its_own_rounding() -> None:
    stack = np.empty((64, 4))
    for gap, sure in ((1e-13, False), (1e-10, True)):
        C = np.zeros((5, 2, 2))
        C[0] = [[1.0, 1.0 - gap], [1.0 - gap, 1.0]]
        assert first_joints.positive_over_range(C, 0.0, -0.1, 0.1, stack) == sure
        wave = np.zeros((5, 1, 1))
        wave[0], wave[1] = 1.0 + gap, -1.0
        assert first_joints.positive_over_range(wave, 0.0, -0.1, 0.1, stack) == sure
        assert not first_joints.positive_over_range(wave, 2.0 * gap, -0.1, 0.1, stack)
