"""The TDE error and Lemma 1 along a run, against what is known of them, and what keeps a law from what it wants."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from law_settings import required_of
from plant_cases import Accelerating, Still, Waving, slider

from asmc_pin.arms import Arm, load_arm
from asmc_pin.baselines import PdGravity
from asmc_pin.condition import lemma1_norm
from asmc_pin.controllers import (
    CONTROLLERS,
    Adrc,
    Baek2016,
    Bsmc,
    Dob,
    Plestan2010,
    Ppc,
    Sample,
    Setpoint,
)
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import ParameterError
from asmc_pin.monitors import BAEK, STATEMENTS, gamma_at_ticks, monitor
from asmc_pin.plant import Disturbance, Drive, Friction, PayloadChange, Plant, Sensor, Spread

SHARED: dict[str, Any] = {"ks": 8.0, "beta": 8.0}
OWN: dict[str, dict[str, Any]] = {
    "ppc": {},
    "bsmc": {"gain": 5.0, "boundary": 0.05},
    "plestan2010": {"rate": 100.0, "epsilon": 0.1, "floor": 0.1},
    "baek2016": {"phi": 800.0, "alpha": 0.03, "epsilon": 0.01},
}
Q0 = np.array([-1.2, 0.4])
RUBBING = Friction(2.0, 0.5)
SMOOTH = Friction(0.0, 0.0)


def law_of(name: str, period: float = 1e-3, **options: Any) -> Any:
    """A registered law; what it requires of its own is 0.4 where OWN has no values that make it work hard."""
    own = required_of(name, 0.4) | {"mbar": [0.08, 0.03], "period": period} | SHARED | OWN.get(name, {})
    return CONTROLLERS[name](**(own | options))


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_arm("two_link")


def run(arm: Arm, law: Any, *, seconds: float = 0.6, batch: int = 1, **plant: Any) -> tuple[Rollout, Plant]:
    world = Plant(arm, **{"friction": RUBBING, "effort_limit": np.inf, **plant})
    return rollout(world, law, Waving(Q0), seconds, batch=batch), world


@dataclass(frozen=True)
class TdeOnly:
    """τ = τ(t−L) + m̄ (u − q̈(t−L)): time-delay estimation under a constant command u."""

    mbar: float
    command: float
    period: float = 1e-3

    def init(self, sample: Sample) -> None:
        return None

    def step(self, state: Any, sample: Sample, setpoint: Setpoint) -> tuple[np.ndarray, np.ndarray]:
        estimate = 0.0 * sample.v if state is None else (sample.v - state) / self.period
        return sample.torque + self.mbar * (self.command - estimate), sample.v


# N and Lemma 1


@pytest.mark.parametrize("mbar", [0.4, 1.9, 3.0])
def test_on_a_constant_mass_the_error_shrinks_by_exactly_what_lemma_1_says(tmp_path: Path, mbar: float) -> None:
    mass = 2.0
    seen = rollout(Plant(slider(tmp_path, mass)), TdeOnly(mbar, 1.5), Still(np.zeros(1)), 0.012)
    found = monitor(seen, slider(tmp_path, mass), TdeOnly(mbar, 1.5))
    factor = 1.0 - mbar / mass
    assert found.norm == pytest.approx(np.full_like(found.norm, abs(factor)), rel=1e-12)
    # N_0 is the whole command: before the first tick the arm rests, and so the law takes it to go on.
    error = found.error[0, :-1, 0]
    assert error == pytest.approx(-1.5 * factor ** np.arange(1, len(error) + 1), rel=1e-8)
    assert found.carried[0, 1:-1] == pytest.approx(abs(factor), rel=1e-8)
    assert found.claim("lemma1").status == "held"
    assert found.claim("contraction").status == "held"


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize("options", [{}, {"acceleration": "position"}, {"filter_hz": 60.0}], ids=str)
def test_the_arm_does_what_the_law_wants_plus_n_and_nothing_else(arm: Arm, name: str, options: dict[str, Any]) -> None:
    # ā = u + N with ideal sensors and drives, for every law and estimate; u from the run, N by (3) and (6).
    law = law_of(name, **options)
    seen, plant = run(arm, law)
    signals = monitor(seen, plant, law).signals
    if not law.estimates:  # by (6): there is no N of it
        assert signals is None
        return
    assert signals is not None
    if signals.switching is None:
        assert not signals.shortfall
        return
    rate = seen.v_ref - seen.v
    wanted = seen.a_ref + law.ks * rate + law.beta * seen.s + signals.switching
    mean = np.diff(seen.v, axis=1) / law.period
    assert mean - wanted[:, :-1] == pytest.approx(signals.error[:, :-1], abs=1e-9)
    for part in signals.shortfall.values():
        assert np.nanmax(np.abs(part)) < 1e-9


def test_gamma_is_everything_that_the_law_does_not_know(tmp_path: Path) -> None:
    # On rails: Γ = −(m g sin + f)/m + (1/m − 1/m̄) τ, constant within each period but for viscous friction.
    mass, slope, coulomb = 2.0, 0.3, 1.5
    arm, law = slider(tmp_path, mass, slope), Ppc(mbar=1.3, period=1e-3, **SHARED)
    seen = rollout(Plant(arm, friction=Friction(coulomb, 0.0)), law, Accelerating(np.array([2.0])), 0.3)
    signals = monitor(seen, arm, law).signals
    assert signals is not None
    sliding = seen.v[0, :-1, 0] > 0.01
    weight = mass * 9.81 * np.sin(slope)
    expected = -(weight + coulomb) / mass + (1.0 / mass - 1.0 / 1.3) * seen.torque[0, :-1, 0]
    assert sliding.sum() > 200
    assert signals.gamma[0, :-1, 0][sliding] == pytest.approx(expected[sliding], rel=1e-9)
    assert gamma_at_ticks(seen, arm, law)[0, :-1, 0][sliding] == pytest.approx(expected[sliding], rel=1e-9)


def within_period(arm: Arm, period: float) -> tuple[float, float]:
    law = law_of("ppc", period)
    seen, _ = run(arm, law, friction=SMOOTH, integrator="rk4")
    found = monitor(seen, arm, law)
    assert found.signals is not None
    late = seen.time > 0.1
    late[-1] = False
    difference = found.signals.gamma - gamma_at_ticks(seen, arm, law)
    return float(np.abs(difference[0, late]).max()), float(np.abs(found.error[0, late]).max())


def test_without_jumps_the_mean_of_gamma_and_the_tde_error_come_in_proportion_to_the_period(arm: Arm) -> None:
    coarse, fine = within_period(arm, 1e-3), within_period(arm, 5e-4)
    assert coarse[0] / fine[0] == pytest.approx(2.0, rel=0.03)
    assert coarse[1] / fine[1] == pytest.approx(2.0, rel=0.03)


def test_where_sgn_of_s_switches_the_tde_error_does_not_vanish_with_the_period(arm: Arm) -> None:
    # Each change of sign puts (I − M⁻¹M̄) 2 K̂ into N; Lemma 1's "→ 0 as L → 0" takes q̈ for continuous.
    largest = []
    for period in (1e-3, 2.5e-4):
        law = Plestan2010(mbar=[0.08, 0.03], period=period, rate=1.0, epsilon=1.0, floor=4.0, **SHARED)
        seen, plant = run(arm, law, friction=SMOOTH)
        largest.append(monitor(seen, plant, law).star[0])
    assert np.all(largest[1] > 0.7 * largest[0])
    assert np.all(largest[1] > 4.0)


def test_lemma_1_is_broken_where_mbar_is_too_large_and_by_as_much(arm: Arm) -> None:
    law = law_of("ppc", mbar=[0.9, 0.02])
    seen, _ = run(arm, law, seconds=0.05)
    norm = lemma1_norm(arm.mass_matrix(seen.q[0]), law.mbar)
    claim = monitor(seen, arm, law).claim("lemma1")
    assert (claim.status, claim.broken) == ("broken", int((norm >= 1.0).sum()))
    assert claim.amount == pytest.approx(norm.max() - 1.0)
    assert norm[round(claim.worst_time / law.period)] == pytest.approx(norm.max(), rel=1e-12)
    assert "design" in claim.reason


# Why


def shares(found: Any) -> dict[str, float]:
    return {name: float(np.nanmax(np.abs(part))) for name, part in found.signals.shortfall.items()}


def test_a_saturated_drive_is_the_reason_where_the_torque_stands_at_its_limit(arm: Arm) -> None:
    law = law_of("ppc", ks=40.0, beta=40.0)
    world = Plant(arm, friction=SMOOTH, effort_limit=[26.0, 6.0])
    seen = rollout(world, law, Waving(Q0), 0.5, q0=Q0 + 0.05)
    found = monitor(seen, world, law)
    assert found.signals is not None
    short = found.signals.shortfall
    at_limit = np.abs(seen.torque) >= np.array([26.0, 6.0]) * (1.0 - 1e-12)
    assert 20 < at_limit.sum() < at_limit.size / 2
    assert np.array_equal(short["saturation"] != 0.0, at_limit)
    assert np.nanmax(np.abs(short["noise"])) == 0.0
    assert np.nanmax(np.abs(short["drive"])) < 1e-9
    # To one who does not know the limits the drive did something else than it was told.
    blind = monitor(seen, arm, law, effort_limit=np.inf).signals
    assert blind is not None
    assert np.array_equal(np.abs(blind.shortfall["drive"]) > 1e-9, at_limit)


def test_noise_is_the_reason_where_sensors_lie(arm: Arm) -> None:
    law = law_of("ppc")
    seen, plant = run(arm, law, friction=SMOOTH, sensor=Sensor(velocity="exact", velocity_noise=1e-3))
    found = monitor(seen, plant, law)
    assert shares(found)["noise"] > 0.5
    assert max(shares(found)[name] for name in ("saturation", "drive")) < 1e-9
    # The error of the estimate is the velocity noise over L, in the law's own words.
    told = np.diff(seen.v_measured - seen.v, axis=1)[:, 1:-1] / law.period
    feedback = -(law.ks + law.beta) * (seen.v_measured - seen.v) - law.ks * law.beta * (seen.q_measured - seen.q)
    torque = (
        seen.torque_measured - np.concatenate([seen.held_torque[:, None], seen.torque[:, :-1]], axis=1)
    ) / law.mbar
    expected = feedback[:, 2:-1] - told + torque[:, 2:-1]
    assert found.signals is not None
    assert found.signals.shortfall["noise"][:, 2:-1] == pytest.approx(expected, abs=1e-9)
    assert found.claim("contraction").causes["noise"] > 50


@pytest.mark.parametrize("drive", [Drive(delay=0.5), Drive(current_hz=80.0)], ids=["delay", "current loop"])
def test_a_slow_drive_is_the_reason_where_the_torque_comes_late(arm: Arm, drive: Drive) -> None:
    law = law_of("bsmc")
    seen, plant = run(arm, law, friction=SMOOTH, drive=drive)
    found = monitor(seen, plant, law)
    assert shares(found)["drive"] > 0.1
    assert max(shares(found)[name] for name in ("saturation", "noise")) < 1e-9
    assert found.claim("contraction").causes["drive"] > 0


def test_friction_is_named_where_joints_stick_and_break_away(arm: Arm) -> None:
    law = law_of("ppc")
    seen, plant = run(arm, law, seconds=1.5, friction=Friction([12.0, 3.0], 0.0))
    assert "friction in" in monitor(seen, plant, law).claim("contraction").reason
    seen, plant = run(arm, law, seconds=1.5, friction=SMOOTH)
    assert "friction in" not in monitor(seen, plant, law).claim("contraction").reason


def test_a_payload_picked_up_in_mid_run_is_in_the_norm_from_that_tick_on(arm: Arm) -> None:
    law = law_of("ppc")
    seen, plant = run(arm, law, payload_changes=[PayloadChange(time=0.3, payload=4.0)])
    found = monitor(seen, plant, law)
    heavy = arm.replace(payload=4.0)
    for carrying, ticks in ((arm, slice(0, 300)), (heavy, slice(300, None))):
        expected = lemma1_norm(carrying.mass_matrix(seen.q[0, ticks]), law.mbar)
        assert found.norm[0, ticks] == pytest.approx(expected, rel=1e-12)


def test_each_payload_of_a_run_is_in_the_norm_while_it_is_carried(arm: Arm) -> None:
    law = law_of("ppc")
    changes = [PayloadChange(time=0.02, payload=4.0), PayloadChange(time=0.05, payload=1.0)]
    seen, plant = run(arm, law, seconds=0.08, payload_changes=changes)
    found = monitor(seen, plant, law)
    for load, ticks in ((None, slice(0, 20)), (4.0, slice(20, 50)), (1.0, slice(50, None))):
        mass = arm.replace(payload=load).mass_matrix(seen.q[0, ticks])
        assert found.norm[0, ticks] == pytest.approx(lemma1_norm(mass, law.mbar), rel=1e-12)


def test_disturbances_are_part_of_gamma(arm: Arm) -> None:
    law = law_of("ppc")
    push = Disturbance(profile="step", torque=[0.0, 3.0], start=0.2)
    seen, plant = run(arm, law, friction=SMOOTH, disturbances=[push])
    found = monitor(seen, plant, law)
    assert found.signals is not None
    assert np.abs(found.signals.gamma - gamma_at_ticks(seen, plant, law))[0, :-1].max() < 0.5
    jump = found.error[0, 200] - found.error[0, 199]
    assert jump == pytest.approx(np.linalg.solve(arm.mass_matrix(seen.q[0, 200]), [0.0, 3.0]), rel=0.02)


# What holds for every run


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_trial_is_judged_the_same_in_any_batch(arm: Arm, name: str) -> None:
    law = law_of(name)
    seen, plant = run(arm, law, batch=3, seconds=0.2, spread=Spread(mass=0.2, inertia=0.1, friction=0.3))
    whole = monitor(seen, plant, law)
    alone = rollout(plant, law, Waving(Q0), 0.2, trials=[2])
    single = monitor(alone, plant, law, trials=[2])
    assert np.array_equal(single.error[0], whole.error[2], equal_nan=True)
    assert np.array_equal(single.norm[0], whole.norm[2], equal_nan=True)
    assert not np.array_equal(whole.norm[0], whole.norm[2])
    for key in STATEMENTS:
        one, other = single.claim(key), whole.claim(key, 2)
        assert (one.status, one.broken, one.causes, one.reason) == (
            other.status,
            other.broken,
            other.causes,
            other.reason,
        )


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_run_that_blows_up_is_judged_up_to_its_end(arm: Arm, name: str) -> None:
    law = law_of(name, ks=900.0, beta=900.0, mbar=[8.0, 3.0])
    seen, plant = run(arm, law, friction=SMOOTH, speed_bound=0.5)
    assert seen.status == ("diverged",)
    found = monitor(seen, plant, law)
    end = int(np.searchsorted(seen.time, seen.end_time[0]))
    assert np.isfinite(found.error[0, : end - 1]).all() == law.estimates
    assert np.isnan(found.norm[0, end:]).all()
    assert all(not claim.broken or claim.worst_time <= seen.end_time[0] for claim in found.claims)


@pytest.mark.parametrize("weight", [0.3, 1.0])
def test_the_error_of_a_low_passed_estimate_is_carried_by_one_minus_c_mbar_over_m(
    tmp_path: Path, weight: float
) -> None:
    """And Lemma 1's condition is that on cM̄: with M̄ = 1.5 M a plain estimate would keep half of the error."""
    mass = 2.0
    cutoff = np.inf if weight == 1.0 else -np.log(1.0 - weight) / (2e-3 * np.pi)
    law = Dob(mbar=1.5 * mass, cutoff_hz=cutoff, period=1e-3, **SHARED)
    arm = slider(tmp_path, mass)
    seen = rollout(Plant(arm, friction=SMOOTH), law, Accelerating(np.array([2.0])), 0.05)
    found = monitor(seen, arm, law)
    factor = 1.0 - 1.5 * weight
    assert found.norm[0] == pytest.approx(abs(factor), rel=1e-12)
    assert found.carried[0, 1:-1] == pytest.approx(abs(factor), rel=1e-8)
    # N_k = (1 − c a) N_{k−1} + (1 − a)(u_{k−1} − u_k), on a joint without load.
    wanted = seen.a_ref + law.ks * (seen.v_ref - seen.v[0]) + law.beta * seen.s[0]
    n, change = found.error[0, :-1, 0], np.diff(wanted[:-1, 0])
    assert n[1:] == pytest.approx(factor * n[:-1] + 0.5 * change, abs=1e-9)


