"""The control laws, tick by tick, against numbers worked out by hand; and what holds for every registered law.

The numbers are sums of powers of two, so that the expected ones are exact and no tolerance is needed, except where
a filter or an ε that is no such number says otherwise.
"""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from law_settings import required_of

from asmc_pin.controllers import (
    CONTROLLERS,
    Baek2016,
    Bsmc,
    ParameterInfo,
    Pid,
    Plestan2010,
    Ppc,
    Sample,
    Setpoint,
    TdeLaw,
    TdeState,
    controllers_table,
    describe_laws,
    signed,
    sliding_variable,
)
from asmc_pin.controllers.one_trial.state_rows import as_rows, named_rows
from asmc_pin.controllers.one_trial.trial_step import WORK_ROWS, Tick
from asmc_pin.errors import ParameterError

SHARED = {"mbar": [0.5, 2.0], "ks": [2.0, 4.0], "beta": 3.0, "period": 0.5}


def rows(*values: float) -> np.ndarray:
    return np.array([values], dtype=float)


def sample(q: tuple[float, float], v: tuple[float, float], torque: tuple[float, float]) -> Sample:
    return Sample(rows(*q), rows(*v), rows(*torque))


def setpoint(q: tuple[float, float], v: tuple[float, float], a: tuple[float, float]) -> Setpoint:
    return Setpoint(rows(*q), rows(*v), rows(*a))


# Three ticks by hand. The second joint's drive gives 20 of the 25 N·m asked for, so τ(t−L) is 20 there.
#   tick 0: e = (1, 0.5), ė = (−1, 1), s = ė + K_s e = (1, 3), wanted q̈_d + K_s ė + β s = (2−2+3, 0+4+9) = (3, 13)
#   tick 1: e = (0.5, 0.25), ė = (−1.5, 0.5), s = (−0.5, 1.5), wanted (−3−1.5, 2+4.5) = (−4.5, 6.5)
#   tick 2: e = ė = s = 0, wanted (0, 1)
SAMPLES = (
    sample((0.0, 0.0), (1.0, 0.0), (1.0, -1.0)),
    sample((0.5, 0.25), (1.5, -0.5), (2.5, 20.0)),
    sample((1.0, 0.5), (1.0, 0.0), (-0.25, 20.0)),
)
SETPOINTS = (
    setpoint((1.0, 0.5), (0.0, 1.0), (2.0, 0.0)),
    setpoint((1.0, 0.5), (0.0, 0.0), (0.0, 0.0)),
    setpoint((1.0, 0.5), (1.0, 0.0), (0.0, 1.0)),
)


def torques(law: object) -> list[list[float]]:
    state = law.init(SAMPLES[0])
    out = []
    for x, wanted in zip(SAMPLES, SETPOINTS, strict=True):
        torque, state = law.step(state, x, wanted)
        out.append(torque[0].tolist())
    return out


def estimated(law: TdeLaw, state: TdeState, x: Sample) -> TdeState:
    """What the estimation remembers after a tick."""
    return law.pole_placement(state, x, Setpoint(x.q, x.v, x.v))[2]


def test_sliding_variable_is_rate_error_plus_ks_error() -> None:
    assert sliding_variable(np.array([2.0, 4.0]), SAMPLES[0], SETPOINTS[0]).tolist() == [[1.0, 3.0]]
    assert sliding_variable(2.0, SAMPLES[1], SETPOINTS[1]).tolist() == [[-0.5, 1.0]]


def test_sgn_of_zero_is_plus_one_whatever_its_sign() -> None:
    s = rows(-2.0, -5e-324, -0.0, 0.0, 5e-324, 3.0)
    assert signed(np.array(4.0), s).tolist() == [[-4.0, -4.0, 4.0, 4.0, 4.0, 4.0]]


def test_ppc_with_velocity_difference() -> None:
    # q̈(t−L): (0, 0); ((1.5−1)/0.5, (−0.5−0)/0.5) = (1, −1); ((1−1.5)/0.5, (0+0.5)/0.5) = (−1, 1)
    # τ = τ(t−L) + M̄ (wanted − q̈(t−L)):
    #   (1 + 0.5·3, −1 + 2·13);  (2.5 + 0.5·(−4.5−1), 20 + 2·(6.5+1));  (−0.25 + 0.5·(0+1), 20 + 2·(1−1))
    assert torques(Ppc(**SHARED)) == [[2.5, 25.0], [-0.25, 35.0], [0.25, 20.0]]


