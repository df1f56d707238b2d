"""What promises reckon from a history, on motions that were made from pushes that are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from asmc_pin.controllers.promises import twisting_order
from asmc_pin.controllers.promises.bounded_gain import BoundedByEnergy
from asmc_pin.controllers.promises.kept_width import KeptWidth
from asmc_pin.controllers.promises.run_history import History, gathered
from asmc_pin.controllers.promises.terminal_time import TerminalTime
from asmc_pin.controllers.promises.twisting_order import TwistingOrder, bounds_of, reach_of

L, BETA, TICKS = 1e-3, 8.0, 50


def history(**signals: Any) -> History:
    """A trial of two joints; what is not given is NaN."""
    nothing = np.full((TICKS, 2), np.nan)
    usual = dict.fromkeys(("error", "rate", "bend", "s", "gain"), nothing)
    return History(time=L * np.arange(TICKS), **{**usual, **signals})


def test_the_push_under_a_shared_gain_is_the_one_that_the_motion_was_made_with() -> None:
    push = np.random.default_rng(0).uniform(-5.0, 5.0, (TICKS - 1, 2))
    s = np.empty((TICKS, 2))
    s[0] = 0.03, -0.02  # both cross 0 on the way
    for k, d in enumerate(push):
        s[k + 1] = s[k] - L * (BETA * s[k] + 3.0 * np.where(s[k] >= 0.0, 1.0, -1.0) + d)
    assert (s > 0.0).any(axis=0).all()
    assert (s < 0.0).any(axis=0).all()
    promise = BoundedByEnergy(rate=40.0, floor=0.1, epsilon=1e-9, beta=BETA, period=L)
    star = np.linalg.norm(push, axis=1).max()
    bound = star + np.sqrt(40.0 * (0.03**2 + 0.02**2) + (3.0 - star) ** 2)  # s stays outside ε from the start
    for share in (0.99, 1.01):
        gain = np.full((TICKS, 2), 3.0)
        gain[-1] = share * bound
        found = promise.findings(history(s=s, gain=gain))
        np.testing.assert_allclose(found.push[:-1], push, rtol=0.0, atol=1e-9)
        assert found.excess[-1] == pytest.approx((share - 1.0) * bound, rel=1e-6)
        assert (found.excess[:-1] < 0.0).all()


def barrier_motion(law: KeptWidth, push: np.ndarray, start: tuple[float, float]) -> np.ndarray:
    reach = L * (1.0 + 0.5 * np.asarray(law.ks) * L)
    s = np.empty((TICKS, 2))
    s[0] = start
    for k, d in enumerate(push):
        gain = np.minimum(law.limit, np.abs(s[k]) / (law.width - np.abs(s[k])))
        s[k + 1] = (1.0 - reach * BETA) * s[k] - reach * (gain * np.sign(s[k]) + d)
    return s


def test_the_push_under_a_barrier_is_the_one_that_the_motion_was_made_with_and_the_worst_joint_is_named() -> None:
    law = KeptWidth(0.05, 20.0, np.array([8.0, 300.0]), BETA, L)
    push = np.random.default_rng(1).uniform(-9.0, 9.0, (TICKS - 1, 2)) * [1.0, 0.3]
    s = barrier_motion(law, push, (0.02, -0.045))
    found = law.findings(history(s=s))
    np.testing.assert_allclose(found.push[:-1], push, rtol=0.0, atol=1e-9)
    assert found.checked.all()
    np.testing.assert_allclose(found.excess, (np.abs(s) - 0.05).max(axis=1), rtol=0.0, atol=1e-15)
    assert "|s|/ε up to 0.9 at joint 2, pushed by" in found.seen
    low, high = law.limits(np.abs(push[:, 1]).max(), 300.0) or (np.nan, np.nan)
    assert f"with U from {low:.3g} to {high:.3g} rad/s²" in found.seen
    assert low < law.limit < high


def stays(law: KeptWidth, push: float, limit: float, period: float, ks: float) -> bool:
    """The same by trying all s of a fine grid, with the push at either end."""
    s = law.width * np.append(np.linspace(0.0, 1.0, 20_001)[:-1], 1.0 - 1e-12)
    reach = period * (1.0 + 0.5 * ks * period)
    ahead = (1.0 - reach * law.beta) * s - reach * np.minimum(limit, s / (law.width - s))
    return bool(ahead.max() + reach * push < law.width and ahead.min() - reach * push > -law.width)


@pytest.mark.parametrize("ks", [8.0, 400.0])
@pytest.mark.parametrize("push", [2.0, 12.0])
def test_the_longest_period_that_is_named_is_the_longest_at_which_no_push_takes_s_out(ks: float, push: float) -> None:
    law = KeptWidth(0.05, 20.0, np.array(ks), BETA, L)
    longest = law.longest_period(push, 20.0, ks)
    assert stays(law, push, 20.0, 0.999 * longest, ks)
    assert not stays(law, push, 20.0, 1.001 * longest, ks)


@pytest.mark.parametrize(
    ("period", "limit", "push", "beta", "ks"), [(0.2, 0.08, 0.1, 1.0, 2.0), (0.3, 0.03, 0.03, 0.5, 1.0)]
)
def test_a_gain_so_steep_that_s_turns_round_at_once_still_keeps_a_weak_push_within_the_width(
    period: float, limit: float, push: float, beta: float, ks: float
) -> None:
    """From no s on does the next one grow with it: the worst place is 0, and nothing outside of the width counts."""
    law = KeptWidth(0.05, limit, np.array(ks), beta, period)
    assert period > 0.05
    assert stays(law, push, limit, period, ks)
    assert law.kept(push, limit, period, ks)
    longest = law.longest_period(push, limit, ks)
    assert stays(law, push, limit, 0.999 * longest, ks)
    assert not stays(law, push, limit, 1.001 * longest, ks)


def test_the_limits_that_are_named_begin_where_they_first_exceed_the_push() -> None:
    law = KeptWidth(0.05, 20.0, np.array(8.0), BETA, 2e-3)
    low, high = law.limits(8.3, 8.0) or (np.nan, np.nan)
    assert 1.0 < low / (8.3 - BETA * 0.05) < 1.005
    assert stays(law, 8.3, high, 2e-3, 8.0)
    assert not stays(law, 8.3, 1.02 * high, 2e-3, 8.0)


def test_a_joint_of_which_nothing_is_claimed_yet_breaks_no_claim_about_another() -> None:
    over = np.array([[-1.0, 7.0], [np.nan, -2.0], [-3.0, -4.0]])
    checked = np.array([[True, False], [True, True], [False, False]])
    found = gathered(over, checked, over, "", "")
    assert found.excess.tolist() == [-1.0, -2.0, -np.inf]
    assert found.checked.tolist() == [True, True, False]


def test_the_push_on_a_terminal_surface_is_what_the_law_s_own_pulls_leave_of_the_motion() -> None:
    rng = np.random.default_rng(2)
    error, rate, push = rng.uniform(-0.1, 0.1, (3, TICKS, 2))
    p, stiffness, layer = 1.5, np.array([8.0, 3.0]), np.array([0.01, 0.05])
    sigma = error + np.sign(rate) * np.abs(rate) ** p / stiffness
    along = -stiffness / p * np.sign(rate) * np.abs(rate) ** (2.0 - p)
    back = -BETA * stiffness * sigma - 2.0 * np.clip(sigma / layer, -1.0, 1.0)
    promise = TerminalTime(p, stiffness, np.array([2.0, 2.0]), layer, BETA)
    found = promise.findings(history(error=error, rate=rate, bend=along + back - push))
    np.testing.assert_allclose(found.push, push, rtol=0.0, atol=1e-12)


def test_a_terminal_surface_is_left_by_sigma_alone_or_by_the_error_alone() -> None:
    p, stiffness, layer = 1.5, np.array([8.0, 8.0]), np.array([0.01, 0.01])
    promise = TerminalTime(p, stiffness, np.array([2.0, 2.0]), layer, BETA)
    error, rate, rest = (np.zeros((TICKS, 2)) for _ in range(3))
    error[:, 0] = 0.005  # small enough; but from half of the run on σ is 0.02
    rate[25:, 0] = (0.015 * 8.0) ** (1.0 / p)
    found = promise.findings(history(error=error, rate=rate, bend=rest))
    np.testing.assert_allclose(found.excess[25:], 0.01, rtol=1e-9)
    assert (found.excess[:25] < 0.0).all()
    assert "besides the law, of K + βBΦ = 2.64;" in found.seen
    error[:, 0], rate[:, 0] = 0.05, -((0.05 * 8.0) ** (1.0 / p))  # σ is 0, and yet the error stays
    found = promise.findings(history(error=error, rate=rate, bend=rest))
    allowed = promise.allowed(L * np.arange(TICKS), np.zeros(2), np.array([0.05, 0.0]))[:, 0]
    np.testing.assert_allclose(found.excess[1:], (0.05 - allowed)[1:], rtol=1e-6)
    assert (found.excess[1:] > 0.0).all()


def test_the_first_tick_is_no_jump_of_the_push_however_small_the_gains() -> None:
    s = np.empty((TICKS, 2))
    s[0], integral = 1e-9, 0.0
    for k in range(TICKS - 1):  # k₁ = k₂ = 1 and nothing pushes: s changes its sign at once
        sign = 1.0 if s[k, 0] >= 0.0 else -1.0
        integral += L * sign
        s[k + 1] = s[k] - L * (np.sqrt(abs(s[k])) * sign + integral)
    assert s[1, 0] < 0.0
    found = TwistingOrder(np.array([1.0, 1.0]), np.array([1.0, 1.0]), L).findings(history(s=s))
    assert found.checked[0]
    assert (found.excess[found.checked] < 0.0).all()


def test_a_gain_at_its_floor_may_rise_by_the_floor_a_second_where_v_allows_less() -> None:
    promise = BoundedByEnergy(rate=1e-9, floor=0.1, epsilon=0.5, beta=BETA, period=L)
    size = np.array([0.6, 0.1, 0.6, 0.1])
    bound = promise.bound(size, np.full(4, 0.1), size >= 0.5, star=0.0)
    np.testing.assert_allclose(bound, 0.1 + L * 0.1, rtol=1e-9)


def test_a_weak_integral_leaves_twisting_on_the_cycle_of_its_root_alone() -> None:
    """x⁺ = x + y − √|x| sgn(x) with y that stands goes to and fro between a² and −b², a² + b² = (a + b)/2.

    So ẋ is (a + b)/2, at most ½ (at a = b), and a at most ¼ + 1/√8.
    """
    far, fast = reach_of(0.01, 0.0)
    assert fast == pytest.approx(0.5, rel=0.03)
    assert far == pytest.approx((0.25 + np.sqrt(0.125)) ** 2, rel=0.03)


def test_a_rate_of_s_beyond_its_order_breaks_the_claim_however_small_s_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(twisting_order, "bounds_of", lambda ratio: (1e9, 1e6, 100.0))  # s to 1, ṡ to 0.1
    s = np.zeros((TICKS, 2))
    s[:, 0] = np.where(np.arange(TICKS) == 0, 1e-6, -1e-6)  # it turns slowly, and is reached
    s[20:, 0] = -1e-6 - 3e-4 * np.arange(1, TICKS - 19)
    found = TwistingOrder(np.ones(2), np.ones(2), L).findings(history(s=s))
    assert (found.excess[:19] < 0.0).all()
    np.testing.assert_allclose(found.excess[19:-1], 3e-4 / L / 0.1 - 1.0, rtol=1e-9)


@pytest.mark.parametrize("ratio", [5.0, 100.0, 1000.0])
def test_where_the_integral_outweighs_the_root_the_bound_holds_for_longer_than_the_search_took(ratio: float) -> None:
    """A loop that still grows when the search ends is not taken for one that is settled."""
    share, far, fast = bounds_of(ratio)
    assert 0.0 < far < np.inf
    rng, often = np.random.default_rng(7), np.linspace(0.0, 1.0, 64)
    x, y = rng.uniform(-1.0 - ratio, 1.0 + ratio, (2, 64))
    most = np.zeros(2)
    for k in range(6400):
        speed = y - np.sign(x) * np.sqrt(np.abs(x))
        if k > 3200:
            most = np.maximum(most, [np.abs(x).max(), np.abs(speed).max()])
        out, x = x * speed >= 0.0, x + speed
        side = np.where(x >= 0.0, 1.0, -1.0)
        push = np.where(rng.random(64) < often, np.where(out, side, -side), rng.choice([-1.0, 1.0], 64))
        y = y - ratio * (side - share * push)
    assert 0.3 * far < most[0] <= far
    assert 0.3 * fast < most[1] <= fast


@pytest.mark.parametrize("k1", [1e-2, 1e-3, 1e-100, 1e-170])
def test_the_joint_whose_gains_have_no_bound_is_named_and_nothing_is_claimed_of_it(k1: float) -> None:
    s = np.zeros((TICKS, 2))
    s[:, 0] = 1e-9
    found = TwistingOrder(np.array([1.0, k1]), np.ones(2), L).findings(history(s=s))
    assert "joint 1" in found.seen
    assert "of joint 2 no bound was found, k₁² is too small for k₂" in found.seen
    alone = TwistingOrder(np.full(2, k1), np.ones(2), L).findings(history(s=s))
    assert not alone.checked.any()
    assert "of joint 1 no bound was found" in alone.untested
