"""The two norms on given matrices, the matrix inequalities that equal them, and their compiled form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from certificate_cases import random_tree
from condition_cases import UR5_MBAR, chain, masses_and_mbars
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from asmc_pin import load_arm
from asmc_pin.condition import lemma1_norm, weighted_norm
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.search.samples import figures_at
from asmc_pin.errors import NotPositiveDefinite, ParameterError
from asmc_pin.rigid_body.mass_matrix import mass_matrices
from asmc_pin.rigid_body.recursion import links_of

KINDS = (
    compiled_norms.LEMMA1,
    compiled_norms.WEIGHTED,
    compiled_norms.LEMMA1_SCALE,
    compiled_norms.WEIGHTED_SCALE,
    compiled_norms.BANDWIDTH,
)


def naive(mass: np.ndarray, mbar: np.ndarray) -> float:
    return float(np.linalg.norm(np.eye(len(mbar)) - np.linalg.solve(mass, np.diag(mbar)), 2))


@given(masses_and_mbars(largest=10))
@settings(max_examples=150, deadline=None)
def test_norm_equals_lapacks_to_nine_digits(case: tuple[np.ndarray, np.ndarray]) -> None:
    mass, mbar = case
    expected = naive(mass, mbar)
    assert lemma1_norm(mass, mbar) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    eigenvalues = np.linalg.eigvals(np.linalg.solve(mass, np.diag(mbar))).real
    assert weighted_norm(mass, mbar) == pytest.approx(np.abs(1.0 - eigenvalues).max(), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("tiny", [1e-3, 1e-5, 1e-7])
def test_norm_of_a_nearly_singular_mass_is_exact_where_the_answer_is_known(tiny: float) -> None:
    # With M̄ = m·I the norm is max|1 − m/λᵢ(M)| (theory, fact 9), whatever the eigenvectors.
    rng = np.random.default_rng(3)
    basis, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    values = np.array([tiny, 0.1, 0.5, 1.0, 2.0, 5.0])
    mass = basis @ np.diag(values) @ basis.T
    mass = 0.5 * (mass + mass.T)
    for m in (tiny * 1e-3, tiny, 0.3):
        expected = np.abs(1.0 - m / values).max()
        # M itself carries errors of some 1e-16, which its inverse turns into 1e-16/tiny.
        assert lemma1_norm(mass, np.full(6, m)) == pytest.approx(expected, rel=max(1e-9, 1e-14 / tiny), abs=1e-9)


def test_scalar_mbar_satisfies_lemma1_exactly_below_twice_the_smallest_eigenvalue() -> None:
    mass = load_arm("ur5").mass_matrix(np.array([0.3, -1.0, 0.7, 0.2, 1.1, -0.4]))
    limit = 2.0 * np.linalg.eigvalsh(mass)[0]
    assert lemma1_norm(mass, np.full(6, limit * (1 - 1e-9))) < 1.0 < lemma1_norm(mass, np.full(6, limit * (1 + 1e-9)))


@given(masses_and_mbars())
@settings(max_examples=200, deadline=None)
def test_lemma1_is_the_matrix_inequality_nm_plus_mn_above_one(case: tuple[np.ndarray, np.ndarray]) -> None:
    mass, mbar = case
    norm = float(lemma1_norm(mass, mbar))
    assume(abs(norm - 1.0) > 1e-9)
    n = np.diag(1.0 / mbar)
    margin = np.linalg.eigvalsh(n @ mass + mass @ n - np.eye(len(mbar)))[0]
    assert (norm < 1.0) == (margin > 0.0)


@given(masses_and_mbars(), st.floats(0.05, 0.999))
@settings(max_examples=200, deadline=None)
def test_a_level_is_its_matrix_inequality(case: tuple[np.ndarray, np.ndarray], level: float) -> None:
    mass, mbar = case
    norm = float(lemma1_norm(mass, mbar))
    assume(abs(norm - level) > 1e-7)
    n, s = np.diag(1.0 / mbar), np.sqrt(1.0 - level**2)
    eye = np.eye(len(mbar))
    block = np.block([[n @ mass + mass @ n - eye, s * mass @ n], [s * n @ mass, eye]])
    assert (norm < level) == (np.linalg.eigvalsh(block)[0] >= 0.0)


@given(masses_and_mbars(), st.floats(0.05, 0.999))
@settings(max_examples=200, deadline=None)
def test_a_weighted_level_lies_between_two_multiples_of_m(case: tuple[np.ndarray, np.ndarray], level: float) -> None:
    mass, mbar = case
    norm = float(weighted_norm(mass, mbar))
    assume(abs(norm - level) > 1e-7)
    below = np.linalg.eigvalsh(np.diag(mbar) - (1.0 - level) * mass)[0] >= 0.0
    above = np.linalg.eigvalsh((1.0 + level) * mass - np.diag(mbar))[0] >= 0.0
    assert (norm < level) == (below and above)


@given(masses_and_mbars())
@settings(max_examples=200, deadline=None)
def test_weighted_norm_never_exceeds_lemma1s(case: tuple[np.ndarray, np.ndarray]) -> None:
    mass, mbar = case
    assert weighted_norm(mass, mbar) <= lemma1_norm(mass, mbar) * (1.0 + 1e-9) + 1e-9


def test_weighted_holds_where_lemma1_fails() -> None:
    mass = np.array([[1.0, 0.9], [0.9, 1.0]])
    mbar = np.array([0.05, 0.3])
    # 2M − M̄ = [[1.95, 1.8], [1.8, 1.7]] has the determinant 0.075; NM + MN − I has a negative one.
    assert weighted_norm(mass, mbar) < 1.0 < lemma1_norm(mass, mbar)


def test_weighted_norm_does_not_depend_on_units_and_lemma1s_does() -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    mass, mbar, units = root @ root.T + np.eye(3), np.array([0.5, 0.4, 0.3]), np.array([1.0, 100.0, 0.01])
    scaled = mass * np.outer(units, units), mbar * units**2
    assert weighted_norm(*scaled) == pytest.approx(weighted_norm(mass, mbar), rel=1e-9)
    assert abs(lemma1_norm(*scaled) - lemma1_norm(mass, mbar)) > 0.1


def test_norms_are_batched_over_both_arguments() -> None:
    arm = load_arm("ur5")
    q = np.random.default_rng(1).uniform(-3, 3, (4, 5, 6))
    mass = arm.mass_matrix(q)
    mbar = np.array(UR5_MBAR) * np.linspace(0.5, 1.5, 5)[:, None]
    norms = lemma1_norm(mass, mbar)
    assert norms.shape == (4, 5)
    assert norms[2, 3] == pytest.approx(naive(mass[2, 3], mbar[3]), rel=1e-12)


def test_an_indefinite_mass_is_named_with_its_eigenvalue() -> None:
    mass = np.stack([np.eye(2), np.diag([1.0, -0.25])])
    with pytest.raises(NotPositiveDefinite, match=r"index \(1,\)") as caught:
        lemma1_norm(mass, np.ones(2))
    assert caught.value.index == (1,)
    assert caught.value.smallest_eigenvalue == pytest.approx(-0.25)


@pytest.mark.parametrize(
    ("mass", "mbar", "message"),
    [
        (np.eye(3), np.ones(2), "shape"),
        (np.ones((2, 3)), np.ones(2), "expected"),
        (np.eye(2), np.array([1.0, -1.0]), "positive"),
        (np.eye(2), np.array([1.0, -0.5]), "-0.5 at index 1: every entry must be positive and finite"),
        (np.eye(2), np.array([0.0, 1.0]), "0 at index 0: every entry must be positive and finite"),
        (np.eye(2), np.array([1.0, np.nan]), "positive and finite"),
        (np.array([[1.0, np.inf], [np.inf, 1.0]]), np.ones(2), "not finite"),
        (np.array([[1.0, 0.5], [0.0, 1.0]]), np.ones(2), "not symmetric"),
        (np.stack([np.eye(2)] * 3), np.ones((2, 2)), "does not go with"),
    ],
)
def test_bad_matrices_are_refused_with_what_was_expected(mass: np.ndarray, mbar: np.ndarray, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        lemma1_norm(mass, mbar)


@given(st.integers(0, 10**6), st.integers(1, 9), st.booleans())
@settings(max_examples=25, deadline=None)
def test_compiled_norms_equal_pinocchio_and_lapack_on_random_chains(
    tmp_path_factory: pytest.TempPathFactory, seed: int, joints: int, prismatic: bool
) -> None:
    arm = chain(tmp_path_factory.getbasetemp(), seed, joints, prismatic).replace(armature=0.02)
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (8, joints))
    mass, mbar = arm.mass_matrix(q), rng.uniform(0.01, 0.05, joints)
    norms = figures_at(compiled_norms.LEMMA1, arm.tree, q, mbar)
    np.testing.assert_allclose(norms, [naive(m, mbar) for m in mass], rtol=1e-9, atol=1e-9)
    weighted = figures_at(compiled_norms.WEIGHTED, arm.tree, q, mbar)
    np.testing.assert_allclose(weighted, weighted_norm(mass, mbar), rtol=1e-9, atol=1e-9)
    # The joint that carries the whole arm does not matter.
    q[:, 0] += rng.uniform(-3, 3, 8)
    np.testing.assert_allclose(figures_at(compiled_norms.LEMMA1, arm.tree, q, mbar), norms, rtol=1e-9)


@pytest.mark.parametrize("name", ["kinova", "panda", "z1", "two_link"])
def test_compiled_norms_equal_pinocchio_and_lapack_on_named_arms(name: str) -> None:
    arm = load_arm(name)
    q = np.random.default_rng(0).uniform(-3, 3, (50, arm.nv))
    mass = arm.mass_matrix(q)
    mbar = 0.3 * np.linalg.eigvalsh(mass).min() * np.ones(arm.nv)
    np.testing.assert_allclose(
        figures_at(compiled_norms.LEMMA1, arm.tree, q, mbar), [naive(m, mbar) for m in mass], rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("prismatic", [False, True])
def test_gradients_equal_differences(tmp_path: Path, kind: int, prismatic: bool) -> None:
    arm = chain(tmp_path, 5, 5, prismatic).replace(armature=0.01)
    rng = np.random.default_rng(kind)
    mbar = np.diag(arm.mass_matrix(np.zeros(5))) * rng.uniform(0.1, 0.4, 5)
    by_angle, by_armature = np.empty(5), np.empty(5)
    armature = np.full(5, 0.01)
    for q in rng.uniform(-1.5, 1.5, (6, 5)):
        value = compiled_norms.figure_gradient(kind, links_of(arm.tree), armature, q, mbar, by_angle, by_armature)
        assert value == pytest.approx(float(figures_at(kind, arm.tree, q[None], mbar)[0]), rel=1e-9)
        h, step = 1e-5, np.eye(5)
        up, down = (figures_at(kind, arm.tree, q + s * h * step, mbar) for s in (1, -1))
        np.testing.assert_allclose(by_angle, (up - down) / (2 * h), rtol=1e-5, atol=1e-5 * np.abs(by_angle).max())
        h = 1e-6
        up, down = (figures_at(kind, arm.tree, np.tile(q, (5, 1)), mbar, 0.01 + s * h * step) for s in (1, -1))
        np.testing.assert_allclose(by_armature, (up - down) / (2 * h), rtol=1e-5, atol=1e-5 * np.abs(by_armature).max())


def test_gradients_equal_differences_where_one_link_carries_several() -> None:
    rng = np.random.default_rng(3)
    parent = np.array([-1, 0, 1, 2, 2, 3, 2], dtype=np.int64)
    n = len(parent)
    tree = replace(random_tree(rng, n), parent=parent, armature=np.full(n, 0.05))
    q = rng.uniform(-1.0, 1.0, n)
    mbar = 0.5 * np.diag(mass_matrices(tree, q[None])[0])
    gradient, by_armature = np.empty(n), np.empty(n)
    compiled_norms.figure_gradient(
        compiled_norms.WEIGHTED, links_of(tree), tree.armature, q, mbar, gradient, by_armature
    )
    h = 1e-5
    up, down = (weighted_norm(mass_matrices(tree, q + s * h * np.eye(n)), mbar) for s in (1, -1))
    np.testing.assert_allclose(gradient, (up - down) / (2 * h), rtol=1e-5, atol=1e-5 * np.abs(gradient).max())
