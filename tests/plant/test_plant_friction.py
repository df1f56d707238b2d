"""Claims about the set-valued friction of one step."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from asmc_pin.arms import load_arm
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Friction
from asmc_pin.plant.friction.compiled_friction import _go, carried_load, slide_or_stick

STEP = 5e-4


def violation(mass, free, step, forward, backward, viscous, next_v):
    """How far h·f = −M(v⁺ − v_free) − hBv⁺ is from h·c·Sgn(v⁺), per joint; N·m·s."""
    load = -np.einsum("...ij,...j->...i", mass, next_v - free) - step * viscous * next_v
    over = np.maximum(load - step * forward, -load - step * backward)
    return np.where(
        next_v > 0.0,
        np.abs(load - step * forward),
        np.where(next_v < 0.0, np.abs(load + step * backward), np.maximum(over, 0.0)),
    )


def solve(mass, v, a, forward, backward, viscous, step=STEP, active=None):
    next_v, impulse = np.full_like(v, np.inf), np.zeros_like(v)
    active = np.ones(len(v), dtype=bool) if active is None else active
    slide_or_stick(mass, v, a, forward, backward, viscous, step, active, next_v, impulse)
    return next_v, impulse


def test_friction_on_random_ur5_states_obeys_the_set_valued_law_to_1e_10():
    arm = load_arm("ur5")
    rng = np.random.default_rng(1)
    batch = 400
    q = rng.uniform(-np.pi, np.pi, (batch, 6))
    v = rng.normal(0.0, 0.5, (batch, 6)) * (rng.random((batch, 6)) < 0.6)
    torque = arm.gravity(q) + rng.normal(0.0, 8.0, (batch, 6))
    coulomb, viscous = rng.uniform(0.0, 10.0, (batch, 6)), rng.uniform(0.0, 1.0, (batch, 6))
    a = arm.forward_dynamics(q, v, torque)
    mass = arm.mass_matrix(q)
    next_v, impulse = solve(mass, v, a, coulomb, coulomb, viscous)
    worst = violation(mass, v + STEP * a, STEP, coulomb, coulomb, viscous, next_v) / STEP
    assert worst.max() < 1e-10  # N·m
    stuck = next_v == 0.0
    assert 0.1 < stuck.mean() < 0.9
    assert np.all(impulse[~stuck] * next_v[~stuck] < 0.0), "friction opposes motion"
    assert np.all(np.abs(impulse[stuck]) <= STEP * coulomb[stuck] * (1 + 1e-12))
    # What the log calls friction is what is missing in the momentum balance.
    np.testing.assert_allclose(
        np.einsum("bij,bj->bi", mass, next_v - v - STEP * a), impulse, rtol=0, atol=1e-13 * np.abs(mass).max()
    )


@st.composite
def cases(draw):
    n = draw(st.integers(1, 10))
    seed = draw(st.integers(0, 2**32 - 1))
    condition = 10.0 ** draw(st.floats(0.0, 8.0))
    rng = np.random.default_rng(seed)
    basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    mass = (basis * condition ** rng.random(n)) @ basis.T
    v = rng.standard_normal(n) * (rng.random(n) < draw(st.floats(0.0, 1.0))) * 10.0 ** rng.uniform(-6, 1)
    a = rng.standard_normal(n) * 100.0
    scale = draw(st.floats(0.0, 3.0)) * np.abs(mass @ a).mean()
    return (mass + mass.T) / 2, v, a, *(scale * rng.random((2, n)) * (rng.random(n) < 0.8)), rng.random(n)


@settings(max_examples=150, deadline=None)
@given(cases())
def test_any_inertia_up_to_condition_1e8_is_solved_to_rounding(case):
    mass, v, a, forward, backward, viscous = case
    next_v, _ = (x[0] for x in solve(*(x[None] for x in case)))
    assert np.isfinite(next_v).all()
    scale = np.abs(mass) @ (np.abs(next_v) + np.abs(v + STEP * a)) + STEP * (forward + backward)
    assert np.all(violation(mass, v + STEP * a, STEP, forward, backward, viscous, next_v) <= 2e-13 * scale.max())


def test_the_walk_ends_on_the_face_that_enumeration_finds():
    rng = np.random.default_rng(2)
    n, step = 3, 1e-2
    for _ in range(100):
        root = rng.standard_normal((n, n))
        mass = root @ root.T + 0.05 * np.eye(n)
        v, a, c = rng.standard_normal(n) * (rng.random(n) < 0.6), 50 * rng.standard_normal(n), 40 * rng.random(n)
        free = v + step * a
        best, best_value = None, np.inf
        for signs in itertools.product((-1.0, 0.0, 1.0), repeat=n):
            s = np.array(signs)
            f = s != 0.0
            x = np.zeros(n)
            x[f] = np.linalg.solve(mass[np.ix_(f, f)], (mass @ free - step * c * s)[f])
            value = 0.5 * x @ mass @ x - free @ mass @ x + step * c @ np.abs(x)
            if np.all(x[f] * s[f] > 0.0) and value < best_value:
                best, best_value = x, value
        next_v, _ = solve(mass[None], v[None], a[None], c[None], c[None], np.zeros((1, n)), step)
        np.testing.assert_allclose(next_v[0], best, rtol=1e-9, atol=1e-12)
        np.testing.assert_array_equal(next_v[0] == 0.0, best == 0.0)


def test_on_the_way_to_a_faces_minimum_the_first_joint_that_would_turn_round_stops_all():
    face, none = np.array([0, 1]), np.zeros(2)
    for start, target, share in (
        (1.0, -1.0, 0.5),
        (2.0, -0.5, 0.8),
        (0.0, 0.0, 0.0),
        (0.0, -1.0, 0.0),
        (1.0, 0.0, 1.0),
    ):
        sign, present = np.array([1, 0]), np.array([start, 1.0])
        assert _go(face, 2, np.array([target, 3.0]), none, sign, present) == 0
        assert sign.tolist() == [0, 0]
        np.testing.assert_allclose(present, [0.0, 1.0 + 2.0 * share], rtol=1e-12)
    # None turns round: all reach it.
    sign, present = np.array([1, -1]), np.array([1.0, -1.0])
    assert _go(face, 2, np.array([0.5, -3.0]), none, sign, present) == -1
    np.testing.assert_allclose(present, [0.5, -3.0])
    assert _go(face, 2, np.array([np.nan, 1.0]), none, sign, present) == -2


def test_what_balances_a_sticking_joint_is_known_with_the_magnitudes_of_its_terms():
    matrix, drag = np.array([[2.0, -1.0], [-1.0, 3.0]]), np.array([0.5, 0.25])
    load, magnitude = carried_load(0, matrix, drag, np.array([0.1, 0.4]))
    assert load == pytest.approx(-0.5 - 0.2 + 0.4)
    assert magnitude == pytest.approx(0.5 + 0.2 + 0.4)


@pytest.mark.parametrize("step", [1e-6, 1e-4, 1e-2, 1.0])
def test_breakaway_is_the_same_at_every_step_size(step):
    mass = np.array([[[2.0]]])
    level = np.array([[3.0]])
    for load, sticks in ((2.9999999, True), (-2.9999999, True), (3.0000001, False), (-3.0000001, False)):
        next_v, impulse = solve(mass, np.zeros((1, 1)), np.array([[load / 2.0]]), level, level, np.zeros((1, 1)), step)
        assert bool(next_v[0, 0] == 0.0) is sticks
        if sticks:
            assert impulse[0, 0] == pytest.approx(-load * step, rel=1e-14)


def test_forward_and_backward_levels_differ_where_asked():
    mass, zero = np.array([[[1.0]]]), np.zeros((1, 1))
    levels = np.array([[1.0]]), np.array([[4.0]])
    assert solve(mass, zero, np.array([[2.0]]), *levels, zero)[0][0, 0] == pytest.approx(STEP * (2.0 - 1.0))
    assert solve(mass, zero, np.array([[-2.0]]), *levels, zero)[0][0, 0] == 0.0


def test_a_mass_matrix_that_is_not_positive_definite_spoils_its_own_trial_only():
    mass = np.array([np.eye(2), -np.eye(2), np.eye(2)])
    v, ones = np.ones((3, 2)), np.ones((3, 2))
    next_v, _ = solve(mass, v, 0.0 * v, ones, ones, ones, active=np.array([True, True, False]))
    assert np.isfinite(next_v[0]).all()
    assert np.isnan(next_v[1]).all()
    assert np.isinf(next_v[2]).all(), "a trial that is not active is left as it is"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"coulomb": -1.0}, "coulomb: got -1.0; it must be at least 0"),
        ({"viscous": [0.1, np.nan]}, "viscous: entry 2 is nan; each must be at least 0"),
        ({"coulomb": np.inf}, "coulomb: got inf; it must be at least 0"),
        ({"coulomb": "stiff"}, "expected a number"),
        (
            {"viscous": np.zeros((2, 2, 2))},
            r"got an array of shape \(2, 2, 2\); expected .* a row of these for each trial",
        ),
    ],
)
def test_friction_that_cannot_be_is_refused(arguments, said):
    with pytest.raises(ParameterError, match=said):
        Friction(**arguments)


def test_friction_is_read_only_and_keeps_no_reference_to_what_was_given():
    given_array = np.array([1.0, 2.0])
    friction = Friction(coulomb=given_array)
    given_array[0] = 9.0
    assert friction.coulomb[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        friction.coulomb[0] = 5.0


def test_friction_may_have_a_row_for_each_trial_and_each_row_is_for_the_joints():
    Friction([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]).check(2)
    with pytest.raises(ParameterError, match=r"friction\."):
        Friction([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]).check(3)
