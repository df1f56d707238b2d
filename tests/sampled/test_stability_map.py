"""The linear map of the sampled loop against the controller itself, closed forms, and a simulation tick by tick."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from asmc_pin._typing import Array
from asmc_pin.controllers import CONTROLLERS, Setpoint, TdeLaw, parameters_of
from asmc_pin.errors import NotPositiveDefinite, ParameterError
from asmc_pin.plant import Sensor
from asmc_pin.plant.sensor.sensor_state import Sensing
from asmc_pin.sampled import SampledLoop, closed_loop, inertia_ratios, modal_radius, spectral_radius
from asmc_pin.words.choices import Acceleration, Pairing

MASS = np.array([[0.7, 0.2, 0.05], [0.2, 0.3, 0.04], [0.05, 0.04, 0.09]])
MBAR = np.array([0.15, 0.1, 0.04])
KS = np.array([12.0, 20.0, 31.0])
TIMINGS: list[dict] = [
    {"acceleration": acceleration, "filter_hz": filter_hz, "delay": delay}
    for acceleration in get_args(Acceleration)
    for filter_hz in (None, 35.0)
    for delay in (0.0, 0.35, 1.0, 2.6)
]
SENSED: list[dict] = [
    {"pairing": "mean"},
    {"acceleration": "position", "pairing": "last", "delay": 1.4},
    {"velocity": "difference"},
    {"velocity": "difference", "pairing": "last", "filter_hz": 35.0},
    {"velocity": "difference", "acceleration": "position", "delay": 1.0},
    {"velocity": "difference", "velocity_filter_hz": 60.0},
    {"velocity": "difference", "velocity_filter_hz": 60.0, "acceleration": "position", "filter_hz": 35.0},
    {"reading_delay": 1.0},
    {"reading_delay": 0.4, "velocity": "difference", "delay": 0.6},
    {"reading_delay": 2.3, "acceleration": "position", "filter_hz": 90.0},
]
TIMINGS += SENSED


def drive_the_real_controller(
    loop: SampledLoop,
    ticks: int,
    *,
    viscous: Array | None = None,
    stiffness: Array | None = None,
    load: Array | None = None,
) -> tuple[Array, Array]:
    """Angles and velocities at the ticks, with `ppc` from the package and the joint solved by matrix exponentials."""
    n = loop.nv
    law = CONTROLLERS["ppc"](
        mbar=loop.mbar, ks=loop.ks, beta=float(loop.beta[0]), period=loop.period,
        acceleration=loop.acceleration, filter_hz=loop.filter_hz,
        pairing="mean" if loop.averages_torque else "last",
    )  # fmt: skip
    damping = np.zeros((n, n)) if viscous is None else np.diag(viscous)
    spring = np.zeros((n, n)) if stiffness is None else stiffness
    load = np.zeros(n) if load is None else load
    inverse = np.linalg.inv(MASS)
    rates = np.zeros((3 * n, 3 * n))
    rates[:n, n : 2 * n] = np.eye(n)
    rates[n : 2 * n] = np.hstack([-inverse @ spring, -inverse @ damping, inverse])
    whole, fraction = divmod(loop.delay, 1.0)
    pieces = [expm(rates * share * loop.period) for share in (fraction, 1.0 - fraction)]
    history = [np.zeros(n)] * (int(whole) + 2)
    q, v, reported = np.array([0.01, -0.02, 0.015]), np.array([0.1, 0.05, -0.2]), np.zeros(n)
    zero = Setpoint(np.zeros((1, n)), np.zeros((1, n)), np.zeros((1, n)))
    # The sensor is the plant's own; before t = 0 it takes the joints to have moved at v(0).
    made = {"measured": "exact", "difference": "difference" if loop.velocity_filter_hz is None else "filter"}
    corner = {} if loop.velocity_filter_hz is None else {"filter_hz": loop.velocity_filter_hz}
    sensor = Sensor(velocity=made[loop.velocity], delay=loop.reading_delay, **corner)
    sensing = Sensing(sensor, np.ones(()), q[None], v[None], loop.period, 0, [0])
    state = None
    seen = []
    for _ in range(ticks):
        seen.append(np.concatenate([q, v]))
        sample = sensing.read(q[None], v[None], reported[None])
        state = law.init(sample) if state is None else state
        torque, state = law.step(state, sample, zero)
        history = [torque[0], *history[:-1]]
        recent, older = history[int(whole)], history[int(whole) + 1]
        for piece, acting in zip(pieces, (older, recent), strict=True):
            x = piece @ np.concatenate([q, v, acting - load])
            q, v = x[:n], x[n : 2 * n]
        reported = fraction * older + (1.0 - fraction) * recent
    states = np.array(seen)
    return states[:, :n], states[:, n:]


@pytest.mark.parametrize("timing", TIMINGS, ids=str)
@pytest.mark.parametrize("surroundings", ["free", "viscous", "gravity"])
def test_map_is_the_controller_on_a_constant_inertia_tick_by_tick(timing: dict, surroundings: str) -> None:
    loop = SampledLoop(MBAR, KS, 25.0, 0.002, **timing)
    viscous = np.array([0.3, 1.0, 0.2]) if surroundings != "free" else None
    stiffness = np.array([[9.0, 2, 0], [2, -4, 1], [0, 1, 3.0]]) if surroundings == "gravity" else None
    load = np.array([0.4, -0.3, 0.1])
    q, v = drive_the_real_controller(loop, 60, viscous=viscous, stiffness=stiffness, load=load)
    system = closed_loop(MASS, loop, viscous=viscous, stiffness=stiffness)
    z = np.zeros(system.matrix.shape[-1])
    # At t = 0 the controller takes the past as unaccelerated motion at v(0) and the drive holds no torque.
    for name, where in system.blocks.items():
        base, _, age = name.partition("-")
        if base in ("v", "rate", "slope"):
            z[where] = v[0]
        elif base == "angle" or base == "q":
            z[where] = q[0] - (loop.reading_delay if base == "angle" else float(age or 0)) * loop.period * v[0]
    for k in range(60):
        np.testing.assert_allclose(z[system.blocks["q"]], q[k], rtol=1e-9, atol=1e-13)
        np.testing.assert_allclose(z[system.blocks["v"]], v[k], rtol=1e-9, atol=1e-11)
        z = system.matrix @ z + system.load @ load


@pytest.mark.parametrize(("a", "gain", "radius"), [(0.0114, 20, 0.9994), (0.0114, 30, 1.0014), (0.0114, 50, 1.0049)])
def test_lemma_1_holds_and_yet_the_sampled_loop_is_unstable(a: float, gain: float, radius: float) -> None:
    assert abs(1.0 - a) < 1.0  # Lemma 1 for this mode
    loop = SampledLoop(1.0, gain, gain, 0.001)
    assert modal_radius(np.array([a]), loop)[0] == pytest.approx(radius, abs=5e-5)


def test_large_mbar_is_unstable_from_53() -> None:
    def radius(gain: float) -> float:
        return float(modal_radius(np.array([1.9]), SampledLoop(1.0, gain, gain, 0.001))[0])

    assert radius(52.6) < 1.0 < radius(52.7)


UNPAIRED = {"acceleration": "position", "pairing": "last"}
DIFFERENCED = {"velocity": "difference"}


@pytest.mark.parametrize(
    ("timing", "large", "small"),
    [
        ({}, 0.9888, 0.9994),
        (UNPAIRED, 1.0071, 0.9994),
        ({"acceleration": "position"}, 0.9803, 1.0009),
        (DIFFERENCED | {"pairing": "last"}, 1.0075, 0.9995),
        (DIFFERENCED, 0.9824, 1.0009),
        (DIFFERENCED | UNPAIRED, 1.0075, 0.9995),
    ],
    ids=str,
)
def test_the_mean_of_two_torques_is_the_price_of_differences_at_small_a_and_their_cure_at_large_a(
    timing: dict, large: float, small: float
) -> None:
    loop = SampledLoop(1.0, 20.0, 20.0, 0.001, **timing)
    radius = modal_radius(np.array([1.95, 0.0114]), loop)
    np.testing.assert_allclose(radius, [large, small], atol=6e-5)


@settings(max_examples=120, deadline=None)
@given(a=st.floats(0.003, 2.2), beta=st.floats(0.5, 400.0), ks=st.floats(0.5, 400.0), period=st.floats(0.0005, 0.004))
def test_closed_form_of_the_plain_loop(a: float, beta: float, ks: float, period: float) -> None:
    # docs/stability.md, from the Jury criterion on the loop's cubic.
    fast = (beta + ks) * period - (4.0 / a - 2.0)
    slow = beta * ks * period * (1.0 / a - 0.5) - (beta + ks)
    radius = float(modal_radius(np.array([a]), SampledLoop(1.0, ks, beta, period))[0])
    if min(abs(fast), abs(slow) / (beta + ks)) > 1e-6 and abs(a - 2.0) > 1e-6:
        assert (radius < 1.0) == (a < 2.0 and fast < 0.0 and slow < 0.0)


def test_the_map_knows_the_estimates_that_the_laws_have() -> None:
    assert get_args(Acceleration) == parameters_of(TdeLaw)["acceleration"].options
    assert get_args(Pairing) == parameters_of(TdeLaw)["pairing"].options
    with pytest.raises(ParameterError, match="expected 'velocity' or 'position'"):
        SampledLoop(MBAR, 18.0, 25.0, 0.002, acceleration="sometimes")  # type: ignore[arg-type]


@pytest.mark.parametrize("timing", TIMINGS, ids=str)
def test_one_mode_at_a_time_gives_the_radius_of_the_full_map(timing: dict) -> None:
    loop = SampledLoop(MBAR, 18.0, 25.0, 0.002, **timing)
    assert loop.modal
    assert spectral_radius(MASS, loop) == pytest.approx(float(closed_loop(MASS, loop).spectral_radius()), abs=2e-9)


@pytest.mark.parametrize("acceleration", get_args(Acceleration))
@pytest.mark.parametrize(("delay", "age"), [(1.0, 0.0), (3.0, 0.0), (1.0, 2.0)])
def test_an_alternating_torque_goes_on_for_ever_where_the_last_one_is_an_odd_number_of_periods_late(
    acceleration: str, delay: float, age: float
) -> None:
    timing = {"velocity": "difference", "acceleration": acceleration, "reading_delay": age, "filter_hz": 35.0}
    spring = np.array([[-9.0, 2.0, 0.0], [2.0, -4.0, 1.0], [0.0, 1.0, 3.0]])
    loop = SampledLoop(MBAR, KS, 25.0, 0.002, delay=delay, pairing="last", **timing)
    assert loop.undamped_delay == 0.0
    matrix = closed_loop(MASS, loop, stiffness=spring).matrix
    assert np.sum(np.abs(np.linalg.eigvals(matrix) + 1.0) < 1e-9) == 3
    assert spectral_radius(MASS, loop, stiffness=spring) >= 1.0
    # It is a single value of the delay, and the mean of two torques has none of it.
    for other, after in (({"delay": delay + 0.6}, 1.4), ({"pairing": "mean"}, math.inf)):
        changed = SampledLoop(MBAR, KS, 25.0, 0.002, **{"delay": delay, "pairing": "last", **timing, **other})
        assert changed.undamped_delay == pytest.approx(after)
        matrix = closed_loop(MASS, changed, stiffness=spring).matrix
        assert np.abs(np.linalg.eigvals(matrix) + 1.0).min() > 1e-3


@pytest.mark.parametrize("timing", TIMINGS, ids=str)
def test_plant_s_substeps_converge_to_held_torque(timing: dict) -> None:
    loop = SampledLoop(MBAR, KS, 25.0, 0.002, **timing)
    viscous, stiffness = np.array([0.3, 1.0, 0.2]), np.diag([9.0, -4.0, 3.0])

    def errors(**surroundings: Array) -> list[float]:
        exact = closed_loop(MASS, loop, **surroundings).matrix
        return [
            float(np.abs(closed_loop(MASS, loop, substeps=s, **surroundings).matrix - exact).max()) for s in (80, 160)
        ]

    first, second = errors(viscous=viscous, stiffness=stiffness), errors(stiffness=stiffness)
    assert first[0] / first[1] == pytest.approx(2.0, rel=0.05)  # friction is taken at the end of a step
    assert second[0] / second[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("substeps", [1, 2, 5])
@pytest.mark.parametrize("acceleration", ["velocity", "position"])
def test_plant_s_substeps_are_exact_without_friction_and_stiffness(substeps: int, acceleration: str) -> None:
    loop = SampledLoop(MBAR, KS, 25.0, 0.002, acceleration=acceleration, filter_hz=35.0, delay=1.0)
    np.testing.assert_allclose(
        closed_loop(MASS, loop, substeps=substeps).matrix, closed_loop(MASS, loop).matrix, rtol=1e-12, atol=1e-9
    )


def test_ratios_are_the_eigenvalues_of_the_paper_s_matrix() -> None:
    expected = np.sort(np.linalg.eigvals(np.linalg.solve(MASS, np.diag(MBAR))).real)
    np.testing.assert_allclose(inertia_ratios(MASS, MBAR), expected, rtol=1e-12)


def test_delay_is_continuous_across_whole_periods() -> None:
    def radius(delay: float) -> float:
        return float(spectral_radius(MASS, SampledLoop(MBAR, KS, 25.0, 0.002, delay=delay)))

    for whole in (1, 2):
        assert radius(whole - 1e-7) == pytest.approx(radius(whole), abs=1e-5)
        assert radius(whole + 1e-7) == pytest.approx(radius(whole), abs=1e-5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ks": [1.0, 2.0]}, "ks: got .* expected a number or 3 of them"),
        ({"ks": -1.0}, "ks: .*positive"),
        ({"beta": math.nan}, "beta: .*finite"),
        ({"mbar": [0.1, 0.0, 0.1]}, "mbar: .*positive"),
        ({"period": 0.0}, "period: .*positive time in s"),
        ({"period": math.inf}, "period: "),
        ({"acceleration": "speed"}, "acceleration: got 'speed'; expected 'velocity' or 'position'"),
        ({"filter_hz": -3.0}, "filter_hz: "),
        ({"delay": -0.5}, "delay: .*0 or more"),
        ({"delay": math.nan}, "delay: "),
    ],
)  # fmt: skip
def test_bad_gains_are_refused_with_advice(change: dict, message: str) -> None:
    good = {"mbar": MBAR, "ks": KS, "beta": 25.0, "period": 0.002}
    with pytest.raises(ParameterError, match=message):
        SampledLoop(**(good | change))


def test_an_indefinite_inertia_is_refused() -> None:
    bad = np.stack([MASS, MASS - 0.2 * np.eye(3)])
    with pytest.raises(NotPositiveDefinite) as caught:
        spectral_radius(bad, SampledLoop(MBAR, KS, 25.0, 0.002))
    assert caught.value.index == (1,)
    assert caught.value.smallest_eigenvalue < 0.0