def test_a_low_passed_estimate_begins_with_the_load_that_the_drive_already_holds(tmp_path: Path) -> None:
    """ā = u + N from the first tick on, on a slope: Γ̂ begins at −M̄⁻¹ times the torque that keeps the mass at rest."""
    arm, law = slider(tmp_path, 2.0, 0.3), Dob(mbar=1.5, cutoff_hz=20.0, period=1e-3, **SHARED)
    assert law.estimate_weight < 0.2
    seen = rollout(Plant(arm, friction=SMOOTH), law, Accelerating(np.array([2.0])), 0.01)
    signals = monitor(seen, arm, law).signals
    assert signals is not None
    weight = 2.0 * 9.81 * np.sin(0.3)
    assert signals.estimate[0, 0, 0] == pytest.approx(-weight / 1.5, rel=1e-9)
    wanted = seen.a_ref + law.ks * (seen.v_ref - seen.v[0]) + law.beta * seen.s[0]
    np.testing.assert_allclose(
        np.diff(seen.v[0], axis=0) / 1e-3 - wanted[:-1], signals.error[0, :-1], rtol=0.0, atol=1e-9
    )


def test_the_theorem_says_nothing_of_the_implicit_form_of_its_law(tmp_path: Path) -> None:
    law, arm = law_of("baek2016", mbar=1.5, switching="implicit"), slider(tmp_path, 2.0)
    found = monitor(rollout(Plant(arm, friction=SMOOTH), law, Accelerating(np.array([2.0])), 0.05), arm, law)
    assert found.claim("eq21").status == "not applicable"
    assert "implicit" in found.claim("eq21").reason
    assert found.claim("lemma1").status == "held"


