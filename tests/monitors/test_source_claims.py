"""What the sources of other laws claim, held against runs: kept widths, finite times, orders in L, bounded gains."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from law_settings import required_of
from plant_cases import Still, Waving, slider

from asmc_pin.controllers import CONTROLLERS, Barrier, Ntsm, Plestan2010, Ppc, Sta
from asmc_pin.controllers.law_card import suggested
from asmc_pin.controllers.promises import twisting_order
from asmc_pin.controllers.promises.bounded_gain import BoundedByEnergy
from asmc_pin.controllers.promises.kept_width import KeptWidth
from asmc_pin.controllers.promises.run_history import Findings
from asmc_pin.controllers.promises.terminal_time import TerminalTime
from asmc_pin.controllers.promises.twisting_order import bounds_of, reach_of
from asmc_pin.engine import Rollout, rollout
from asmc_pin.monitors import CAUSES, STATEMENTS, Claim, monitor
from asmc_pin.monitors.run_again import recorded, tried_again
from asmc_pin.monitors.source_claims import _causes, _kept
from asmc_pin.plant import Disturbance, Friction, Plant

SOURCES = [key for key, item in STATEMENTS.items() if item.sources]
GAINS: dict[str, Any] = {"mbar": 1.2, "ks": 8.0, "beta": 8.0}
SMOOTH = Friction(0.0)
LOAD = Disturbance(profile="sine", torque=10.0, frequency=3.0, start=0.0)


def ran(law: Any, folder: Path, q0: float = 0.0, seconds: float = 1.0, **plant: Any) -> tuple[Rollout, Plant]:
    """A mass of 2 kg that is to stand at 0 while it is pushed to and fro."""
    usual = {"friction": SMOOTH, "effort_limit": np.inf, "disturbances": (LOAD,)}
    world = Plant(slider(folder, 2.0), **{**usual, **plant})
    return rollout(world, law, Still(np.zeros(1)), seconds, q0=[q0]), world


def judged(law: Any, folder: Path, key: str, **options: Any) -> Claim:
    run, world = ran(law, folder, **options)
    assert run.status == ("ok",)
    return monitor(run, world, law).claim(key)


def barrier(period: float = 1e-3, **changes: Any) -> Barrier:
    return Barrier(**{**GAINS, "width": 0.05, "limit": 20.0, **changes}, period=period)


# |s| < ε --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(40))
def test_the_width_is_kept_exactly_where_no_push_of_that_size_takes_s_out(seed: int) -> None:
    """Against every |d| ≤ D: found by trying all s of a fine grid with d = ±D, the ends of what is linear in d."""
    rng = np.random.default_rng(seed)
    width, limit, period = 0.05, float(10 ** rng.uniform(0.0, 2.0)), float(10 ** rng.uniform(-4.0, -2.0))
    push = float(rng.uniform(0.0, 1.3) * min(limit, 2.0 * width / period))
    law = KeptWidth(width, limit, np.array(8.0), 8.0, period)
    s = width * np.append(np.linspace(0.0, 1.0, 400_001)[:-1], 1.0 - 1e-12)
    with np.errstate(divide="ignore"):
        gain = np.minimum(limit, s / (width - s))
    reach = period * (1.0 + 0.5 * 8.0 * period)
    ahead = (1.0 - reach * 8.0) * s - reach * gain
    stays = ahead.max() + reach * push < width and ahead.min() - reach * push > -width
    assert law.kept(push, limit, period, 8.0) == stays


def test_a_barrier_that_is_sampled_fast_keeps_its_width_and_says_up_to_which_period(tmp_path: Path) -> None:
    claim = judged(barrier(), tmp_path, "width")
    assert claim.status == "held"
    assert "Any push of that size is held with U = 20 for L up to" in claim.reason


def test_a_barrier_that_is_sampled_too_slowly_does_not_and_the_period_that_is_named_does(tmp_path: Path) -> None:
    law = barrier(period=0.016, width=0.02)
    claim = judged(law, tmp_path, "width")
    assert claim.status == "broken"
    assert claim.causes == {"sampling": claim.broken}
    named = claim.reason.partition("with period = ")[2].partition(" it holds")[0]
    assert judged(replace(law, period=float(named)), tmp_path, "width").status == "held"


def test_s_that_never_comes_within_the_width_tests_nothing(tmp_path: Path) -> None:
    claim = judged(barrier(width=1e-3), tmp_path, "width", q0=1.0, seconds=0.02)
    assert claim.status == "not tested"


def test_a_drive_at_its_limit_is_the_reason_where_the_barrier_is_not_kept(tmp_path: Path) -> None:
    claim = judged(barrier(), tmp_path, "width", effort_limit=3.0)  # the load is up to 10 N
    assert claim.status == "broken"
    assert claim.causes == {"saturation": claim.broken}


# Finite time ----------------------------------------------------------------------------------------------------------


def test_what_e_may_be_is_the_solution_on_the_surface() -> None:
    p, stiffness, layer = 5.0 / 3.0, 8.0, 0.01
    promise = TerminalTime(p, np.array([stiffness]), np.array([2.0]), np.array([layer]), 8.0)
    time = np.linspace(0.0, 0.5, 100_001)
    x = np.full(1, 0.3 - layer)
    found = [x[0]]
    for _ in time[1:]:
        x = np.maximum(x - (time[1] - time[0]) * (stiffness * np.maximum(x, 0.0)) ** (1.0 / p), 0.0)
        found.append(x[0])
    allowed = promise.allowed(time, np.zeros(1), np.array([0.3]))[:, 0]
    assert allowed == pytest.approx(layer + np.array(found), abs=2e-5)
    assert allowed[-1] == layer


def test_the_error_of_a_terminal_surface_is_gone_by_the_time_that_is_due(tmp_path: Path) -> None:
    law = Ntsm(**GAINS, period=1e-3, stiffness=8.0, gain=5.0, boundary=0.01)
    run, world = ran(law, tmp_path, q0=0.3, seconds=2.0)
    claim = monitor(run, world, law).claim("finite_time")
    assert claim.status == "held"
    due = float(claim.reason.partition("is due at ")[2].partition(" s")[0])
    assert due < 1.0
    assert np.abs(run.q[0, run.time > due]).max() <= 0.01
    assert np.abs(run.q[0, run.time < 0.5 * due]).max() > 0.1


def test_a_terminal_surface_that_is_sampled_too_slowly_is_left(tmp_path: Path) -> None:
    law = Ntsm(**GAINS, period=0.03, stiffness=8.0, gain=5.0, boundary=0.002)
    claim = judged(law, tmp_path, "finite_time", q0=0.3, seconds=3.0)
    assert claim.status == "broken"
    assert claim.causes == {"sampling": claim.broken}


def test_with_an_exponent_of_1_no_time_is_finite(tmp_path: Path) -> None:
    law = Ntsm(**GAINS, period=1e-3, exponent=1.0, stiffness=8.0, gain=0.0, boundary=0.1)
    claim = judged(law, tmp_path, "finite_time", seconds=0.05)
    assert claim.status == "not applicable"
    assert "PPC" in claim.reason


# Second order ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.1, 1.1])
def test_the_bounds_of_twisting_are_not_left_under_pushes_that_the_search_did_not_try(ratio: float) -> None:
    share, far, fast = bounds_of(ratio)
    assert share == 0.5
    rng = np.random.default_rng(7)
    x, y = rng.uniform(-0.3, 0.3, (2, 64))
    most = np.zeros(2)
    frequency = np.geomspace(1e-3, 1.0, 64)
    for k in range(2000):
        speed = y - np.sign(x) * np.sqrt(np.abs(x))
        if k > 1000:
            most = np.maximum(most, [np.abs(x).max(), np.abs(speed).max()])
        x = x + speed
        y = y - ratio * (np.where(x >= 0.0, 1.0, -1.0) - share * np.sign(np.cos(frequency * k)))
    assert most[0] <= far
    assert most[1] <= fast


def test_twisting_that_cannot_be_bounded_has_no_bound() -> None:
    assert reach_of(20.0, 0.5) == (np.inf, np.inf)


@pytest.mark.parametrize("period", [1e-3, 5e-4, 2.5e-4])
def test_super_twisting_keeps_to_orders_l2_and_l_with_the_same_constants_at_every_period(
    tmp_path: Path, period: float
) -> None:
    law = Sta(**GAINS, period=period, k1=3.0, k2=10.0)
    run, world = ran(law, tmp_path, seconds=1.0)
    claim = monitor(run, world, law).claim("second_order")
    assert claim.status == "held"
    assert claim.checked > 0.3 * len(run.time)
    bound = float(claim.reason.partition("(bound ")[2].partition(")")[0])
    assert bound == pytest.approx(bounds_of(10.0 / 9.0)[1] * 9.0, rel=5e-3)


def test_a_push_that_jumps_ends_the_claim_until_s_is_reached_again(tmp_path: Path) -> None:
    law = Sta(**GAINS, period=1e-3, k1=3.0, k2=10.0)
    jumps = Disturbance(profile="pulse", torque=20.0, start=0.5005, duration=0.1)
    run, world = ran(law, tmp_path, disturbances=(LOAD, jumps))
    calm, jumped = (monitor(*each, law).claim("second_order") for each in (ran(law, tmp_path), (run, world)))
    assert jumped.status == "held"
    assert 0 < jumped.checked < calm.checked


def test_s_beyond_its_bound_breaks_the_claim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    share, far, fast = bounds_of(10.0 / 9.0)
    monkeypatch.setattr(twisting_order, "bounds_of", lambda ratio: (share, 0.1 * far, fast))
    claim = judged(Sta(**GAINS, period=1e-3, k1=3.0, k2=10.0), tmp_path, "second_order")
    assert claim.status == "broken"
    assert claim.amount > 0.0


@pytest.mark.parametrize(("changes", "reason"), [({"rate": 1.0}, "threshold"), ({"k1": 0.0}, "does not twist")])
def test_no_order_is_claimed_where_gains_adapt_or_are_0(tmp_path: Path, changes: dict[str, Any], reason: str) -> None:
    law = Sta(**GAINS, **{"period": 1e-3, "k1": 3.0, "k2": 10.0, **changes})
    claim = judged(law, tmp_path, "second_order", seconds=0.05)
    assert claim.status == "not applicable"
    assert reason in claim.reason


# Gains ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("epsilon", ["4KL", 0.001])
def test_the_gain_of_plestan_keeps_to_the_bound_of_its_proof_and_a_larger_one_would_not(
    tmp_path: Path, epsilon: float | str
) -> None:
    law = Plestan2010(**GAINS, period=1e-3, rate=3e4, epsilon=epsilon, floor=0.1)
    run, world = ran(law, tmp_path)
    assert run.gain.max() > 0.15
    assert monitor(run, world, law).claim("gain").status == "held"
    grown = replace(run, gain=np.linspace(1.0, 1e3, len(run.time))[None, :, None] * run.gain)
    assert monitor(grown, world, law).claim("gain").status == "broken"


def test_the_bound_of_a_shared_gain_is_that_of_the_energy_when_s_went_out() -> None:
    promise = BoundedByEnergy(rate=2.0, floor=0.1, epsilon=0.5, beta=8.0, period=1e-3)
    size, gain = np.array([0.1, 0.6, 0.8, 0.2, 0.9]), np.array([0.1, 0.1, 3.0, 3.0, 2.0])
    bound = promise.bound(size, gain, size >= 0.5, star=4.0)
    first = 4.0 + np.sqrt(2.0 * 0.36 + 3.9**2)
    assert bound == pytest.approx([0.1001, first, first, first, 4.0 + np.sqrt(2.0 * 0.81 + 4.0)])


def test_a_barrier_gain_is_no_larger_than_what_pushes_s(tmp_path: Path) -> None:
    run, world = ran(barrier(), tmp_path)
    assert monitor(run, world, barrier()).claim("gain").status == "held"
    grown = replace(run, gain=run.gain + np.linspace(0.0, 30.0, len(run.time))[None, :, None])
    assert monitor(grown, world, barrier()).claim("gain").status == "broken"


# All of them ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_claim_of_a_source_is_judged_or_has_a_reason_why_not(tmp_path: Path, name: str) -> None:
    # A law that suggests no values of its own has some, too.
    law = suggested(CONTROLLERS[name], **required_of(name, 1.0))
    run, world = ran(law, tmp_path, seconds=0.1)
    found = monitor(run, world, law)
    for key in SOURCES:
        claim = found.claim(key)
        promised = law.promises().get(key)
        assert (claim.status == "not applicable") == (promised is None or isinstance(promised, str))
        assert claim.reason


def test_a_class_derived_from_a_law_promises_nothing_of_itself() -> None:
    class Mine(Barrier):
        pass

    assert barrier().promises()
    assert Mine(**GAINS, period=1e-3, width=0.05, limit=20.0).promises() == {}


def test_a_recorded_reference_is_the_one_that_was_followed() -> None:
    wave = Waving(np.array([0.2, -0.3]))
    time = np.arange(500) * 1e-2
    zero = np.zeros((1, 500, 2))
    asked = wave.evaluate(time)
    run = Rollout(
        **dict.fromkeys(("q", "v", "torque", "friction_torque", "s", "gain"), zero),
        time=time,
        q_ref=asked.q,
        v_ref=asked.v,
        a_ref=asked.a,
        status=("ok",),
        end_time=time[-1:],
        joint_names=("a", "b"),
        period=1e-2,
        limit_violations=(),
    )
    between = time[:-1] + 0.0037
    found, expected = recorded(run).evaluate(between), wave.evaluate(between)
    for name, close in (("q", 1e-11), ("v", 1e-8), ("a", 1e-5)):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), abs=close)


@pytest.mark.parametrize(
    ("excess", "checked", "kept"),
    [
        ([-1.0, 0.0], [True, True], True),
        ([-1.0, 1e-300], [True, True], False),
        ([1.0, -1.0], [False, True], True),
        ([-1.0, -1.0], [False, False], False),
    ],
)
def test_a_claim_is_kept_where_it_was_tested_and_nothing_exceeds_it(
    tmp_path: Path, excess: list[float], checked: list[bool], kept: bool
) -> None:
    class Told:
        def findings(self, history: Any) -> Findings:
            return Findings(np.array(excess), np.array(checked), np.zeros((2, 1)), "", "")

    class Promising(Barrier):
        def promises(self) -> Any:
            return {"width": Told()}

    law = Promising(**GAINS, width=0.05, limit=20.0, period=1e-3)
    run, _ = ran(law, tmp_path, seconds=1e-3)
    assert _kept("width", run, law) == kept


def test_a_trial_is_run_again_from_where_it_began_at_shorter_periods_up_to_the_first_that_keeps_the_claim(
    tmp_path: Path,
) -> None:
    law, again = Ppc(**GAINS, period=4e-3), []
    world = Plant(slider(tmp_path, 2.0), friction=SMOOTH, effort_limit=np.inf)
    run = rollout(world, law, Still(np.zeros(1)), 0.016, q0=[[0.1], [0.3]], v0=[[0.0], [0.7]], batch=2)

    def kept(other: Rollout, tried: Any) -> bool:
        again.append(other)
        return bool(tried.period < 1.5e-3)

    said = tried_again(run, 1, 1, world, law, ("period",), kept)
    assert said == "run again: with period = 0.001 it holds; with period = 0.002 it does not"
    for other in again:
        assert (other.q[0, 0, 0], other.v[0, 0, 0]) == (0.3, 0.7)
        assert other.time[-1] == pytest.approx(run.time[-1])


@pytest.mark.parametrize(
    ("norm", "cause"), [(0.9, CAUSES.index("sampling")), (1.0, -1), (1.2, -1), (np.nan, CAUSES.index("sampling"))]
)
def test_no_period_is_blamed_where_lemma_1_is_broken_between_the_last_kept_tick_and_the_breach(
    tmp_path: Path, norm: float, cause: int
) -> None:
    run, _ = ran(barrier(), tmp_path, seconds=3e-3)
    over, norms = np.array([-1.0, -1.0, 1.0, 1.0]), np.array([5.0, norm, 0.5, 0.5])
    found = Findings(over, np.ones(4, dtype=bool), np.ones((4, 1)), "", "")
    causes = _causes(found, np.ones((4, 1)), norms, np.zeros(4, dtype=bool), run)
    assert causes[2:].tolist() == [cause, cause]
