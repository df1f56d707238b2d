"""Eigenvalues of small matrices where their parts differ by more than a float's square can hold."""

from __future__ import annotations

import numpy as np

from asmc_pin.numerics.eigen import eigen


def test_a_coupling_whose_square_is_nothing_leaves_the_other_eigenvalues_as_they_are():
    tiny = 1e-170
    matrix = np.array([[1.0, 0.5, 0.0], [0.5, 0.0, tiny], [0.0, tiny, 0.0]])
    vectors, values = np.empty((3, 3)), np.empty(3)
    eigen(matrix, vectors, values, np.empty(3))
    # Of λ² − λ − 1/4, and of what is coupled by nothing.
    np.testing.assert_allclose(np.sort(values), [0.5 - np.sqrt(0.5), 0.0, 0.5 + np.sqrt(0.5)], atol=1e-15)
    np.testing.assert_allclose((vectors * values) @ vectors.T, matrix, atol=1e-15)