def test_a_law_with_another_estimate_has_no_n_and_the_reason_is_given(tmp_path: Path) -> None:
    law, arm = Adrc(mbar=1.5, observer_hz=50.0, period=1e-3, **SHARED), slider(tmp_path, 2.0)
    found = monitor(rollout(Plant(arm, friction=SMOOTH), law, Accelerating(np.array([2.0])), 0.05), arm, law)
    assert {claim.status for claim in found.claims} == {"not applicable"}
    assert "an estimate of its own in the place of (6)" in found.claim("lemma1").reason
    assert "not for adrc" in found.claim("eq16").reason


class OwnLaw:
    """A law of the user's own: PPC's step, and none of what the package's laws derive from."""

    def __init__(self, law: Ppc) -> None:
        self._law = law
        self.mbar, self.ks, self.beta, self.period = law.mbar, law.ks, law.beta, law.period

    def init(self, seen: Sample) -> Any:
        return self._law.init(seen)

    def step(self, state: Any, seen: Sample, wanted: Any) -> Any:
        return self._law.step(state, seen, wanted)


def test_a_law_that_says_nothing_of_its_estimate_is_judged_by_the_whole_of_it(tmp_path: Path) -> None:
    ppc, arm = Ppc(mbar=1.5, period=1e-3, **SHARED), slider(tmp_path, 2.0)
    seen = rollout(Plant(arm, friction=SMOOTH), OwnLaw(ppc), Accelerating(np.array([2.0])), 0.1)
    own, shipped = monitor(seen, arm, OwnLaw(ppc)), monitor(seen, arm, ppc)
    for name in ("norm", "growth", "carried", "error"):
        np.testing.assert_array_equal(getattr(own, name), getattr(shipped, name), err_msg=name)
    assert own.norm[0, -1] == pytest.approx(0.25)  # |1 − m̄/m|
    assert [claim.status for claim in own.claims] == [claim.status for claim in shipped.claims]


