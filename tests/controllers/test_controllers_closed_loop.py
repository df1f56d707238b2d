"""The laws on masses whose motion is known in closed form: no arm, no integrator, the torque held over a period."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from asmc_pin.controllers import Baek2016, Bsmc, Plestan2010, Ppc, Sample, Setpoint

L = 1e-3


def run(law: object, mass: float, drift: float, ticks: int, constant: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Hold q_d = 0 with a mass under the load h(t) = constant + drift·t (N·m, against positive motion).

    m q̈ = τ_k − h(t) over each period, integrated exactly.

    Returns:
        e and s at the ticks, rad and rad/s.
    """
    q, v, torque = (np.zeros((1, 1)) for _ in range(3))
    torque = torque + constant
    rest = Setpoint(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)))
    state = law.init(Sample(q, v, torque))
    e, s = np.empty(ticks), np.empty(ticks)
    for k in range(ticks):
        e[k], s[k] = -q.item(), -(v + law.ks * q).item()
        torque, state = law.step(state, Sample(q, v, torque), rest)
        a = (torque - constant - drift * k * L) / mass  # at the start of the period; it falls at drift/m from there
        q = q + L * v + L**2 / 2.0 * a - L**3 / 6.0 * drift / mass
        v = v + L * a - L**2 / 2.0 * drift / mass
    return e, s


@pytest.mark.parametrize(
    ("acceleration", "pairing", "age"),
    [("velocity", "last", 1.0), ("position", "last", 1.0), ("position", "matched", 1.5)],
)
@pytest.mark.parametrize(
    ("mass", "mbar", "ks", "beta", "drift"),
    [(1.0, 0.5, 10.0, 10.0, 3.0), (2.0, 2.0, 20.0, 5.0, -30.0), (0.3, 0.05, 5.0, 8.0, 1.0)],
)
def test_drifting_load_leaves_the_steady_error_of_theory(
    acceleration: str, pairing: str, age: float, mass: float, mbar: float, ks: float, beta: float, drift: float
) -> None:
    """theory: e → L ḣ/(m̄ β k_s), and half as much again where the mean of the last two torques is taken.

    Between the ticks the load drifts away from the held torque, so that v at the ticks is not 0 but −ḣ L²/(12 m);
    that takes (β + k_s) ḣ L²/(12 m β k_s) off the error. With it the prediction is exact.
    """
    e, _ = run(
        Ppc(mbar=mbar, ks=ks, beta=beta, period=L, acceleration=acceleration, pairing=pairing), mass, drift, 8000
    )
    leading = age * L * drift / (mbar * beta * ks)
    between = (beta + ks) * drift * L**2 / (12.0 * mass * beta * ks)
    assert e[-1] == pytest.approx(leading - between, rel=1e-6)


def test_a_low_pass_on_the_acceleration_leaves_the_steady_error_as_it_is() -> None:
    plain, _ = run(Ppc(mbar=0.5, ks=10.0, beta=10.0, period=L), 1.0, 3.0, 5000)
    filtered, _ = run(Ppc(mbar=0.5, ks=10.0, beta=10.0, period=L, filter_hz=100.0), 1.0, 3.0, 5000)
    assert filtered[-1] == pytest.approx(plain[-1], rel=1e-6)
    assert np.abs(filtered - plain).max() > 1e-3 * abs(plain[-1])  # but the filter is not idle on the way there


def test_a_constant_load_that_the_drive_holds_is_not_felt() -> None:
    e, _ = run(Ppc(mbar=0.5, ks=10.0, beta=10.0, period=L), 1.0, 0.0, 200, constant=25.0)
    assert not e.any()


def accelerations(law: Ppc, mass: float, ticks: int) -> np.ndarray:
    """q̈ in each period with q̈_d = 1 rad/s² and a setpoint that is where the mass is, so that e = ė = 0."""
    q, v, torque = np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1))
    state = law.init(Sample(q, v, torque))
    found = []
    for _ in range(ticks):
        torque, state = law.step(state, Sample(q, v, torque), Setpoint(q, v, np.ones((1, 1))))
        a = torque / mass
        found.append(a.item())
        q, v = q + L * v + L**2 / 2.0 * a, v + L * a
    return np.array(found)


