"""Arrays in a table: compiled code and Python see the same numbers in the same places, and the arrays themselves."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from asmc_pin.numerics.array_table import ArrayTable, floats1, floats2, floats3, floats4, whole1, whole2

VIEWS = [(floats1, 1), (floats2, 2), (floats3, 3), (floats4, 4), (whole1, 1), (whole2, 2)]


@pytest.mark.parametrize(("view", "axes"), VIEWS, ids=lambda value: getattr(value, "__name__", ""))
def test_a_view_is_the_array_in_python_and_compiled(view, axes):
    kind = np.int64 if view in (whole1, whole2) else np.float64
    arrays = [np.arange(np.prod(shape), dtype=kind).reshape(shape) for shape in ((2, 3, 4, 5)[:axes], (3,) * axes)]
    table = ArrayTable(arrays)

    @numba.njit
    def doubled(rows, row):
        seen = view(rows, row)
        seen *= 2
        return seen.copy()

    for row, array in enumerate(arrays):
        before = array.copy()
        np.testing.assert_array_equal(view(table.rows, row), before)
        np.testing.assert_array_equal(doubled(table.rows, row), 2 * before)
        np.testing.assert_array_equal(array, 2 * before)


def test_an_array_that_does_not_lie_in_a_row_is_refused():
    with pytest.raises(ValueError, match="array 1 of a table"):
        ArrayTable([np.zeros(3), np.zeros((3, 4)).T])
