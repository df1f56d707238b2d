"""A statement's quadratic form is its matrix, and the boxes of a record cover the whole, rounding included."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from check_cases import KINDS, arm, parsed_statement

from asmc_pin._typing import Array
from asmc_pin.condition.checker.boxes.bisection import Broken, Cells, cells, leaves
from asmc_pin.condition.checker.boxes.quadratic_form import Form, form_of, joint_space, least_eigenvalues, metrics
from asmc_pin.condition.checker.boxes.statements import _halves
from asmc_pin.condition.checker.reading.header_parts import WrittenStatement

# The four statements ------------------------------------------------------------------------------------------------


def _written(said: WrittenStatement, M: Array, mbar: Array) -> Array:
    """The matrix of docs/certificate.md, M with the armature in it."""
    f, gamma, N = said.scale, said.level, np.diag(1.0 / mbar)
    one = np.eye(mbar.size)
    if said.kind == "weighted":
        return M - f / (1.0 + gamma) * np.diag(mbar)
    if said.kind == "bounded":
        return np.asarray(f / (1.0 - gamma) * np.diag(mbar) - M)
    first = N @ M + M @ N - f * one
    if said.kind == "lemma1":
        return first
    s = np.sqrt(1.0 - gamma * gamma)
    return np.block([[first, s * M @ N], [s * N @ M, f * one]])


def _in_their_units(form: Form, P: Array, mbar: Array) -> Array:
    """A form's matrix in joint velocities, each joint's together, in the units and the order of the statement."""
    n, e = mbar.size, form.mixing.shape[2]
    P = P.reshape(n, e, n, e).transpose(1, 0, 3, 2).reshape(n * e, n * e)
    if form.pairing.shape[0] == 1:
        return P
    # What lifts a form of M̄⁻¹M in two twists measures each velocity by the root of M̄.
    root = np.tile(np.sqrt(mbar), e)
    return np.asarray(P / root[:, None] / root)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("prismatic", [False, True])
def test_the_form_of_a_statement_is_its_matrix(kind: str, prismatic: bool) -> None:
    rng = np.random.default_rng(0)
    for seed in range(6):
        n = int(rng.integers(1, 6))
        chain, _ = arm(seed, n, prismatic)
        mbar, armature = 10.0 ** rng.uniform(-2.0, 1.0, n), rng.uniform(0.0, 2.0, n)
        level = {"weighted": 0.7, "bounded": 0.3, "lemma1": 1.0, "level": 0.6}[kind]
        said = parsed_statement(n, kind, scale=rng.uniform(0.2, 3.0), level=level, armature=armature)
        form = form_of(chain, mbar, said, -np.ones(n), np.ones(n))
        q = rng.uniform(-2.0, 2.0, (3, n))
        for M, P in zip(chain.mass_matrix(q, armature), joint_space(form, q), strict=True):
            expected = _written(said, M, mbar)
            assert _in_their_units(form, P, mbar) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        values = np.linalg.eigvalsh(joint_space(form, q))
        assert least_eigenvalues(form, q) == pytest.approx(values[:, 0] / np.abs(values[:, -1]))


def test_a_level_near_one_keeps_its_digits() -> None:
    chain, _ = arm(1, 2)
    gamma = 1.0 - 2.0**-40
    said = parsed_statement(2, "level", level=gamma)
    form = form_of(chain, np.ones(2), said, -np.ones(2), np.ones(2))
    with np.errstate(all="raise"):
        s = form.mixing[0, 1, 1] / form.mixing[0, 1, 0]
    exact = 1 - Fraction(gamma) ** 2
    assert abs(Fraction(float(s)) ** 2 / exact - 1) < Fraction(1, 10**14)


@pytest.mark.parametrize("kind", ["bounded", "level"])
def test_a_statement_with_slack_implies_it_at_every_armature_of_the_range(kind: str) -> None:
    rng = np.random.default_rng(1)
    chain, _ = arm(3, 3)
    mbar = 10.0 ** rng.uniform(-1.0, 1.0, 3)
    low, slack = rng.uniform(0.0, 0.5, 3), rng.uniform(0.0, 0.5, 3) * (0.0, 1.0, 1.0)
    ends = np.zeros(3), np.ones(3)
    of_all = form_of(chain, mbar, parsed_statement(3, kind, armature=low, slack=slack), *ends)
    shares = [*product((0.0, 1.0), repeat=3), *rng.random((20, 3))]
    for share in shares:
        armature = low + np.array(share) * slack
        of_one = form_of(chain, mbar, parsed_statement(3, kind, armature=armature), *ends)
        above = of_one.own - of_all.own
        assert np.all(np.linalg.eigvalsh(above) >= -1e-15 * of_all.own_size)
    # Of `bounded` it is the statement at the upper end, and of `level` no more is taken off than one direction needs.
    upper = form_of(chain, mbar, parsed_statement(3, kind, armature=low + slack), *ends)
    lost = upper.own - of_all.own
    assert np.all(np.abs(np.linalg.eigvalsh(lost)[:, 0]) <= 1e-15 * of_all.own_size[:, 0])


def test_the_slack_is_replayed_larger_than_a_range_is_rounded() -> None:
    chain, _ = arm(3, 3)
    low, high = np.array([0.1, 1e3, 1e-3]), np.array([0.3, 1e3 + 0.1, 1e3])
    said = parsed_statement(3, "bounded", armature=low, slack=high - low)
    form = form_of(chain, np.ones(3), said, np.zeros(3), np.ones(3))
    for own, end in zip(form.own[:, 0, 0], high, strict=True):
        # Upper ends that are two units of rounding above are inside.
        assert Fraction(float(own)) <= 2 - Fraction(float(end)) * (1 + Fraction(1, 2**51))


@pytest.mark.parametrize("kind", KINDS)
def test_the_magnitudes_of_a_joints_own_form_are_those_before_they_cancel(kind: str) -> None:
    chain, _ = arm(3, 2)
    ranged = kind in ("bounded", "level")
    # Each of what takes part is the larger one in turn.
    for armature, m, slack in ((1e6, 1.0, 0.0), (1.0, 1e6, 0.0), (1.0, 1.0, 1e6), (1e6, 2e6, 1.0)):
        slack *= ranged
        said = parsed_statement(2, kind, scale=0.5, armature=[armature] * 2, slack=[slack] * 2)
        form = form_of(chain, np.full(2, m), said, np.zeros(2), np.ones(2))
        first = {"weighted": armature + 0.25 * m, "bounded": armature + m + slack}.get(kind, 2.0 * armature + 0.5 * m)
        assert np.all(form.own_size >= (first + slack) / (1.0 + (kind == "bounded")) * (1.0 - 1e-12))
        assert np.all(form.own_size[:, 0] >= first * (1.0 - 1e-12))
        assert np.all(form.own_size >= np.abs(form.own).sum(axis=2) * (1.0 - 1e-12))
        if kind == "level":
            second = np.sqrt(0.75) * armature + 0.5 * m + slack
            assert np.all(form.own_size[:, 1] >= second * (1.0 - 1e-12))
        assert np.all(form.own_size <= 4.0 * (armature + m + slack))


@pytest.mark.parametrize(
    ("parents", "slides", "exact"),
    [
        ([-1], [False], False),
        ([-1, 0], [False, False], True),
        ([-1, 0], [True, False], True),
        ([-1, 0], [False, True], False),
        ([-1, -1], [False, False], False),
        ([-1, 0, 0], [False, False, False], True),
        ([-1, -1, 1], [False, False, False], False),
    ],
)
def test_only_a_second_joint_that_turns_on_the_first_is_followed(
    parents: list[int], slides: list[bool], exact: bool
) -> None:
    n = len(parents)
    chain, _ = arm(2, n)
    chain.parent[:], chain.slides[:] = parents, slides
    lower, upper = -np.arange(1.0, n + 1.0), np.arange(2.0, n + 2.0)
    form = form_of(chain, np.ones(n), parsed_statement(n, "weighted"), lower, upper)
    assert form.exact is exact
    assert form.range_1 == ((-2.0, 3.0) if exact else (0.0, 0.0))


@pytest.mark.parametrize("lower", [-10.0, -3.0, 1.0, 100.0])
def test_of_a_range_of_more_than_a_turn_one_turn_is_followed(lower: float) -> None:
    chain, _ = arm(2, 2)
    for width in (0.0, 1.0, 6.28, 6.29, 20.0):
        ends = np.array([0.0, lower]), np.array([0.0, lower + width])
        start, end = form_of(chain, np.ones(2), parsed_statement(2, "weighted"), *ends).range_1
        assert start == lower
        assert end == lower + width if width < 6.283 else lower + 2.0 * np.pi <= end <= lower + 6.2832


@pytest.mark.parametrize("kind", KINDS)
def test_the_metric_that_guides_is_one(kind: str) -> None:
    n = 4
    chain, _ = arm(2, n)
    form = form_of(chain, np.full(n, 0.1), parsed_statement(n, kind), -np.ones(n), np.ones(n))
    c = np.random.default_rng(0).uniform(-1.0, 1.0, (3, n))
    roots, inverses, weak, least = metrics(form, c)
    for i in range(1, n):
        assert roots[i] @ inverses[i] == pytest.approx(
            np.broadcast_to(np.eye(roots[i].shape[1]), roots[i].shape), abs=1e-6
        )
        assert weak[i].shape == (3, roots[i].shape[1])
    q = c.copy()
    q[:, 1] = 0.0
    assert np.all(least <= least_eigenvalues(form, q) + 1e-3)


@pytest.mark.parametrize("kind", ["lemma1", "level"])
def test_the_metric_that_guides_does_not_depend_on_the_units_of_the_two_twists(kind: str) -> None:
    n, factor = 4, np.array([100.0, 0.01])
    chain, _ = arm(2, n)
    form = form_of(chain, np.array([0.1, 0.03, 0.2, 0.05]), parsed_statement(n, kind), -np.ones(n), np.ones(n))
    # One twist in other units and the other in their inverse: the same form, which pairs one with the other.
    other = replace(form, mixing=form.mixing * factor[:, None])
    c = np.random.default_rng(0).uniform(-1.0, 1.0, (3, n))
    assert joint_space(other, c) == pytest.approx(joint_space(form, c), rel=1e-12, abs=1e-12)
    roots, _, weak, _ = metrics(form, c)
    found, _, moved, _ = metrics(other, c)
    units = np.repeat(factor, 6)
    for i in range(1, n):
        # So is what it measures, and the cost of a cell with it.
        expected = roots[i] / units[:, None]
        assert found[i] == pytest.approx(expected, rel=1e-6, abs=1e-9 * np.abs(expected).max())
        assert moved[i] == pytest.approx(weak[i] * units, rel=1e-6, abs=1e-9 * np.abs(weak[i] * units).max())


# Halving ------------------------------------------------------------------------------------------------------------


def test_the_halves_of_a_box_cover_it_also_where_rounding_is_worst() -> None:
    rng = np.random.default_rng(2)
    for exponent in np.arange(0.0, 16.5, 0.5):
        centre = rng.uniform(-1.0, 1.0, (40, 3)) * 10.0 ** rng.uniform(-3.0, 6.0, (40, 1))
        half = np.abs(centre) * 10.0**-exponent * rng.uniform(0.5, 2.0, (40, 3))
        cost = rng.random((40, 3))
        both, narrow, depth = _halves(centre, half, np.arange(40), cost)
        assert both.shape == narrow.shape == (80, 3)
        assert depth.tolist() == [k + 1 for k in range(40) for _ in range(2)]
        for k in range(40):
            joint = int(np.argmax(cost[k]))
            for j in range(3):
                c, r = Fraction(float(centre[k, j])), Fraction(float(half[k, j]))
                ends = [
                    (Fraction(float(both[m, j])) - Fraction(float(narrow[m, j])),
                     Fraction(float(both[m, j])) + Fraction(float(narrow[m, j])))
                    for m in (2 * k, 2 * k + 1)
                ]  # fmt: skip
                if j != joint:
                    assert ends == [(c - r, c + r)] * 2
                    continue
                (a, b), (x, y) = sorted(ends)
                assert a <= c - r
                assert b >= x
                assert y >= c + r
                # And are halves, but for the rounding of the centre.
                assert b - a <= r + (abs(c) + r) * Fraction(1, 10**14)


def test_a_box_is_halved_where_it_costs_most_and_is_wide() -> None:
    centre, half = np.zeros((4, 3)), np.array([[1.0, 0.0, 1.0]] * 4)
    cost = np.array([[1.0, 9.0, 2.0], [3.0, 9.0, 2.0], [0.0, 0.0, 0.0], [np.nan, 9.0, 5.0]])
    narrow = _halves(centre, half, np.zeros(4, dtype=np.int64), cost)[1][::2]
    expected = [[1.0, 0.0, 0.5], [0.5, 0.0, 1.0], [0.5, 0.0, 1.0], [0.5, 0.0, 1.0]]
    assert narrow == pytest.approx(np.array(expected), rel=1e-12)


# Records ------------------------------------------------------------------------------------------------------------


def _record(rng: np.random.Generator, joints: int, halvings: int) -> np.ndarray:
    """A random complete bisection of so many halvings."""
    out, open_boxes = [], 1
    while open_boxes:
        if halvings and (open_boxes == 1 or rng.random() < 0.5):
            out.append(int(rng.integers(joints)))
            halvings, open_boxes = halvings - 1, open_boxes + 1
        else:
            out.append(255)
            open_boxes -= 1
    return np.array(out, dtype=np.uint8)


def test_the_cells_of_a_record_are_the_whole_box_each_part_once() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        record = _record(rng, 3, 30)
        (found,) = cells(record, 3)
        assert len(found.level) == leaves(record) == 31
        boxes = [
            [(Fraction(int(i), 2 ** int(level)), Fraction(int(i) + 1, 2 ** int(level)))
             for level, i in zip(*row, strict=True)]
            for row in zip(found.level, found.index, strict=True)
        ]  # fmt: skip
        assert all(0 <= a < b <= 1 for box in boxes for a, b in box)
        assert sum((b - a) * (d - c) * (f - e) for (a, b), (c, d), (e, f) in boxes) == 1
        for one, other in product(range(31), repeat=2):
            if one < other:
                assert any(a >= d or c >= b for (a, b), (c, d) in zip(boxes[one], boxes[other], strict=True))


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_boxes_of_floats_cover_the_cells_that_they_stand_for_down_to_the_deepest(size: float) -> None:
    rng = np.random.default_rng(4)
    # Both ends large, one of them next to zero, and a range that is short beside its ends.
    lower = size * np.array([rng.uniform(-2.0, 1.0), 1e-9, -1.0, -1.0 - 3e-7, 0.7])
    upper = size * np.array([1.0 + rng.random(), 1.0 / 3.0, 1e-9, -1.0, 0.7])
    for depth in (0, 1, 7, 30, 60):
        last = 2**depth - 1
        drawn = [int(rng.integers(0, last + 1)) for _ in range(20)]
        index = np.array([[k] * 5 for k in (0, last, last // 3, max(last - 1, 0), *drawn)], dtype=np.int64)
        level = np.full(index.shape, depth, dtype=np.int64)
        centre, half = Cells(level, index).boxes(lower, upper)
        assert np.all(half[:, 4] == 0.0)
        assert np.all(centre[:, 4] == lower[4])
        for row, (c, r) in zip(index, zip(centre, half, strict=True), strict=True):
            for j in range(4):
                lo, width = Fraction(float(lower[j])), Fraction(float(upper[j])) - Fraction(float(lower[j]))
                start, end = (lo + width * Fraction(int(row[j]) + k, 2**depth) for k in (0, 1))
                middle, radius = Fraction(float(c[j])), Fraction(float(r[j]))
                assert middle - radius <= start < end <= middle + radius
                assert 2 * radius <= (end - start) + (abs(lo) + abs(lo + width)) * Fraction(1, 10**13)


def test_a_joint_is_halved_sixty_times_and_not_once_more() -> None:
    def deep(times: int) -> np.ndarray:
        return np.array([0] * times + [255] * (times + 1), dtype=np.uint8)

    (found,) = cells(deep(60), 1)
    assert found.level.max() == 60
    assert sum(Fraction(1, 2 ** int(level)) for level in found.level[:, 0]) == 1
    with pytest.raises(Broken, match="too often"):
        list(cells(deep(61), 1))
    # Of two joints each.
    both = np.array([0, 1] * 60 + [255] * 121, dtype=np.uint8)
    (found,) = cells(both, 2)
    assert found.level.max(axis=0).tolist() == [60, 60]
    assert sum(Fraction(1, 2 ** int(level.sum())) for level in found.level) == 1


@pytest.mark.parametrize(
    ("record", "why"),
    [
        ([], "1 boxes open"),
        ([0], "2 boxes open"),
        ([0, 255], "1 boxes open"),
        ([255, 255], "goes on"),
        ([0, 255, 255, 0, 255, 255], "goes on"),
        ([2, 255, 255], "not there"),
        ([254, 255, 255], "not there"),
    ],
)
def test_what_is_no_bisection_says_why(record: list[int], why: str) -> None:
    with pytest.raises(Broken, match=why):
        list(cells(np.array(record, dtype=np.uint8), 2))


def test_pieces_of_a_long_record_are_the_same_cells_in_bounded_memory() -> None:
    # All cells of 2^14, joint after joint.
    def whole(depth: int) -> list[int]:
        return [255] if depth == 0 else [depth % 2, *whole(depth - 1), *whole(depth - 1)]

    record = np.array(whole(14), dtype=np.uint8)
    pieces = list(cells(record, 2))
    assert [len(piece.level) for piece in pieces] == [4096] * 4
    index = np.concatenate([piece.index for piece in pieces])
    assert len({tuple(row) for row in index.tolist()}) == 2**14
    assert np.all(np.concatenate([piece.level for piece in pieces]) == 7)
    tracemalloc.start()
    count = sum(len(piece.level) for piece in cells(record, 2))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count == leaves(record) == 2**14
    # Two pieces and not four.
    assert peak < 2.5 * 4096 * 2 * 2 * 100


def test_a_record_that_ends_with_a_full_piece_is_complete() -> None:
    def whole(depth: int) -> list[int]:
        return [255] if depth == 0 else [0, *whole(depth - 1), *whole(depth - 1)]

    assert [len(piece.level) for piece in cells(np.array(whole(12), dtype=np.uint8), 1)] == [4096]
    broken = np.array([0, *whole(12)], dtype=np.uint8)
    found = cells(broken, 1)
    assert len(next(found).level) == 4096
    with pytest.raises(Broken):
        next(found)
