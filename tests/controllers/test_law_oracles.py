"""Every oracle of docs/laws.md, through the plant; and that no law is without one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from law_oracles import ORACLES, Oracle, of_law, run

from asmc_pin.controllers import CONTROLLERS, Adrc, Pid, Sta

WITHOUT = {"bsmc"}  # tests/controllers/test_controllers_closed_loop.py has its oracle


@pytest.mark.parametrize("item", ORACLES, ids=lambda item: f"{item.law}: {item.property}")
def test_an_oracle_of_a_law_holds_through_the_plant(item: Oracle) -> None:
    assert abs(item.measure() - item.value) <= item.within


@pytest.mark.parametrize(
    ("name", "share"), [("implicit", 1.0), ("implicit", 0.4), ("plestan2010", 0.4), ("baek2016", 0.4)]
)
def test_where_the_mass_is_known_an_implicit_law_takes_the_share_of_s_that_it_states_in_one_tick(
    name: str, share: float
) -> None:
    """With M̄ = m and no load the estimate is exact, so that N = 0 and s_{k+1} = (1 − λ) b_k."""
    large = {"implicit": {"gain": 1e6}, "plestan2010": {"rate": 1.0, "epsilon": 1e3, "floor": 1e6}}
    own = large.get(name, {"phi": 1e12, "alpha": 1.0, "epsilon": 1e-9})
    choice = {} if name == "implicit" else {"switching": "implicit"}
    law: Any = CONTROLLERS[name](mbar=1.3, share=share, ks=12.0, beta=9.0, period=1e-3, **own, **choice)
    trace = run(law, 1.3, ticks=12, load=np.zeros((12, 1)), kicks=0.0, start=(0.02, 0.5))
    s, rate = trace.s[:, 0], trace.rate[:, 0]
    reach = 1e-3 * (1.0 + 0.5 * 12.0 * 1e-3)
    ahead = s + 1e-3 * 12.0 * rate - reach * (12.0 * rate + 9.0 * s)
    assert abs(s[0]) > 0.1
    np.testing.assert_allclose(s[1:5], (1.0 - share) * ahead[:4], rtol=0.0, atol=1e-9 * abs(s[0]))


def test_gains_of_super_twisting_grow_beyond_the_threshold_and_fall_within_it_at_one_rate_but_not_below_the_floor() -> (
    None
):
    law = Sta(mbar=0.6, k1=1.0, k2=2.0, rate=150.0, threshold=0.004, floor=0.5, ks=12.0, beta=9.0, period=1e-3)
    trace = run(law, 1.0, ticks=300)
    scale = np.array([1.0, *(state.scale[0, 0] for state in trace.states)])
    outside, change = np.abs(trace.s[:, 0]) >= 0.004, np.diff(scale)
    assert 30 < outside.sum() < 270
    np.testing.assert_allclose(change[outside], 0.15, rtol=1e-9)
    np.testing.assert_allclose(change[~outside], np.maximum(-0.15, 0.5 - scale[:-1][~outside]), rtol=1e-9, atol=1e-12)
    assert (scale[1:] == 0.5).any()


def test_gains_of_a_pid_are_those_of_the_mbar_ks_and_beta_that_stand_for_them() -> None:
    given = Pid(kp=[400.0, 300.0], ki=[900.0, 80.0], kd=[40.0, 25.0], period=2e-3)
    for found, gain in zip(
        Pid(mbar=given.mbar, ks=given.ks, beta=given.beta[0], period=2e-3).gains, given.gains, strict=True
    ):
        assert found[0] == pytest.approx(gain[0], rel=1e-12)


def test_gains_of_a_pid_go_into_another_loop_as_those_of_its_twin_do() -> None:
    twin = Pid(mbar=[0.6, 0.2], ks=12.0, beta=9.0, period=2e-3)
    given = Pid(**dict(zip(("kp", "ki", "kd"), twin.gains, strict=True)), period=2e-3)
    loop = (np.array([1.8, 0.1]), np.full(2, 6.0), np.full(2, 20.0), 2e-3)
    np.testing.assert_allclose(given.with_loop(*loop).gains, twin.with_loop(*loop).gains, rtol=1e-9)


@pytest.mark.parametrize("observer_hz", [15.0, np.inf])
def test_where_the_mass_is_known_and_free_adrc_accelerates_by_just_what_its_errors_ask_for(observer_hz: float) -> None:
    """q̈ = q̈_d + (K_s + β) ė + β K_s e in every period: its observer then errs in nothing, however slow it is."""
    law = Adrc(mbar=1.3, observer_hz=observer_hz, ks=12.0, beta=9.0, period=1e-3)
    trace = run(law, 1.3, ticks=12, load=np.zeros((12, 1)), start=(0.02, 0.5))
    assert np.abs(trace.rate).min() > 0.3
    np.testing.assert_allclose(trace.a, trace.wanted[:-1], rtol=0.0, atol=1e-7)


def test_every_law_has_an_oracle() -> None:
    assert {name for name in CONTROLLERS if not list(of_law(name))} == WITHOUT