def test_ppc_with_second_position_difference() -> None:
    # q̈(t−L): (0, 0); second tick with q₋₁ = q₀ − L v₀ = (−0.5, 0): (0.5 − 0 − 0.5, 0.25)/0.25 = (0, 1);
    #          third: (q₂ − 2q₁ + q₀)/L² = (1 − 1 + 0, 0.5 − 0.5 + 0)/0.25 = (0, 0)
    # τ: as above, then (2.5 + 0.5·(−4.5−0), 20 + 2·(6.5−1)), then (−0.25 + 0.5·0, 20 + 2·1)
    law = Ppc(**SHARED, acceleration="position", pairing="last")
    assert torques(law) == [[2.5, 25.0], [0.25, 31.0], [-0.25, 22.0]]


def test_second_position_difference_goes_with_the_mean_of_the_last_two_torques() -> None:
    # Reported: (1, −1), (2.5, 20), (−0.25, 20), and before t = 0 what is held there, so the means are
    # (1, −1), (1.75, 9.5), (1.125, 20) in the place of these; the rest of τ as with the last torque.
    expected = [[2.5, 25.0], [-0.5, 20.5], [1.125, 22.0]]
    assert torques(Ppc(**SHARED, acceleration="position")) == expected
    assert torques(Ppc(**SHARED, acceleration="position", pairing="mean")) == expected


def test_measured_velocities_go_with_the_last_torque_and_the_mean_is_a_choice() -> None:
    assert torques(Ppc(**SHARED)) == torques(Ppc(**SHARED, pairing="last"))
    assert torques(Ppc(**SHARED, pairing="mean")) == [[2.5, 25.0], [-1.0, 24.5], [1.625, 20.0]]


def test_second_position_difference_is_exact_on_a_parabola_and_ignores_the_measured_velocity() -> None:
    law = Ppc(mbar=1.0, ks=1.0, beta=1.0, period=0.25, acceleration="position")
    state = law.start(Sample(rows(0.0), rows(0.0), rows(0.0)))
    estimates = []
    for k in range(6):
        q = 3.0 * (0.25 * k) ** 2  # q̈ = 6 rad/s²
        state = estimated(law, state, Sample(rows(q), rows(99.0 if k else 0.0), rows(0.0)))
        estimates.append(state.acceleration.item())
    # 0 at the first tick; half at the second, for the tick before t = 0 counts as unaccelerated; exact from then on.
    assert estimates == [0.0, 3.0, 6.0, 6.0, 6.0, 6.0]


def test_low_pass_on_the_acceleration_is_a_held_input_lag() -> None:
    # Corner so that exp(−2π f L) = 1/2: every tick closes half the gap. Raw estimates of joint 1: 0, 1, −1.
    law = Ppc(**SHARED, filter_hz=math.log(2.0) / (2.0 * math.pi * 0.5))
    assert law.filter_weight == pytest.approx(0.5, rel=1e-15)
    state = law.init(SAMPLES[0])
    filtered = []
    for x in SAMPLES:
        state = estimated(law, state, x)
        filtered.append(state.acceleration[0, 0])
    assert filtered == pytest.approx([0.0, 0.5, 0.5 + 0.5 * (-1.0 - 0.5)], rel=1e-14)
    # The torque of tick 1 uses the filtered value: 2.5 + 0.5 (−4.5 − 0.5).
    assert torques(law)[1][0] == pytest.approx(0.0, abs=1e-14)


