"""Lemma 2, (16), t_ε and Theorem 1 along runs of baek2016: exact bookkeeping, and verdicts with their reasons."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plant_cases import Still, Waving, slider

from asmc_pin.arms import Arm, load_arm
from asmc_pin.controllers import Baek2016
from asmc_pin.engine import Rollout, rollout
from asmc_pin.monitors import BAEK, CAUSES, STATEMENTS, STATUSES, Monitors, claim_rows, monitor, monitor_dataset
from asmc_pin.monitors.claim_texts import judge, percent
from asmc_pin.monitors.claim_verdicts import _lemma2, contraction
from asmc_pin.monitors.law_signals import Signals
from asmc_pin.monitors.lyapunov_monitor import gain_bounds, lyapunov_of
from asmc_pin.monitors.tde_monitor import Contraction
from asmc_pin.plant import Disturbance, Drive, Friction, Plant, Sensor

Q0 = np.array([-1.2, 0.4])
MBAR = [0.08, 0.03]


def law_of(period: float = 1e-3, **options: Any) -> Baek2016:
    gains: dict[str, Any] = {"ks": 8.0, "beta": 8.0, "phi": [400.0, 900.0], "alpha": [0.03, 0.05], "epsilon": 0.01}
    return Baek2016(**{"mbar": MBAR, "period": period, **gains, **options})


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_arm("two_link")


def run(arm: Arm, law: Baek2016, seconds: float = 0.5, offset: float = 0.0, **plant: Any) -> tuple[Rollout, Monitors]:
    world = Plant(arm, **{"friction": Friction(2.0, 0.5), "effort_limit": np.inf, **plant})
    seen = rollout(world, law, Waving(Q0), seconds, q0=Q0 - offset)
    return seen, monitor(seen, world, law)


WORLDS: dict[str, dict[str, Any]] = {
    "ideal": {},
    "noise": {"sensor": Sensor(velocity="exact", torque_noise=0.3), "friction": Friction(0.0, 0.5)},
    "limits": {"effort_limit": [26.0, 6.0], "offset": 0.05},
    "delay": {"drive": Drive(delay=0.3)},
}


# Bookkeeping


def test_v_is_that_of_12_with_the_gain_that_acts_and_the_largest_error_of_the_run(arm: Arm) -> None:
    law = law_of()
    seen, found = run(arm, law)
    star = np.nanmax(np.abs(found.error[0]), axis=0)
    expected = 0.5 * np.sum(seen.s[0] ** 2, axis=1) + 0.5 * np.sum(
        law.alpha / law.phi * (star - seen.gain[0]) ** 2, axis=1
    )
    assert found.star[0] == pytest.approx(star)
    assert found.lyapunov[0] == pytest.approx(expected, rel=1e-12)
    bound = np.sqrt(2 * 0.01**2 + np.max(np.sum(law.alpha / law.phi * (star - seen.gain[0]) ** 2, axis=1)))
    assert found.s_bound[0] == pytest.approx(bound, rel=1e-12)


@pytest.mark.parametrize("world", WORLDS)
def test_the_excess_of_16_is_the_sum_of_the_papers_estimate_and_what_is_named(arm: Arm, world: str) -> None:
    law = law_of()
    seen, found = run(arm, law, **WORLDS[world])
    assert found.signals is not None
    proof = lyapunov_of(found.signals, seen.gain, law, found.star, 0)
    L, s, error = law.period, found.signals.s[0], found.error[0, :-1]
    slope, change = np.diff(s, axis=0) / L, np.diff(seen.gain[0], axis=0) / L
    s, gain, weight = s[:-1], seen.gain[0, :-1], law.alpha / law.phi
    # s·δ: what q̈_d + K_s ė, held at its value of t_k, misses in the period.
    rate, position = seen.v_ref - seen.v[0], seen.q_ref - seen.q[0]
    mean = np.diff(seen.v_ref, axis=0) / L + law.ks * np.diff(position, axis=0) / L
    held = np.sum(s * (mean - seen.a_ref[:-1] - law.ks * rate[:-1]), axis=1)
    adapts = -np.sum(weight * (found.star[0] - gain) * (change - np.abs(s) / weight), axis=1)
    finite = 0.5 * L * np.sum(slope**2 + weight * change**2, axis=1)
    scale = np.abs(found.excess[0, :-1]).max()
    assert proof.parts["sampling"][:-1] == pytest.approx(held + adapts + finite, abs=1e-9 * scale)
    # V̇ itself, as a plain difference of V.
    plain = np.diff(found.lyapunov[0]) / L + law.beta * np.sum(s**2, axis=1)
    assert found.excess[0, :-1] == pytest.approx(plain, abs=1e-9 * max(scale, found.lyapunov[0].max() / L * 1e-3))
    estimate = -np.sum(found.star[0] * np.abs(s) + s * error, axis=1)
    assert np.all(estimate <= 0.0)
    total = estimate + sum(proof.parts[name][:-1] for name in CAUSES)
    assert total == pytest.approx(found.excess[0, :-1], abs=1e-9 * scale)
    present = {name for name in CAUSES if np.nanmax(np.abs(proof.parts[name])) > 1e-6}
    expected = {"ideal": set(), "noise": {"noise"}, "limits": {"saturation"}, "delay": {"drive"}}
    assert present == {"sampling"} | expected[world]


def far_away(folder: Path, period: float) -> Monitors:
    """One joint on the way to a reference that stands: nothing jumps, s does not cross zero before it is in."""
    arm, law = slider(folder, 2.0), law_of(period, mbar=1.2, phi=50.0, alpha=0.5, epsilon=0.05)
    seen = rollout(Plant(arm), law, Still(np.array([0.3])), 0.3, q0=[0.0])
    return monitor(seen, arm, law)


def test_s_comes_in_while_v_falls_as_16_says_but_for_what_one_period_hides(tmp_path: Path) -> None:
    coarse, fine = far_away(tmp_path, 2e-4), far_away(tmp_path, 1e-4)
    assert 0.0 < fine.t_eps[0] <= fine.lyapunov[0, 0] / (8.0 * 0.05**2)
    assert {fine.claim(key).status for key in ("lemma2", "t_eps", "eq21")} == {"held"}
    # At t = 0 alone N = −Γ*, so that (16) has no slack at all; there the finite step shows, in proportion to it.
    claims = [found.claim("eq16") for found in (coarse, fine)]
    assert [(claim.broken, claim.first_time) for claim in claims] == [(1, 0.0), (1, 0.0)]
    assert claims[1].checked > 1000
    assert claims[0].amount / claims[1].amount == pytest.approx(2.0, rel=1e-2)


# Verdicts and reasons


def test_stick_and_slip_alone_do_not_break_16(tmp_path: Path) -> None:
    arm, law = slider(tmp_path, 2.0), law_of(mbar=1.2, phi=500.0, alpha=0.1, epsilon=1e-4)
    seen = rollout(Plant(arm, friction=Friction(3.0, 0.0)), law, Waving(np.zeros(1)), 2.5)
    claim = monitor(seen, arm, law).claim("eq16")
    assert np.any(seen.v > 0.1)
    assert np.any(seen.v < -0.1)
    assert claim.status == "held"
    assert claim.checked > 300


@pytest.mark.parametrize(
    ("world", "cause"), [("ideal", "sampling"), ("noise", "noise"), ("limits", "saturation"), ("delay", "drive")]
)
def test_each_tick_that_breaks_16_is_blamed_on_what_added_most(arm: Arm, world: str, cause: str) -> None:
    _, found = run(arm, law_of(), **WORLDS[world])
    claim = found.claim("eq16")
    over = found.claimed[0] & (np.nan_to_num(found.excess[0]) > 0.0)
    assert (claim.status, claim.broken, claim.checked) == ("broken", over.sum(), found.claimed[0].sum())
    assert sum(claim.causes.values()) == claim.broken
    assert claim.first_time == found.time[np.argmax(over)]
    assert claim.amount == pytest.approx(found.excess[0][over].max(), rel=1e-9)
    assert claim.causes[cause] > 0
    assert set(claim.causes) <= {"sampling", cause}
    assert "changes its sign within the period" in claim.reason


def overloaded(arm: Arm) -> tuple[Rollout, Monitors, Baek2016]:
    """At rest inside ε; then a push that grows slowly beyond what the drive of joint 2 can resist."""
    law = law_of(phi=1.0, alpha=1.0)
    push = Disturbance(profile="sine", torque=[0.0, -20.0], start=0.2, frequency=0.5)
    world = Plant(arm, friction=Friction(0.0, 2.0), effort_limit=[60.0, 12.0], disturbances=[push])
    seen = rollout(world, law, Still(Q0), 0.9)
    return seen, monitor(seen, world, law), law


def test_saturation_breaks_theorem_1_and_says_when_and_by_how_much(arm: Arm) -> None:
    seen, found, _ = overloaded(arm)
    claim = found.claim("eq21")
    assert claim.status == "broken"
    assert claim.causes == {"saturation": claim.broken}
    size = np.linalg.norm(seen.s[0], axis=1)
    assert claim.amount == pytest.approx(size.max() - found.s_bound[0])
    assert claim.worst_time == seen.time[np.argmax(size)]
    assert claim.first_time == seen.time[np.argmax(size > found.s_bound[0])]
    assert claim.first_time > 0.2
    assert found.claim("eq16").causes == {"saturation": found.claim("eq16").broken}
    assert found.claim("t_eps").status == "held"  # it was inside before
    assert f"bound {found.s_bound[0]:.4g}" in claim.reason


def test_lemma_2_has_a_bound_for_each_stay_outside_and_it_is_broken_where_16_is(arm: Arm) -> None:
    seen, found, law = overloaded(arm)
    begins = int(np.argmax(found.claimed[0]))
    expected = found.star[0] + np.sqrt(2.0 * found.lyapunov[0, begins] * law.phi / law.alpha)
    assert found.gain_bound[0, begins] == pytest.approx(expected)
    assert found.gain_bound[0, begins - 1] == pytest.approx(law.period * law.phi * law.epsilon / law.alpha)
    claim = found.claim("lemma2")
    over = np.any(seen.gain[0] > found.gain_bound[0] * (1.0 + 1e-12), axis=1)
    assert (claim.status, claim.broken) == ("broken", over.sum())
    assert claim.causes == {"saturation": claim.broken}


def test_where_epsilon_is_never_reached_16_is_not_tested_and_the_rest_says_so(arm: Arm) -> None:
    _, found = run(arm, law_of(epsilon=50.0), 0.1)
    assert found.claim("eq16").status == "not tested"
    assert "never reached ε = 50" in found.claim("eq16").reason
    assert found.t_eps[0] == 0.0
    assert np.isnan(found.claim("eq16").first_time)


def test_a_run_that_ends_before_its_time_is_up_refutes_no_finite_t_eps(arm: Arm) -> None:
    _, found = run(arm, law_of(epsilon=1e-6), 0.05, offset=0.3)
    claim = found.claim("t_eps")
    assert claim.status == "not tested"
    assert "s did not enter ‖s‖_∞ < ε by 0.05 s, but V(0)/(βε²) allows" in claim.reason
    assert found.claim("eq21").status == "not tested"
    assert np.isnan(found.t_eps[0])


def test_s_that_stays_out_for_longer_than_v_allows_breaks_the_finite_time(arm: Arm) -> None:
    # A drive too weak to lift the arm: s never comes in, and the reason is the limit.
    law = law_of(epsilon=4.0, phi=1e-3, alpha=1e-4)
    world = Plant(arm, friction=Friction(0.0, 5.0), effort_limit=[2.0, 0.2])
    seen = rollout(world, law, Still(Q0 + 1.2), 1.5, q0=Q0)
    claim = monitor(seen, world, law).claim("t_eps")
    assert claim.status == "broken"
    assert claim.reason.startswith("saturation")
    assert claim.worst_time == seen.time[-1]
    assert claim.amount == pytest.approx(claim.worst_time - claim.first_time)
    # One claim that is broken once has one cause.
    assert claim.causes == {"saturation": 1}


@pytest.mark.parametrize("excess", [[-1.0, 0.0, -2.0], [np.nan, -1.0, -1.0]])
def test_nothing_above_zero_where_claimed_is_held(excess: list[float]) -> None:
    values = np.array(excess)
    claim = judge("eq16", 0, np.arange(3.0), values, np.isfinite(values), None, "fine", "none", "bad")
    assert (claim.status, claim.broken, claim.reason) == ("held", 0, "fine")


def test_after_a_divergence_nothing_is_held_and_what_was_broken_before_stays_broken(arm: Arm) -> None:
    seen, found = run(arm, law_of(mbar=[9.0, 5.0]), friction=Friction(0.0, 0.0))
    assert seen.status == ("diverged",)
    end = seen.end_time[0]
    judged = [claim for claim in found.claims if claim.status != "not applicable"]
    assert {claim.status for claim in judged} == {"broken", "not tested after"}
    assert {claim.key for claim in judged} == set(BAEK)
    for claim in judged:
        assert claim.until == end
        assert claim.short.endswith(f"not tested after {end:.4g} s, where it diverged") or (
            claim.short == f"not tested after {end:.4g} s, where it diverged; not broken before"
        )
    whole = run(arm, law_of())[1]
    assert all(np.isnan(claim.until) for claim in whole.claims)


def test_error_that_grows_by_itself_is_not_put_down_to_sampling(arm: Arm) -> None:
    # M̄ too large: E_k N_{k−1} is larger than N_{k−1}, which no period however short would mend.
    _, found = run(arm, law_of(mbar=[0.3, 0.2]), friction=Friction(0.0, 0.0))
    claim = found.claim("contraction")
    grown = int((np.isfinite(found.growth[0]) & (found.carried[0] >= 1.0)).sum())
    assert grown > 2
    assert (claim.status, claim.broken) == ("broken", grown)
    assert claim.causes == {}
    assert claim.short.startswith("broken at ")
    assert f"the old error grows by itself in {grown} ticks" in claim.reason


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0, "0 %"), (1e-4, "0.01 %"), (0.034, "3.4 %"), (0.5, "50 %"), (0.9999, "99.9 %"), (1.0, "100 %")],
)
def test_a_share_is_never_0_or_100_percent_unless_it_is(share: float, text: str) -> None:
    assert percent(share) == text


def test_growth_of_n_by_round_off_of_its_largest_value_is_none() -> None:
    def judged(growth: float) -> str:
        nothing = np.full(3, np.nan)
        size = np.array([1000.0, 1e-3, np.nan])
        found = Contraction(nothing, size, np.array([0.0, growth, np.nan]), nothing, {})
        return contraction(0, np.arange(3.0), found).status

    assert judged(0.9e-6) == "held"
    assert judged(1.1e-6) == "broken"


@pytest.mark.parametrize(("carried", "itself"), [(0.5, False), (0.999, False), (1.0, True), (1.5, True), (3.0, True)])
def test_growth_is_sampling_s_only_where_the_old_error_by_itself_would_have_shrunk(
    carried: float, itself: bool
) -> None:
    nothing = np.full(2, np.nan)
    found = Contraction(nothing, np.ones(2), np.array([0.5, np.nan]), np.array([carried, np.nan]), {})
    claim = contraction(0, np.arange(2.0), found)
    assert (claim.status, claim.broken) == ("broken", 1)
    assert claim.causes == ({} if itself else {"sampling": 1})
    assert ("the old error grows by itself in 1 ticks" in claim.reason) is itself


def test_s_crosses_where_its_sign_at_the_next_tick_is_another_and_that_of_0_is_plus() -> None:
    law = Baek2016(mbar=[1.0, 1.0], period=0.01, ks=8.0, beta=8.0, phi=400.0, alpha=0.25, epsilon=0.01)
    s = np.array([[[0.3, 1.0], [-0.2, 1.0], [-0.1, 1.0], [0.0, 1.0], [0.2, 1.0], [0.1, -1.0]]])
    nothing = np.zeros_like(s)
    found = lyapunov_of(Signals(s, nothing, nothing, nothing, nothing, {}), nothing, law, np.ones((1, 2)), 0)
    assert found.crossing.tolist() == [True, False, True, False, True, False]


def test_the_bound_of_a_gain_is_that_of_v_or_of_what_counts_as_zero() -> None:
    law = Baek2016(mbar=[1.0], period=0.01, ks=8.0, beta=8.0, phi=400.0, alpha=0.25, epsilon=0.01, threshold=0.3)
    idle = 0.3 + 0.01 * 400.0 * 0.01 / 0.25
    value, outside = np.array([0.5, 0.4, 0.3, 0.2, np.nan]), np.array([False, True, True, False, False])
    star = np.array([2.0])
    found = gain_bounds(value, np.full((5, 1), 0.1), outside, law, star)
    steep = np.sqrt(2.0 * 400.0 / 0.25)
    assert found[:, 0] == pytest.approx([idle, *[2.0 + steep * np.sqrt(0.4)] * 3, np.nan], nan_ok=True)
    # Where V says less than what counts as zero, that is the bound; and it begins no lower than the gain.
    assert gain_bounds(0.0 * value, np.full((5, 1), 0.1), outside, law, 0.0 * star)[2, 0] == pytest.approx(idle)
    assert gain_bounds(value, np.full((5, 1), 9.0), outside, law, star)[0, 0] == 9.0


def test_a_gain_at_its_bound_is_held_and_one_above_it_is_not() -> None:
    bounds = SimpleNamespace(
        value=np.ones(2),
        gain_bound=np.full((2, 2), 3.0),
        outside=np.ones(2, dtype=bool),
        parts={name: np.ones(2) for name in CAUSES},
    )
    for share, status in ((1.0, "held"), (1.0 + 1e-13, "held"), (1.0 + 1e-9, "broken")):
        gain = np.array([[1.0, 3.0 * share], [2.0, 1.0]])
        assert _lemma2(0, np.arange(2.0), gain, bounds, np.zeros(2, dtype=int)).status == status


# Tables and files


def test_rows_and_arrays_carry_every_claim_with_units(arm: Arm) -> None:
    law = law_of()
    _, found = run(arm, law, 0.1)
    rows = claim_rows({"A": found, "B": found})
    assert list(rows.claim) == [*STATEMENTS] * 2
    assert rows[list(CAUSES)].to_numpy().sum(axis=1)[rows.claim == "eq16"][0] == found.claim("eq16").broken
    assert set(rows.status) <= set(STATUSES)
    assert rows.until.isna().all()
    assert (rows.reason != "").sum() >= 10
    assert json.loads(rows.to_json(orient="records"))[0]["controller"] == "A"
    dataset = monitor_dataset({"A": found, "B": found})
    assert dict(dataset.sizes) == {"controller": 2, "trial": 1, "time": 101, "joint": 2}
    assert np.array_equal(dataset.tde_error.to_numpy()[1], found.error, equal_nan=True)
    assert all(dataset[name].attrs["units"] for name in dataset.data_vars)


def test_a_cell_says_when_by_how_much_and_how_often(arm: Arm) -> None:
    _, found, _ = overloaded(arm)
    claim = found.claim("eq21")
    assert claim.short == (
        f"broken by saturation at {claim.first_time:.4g} s, up to {claim.amount:.3g} rad/s over, in {claim.broken} of "
        f"{claim.checked} ticks from t_ε on ({percent(claim.broken / claim.checked)})"
    )
    assert found.claim("t_eps").short == "held"
