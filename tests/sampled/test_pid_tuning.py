"""TDC on backward differences is a PID in velocity form, and its margins are those of that map."""

from __future__ import annotations

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.controllers import CONTROLLERS, Sample, Setpoint
from asmc_pin.sampled import SampledLoop, modal_radius
from asmc_pin.sampled.gain_choice.pid_tuning import pid_of

PERIOD, TICKS = 0.002, 200
MBAR, KS, BETA = np.array([0.3, 0.04]), 7.0, 45.0


def backward(values: Array) -> tuple[Array, Array]:
    """First and second backward differences over the period; the first tick's are 0, as of a standstill before."""
    first = np.diff(values, axis=0, prepend=values[:1]) / PERIOD
    return first, np.diff(first, axis=0, prepend=first[:1]) / PERIOD


@pytest.mark.parametrize("acceleration", ["position", "velocity"])
def test_the_law_on_backward_differences_is_the_velocity_form_pid_to_rounding(acceleration: str) -> None:
    rng = np.random.default_rng(3)
    # Readings jump and so does the reference: nothing is left to smoothness.
    q, wanted = (np.cumsum(rng.normal(scale=1e-3, size=(TICKS, 2)), axis=0) for _ in range(2))
    q[:2], wanted[:2] = q[0], wanted[0]  # at rest before the second tick
    reported = rng.normal(scale=2.0, size=(TICKS, 2))  # the drive's limits are no business of the law
    (v, _), (v_wanted, a_wanted) = backward(q), backward(wanted)
    law = CONTROLLERS["ppc"](
        mbar=MBAR, ks=KS, beta=BETA, period=PERIOD, acceleration=acceleration, pairing="last"
    ).for_joints(2)
    pid = pid_of(SampledLoop(MBAR, KS, BETA, PERIOD, velocity="difference", pairing="last"))
    e = wanted - q
    state = law.init(Sample(q[:1], v[:1], reported[:1]))
    for tick in range(TICKS):
        now = slice(tick, tick + 1)
        torque, state = law.step(
            state, Sample(q[now], v[now], reported[now]), Setpoint(wanted[now], v_wanted[now], a_wanted[now])
        )
        if tick < 2:
            continue
        step, bend = e[tick] - e[tick - 1], e[tick] - 2.0 * e[tick - 1] + e[tick - 2]
        expected = reported[tick] + pid.k * (step + PERIOD / pid.ti * e[tick] + pid.td / PERIOD * bend)
        np.testing.assert_allclose(torque[0], expected, rtol=1e-12, atol=1e-11)


def test_the_pid_is_unstable_where_the_same_gains_with_a_measured_velocity_are_stable() -> None:
    gains = {"ks": 20.0, "beta": 20.0, "period": 0.001}
    measured = SampledLoop(np.ones(1), **gains)
    pid = SampledLoop(np.ones(1), **gains, velocity="difference", pairing="last")
    assert modal_radius(np.array([1.95]), measured)[0] < 1.0 < modal_radius(np.array([1.95]), pid)[0]
    assert "not these" in pid_of(measured).line(measured)
    assert "it is the loop of these margins" in pid_of(pid).line(pid)