def test_without_a_filter_the_estimate_forgets_a_spike_of_the_velocity_at_once() -> None:
    law = Ppc(mbar=1.0, ks=1.0, beta=1.0, period=0.5)
    still = setpoint((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    state = law.init(sample((0.0, 0.0), (0.0, 0.0), (0.0, 0.0)))
    for speed in (0.0, 1e18, 0.25, 0.75):
        torque, state = law.step(state, sample((0.0, 0.0), (speed, speed), (0.0, 0.0)), still)
    # ė = s = −0.75, wanted −1.5, and q̈ = (0.75 − 0.25)/0.5 = 1 to the last bit.
    assert torque.tolist() == [[-2.5, -2.5]]


def test_a_filter_far_above_the_control_rate_changes_nothing() -> None:
    assert torques(Ppc(**SHARED, filter_hz=1e3)) == torques(Ppc(**SHARED))


def test_bsmc_saturates_outside_its_boundary_layer() -> None:
    # s = (1, 3), (−0.5, 1.5), (0, 0); Φ = (2, 1): sat = (0.5, 1), (−0.25, 1), (0, 0)
    # PPC plus M̄ K sat with K = (4, 8): (0.5·4·0.5, 2·8·1) = (1, 16); (−0.5, 16); (0, 0)
    law = Bsmc(**SHARED, gain=[4.0, 8.0], boundary=[2.0, 1.0])
    assert torques(law) == [[3.5, 41.0], [-0.75, 51.0], [0.25, 20.0]]
    assert law.saturation(rows(-5.0, -1.0)).tolist() == [[-1.0, -1.0]]
    assert law.saturation(rows(2.0, 0.5)).tolist() == [[1.0, 0.5]]


def follow(law: object, s: list[tuple[float, ...]]) -> tuple[list[list[float]], list[list[float]]]:
    """Drive a law through the given s: the arm rests at 0 with τ(t−L) = 0, and q̈_d cancels PPC, so τ = M̄ k̂ sgn(s)."""
    nv = len(s[0])
    x = Sample(np.zeros((1, nv)), np.zeros((1, nv)), np.zeros((1, nv)))
    state = law.init(x)
    gains, out = [], []
    for value in s:
        rate = np.array([value])
        torque, state = law.step(state, x, Setpoint(np.zeros((1, nv)), rate, -(law.ks + law.beta) * rate))
        gains.append(state.gain[0].tolist())
        out.append(torque[0].tolist())
    return gains, out


def test_a_pid_meets_a_joint_that_moves_on_unaccelerated_at_the_first_tick_as_at_any_other() -> None:
    # ė = (1, −2) stands: every tick adds k_p L ė = (8·0.5·1, 4·0.5·(−2)) and, as ė does not change, nothing by k_d.
    law, rate = Pid(kp=[8.0, 4.0], ki=0.0, kd=2.0, period=0.5), np.array([1.0, -2.0])
    still = setpoint((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    state, told = None, []
    for k in range(3):
        seen = Sample(-(3.0 + 0.5 * k * rate)[None], -rate[None], rows(16.0, 32.0))
        torque, state = law.step(law.init(seen) if state is None else state, seen, still)
        told.append(torque[0].tolist())
    assert told == [[16.0 + 4.0, 32.0 - 4.0]] * 3


def test_plestan_ticks() -> None:
    law = Plestan2010(**SHARED, rate=2.0, epsilon=5.0, floor=0.25)  # L·rate = 1, L·floor = 0.125
    gains, out = follow(
        law,
        [
            (3.0, 4.0),  # k̂₀ = μ: up by L μ although ‖s‖ = 5             0.25 + 0.125 = 0.375
            (3.0, -4.0),  # ‖s‖₂ = 5 = ε counts as outside: up by 5       5.375
            (0.0, 1.0),  # ‖s‖ = 1, inside: down by 1                     4.375
            (-0.0, 4.0),  # down by 4                                     0.375
            (3.0, 0.0),  # 0.375 − 3 is below the floor                   0.25
            (0.0, 0.0),  # at the floor: up by L μ                        0.375
            (0.0, 0.0),  # above it: down by ‖s‖ = 0                      0.375
            (-6.0, -8.0),  # ‖s‖ = 10: up by 10                           10.375
        ],
    )
    expected = [0.375, 5.375, 4.375, 0.375, 0.25, 0.375, 0.375, 10.375]
    assert gains == [[k, k] for k in expected]
    # τ_k = M̄ k̂_k sgn(s_k) with the gain of the same tick, sgn(0) = sgn(−0) = +1
    signs = [(1, 1), (1, -1), (1, 1), (1, 1), (1, 1), (1, 1), (1, 1), (-1, -1)]
    assert out == [[0.5 * k * a, 2.0 * k * b] for k, (a, b) in zip(expected, signs, strict=True)]


def test_plestan_with_the_authors_epsilon_measures_s_by_what_its_own_gain_moves_in_a_period() -> None:
    law = Plestan2010(**SHARED, rate=2.0, epsilon="4KL", floor=0.25)  # ε = 4 k̂ L = 2 k̂
    gains, _ = follow(
        law,
        [
            (3.0, 4.0),  # at the floor: up by L μ                        0.375
            (0.75, 0.0),  # ‖s‖ = 0.75 = 2·0.375 counts as outside        1.125
            (2.0, 0.0),  # 2 < 2.25, inside: down by 2, to the floor      0.25
            (0.0, 9.0),  # at the floor: up by L μ                        0.375
            (3.0, 4.0),  # up by 5                                        5.375
            (3.0, 4.0),  # the same s, and inside: 5 < 10.75: down by 5   0.375
        ],
    )
    assert [k for k, _ in gains] == [0.375, 1.125, 0.25, 0.375, 5.375, 0.375]


def baek(**changes: object) -> Baek2016:
    # L φ/α = (0.5·4/2, 0.5·8/0.5) = (1, 8), the growth per |s|;  L φα = (4, 2), the drop times |s|
    return Baek2016(**(SHARED | {"phi": [4.0, 8.0], "alpha": [2.0, 0.5], "epsilon": 1.0} | changes))


def test_baek_ticks() -> None:
    gains, out = follow(
        baek(),
        [
            (0.5, -0.25),  # inside ε, but k̂ = 0 grows:    0 + 0.5,         0 + 8·0.25
            (1.0, 0.0),  # ‖s‖_∞ = ε counts as outside:    0.5 + 1,         2 + 0
            (-3.0, -0.5),  # one θ for both joints:        1.5 + 3,         2 + 4 although |s₂| < ε
            (0.5, -0.5),  # inside, θ = −1:                4.5 − 4/0.5 < 0, 6 − 2/0.5
            (0.5, -0.5),  # branch from k̂_{k−1}:           0 + 0.5,         2 − 4 < 0
            (0.0, -0.0),  # |s| = 0:                       0.5 − ∞,         0 + 8·0
            (0.25, 8.0),  # outside:                       0 + 0.25,        0 + 64
            (0.5, 0.5),  # inside:                         0.25 − 8 < 0,    64 − 4
            (0.0, 0.5),  # k̂₁ = 0 with s₁ = 0 stays:       0,               60 − 4
        ],
    )
    assert gains == [
        [0.5, 2.0],
        [1.5, 2.0],
        [4.5, 6.0],
        [0.0, 2.0],
        [0.5, 0.0],
        [0.0, 0.0],
        [0.25, 64.0],
        [0.0, 60.0],
        [0.0, 56.0],
    ]
    assert out == [
        [0.25, -4.0],
        [0.75, 4.0],
        [-2.25, -12.0],
        [0.0, -4.0],
        [0.25, 0.0],
        [0.0, 0.0],
        [0.125, 128.0],
        [0.0, 120.0],
        [0.0, 112.0],
    ]


def test_baek_adds_its_switching_term_to_ppc() -> None:
    # On the three ticks of PPC: s = (1, 3), (−0.5, 1.5), (0, 0) gives k̂ = (1, 24), (1.5, 36), then 1.5 → 0 and 36 → 0.
    # M̄ k̂ sgn(s) = (0.5, 48), (−0.75, 72), (0, 0)
    assert torques(baek()) == [[3.0, 73.0], [-1.0, 107.0], [0.25, 20.0]]


def test_baek_threshold_counts_small_gains_as_zero() -> None:
    law = baek(threshold=1e-4)
    inside = rows(0.5, 0.5)
    # At the threshold: growth by L φ|s|/α = (0.5, 4). Just above it: shrinks, here to 0.
    assert law.adapt(rows(1e-4, 1e-4), inside).tolist() == [[1e-4 + 0.5, 1e-4 + 4.0]]
    assert law.adapt(rows(1.0001e-4, 1.0001e-4), inside).tolist() == [[0.0, 0.0]]
    # Without a threshold 1e-4 is a gain like any other.
    assert baek().adapt(rows(1e-4, 1e-4), inside).tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize("s", [0.0, -0.0, 5e-324, -1e-310, 1e-300, 1e-12])
def test_baek_gain_falls_to_zero_without_overflow_as_s_vanishes(s: float) -> None:
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        assert baek().adapt(rows(600.0, 1e300), rows(s, s)).tolist()[0] == [0.0, 0.0 if abs(s) < 1e-299 else 1e300]


@given(
    gain=st.floats(0.0, 1e4),
    s=st.floats(-1e3, 1e3),
    threshold=st.sampled_from([0.0, 1e-4, 1.0]),
)
def test_baek_gain_is_the_explicit_euler_step_of_its_law(gain: float, s: float, threshold: float) -> None:
    law = Baek2016(mbar=1.0, ks=1.0, beta=1.0, period=1e-3, phi=40.0, alpha=0.3, epsilon=0.5, threshold=threshold)
    theta = 1 if abs(s) >= 0.5 or gain <= threshold else -1
    if theta == 1:
        expected = gain + 1e-3 * 40.0 * abs(s) / 0.3
    else:
        expected = max(0.0, gain - 1e-3 * 40.0 * 0.3 / abs(s)) if s else 0.0
    assert law.adapt(rows(gain), rows(s)).item() == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert law.adapt(rows(gain), rows(s)).item() >= 0.0


# What holds for every registered law ---------------------------------------------------------------------------------


def built(name: str, nv: int, **changes: object) -> object:
    """A registered law; what it requires of its own is 0.4, so that a new law is under test once it is registered."""
    return CONTROLLERS[name](
        **(
            required_of(name, 0.4)
            | {"mbar": np.linspace(0.1, 0.3, nv), "ks": 3.0, "beta": 2.0, "period": 0.01}
            | changes
        )
    )


@pytest.mark.parametrize("pairing", ["last", "mean"])
@pytest.mark.parametrize("acceleration", ["velocity", "position"])
def test_matched_is_the_pairing_whose_load_estimate_is_exact_under_a_torque_that_changes(
    acceleration: str, pairing: str
) -> None:
    """A mass of 2 kg under a torque that changes from period to period: Γ̂ is (1/m − 1/m̄) times the torque that goes
    with the estimate, exactly, where the pair fits, and not where it does not."""
    law = Ppc(mbar=0.5, ks=1.0, beta=1.0, period=0.25, acceleration=acceleration, pairing=pairing)
    fits = (
        law.averages_torque == Ppc(mbar=0.5, ks=1.0, beta=1.0, period=0.25, acceleration=acceleration).averages_torque
    )
    q, v, state = 0.0, 0.0, law.start(Sample(rows(0.0), rows(0.0), rows(0.0)))
    past, misses = [0.0, 0.0], []
    for torque in (0.0, 3.0, -1.0, 4.0, 1.0, -5.0):
        q, v = q + 0.25 * v + 0.5 * 0.25**2 * torque / 2.0, v + 0.25 * torque / 2.0
        past = [past[1], torque]
        state = estimated(law, state, Sample(rows(q), rows(v), rows(torque)))
        paired = 0.5 * sum(past) if law.averages_torque else torque
        if state.ticks > 2:
            misses.append(abs(2.0 * state.acceleration.item() - paired))
    assert (max(misses) < 1e-12) == fits


def random_ticks(batch: int, nv: int, ticks: int, seed: int = 0) -> list[tuple[Sample, Setpoint]]:
    rng = np.random.default_rng(seed)
    shape = (ticks, 6, batch, nv)
    return [(Sample(*x[:3]), Setpoint(*x[3:])) for x in 0.3 * rng.standard_normal(shape)]


def leaves(state: object) -> Iterator[np.ndarray]:
    for part in state:
        yield from leaves(part) if isinstance(part, tuple) else [np.asarray(part)]


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize(
    ("acceleration", "pairing"), [("velocity", "last"), ("velocity", "mean"), ("position", "mean")]
)
def test_steps_are_pure(name: str, acceleration: str, pairing: str) -> None:
    law = built(name, 3, acceleration=acceleration, pairing=pairing, filter_hz=20.0)
    ticks = random_ticks(4, 3, 6)
    state = law.init(ticks[0][0])
    for x, wanted in ticks:
        before = copy.deepcopy((state, x, wanted))
        torque, following = law.step(state, x, wanted)
        again, following_again = law.step(state, x, wanted)
        np.testing.assert_array_equal(torque, again)
        for one, other in zip(leaves(following), leaves(following_again), strict=True):
            np.testing.assert_array_equal(one, other)
        for one, other in zip(leaves(before[0]), leaves(state), strict=True):
            np.testing.assert_array_equal(one, other)
        for field in ("q", "v"):
            np.testing.assert_array_equal(getattr(before[1], field), getattr(x, field))
            np.testing.assert_array_equal(getattr(before[2], field), getattr(wanted, field))
        # The state keeps no view of the sample: a caller may write the next one into the same arrays.
        assert not any(np.shares_memory(a, b) for a in leaves(following) for b in (x.q, x.v, x.torque))
        state = following


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_compiled_step_is_the_step_that_is_written_and_writes_no_parameter(name: str) -> None:
    law = built(name, 3, acceleration="position", filter_hz=20.0)
    if law.trial_step is None:  # a law that has its step in numpy
        return
    rows = law.law_rows(3)
    before = rows.copy()
    ticks = random_ticks(1, 3, 20)
    state = law.init(ticks[0][0])
    _, memory = as_rows(state, (1, 3))
    work, command = np.full((WORK_ROWS, 3), np.nan), np.full(3, np.nan)
    for k, (x, wanted) in enumerate(ticks):
        torque, state = law.step(state, x, wanted)
        tick = Tick(k, x.q[0], x.v[0], x.torque[0], wanted.q[0], wanted.v[0], wanted.a[0])
        law.trial_step.function(tick, rows[0], memory[0], work, command)
        np.testing.assert_allclose(torque[0], command, rtol=1e-12)
        np.testing.assert_allclose(as_rows(state, (1, 3))[1], memory, rtol=1e-12, atol=1e-15)
        work[:], command[:] = np.nan, np.nan  # nothing of them is known at the next tick
    np.testing.assert_array_equal(rows, before)


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize("nv", [1, 2, 7])
def test_a_trial_is_bitwise_the_same_alone_and_in_a_batch(name: str, nv: int) -> None:
    law = built(name, nv)
    ticks = random_ticks(5, nv, 20)
    state = law.init(ticks[0][0])
    alone = [
        law.init(Sample(*(f[i : i + 1] for f in (ticks[0][0].q, ticks[0][0].v, ticks[0][0].torque)))) for i in range(5)
    ]
    for x, wanted in ticks:
        torque, state = law.step(state, x, wanted)
        for i in range(5):
            one = slice(i, i + 1)
            single, alone[i] = law.step(
                alone[i],
                Sample(x.q[one], x.v[one], x.torque[one]),
                Setpoint(wanted.q[one], wanted.v[one], wanted.a[one]),
            )
            np.testing.assert_array_equal(torque[one], single)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_trial_of_nan_leaves_the_others_alone(name: str) -> None:
    law = built(name, 2)
    clean, broken = random_ticks(3, 2, 10), random_ticks(3, 2, 10)
    for x, _ in broken[4:]:
        for field in (x.q, x.v, x.torque):
            field[1] = np.nan
    states = [law.init(clean[0][0]), law.init(broken[0][0])]
    with np.errstate(all="raise"):
        for (x, wanted), (y, other) in zip(clean, broken, strict=True):
            good, states[0] = law.step(states[0], x, wanted)
            bad, states[1] = law.step(states[1], y, other)
            np.testing.assert_array_equal(good[[0, 2]], bad[[0, 2]])
    assert np.isnan(bad[1]).all()


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize("on_the_surface", [True, False])
def test_a_law_is_ppc_and_the_switching_term_that_it_states(name: str, on_the_surface: bool) -> None:
    law = built(name, 2)
    ticks = random_ticks(3, 2, 12)
    if on_the_surface:  # s = 0 throughout; sgn(0) = +1
        ticks = [(x, Setpoint(x.q, x.v, wanted.a)) for x, wanted in ticks]
    ppc = Ppc(mbar=law.mbar, ks=3.0, beta=2.0, period=0.01)
    state, other = law.init(ticks[0][0]), ppc.init(ticks[0][0])
    torques, bare, gains = [], [], []
    for x, wanted in ticks:
        torque, state = law.step(state, x, wanted)
        expected, other = ppc.step(other, x, wanted)
        torques.append(torque)
        bare.append(expected)
        gains.append(getattr(state, "gain", np.full_like(torque, np.nan)))
    s = np.stack([sliding_variable(law.ks, x, wanted) for x, wanted in ticks], axis=1)
    stated = law.switching_term(s, np.stack(gains, axis=1))
    if stated is None:  # a law that does not say what it adds to PPC
        return
    assert stated.shape == s.shape
    # A law may multiply its factors in another order.
    close = {"rtol": 0.0, "atol": 0.0} if on_the_surface else {"rtol": 1e-13, "atol": 1e-13}
    np.testing.assert_allclose(np.stack(torques, axis=1), np.stack(bare, axis=1) + law.mbar * stated, **close)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_the_slope_of_a_boundary_layer_is_that_of_the_switching_term_at_0(name: str) -> None:
    law, step = built(name, 2), 1e-6
    at = np.full((1, 1, 2), step)
    if law.boundary_slope is None:
        return
    rise = law.switching_term(at, np.full_like(at, np.nan)) - law.switching_term(-at, np.full_like(at, np.nan))
    np.testing.assert_allclose(rise[0, 0] / (2.0 * step), np.broadcast_to(law.boundary_slope, (2,)), rtol=1e-9)


def test_a_class_that_has_a_step_of_its_own_is_not_run_by_that_of_the_law_it_derives_from() -> None:
    class Bare(Baek2016):
        def step(self, state: object, x: Sample, wanted: Setpoint) -> tuple[np.ndarray, object]:
            return 0.0 * x.q, state

    class Same(Baek2016):
        pass

    own = {"phi": 1.0, "alpha": 1.0, "epsilon": 1.0}
    assert Bare(**SHARED, **own).trial_step is None
    assert Same(**SHARED, **own).trial_step is Baek2016.trial_step
    assert torques(Bare(**SHARED, **own)) == [[0.0, 0.0]] * 3


def test_a_law_without_a_step_says_so() -> None:
    with pytest.raises(NotImplementedError, match="neither a trial_step nor a step"):
        torques(TdeLaw(**SHARED))


def test_bsmc_has_a_boundary_layer_and_ppc_has_none() -> None:
    assert Bsmc(**SHARED, gain=[4.0, 8.0], boundary=[2.0, 1.0]).boundary_slope.tolist() == [2.0, 8.0]
    assert Ppc(**SHARED).boundary_slope is None


def test_what_a_law_says_of_its_term_is_not_taken_for_that_of_a_class_derived_from_it() -> None:
    class Mine(Baek2016):
        pass

    class Said(Baek2016):
        switching_term = Baek2016.switching_term

    own = {"phi": 1.0, "alpha": 1.0, "epsilon": 1.0}
    s = np.ones((1, 1, 2))
    assert Mine(**SHARED, **own).switching_term(s, s) is None
    assert Said(**SHARED, **own).switching_term(s, 2.0 * s).tolist() == [[[2.0, 2.0]]]
    assert [law.theorem1 for law in (Baek2016, Mine, Said)] == [True, False, False]


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_scalar_parameter_is_that_value_for_every_joint(name: str) -> None:
    scalar, vector = built(name, 3, mbar=0.2), built(name, 3, mbar=[0.2] * 3)
    assert (scalar.nv, vector.nv, scalar.for_joints(3).nv) == (None, 3, 3)
    ticks = random_ticks(2, 3, 4)
    states = [law.init(ticks[0][0]) for law in (scalar, vector, scalar.for_joints(3))]
    for x, wanted in ticks:
        results = [
            law.step(s, x, wanted) for law, s in zip((scalar, vector, scalar.for_joints(3)), states, strict=True)
        ]
        states = [state for _, state in results]
        np.testing.assert_array_equal(results[0][0], results[1][0])
        np.testing.assert_array_equal(results[0][0], results[2][0])


@pytest.mark.parametrize("name", CONTROLLERS)
def test_parameters_are_copied_read_only_and_survive_pickling(name: str) -> None:
    mbar = np.array([0.1, 0.2])
    law = built(name, 2, mbar=mbar)
    mbar[0] = 9.0
    for one in (law, pickle.loads(pickle.dumps(law)), copy.deepcopy(law)):
        assert one.mbar.tolist() == [0.1, 0.2]
        with pytest.raises(ValueError, match="read-only"):
            one.mbar[0] = 1.0
        with pytest.raises(AttributeError, match="cannot assign"):
            one.beta = 1.0


# Wrong parameters ----------------------------------------------------------------------------------------------------

WRONG = [
    ("ppc", "mbar", [0.1, -0.2], r"mbar: entry 2 is -0.2; each must be above 0 kg·m²"),
    ("ppc", "mbar", [0.1, 0.0], r"entry 2 is 0.0; each must be above 0"),
    ("ppc", "mbar", [[0.1, 0.2]], r"shape \(1, 2\); expected a number or a list of one per joint"),
    ("ppc", "mbar", [], r"got \[\]; expected a number or a list"),
    ("ppc", "mbar", "0.1", r"got '0.1'; expected a number"),
    ("ppc", "mbar", True, r"got True; expected a number"),
    ("ppc", "ks", [1.0, 2.0, 3.0], r"ks: has 3 values but mbar has 2; give both one value per joint, or a single"),
    ("ppc", "ks", [1.0, math.nan], r"entry 2 is nan"),
    ("ppc", "ks", math.inf, r"got inf; it must be above 0 1/s"),
    ("ppc", "beta", -1.0, r"beta: got -1.0; it must be above 0 1/s"),
    ("ppc", "beta", [1.0, 2.0], r"expected one number, above 0 1/s, for all joints"),
    ("ppc", "period", 0.0, r"period: got 0.0; it must be above 0 s"),
    ("ppc", "period", None, r"period: got None"),
    ("ppc", "acceleration", "velocty", r"one of 'velocity', 'position'; did you mean 'velocity'\?"),
    ("ppc", "acceleration", 3, r"got 3; expected one of"),
    ("ppc", "filter_hz", 0.0, r"filter_hz: got 0.0; it must be above 0 Hz"),
    ("bsmc", "gain", -1.0, r"gain: got -1.0; it must be at least 0 rad/s²"),
    ("bsmc", "boundary", 0.0, r"boundary: got 0.0; it must be above 0 rad/s"),
    ("bsmc", "boundary", [0.1] * 3, r"boundary: has 3 values but mbar has 2"),
    ("plestan2010", "rate", -1.0, r"rate: got -1.0"),
    ("plestan2010", "floor", 0.0, r"floor: got 0.0"),
    ("plestan2010", "epsilon", [1.0, 1.0], r"epsilon: got .* expected one number"),
    ("plestan2010", "epsilon", "4LK", r"epsilon: got '4LK'; expected one number, above 0 rad/s, or '4KL'"),
    ("plestan2010", "epsilon", 0.0, r"epsilon: got 0.0; it must be above 0 rad/s"),
    ("plestan2010", "share", 1.5, r"share: got 1.5; it must be .* at most 1"),
    ("baek2016", "share", 1.001, r"share: got 1.001; it must be .* at most 1"),
    ("implicit", "share", 1.5, r"share: got 1.5; it must be .* at most 1"),
    ("ppc", "pairing", "both", r"pairing: got 'both'; expected one of 'matched', 'last', 'mean'"),
    ("baek2016", "phi", [1.0, -1.0], r"phi: entry 2 is -1.0"),
    ("baek2016", "alpha", 0.0, r"alpha: got 0.0; it must be above 0 rad/s"),
    ("baek2016", "epsilon", math.nan, r"epsilon: got nan"),
    ("baek2016", "threshold", -1e-9, r"threshold: got -1e-09; it must be at least 0 rad/s²"),
]


@pytest.mark.parametrize(("name", "parameter", "value", "message"), WRONG)
def test_wrong_parameters_are_refused_by_name(name: str, parameter: str, value: object, message: str) -> None:
    with pytest.raises(ParameterError, match=message) as caught:
        built(name, 2, **{parameter: value})
    assert caught.value.parameter == parameter


def test_a_law_for_two_joints_refuses_an_arm_with_three() -> None:
    with pytest.raises(ParameterError, match="has 2 values but the arm has 3 joints; give 3 values or a single number"):
        Ppc(**SHARED).init(Sample(*np.zeros((3, 1, 3))))
    with pytest.raises(ParameterError, match="has 2 values but the arm has 3"):
        Ppc(**SHARED).for_joints(3)


def test_a_sample_without_a_batch_axis_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"shapes \(2,\), .* expected \(batch, nv\)"):
        Ppc(**SHARED).init(Sample(*np.zeros((3, 2))))


@pytest.mark.parametrize("odd", range(3))
def test_a_sample_of_which_one_field_is_of_another_shape_is_refused(odd: int) -> None:
    fields = [np.zeros((2, 2)) for _ in range(3)]
    fields[odd] = np.zeros((1, 2))
    with pytest.raises(ParameterError, match=r"expected \(batch, nv\) for all three"):
        Ppc(**SHARED).init(Sample(*fields))


class TwoLines(NamedTuple):
    """What a law of somebody's own remembers.

    Attributes:
        angle: The angle at the last tick, (batch, nv), as it was
            read, rad.
        rate: Its rate, rad/s.
    """

    angle: np.ndarray
    rate: np.ndarray


def test_what_is_remembered_is_told_in_the_whole_words_of_its_class() -> None:
    told = named_rows(TwoLines(rows(1.0), rows(2.0)))
    assert [(name, said, part.item()) for name, said, part in told] == [
        ("angle", "The angle at the last tick, as it was read, rad.", 1.0),
        ("rate", "Its rate, rad/s.", 2.0),
    ]


def test_the_table_lists_every_law_with_its_own_parameters() -> None:
    own = {law.name: [item.name for item in law.parameters] for law in describe_laws()}
    assert list(own) == list(CONTROLLERS)
    known = {
        "ppc": [],
        "bsmc": ["gain", "boundary"],
        "plestan2010": ["rate", "epsilon", "floor", "switching", "share"],
        "baek2016": ["phi", "alpha", "epsilon", "threshold", "switching", "share"],
    }
    assert {name: own[name] for name in known} == known
    assert all(all(row.values()) for row in controllers_table())


def test_a_parameter_shows_its_unit_where_it_has_one_and_its_default_where_it_need_not_be_given() -> None:
    shown = {key: str(ParameterInfo(key, "", unit, True, needed, 0.5)) for key, unit, needed in UNITS}
    assert shown == {"ks": "ks [1/s]", "share": "share = 0.5", "cutoff": "cutoff [Hz] = 0.5"}


UNITS = (("ks", "1/s", True), ("share", "", False), ("cutoff", "Hz", False))


def test_pole_placement_takes_whatever_arrays_there_are_and_gives_what_the_compiled_step_does() -> None:
    """Whole numbers, other layouts, set points for all trials at once; and a batch that does not fit is refused."""
    law = Ppc(**SHARED, acceleration="position", filter_hz=0.3)
    q, v, torque = np.random.default_rng(3).integers(-5, 5, (3, 4, 2))
    one, wanted = Setpoint(*np.ones((3, 2))), Setpoint(*np.broadcast_to(1.0, (3, 4, 2)))
    state = law.init(Sample(*(x.astype(float) for x in (q, v, torque))))
    for k in range(3):
        float_sample = Sample(*(k * x.astype(float) for x in (q, v, torque)))
        expected, after = law.step(state, float_sample, wanted)
        for told in (
            Sample(k * q, k * v, k * torque),
            Sample(*(np.asfortranarray(x) for x in (k * q, k * v, torque * k))),
        ):
            for reference in (one, wanted):
                found, s, following = law.pole_placement(state, told, reference)
                np.testing.assert_array_equal(found, expected)
                np.testing.assert_array_equal(s, sliding_variable(law.ks, float_sample, wanted))
                for mine, known in zip(following, after, strict=True):
                    np.testing.assert_array_equal(mine, known)
        state = after
    with pytest.raises(ValueError, match="shape"):
        law.pole_placement(state, float_sample, Setpoint(*np.ones((3, 3, 2))))