def test_a_law_without_mbar_has_no_gamma_and_the_reason_is_given(arm: Arm) -> None:
    law = PdGravity(arm=arm, period=1e-3, kp=300.0, kd=30.0)
    seen, plant = run(arm, law, seconds=0.05)
    found = monitor(seen, plant, law)
    assert {claim.status for claim in found.claims} == {"not applicable"}
    assert all("PdGravity has no M̄" in found.claim(key).reason for key in BAEK)
    assert np.isnan(found.error).all()


@pytest.mark.parametrize("name", CONTROLLERS)
def test_what_is_proved_for_the_adaptive_law_says_nothing_about_others(arm: Arm, name: str) -> None:
    law = law_of(name)
    seen, plant = run(arm, law, seconds=0.05)
    found = monitor(seen, plant, law)
    for key in ("lemma2", "eq16", "t_eps", "eq21"):
        claim = found.claim(key)
        assert (claim.status == "not applicable") is not law.theorem1
        assert (f"not for {name}" in claim.reason) is not law.theorem1
    judged = {"held", "broken"} if law.estimates else {"not applicable"}
    assert {found.claim(key).status for key in ("lemma1", "contraction")} <= judged


def test_a_law_derived_from_one_of_ours_is_not_taken_for_it(arm: Arm) -> None:
    class Mine(Baek2016):
        pass

    law = Mine(mbar=[0.08, 0.03], period=1e-3, **SHARED, **OWN["baek2016"])
    seen, plant = run(arm, law, seconds=0.05)
    found = monitor(seen, plant, law)
    assert found.claim("eq16").status == "not applicable"
    assert found.signals is not None
    assert not found.signals.shortfall


def test_arms_and_laws_for_another_run_are_refused(arm: Arm) -> None:
    law = law_of("ppc")
    seen, _ = run(arm, law, seconds=0.01)
    with pytest.raises(ParameterError, match="one arm of 2 joints"):
        monitor(seen, load_arm("ur5"), law)
    with pytest.raises(ParameterError, match="one arm of 2 joints"):
        monitor(seen, [arm, arm], law)
    with pytest.raises(ParameterError, match="3 values, the run has 2"):
        monitor(seen, arm, Bsmc(mbar=[1.0, 1.0, 1.0], period=1e-3, gain=1.0, boundary=1.0, **SHARED))
    with pytest.raises(ParameterError, match="known are lemma1"):
        monitor(seen, arm, law).claim("lemma3")
