"""Claims about Stribeck, asymmetric and presliding friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plant_cases import OpenLoop, Still, slider
from scipy.integrate import solve_ivp

from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import INTEGRATORS, Friction, Plant
from asmc_pin.plant.friction.friction_parameters import VelocityTerm
from asmc_pin.plant.friction.presliding import slide_or_bend

MASS = 2.0


@pytest.fixture
def arm(tmp_path):
    return slider(tmp_path, MASS)


def run(arm, friction, torque, duration, period=1e-3, substeps=2, v0=0.0, integrator="semi_implicit", batch=1):
    plant = Plant(arm, substeps=substeps, friction=friction, start="relaxed", integrator=integrator)
    return rollout(plant, OpenLoop(torque, period), Still(np.zeros(1)), duration, v0=[v0], batch=batch)


# Stribeck


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_it_sticks_up_to_breakaway_and_then_needs_less(arm, integrator):
    friction = Friction(2.0, breakaway=3.0, stribeck_velocity=0.02)
    assert np.all(run(arm, friction, lambda t: 2.999999, 0.5, integrator=integrator).q == 0.0)
    moved = run(arm, friction, lambda t: 3.2 if t < 0.3 else 2.5, 3.0, integrator=integrator)
    assert moved.v[0, -1, 0] > 0.5, "2.5 N·m would not have started it, but keep it going"
    assert moved.friction_torque[0, -1, 0] == pytest.approx(-2.0, abs=1e-9)


@pytest.mark.parametrize(("integrator", "bound"), [("semi_implicit", 6e-4), ("midpoint", 2e-6), ("rk4", 1e-9)])
def test_sliding_follows_the_stribeck_curve(arm, integrator, bound):
    friction = Friction(2.0, 1.5, breakaway=4.0, stribeck_velocity=0.3)

    def slope(t, v):
        return (3.0 - 2.0 - 2.0 * np.exp(-((v / 0.3) ** 2)) - 1.5 * v) / MASS

    exact = solve_ivp(slope, (0.0, 2.0), [0.5], rtol=1e-11, atol=1e-12, t_eval=np.linspace(0.0, 2.0, 2001)).y[0]
    result = run(arm, friction, lambda t: 3.0, 2.0, v0=0.5, integrator=integrator)
    assert np.abs(result.v[0, :, 0] - exact).max() < bound


def test_the_falling_curve_makes_a_spring_drawn_mass_stick_and_slip(arm):
    # A spring of 50 N/m drawn at 0.02 m/s: a level that falls with speed gives stick-slip, a flat one does not.
    def drawn(friction):
        plant = Plant(arm, friction=friction, start="relaxed")

        class Spring(OpenLoop):
            def step(self, state, sample, setpoint):
                return 50.0 * (0.02 * state * self.period - sample.q), state + 1

        return rollout(plant, Spring(None, 1e-3), Still(np.zeros(1)), 12.0)

    slipping, steady = drawn(Friction(2.0, 0.2, breakaway=4.0)), drawn(Friction(2.0, 2.0))
    late = slipping.time > 4.0
    assert np.mean(slipping.v[0, late, 0] == 0.0) > 0.5
    assert slipping.v[0, late, 0].max() > 5 * 0.02
    np.testing.assert_allclose(steady.v[0, steady.time > 9.0, 0], 0.02, atol=1e-3)


def test_levels_may_differ_by_direction_and_by_trial(arm):
    friction = Friction([[1.0], [2.0]], breakaway=[[1.5], [2.5]], coulomb_backward=3.0, breakaway_backward=3.5)
    for torque, expected in ((2.0, [1.0, 0.0]), (3.0, [2.0, 1.0]), (-3.4, [0.0, 0.0]), (-4.0, [-1.0, -1.0])):
        result = run(arm, friction, lambda t, torque=torque: torque, 1.0, batch=2)
        np.testing.assert_allclose(result.v[:, -1, 0] - result.v[:, -2, 0], np.array(expected) / MASS * 1e-3, atol=1e-7)


def test_with_breakaway_at_the_coulomb_level_nothing_changes():
    arm = load_arm("ur5")
    q = np.array([[0.3, -1.0, 1.2, 0.4, 0.8, 0.2]])
    plain, curved = (
        Plant(arm, friction=Friction(3.0, 0.4, **more)).begin(q, 0.5 * q, 1e-3)
        for more in ({}, {"breakaway": np.full(6, 3.0), "coulomb_backward": 3.0})
    )
    for _ in range(50):
        np.testing.assert_array_equal(plain.advance(), curved.advance())
    np.testing.assert_array_equal(plain.q, curved.q)


# Presliding


@st.composite
def cases(draw):
    n = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    mass = (basis * 10.0 ** (draw(st.floats(0.0, 5.0)) * rng.random(n))) @ basis.T
    stiff = 10.0 ** rng.uniform(2, 6, n) * (rng.random(n) < 0.8)
    levels = rng.uniform(0.5, 20.0, (2, n)) * (stiff > 0.0)
    bend = np.where(stiff > 0.0, rng.uniform(-1, 1, n) * levels.min(axis=0) / np.maximum(stiff, 1.0), 0.0)
    v = rng.standard_normal(n) * 10.0 ** rng.uniform(-6, 0)
    return (
        (mass + mass.T) / 2,
        v,
        100.0 * rng.standard_normal(n),
        *levels,
        rng.random(n),
        stiff,
        5 * rng.random(n),
        bend,
    )


@settings(max_examples=60, deadline=None)
@given(cases())
def test_a_presliding_step_solves_its_equations_to_rounding(case):
    mass, v, a, forward, backward, viscous, stiff, damping, bend = (x[None] for x in case)
    h = 5e-4
    next_v, impulse, next_bend = np.full_like(v, np.nan), np.zeros_like(v), bend.copy()
    active = np.ones(1, dtype=bool)
    slide_or_bend(mass, v, a, forward, backward, viscous, stiff, damping, bend, h, active, next_v, impulse, next_bend)
    carried = np.where(stiff > 0.0, np.clip(stiff * (bend + h * next_v) + damping * next_v, -backward, forward), 0.0)
    terms = np.abs(mass[0]) @ (np.abs(next_v) + np.abs(v + h * a))[0] + h * np.abs(stiff * bend)[0]
    left = mass[0] @ (next_v - v - h * a)[0] + h * (viscous * next_v + carried)[0]
    assert np.abs(left).max() <= 1e-12 * terms.max()
    np.testing.assert_allclose(impulse, -h * (viscous * next_v + carried), rtol=1e-9, atol=1e-12 * terms.max())
    np.testing.assert_allclose(
        (stiff * next_bend + damping * next_v)[stiff > 0], carried[stiff > 0], rtol=1e-9, atol=1e-9
    )


def test_however_strongly_joints_pull_at_each_other_a_presliding_step_has_a_solution():
    """Where several leave their piece on the way, the walk goes no further than the first of them does."""
    rng = np.random.default_rng(0)
    h = 0.1
    for _ in range(60):
        n = int(rng.integers(2, 6))
        mixed = rng.normal(size=(n, n))
        mass = mixed @ mixed.T + 10.0 ** rng.uniform(-6.0, 0.0) * np.eye(n)
        stiff, levels = 10.0 ** rng.uniform(0.0, 5.0, (1, n)), 10.0 ** rng.uniform(-1.0, 2.0, (2, 1, n))
        push, v = rng.normal(size=n) * 10.0 ** rng.uniform(-1.0, 3.0, n), rng.normal(size=(1, n))
        a = np.linalg.solve(mass, push)[None]
        nothing, next_v, impulse, next_bend = np.zeros((1, n)), np.empty((1, n)), np.zeros((1, n)), np.empty((1, n))
        slide_or_bend(
            mass[None], v, a, *levels, nothing, stiff, nothing, nothing, h, np.ones(1, bool), next_v, impulse, next_bend
        )
        carried = np.clip(stiff * h * next_v, -levels[1], levels[0])
        terms = np.abs(mass) @ (np.abs(next_v) + np.abs(v) + h * np.abs(a))[0]
        left = mass @ (next_v - v - h * a)[0] + h * carried[0]
        assert np.abs(left).max() <= 1e-12 * (terms + h * np.abs(push)).max()


def test_before_breaking_loose_it_gives_way_like_a_spring_and_springs_back(arm):
    friction = Friction(5.0, presliding=1e4, presliding_damping=100.0)
    result = run(arm, friction, lambda t: 4.0 * np.sin(np.pi * min(t, 1.0)), 2.0)
    q = result.q[0, :, 0]
    np.testing.assert_allclose(q[:1000], 4e-4 * np.sin(np.pi * result.time[:1000]), atol=3e-5)
    assert abs(q[-1]) < 1e-9


@pytest.mark.parametrize("wave", [0.0, 1.0])
def test_presliding_does_not_creep_in_60_s_under_a_load_that_trembles(arm, wave):
    friction = Friction(5.0, presliding=1e4, presliding_damping=100.0)
    result = run(
        arm,
        friction,
        lambda t: min(4.0, 8.0 * t) + 0.5 * wave * np.sin(10.0 * np.pi * t),
        60.0,
        period=0.01,
        substeps=1,
    )
    q = result.q[0, :, 0]
    early, late = q[501:2001], q[4501:6001]  # whole waves of 20 ticks
    assert abs(late.mean() - early.mean()) < 1e-9
    assert late.max() < 5.0 / 1e4


def test_there_and_back_slides_dissipate_and_leave_the_bend_of_the_level(arm):
    friction = Friction(5.0, presliding=2e3, presliding_damping=60.0)
    result = run(arm, friction, lambda t: 7.0 * np.sin(6.0 * t), 4.0)
    work = np.sum(result.torque[0, :-1, 0] * np.diff(result.q[0, :, 0]))
    lost = np.sum(result.friction_torque[0, :-1, 0] * np.diff(result.q[0, :, 0]))
    kinetic = 0.5 * MASS * result.v[0, -1, 0] ** 2
    assert lost < 0.0
    assert work + lost == pytest.approx(kinetic, abs=0.01 * work)
    assert np.abs(result.friction_torque).max() <= 5.0 * (1 + 1e-12)


def test_stiff_presliding_comes_to_stick_and_slip(arm):
    def torque(t):
        return 7.0 * np.sin(6.0 * t)

    rigid = run(arm, Friction(5.0), torque, 2.0)
    gaps = [
        np.abs(run(arm, Friction(5.0, presliding=k, presliding_damping=1e-2 * k), torque, 2.0).q - rigid.q).max()
        for k in (1e3, 1e4, 1e5)
    ]
    assert gaps[1] < 0.2 * gaps[0]
    assert gaps[2] < 0.2 * gaps[1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"coulomb": 2.0, "breakaway": 1.0}, "below coulomb"),
        ({"coulomb": 2.0, "coulomb_backward": 3.0, "breakaway_backward": 2.0}, "below coulomb_backward"),
        ({"stribeck_velocity": 0.0}, "stribeck_velocity: got 0.0; it must be above 0"),
        ({"presliding": -1.0}, "presliding: got -1.0; it must be at least 0"),
    ],
)
def test_friction_that_cannot_be_is_refused(options, said):
    with pytest.raises(ParameterError, match=said):
        Friction(**options)


def test_a_scheme_that_cannot_carry_presliding_says_so(arm):
    with pytest.raises(ParameterError, match="rk4 cannot carry presliding"):
        Plant(arm, friction=Friction(1.0, presliding=1e3), integrator="rk4")


def test_presliding_is_for_every_joint_with_coulomb_friction_or_for_none():
    two = load_arm("two_link")
    with pytest.raises(ParameterError, match=r"friction.presliding: is 0 in a joint with Coulomb friction"):
        Plant(two, friction=Friction([1.0, 1.0], presliding=[1e3, 0.0])).begin(np.zeros((1, 2)), np.zeros((1, 2)), 1e-3)
    Plant(two, friction=Friction([1.0, 0.0], presliding=[1e3, 0.0])).begin(np.zeros((1, 2)), np.zeros((1, 2)), 1e-3)


# A term of velocity ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Dragged(Friction):
    """Friction with a drag that grows with the square of the speed, c·v·|v|."""

    drag: VelocityTerm = VelocityTerm("drag", "N·m·s²/rad²", level=lambda c, v: c * v * v)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_mass_that_is_pulled_reaches_the_speed_at_which_its_drag_balances_the_pull(arm, integrator):
    # m v' = F − c v²: v = √(F/c) tanh(√(F c) t/m)
    moved = run(arm, Dragged(drag=2.0), lambda t: 8.0, 2.0, integrator=integrator)
    exact = 2.0 * np.tanh(4.0 * np.linspace(0.0, 2.0, 2001) / MASS)
    assert np.abs(moved.v[0, :, 0] - exact).max() < 2e-3
    assert exact[-1] == pytest.approx(2.0, rel=1e-2)
    assert moved.friction_torque[0, -1, 0] == pytest.approx(-2.0 * exact[-1] ** 2, rel=1e-2)


def test_a_term_without_a_coefficient_changes_nothing(arm):
    def torque(t):
        return 6.0 * np.sin(9.0 * t)

    assert Dragged(1.0).constant
    np.testing.assert_array_equal(run(arm, Dragged(1.0), torque, 0.5).q, run(arm, Friction(1.0), torque, 0.5).q)
