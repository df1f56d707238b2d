"""Factors of small matrices: what is said to be positive definite is, and an inverse is one."""

from __future__ import annotations

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.numerics.cholesky import invert_lower, surely_positive


def symmetric(seed: int, eigenvalues: list[float]) -> Array:
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(len(eigenvalues),) * 2))[0]
    return np.asarray((turn * eigenvalues) @ turn.T)


def proven(matrix: Array, slack: float) -> bool:
    size = len(matrix)
    return bool(surely_positive(matrix.copy(), np.full(size, slack), np.zeros((size, size))))


@pytest.mark.parametrize("seed", range(5))
def test_a_matrix_is_surely_positive_where_its_least_eigenvalue_is_above_the_slack_and_not_where_it_is_below(seed):
    matrix = symmetric(seed, [0.3, 1.0, 2.5, 4.0])
    assert proven(matrix, 0.0)
    assert proven(matrix, 0.3 - 1e-5)
    assert not proven(matrix, 0.3 + 1e-9)
    assert not proven(-matrix, 0.0)
    assert not proven(symmetric(seed, [-1e-6, 1.0, 2.5, 4.0]), 0.0)


def test_what_is_positive_by_less_than_rounding_is_not_sure():
    assert not proven(symmetric(0, [1e-18, 1.0, 1.0]), 0.0)


def test_the_inverse_of_a_lower_triangle_times_it_is_one():
    lower = np.tril(np.random.default_rng(0).uniform(0.5, 2.0, (5, 5)))
    found = np.full((5, 5), np.nan)
    invert_lower(lower, found)
    np.testing.assert_allclose(found @ lower, np.eye(5), atol=1e-13)
    assert not np.triu(found, 1).any()
