"""Every step of a proof is a lower bound: of Schur complements, of turned forms between two angles, of polynomials."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled import cell_loss, first_joints, joint_steps, loss_metric
from asmc_pin.condition.certificate.compiled.loss_metric import metric_of
from asmc_pin.condition.certificate.compiled.working_state import Problem, scratch
from asmc_pin.numerics.cholesky import invert_lower, surely_positive
from asmc_pin.numerics.eigen import eigen

SIZES = (6, 12)


def random_form(rng: np.random.Generator, m: int) -> Array:
    """A symmetric matrix: sometimes positive, sometimes of low rank, sometimes with parts of very different size."""
    kind = rng.integers(4)
    A = rng.normal(size=(m, m if kind != 1 else 2))
    A = A @ A.T if kind < 2 else A + A.T
    scale = 10.0 ** rng.uniform(-3.0, 3.0, m) if kind == 3 else np.ones(m)
    out: Array = A * scale[:, None] * scale
    return np.tril(out) + np.tril(out, -1).T


def turned(F: Array, angle: float) -> Array:
    """The form seen from before a turn about z."""
    c, s = np.cos(angle), np.sin(angle)
    Z = np.kron(np.eye(F.shape[0] // 3), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
    return np.asarray(Z @ F @ Z.T)


def slid(F: Array, q: float) -> Array:
    """The form seen from before a slide along z: v + ω × z q."""
    X = np.eye(6)
    X[3, 1], X[4, 0] = q, -q
    X = np.kron(np.eye(F.shape[0] // 6), X)
    return np.asarray(X.T @ F @ X)


@pytest.mark.parametrize("m", SIZES)
def test_turning_and_sliding_a_form_is_the_congruence_it_says(m: int) -> None:
    rng = np.random.default_rng(0)
    out = np.empty((m, m))
    for _ in range(20):
        F, q = random_form(rng, m), rng.uniform(-3.0, 3.0)
        joint_steps.turn(F, np.cos(q), np.sin(q), out)
        assert out == pytest.approx(turned(F, q), rel=1e-12, abs=1e-12 * np.abs(F).max())
        joint_steps.slide(F, q, out)
        assert out == pytest.approx(slid(F, q), rel=1e-12, abs=1e-11 * np.abs(F).max())


def any_basis(m: int, rng: np.random.Generator) -> Array:
    """The square root of some metric."""
    return np.asarray(np.linalg.qr(rng.normal(size=(m, m)))[0] * 10.0 ** rng.uniform(-1.0, 1.0, m))


def covered(F: Array, slides: bool, r: float, basis: Array) -> tuple[float, float]:
    """Least eigenvalue of (form − mix of the ends + loss) over a cell, and the largest of the loss."""
    m = F.shape[0]
    K, work = np.empty((m, m)), np.empty((10, m, m))
    size = np.abs(F).sum(axis=1)
    assert cell_loss.loss(F, slides, r, basis, np.linalg.inv(basis), basis @ basis.T, size, K, work)
    moved = slid if slides else turned
    low, high = moved(F, -r), moved(F, r)
    mean = np.empty((m, m))
    cell_loss.mean_of_turn(F, mean)
    least = np.inf
    for at in np.linspace(-r, r, 41):
        share = at / r if slides else np.sin(at) / np.sin(r)
        mix = mean if not slides and r > cell_loss.WHOLE else 0.5 * ((1.0 - share) * low + (1.0 + share) * high)
        least = min(least, float(np.linalg.eigvalsh(moved(F, at) - mix + K)[0]))
    return least, float(np.linalg.eigvalsh(K)[-1])


@pytest.mark.parametrize("m", SIZES)
@pytest.mark.parametrize("case", ["narrow", "middling", "wide", "slide"])
def test_the_loss_covers_all_that_a_form_does_between_the_ends_of_a_cell(m: int, case: str) -> None:
    rng = np.random.default_rng(m)
    ranges = {"narrow": (0.01, 0.1), "middling": (0.1, 1.4), "wide": (1.41, np.pi), "slide": (0.01, 0.8)}
    for _ in range(60):
        F = random_form(rng, m)
        least, _ = covered(F, case == "slide", rng.uniform(*ranges[case]), any_basis(m, rng))
        assert least >= -1e-12 * np.abs(F).max()


def test_a_metric_that_favours_one_axis_does_not_let_waves_of_two_degrees_pay_for_each_other() -> None:
    # Half a turn away the first degree has changed its sign and the second has not: each needs a part of its own.
    F = np.zeros((6, 6))
    F[0, 0], F[0, 2], F[2, 0] = -1.0, 0.1, 0.1
    for far in (1.0, 10.0, 1000.0):
        least, _ = covered(F, False, np.pi, np.diag([1.0, far, 1.0, 1.0, 1.0, 1.0]))
        assert least >= 0.0


def test_the_loss_is_of_second_order_in_the_width_of_a_cell() -> None:
    rng = np.random.default_rng(1)
    for slides in (False, True):
        F = random_form(np.random.default_rng(5), 6)
        wide, narrow = (covered(F, slides, r, any_basis(6, np.random.default_rng(2)))[1] for r in (2e-2, 1e-2))
        assert wide / narrow == pytest.approx(4.0, rel=0.1)
    # And at the middle of a narrow cell it is next to nothing more than is needed.
    F = random_form(rng, 6)
    least, loss = covered(F, False, 1e-3, any_basis(6, rng))
    assert least < 0.02 * loss


@pytest.mark.parametrize(("p", "e"), [(1, 1), (2, 1), (2, 2)])
def test_elimination_is_below_the_minimum_over_the_joints_velocities(p: int, e: int) -> None:
    rng = np.random.default_rng(2)
    m, done = 6 * p, 0
    for _ in range(300):
        A = random_form(rng, m)
        R, T = rng.normal(size=(p, e)), rng.normal(size=(e, e))
        T = T + T.T + 0.5 * np.abs(A).max() * np.eye(e)
        axis = int(rng.choice([2, 5]))
        size = np.abs(A).sum(axis=1)
        F, U, D = np.empty((m, m)), np.empty((e, m)), np.empty((e, e))
        sure = joint_steps.eliminate(A, size, axis, R, T, F, U, D, np.empty((e, m)), np.empty((e, e)))
        columns = np.kron(R, np.eye(6)[:, [axis]])
        own = columns.T @ A @ columns + T
        if not sure:
            assert np.linalg.eigvalsh(own)[0] < 1e-8 * np.abs(own).max()
            continue
        done += 1
        F -= joint_steps.GUARD * np.diag(size)
        # F is below if the minimum less F is positive: the Schur complement of own in what is left.
        left = np.block([[A - F, A @ columns], [columns.T @ A, own]])
        scale = 1.0 / np.sqrt(np.abs(np.diag(left)).clip(1e-300))
        assert np.linalg.eigvalsh(left * scale[:, None] * scale)[0] > -1e-13
    assert done > 100


def test_shifting_a_form_to_the_parent_rounds_down() -> None:
    rng = np.random.default_rng(3)
    for m in SIZES:
        for _ in range(50):
            B, A, X = random_form(rng, m), random_form(rng, m), rng.normal(size=(6, 6))
            lifted = np.kron(np.eye(m // 6), X)
            exact = A + lifted.T @ B @ lifted
            out, size = A.copy(), np.empty(m)
            joint_steps.shift_onto(B, X, out, size, np.empty((m, m)), np.empty(m), np.empty(m))
            assert np.all(np.diag(exact - out) > 0.0)
            assert np.abs(exact - out).max() < 1e-11 * size.max()
            scale = 1.0 / np.sqrt(size)
            assert np.linalg.eigvalsh((exact - out) * scale[:, None] * scale)[0] > 0.0


@pytest.mark.parametrize("m", SIZES)
def test_magnitudes_cover_what_a_turn_or_a_slide_makes_of_them_and_hardly_more(m: int) -> None:
    rng = np.random.default_rng(7)
    for _ in range(30):
        F = random_form(rng, m)
        for slides, q in ((False, rng.uniform(-3.0, 3.0)), (True, rng.uniform(0.0, 2.0))):
            size = np.abs(F).sum(axis=1)
            before = size.copy()
            joint_steps.spread(size, slides, q)
            if slides:
                # One row takes q of another, and each entry meets both sides of the congruence.
                X = np.eye(6)
                X[3, 1] = X[4, 0] = q
                X = np.kron(np.eye(m // 6), X)
                assert size == pytest.approx((1.0 + q) * (X.T @ before), rel=1e-12)
                made = X.T @ np.abs(F) @ X
            else:
                c, s = abs(np.cos(q)), abs(np.sin(q))
                Z = np.kron(np.eye(m // 3), np.array([[c, s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
                made = Z @ np.abs(F) @ Z.T
                pairs = np.kron(np.eye(m // 3), np.array([[2.0, 2.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0]]))
                assert size == pytest.approx(pairs @ before, rel=1e-12)
            assert np.all(size >= made.sum(axis=1) * (1.0 - 1e-12))


@pytest.mark.parametrize("n", [1, 2, 6])
def test_the_inverse_of_a_triangle_is_its_inverse(n: int) -> None:
    rng = np.random.default_rng(n)
    for _ in range(10):
        L = np.tril(rng.normal(size=(n, n)), -1) + np.diag(rng.uniform(0.5, 2.0, n))
        out = np.full((n, n), np.nan)
        invert_lower(L, out)
        assert out @ L == pytest.approx(np.eye(n), abs=1e-12 * np.abs(out).max() * np.abs(L).max() * n)
        assert np.all(np.triu(out, 1) == 0.0)


@pytest.mark.parametrize("m", SIZES)
def test_the_metric_of_losses_is_what_joints_can_do_and_a_share_of_the_rigid(m: int) -> None:
    """Its inverse is Ω / tr(Ω R) + spread · R⁻¹, R the composite inertia, of two twists weighed to the same reach."""
    rng = np.random.default_rng(8)
    for _ in range(10):

        def gentle(n: int, rng: np.random.Generator = rng) -> Array:
            # Far from singular, so that no pivot is lifted.
            A = 0.2 * rng.normal(size=(n, n))
            return np.asarray(np.eye(n) + 0.1 * A @ A.T) * 10.0 ** rng.uniform(-1.0, 1.0)

        C, Om, share = gentle(6), gentle(m), rng.uniform(0.2, 2.0)
        if m == 12:
            Om[6:] *= 7.0
            Om[:, 6:] *= 7.0
        k = scratch(2, m, 1)
        k.composite[1] = C
        none = np.zeros((2, m, m))
        problem = Problem(
            *(np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.bool_), np.zeros((2, 6, 6)), np.zeros((2, 6, 6)), none),
            *(np.zeros((2, m // 6, 1)), np.zeros((2, 1, 1)), np.zeros(2), np.zeros(2), False, share),
        )
        metric_of(problem, k, 1, Om)
        R = C
        if m == 12:
            weight = np.sqrt(np.sum(Om[6:, 6:] * C) / np.sum(Om[:6, :6] * C))
            R = np.block([[weight * C, np.zeros((6, 6))], [np.zeros((6, 6)), C / weight]])
        expected = np.linalg.inv(Om / np.sum(Om * R) + share * np.linalg.inv(R))
        assert k.metric[1] == pytest.approx(expected, rel=1e-9, abs=1e-11 * np.abs(expected).max())
        assert k.basis[1] @ k.basis[1].T == pytest.approx(k.metric[1], rel=1e-9, abs=1e-11 * np.abs(expected).max())
        assert k.inverse[1] @ k.basis[1] == pytest.approx(np.eye(m), abs=1e-10)


def test_twists_that_nothing_before_a_joint_moves_weigh_alike_in_the_metric_of_losses() -> None:
    k = scratch(2, 12, 1)
    k.composite[1] = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    none = np.zeros((2, 12, 12))
    problem = Problem(
        *(np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.bool_), np.zeros((2, 6, 6)), np.zeros((2, 6, 6)), none),
        *(np.zeros((2, 2, 1)), np.zeros((2, 1, 1)), np.zeros(2), np.zeros(2), False, 0.5),
    )
    metric_of(problem, k, 1, np.zeros((12, 12)))
    assert k.metric[1] == pytest.approx(2.0 * np.kron(np.eye(2), k.composite[1]), rel=1e-12, abs=1e-12)


def test_no_metric_of_losses_is_singular_even_of_a_point_mass() -> None:
    arm = np.array([[0.0, -0.3, 0.2], [0.3, 0.0, -0.1], [-0.2, 0.1, 0.0]])
    k = scratch(2, 6, 1)
    k.composite[1] = np.block([[arm @ arm.T, arm], [arm.T, np.eye(3)]])  # 1 kg at (0.1, 0.2, 0.3), nothing about itself
    assert abs(np.linalg.eigvalsh(k.composite[1])[0]) < 1e-15
    none = np.zeros((2, 6, 6))
    problem = Problem(
        *(np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.bool_), none, none, none),
        *(np.zeros((2, 1, 1)), np.zeros((2, 1, 1)), np.zeros(2), np.zeros(2), False, 1.0),
    )
    loss_metric.metric_of(problem, k, 1, np.eye(6))
    assert np.linalg.cond(k.metric[1]) < 1e5
    assert k.inverse[1] @ k.basis[1] == pytest.approx(np.eye(6), abs=1e-9)


def exactly_positive(S: Array) -> bool:
    P = [[Fraction(float(x)) for x in row] for row in S]
    for k in range(len(P)):
        if P[k][k] <= 0:
            return False
        for i in range(k + 1, len(P)):
            factor = P[i][k] / P[k][k]
            P[i] = [a - factor * b for a, b in zip(P[i], P[k], strict=True)]
    return True


def test_what_cholesky_calls_positive_is_so_in_exact_fractions() -> None:
    rng = np.random.default_rng(4)
    yes = 0
    for _ in range(400):
        m = int(rng.integers(2, 13))
        basis = np.linalg.qr(rng.normal(size=(m, m)))[0]
        values = 10.0 ** rng.uniform(-1.0, 1.0, m)
        # A least eigenvalue on either side of zero, down to where rounding alone decides.
        values[0] = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-17.0, -10.0)
        S = (basis * values) @ basis.T
        S = np.tril(S) + np.tril(S, -1).T
        if surely_positive(S, np.zeros(m), np.empty((m, m))):
            yes += 1
            assert exactly_positive(S)
    assert yes > 50


@pytest.mark.parametrize("e", [1, 2])
def test_a_polynomial_is_called_positive_over_a_range_only_where_it_is(e: int) -> None:
    rng = np.random.default_rng(5)
    stack = np.empty((64, 4))
    q = np.linspace(0.0, 1.0, 4001)  # fine enough to see the least value to some 1e-5
    yes = no = 0
    for _ in range(300):
        C = rng.normal(size=(5, e, e)) * 10.0 ** rng.uniform(-2.0, 0.5, 5)[:, None, None]
        C = C + C.swapaxes(1, 2)
        lower = rng.uniform(-3.0, 3.0)
        upper = lower + rng.uniform(0.0, 2.0 * np.pi)
        angle = lower + q * (upper - lower)
        basis = np.stack((np.ones_like(q), np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)))
        least = np.linalg.eigvalsh(np.tensordot(basis, C, axes=(0, 0)))[:, 0].min()
        # Lift it so that its least value is a hair above or below zero.
        C[0] += (rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6.0, -1.0) - least) * np.eye(e)
        least = np.linalg.eigvalsh(np.tensordot(basis, C, axes=(0, 0)))[:, 0].min()
        sure = first_joints.positive_over_range(C, 0.0, lower, upper, stack)
        assert not sure or least > 0.0
        yes, no = yes + sure, no + (not sure and least > 5e-5)
    assert yes > 100
    assert no == 0


def test_a_range_is_followed_to_its_last_angle_and_not_to_one_beside_it() -> None:
    # In floating point −3 + (0.3 + 3) is a little less than 0.3; the last cell of a proof ends where the range does.
    lower, upper, stack = -3.0, 0.3, np.empty((64, 4))
    assert lower + (upper - lower) < upper
    C = np.zeros((5, 2, 2))
    C[0] = np.eye(2)
    assert first_joints.positive_over_range(C, 0.0, lower, upper, stack)
    assert stack[0, 1] == upper


def test_eigenpairs_that_guide_the_loss_are_eigenpairs() -> None:
    rng = np.random.default_rng(6)
    for m in SIZES:
        for _ in range(50):
            A = random_form(rng, m)
            V, d = np.empty((m, m)), np.empty(m)
            eigen(A, V, d, np.empty(m))
            assert np.abs(V.T @ V - np.eye(m)).max() < 1e-12
            assert (V * d) @ V.T == pytest.approx(A, abs=1e-11 * np.abs(A).max())
    # A form without any part keeps the eigenvectors' basis whole.
    V, d = np.empty((6, 6)), np.empty(6)
    eigen(np.zeros((6, 6)), V, d, np.empty(6))
    assert np.all(d == 0.0)
    assert np.abs(V.T @ V - np.eye(6)).max() < 1e-14


def test_eigenpairs_of_a_chain_of_equal_masses_are_those_of_its_closed_form() -> None:
    # 2 − 2 cos(kπ/(m + 1)); neighbours on the diagonal are alike, where a shift by their difference says nothing.
    for m in (2, 3, 6):
        A = 2.0 * np.eye(m) - np.eye(m, k=1) - np.eye(m, k=-1)
        V, d = np.empty((m, m)), np.empty(m)
        eigen(A, V, d, np.empty(m))
        assert np.sort(d) == pytest.approx(2.0 - 2.0 * np.cos(np.arange(1, m + 1) * np.pi / (m + 1)), abs=1e-13)
        assert (V * d) @ V.T == pytest.approx(A, abs=1e-13)