@settings(max_examples=30, deadline=None)
@given(ratio=st.floats(0.05, 1.95))
def test_tde_error_shrinks_by_one_minus_mbar_over_m(ratio: float) -> None:
    error = 1.0 - accelerations(Ppc(mbar=0.7 * ratio, ks=1.0, beta=1.0, period=L), 0.7, 40)
    np.testing.assert_allclose(error, (1.0 - ratio) ** np.arange(1, 41), rtol=0.0, atol=1e-10)


@pytest.mark.parametrize(("ratio", "grows"), [(1.99, False), (2.01, True)])
def test_tde_error_grows_beyond_twice_the_mass(ratio: float, grows: bool) -> None:
    error = np.abs(1.0 - accelerations(Ppc(mbar=ratio, ks=1.0, beta=1.0, period=L), 1.0, 200))
    assert bool(error[-1] > error[0]) == grows


@settings(max_examples=30, deadline=None)
@given(ratio=st.floats(0.05, 1.95))
def test_tde_error_with_a_pair_of_two_periods_is_the_mean_of_the_last_two_shrunk_by_one_minus_mbar_over_m(
    ratio: float,
) -> None:
    """ā_k = (1 − a) (ā_{k−1} + ā_{k−2})/2 + a with a = m̄/m: stable for all a < 2, as Lemma 1 has it, and beyond."""
    error = 1.0 - accelerations(Ppc(mbar=0.7 * ratio, ks=1.0, beta=1.0, period=L, acceleration="position"), 0.7, 40)
    expected = [1.0, 1.0]
    for _ in range(40):
        expected.append((1.0 - ratio) * (expected[-1] + expected[-2]) / 2.0)
    np.testing.assert_allclose(error, expected[2:], rtol=0.0, atol=1e-7)


@settings(max_examples=30, deadline=None)
@given(ratio=st.floats(0.05, 0.95))
def test_tde_error_of_an_unpaired_second_difference_sees_the_mean_of_two_periods(ratio: float) -> None:
    """(q_k − 2q_{k−1} + q_{k−2})/L² is the mean acceleration of the last two periods, so the error r of q̈ obeys
    r_k = r_{k−1} − (m̄/m)(r_{k−1} + r_{k−2})/2 — with r = 1 at first, for nothing moves before t = 0."""
    law = Ppc(mbar=0.7 * ratio, ks=1.0, beta=1.0, period=L, acceleration="position", pairing="last")
    error = 1.0 - accelerations(law, 0.7, 40)
    expected = [1.0, 1.0]  # before t = 0: q̈ = 0, wanted 1
    for _ in range(40):
        expected.append(expected[-1] - ratio * (expected[-1] + expected[-2]) / 2.0)
    np.testing.assert_allclose(error, expected[2:], rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("law", "own"),
    [(Baek2016, {"phi": 1.0, "alpha": 5e-3}), (Plestan2010, {"rate": 20.0, "floor": 1e-3})],
)
def test_adaptive_laws_bring_s_to_the_layer_that_ppc_stays_outside(law: type, own: dict[str, float]) -> None:
    """Baek 2016 (16): s enters |s| < ε in a finite time. The load drifts at 30 N·m/s, which leaves PPC at
    s = L ḣ/(m̄ β) = 3ε; sampled, the gain breathes and s comes back out by a part of ε, but never half-way to PPC."""
    shared = {"mbar": 0.5, "ks": 10.0, "beta": 10.0, "period": L}
    epsilon = 2e-3
    _, ppc = run(Ppc(**shared), 1.0, 30.0, 4000)
    assert ppc[-1] == pytest.approx(3.0 * epsilon, rel=2e-3)
    _, s = run(law(**shared, **own, epsilon=epsilon), 1.0, 30.0, 4000)
    outside = np.flatnonzero(np.abs(s) >= epsilon)[0]
    assert (np.abs(s[outside:]) < epsilon).any()
    assert np.abs(s[2000:]).max() < 2.0 * epsilon < 0.7 * ppc[-1]


def test_boundary_layer_divides_the_steady_s_by_one_plus_k_over_beta_phi() -> None:
    """Inside the layer K s/Φ adds to β s: s = L ḣ/(m̄ (β + K/Φ)), here a third of PPC's."""
    shared = {"mbar": 0.5, "ks": 10.0, "beta": 10.0, "period": L}
    _, s = run(Bsmc(**shared, gain=2.0, boundary=0.1), 1.0, 30.0, 4000)
    assert s[-1] == pytest.approx(L * 30.0 / (0.5 * (10.0 + 20.0)), rel=2e-3)
