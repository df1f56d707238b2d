"""Laws that know the model: the error equations that they promise, with an exact model and with a stated error."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plant_cases import Accelerating, Still, Waving, slider

from asmc_pin.arms import Arm, load_arm
from asmc_pin.baselines import BASELINES, MARK, ComputedTorque, PdGravity, baselines_table, knows_model
from asmc_pin.controllers import CONTROLLERS, Ppc, Sample, Setpoint, parameters_of
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.plant import Friction, Plant

Q0 = np.array([0.3, -1.0, 1.2, 0.4, 0.8, 0.2])
GAINS: dict[str, dict[str, Any]] = {
    "computed_torque": {"ks": 8.0, "beta": 12.0},
    "pd_gravity": {"kp": [900.0, 900.0, 500.0, 90.0, 90.0, 20.0], "kd": [90.0, 90.0, 50.0, 9.0, 9.0, 2.0]},
    "slotine_li": {"ks": 8.0, "kd": [90.0, 90.0, 50.0, 9.0, 9.0, 2.0], "rate": 1.0},
}
NO_FRICTION = Friction(0.0, 0.0)


@pytest.fixture(scope="module")
def ur5() -> Arm:
    return load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])


def computed_torque(arm: Arm, period: float = 1e-3, **options: Any) -> ComputedTorque:
    return ComputedTorque(arm=arm, period=period, **GAINS["computed_torque"], **options)


# Exact model


def test_with_an_exact_model_the_torque_is_that_of_inverse_dynamics(ur5: Arm) -> None:
    generator = np.random.default_rng(3)
    q, v, a = generator.uniform(-1.0, 1.0, (3, 5, 6))
    torque, _ = computed_torque(ur5).step(None, Sample(q, v, 0.0 * q), Setpoint(q, v, a))  # no error: s = 0
    assert ur5.forward_dynamics(q, v, torque) == pytest.approx(a, abs=1e-10)


def test_the_error_of_computed_torque_obeys_the_linear_equation_of_ks_and_beta(ur5: Arm) -> None:
    # ë + (k_s + β) ė + β k_s e = 0 from e(0) = e₀ at rest: e = e₀ (β exp(−k_s t) − k_s exp(−β t)) / (β − k_s).
    offset = 0.2 * np.array([1.0, -1.0, 0.5, 1.0, -0.5, 1.0])
    left = []
    for period in (2e-4, 1e-4):
        law = computed_torque(ur5, period)
        run = rollout(Plant(ur5, friction=NO_FRICTION), law, Still(Q0 + offset), 1.0, q0=Q0)
        shape = (12.0 * np.exp(-8.0 * run.time) - 8.0 * np.exp(-12.0 * run.time)) / 4.0
        left.append(np.abs(run.q_ref - run.q[0] - offset * shape[:, None]).max())
    assert left[1] < 2e-3 * np.abs(offset).max()
    assert left[0] / left[1] == pytest.approx(2.0, rel=0.05)  # what is left is the sampling, of first order


def test_friction_in_the_model_takes_friction_of_the_plant_away(ur5: Arm) -> None:
    coulomb, viscous = np.array([8, 8, 5, 2, 2, 1.0]), np.array([2, 2, 2, 0.2, 0.2, 0.1])
    plant, motion = Plant(ur5, friction=Friction(coulomb, viscous)), Waving(Q0)
    without = rollout(plant, computed_torque(ur5), motion, 2.0)
    told = rollout(plant, computed_torque(ur5, coulomb=coulomb, viscous=viscous), motion, 2.0)
    error = [np.sqrt(np.mean((run.q_ref - run.q[0]) ** 2, axis=0)) for run in (without, told)]
    assert np.all(error[1] < 0.1 * error[0])


def test_pd_with_gravity_settles_at_every_standing_reference(ur5: Arm) -> None:
    law = PdGravity(arm=ur5, period=1e-3, **GAINS["pd_gravity"])
    run = rollout(Plant(ur5, friction=NO_FRICTION), law, Still(Q0 + 0.3), 4.0, q0=Q0, v0=np.full(6, 0.2))
    assert np.abs(run.q_ref - run.q[0])[-1].max() < 1e-6


def test_pd_lags_behind_an_accelerating_mass_by_inertia_over_stiffness(tmp_path: Path) -> None:
    arm, a = slider(tmp_path, 2.0), 4.0
    law = PdGravity(arm=arm, period=1e-3, kp=50.0, kd=20.0)
    run = rollout(Plant(arm), law, Accelerating(np.array([a])), 6.0)
    assert (run.q_ref - run.q[0])[-1, 0] == pytest.approx(2.0 * a / 50.0, rel=1e-3)


# Stated errors of the model


def test_a_wrong_mass_leaves_the_error_of_its_share(tmp_path: Path) -> None:
    # m q̈ = c m (q̈_d + K_d ė + K_p e): under constant q̈_d the error stays at (1 − c) q̈_d / (c K_p).
    arm, a, c = slider(tmp_path, 2.0), 4.0, 0.8
    run = rollout(Plant(arm), computed_torque(arm, mass_scale=c), Accelerating(np.array([a])), 6.0)
    assert (run.q_ref - run.q[0])[-1, 0] == pytest.approx((1.0 - c) * a / (c * 8.0 * 12.0), rel=1e-3)


def test_armature_is_known_whatever_the_masses_are_taken_for(ur5: Arm) -> None:
    acceleration = np.eye(6)
    q = np.tile(Q0, (6, 1))
    links = ur5.mass_matrix(Q0) - np.diag(ur5.armature)
    assert computed_torque(ur5, mass_scale=1.3).inertial_torque(q, acceleration) == pytest.approx(
        1.3 * links + np.diag(ur5.armature), rel=1e-12, abs=1e-12
    )


def test_an_unknown_payload_leaves_its_weight_as_the_error_of_a_standing_arm(ur5: Arm) -> None:
    law = PdGravity(arm=ur5, period=1e-3, payload="unknown", **GAINS["pd_gravity"])
    run = rollout(Plant(ur5, friction=NO_FRICTION), law, Still(Q0), 6.0)
    end = run.q[0, -1]
    weight = ur5.gravity(end) - ur5.replace(payload=None).gravity(end)
    assert (run.q_ref - run.q[0])[-1] * law.kp == pytest.approx(weight, abs=1e-6)
    assert np.abs(weight).max() > 1.0


def test_a_model_error_costs_more_than_an_exact_model_and_ppc_knows_neither(ur5: Arm) -> None:
    plant, motion = Plant(ur5, friction=NO_FRICTION), Waving(Q0)

    def rms(law: Any) -> float:
        run = rollout(plant, law, motion, 2.0)
        return float(np.sqrt(np.mean((run.q_ref - run.q[0]) ** 2)))

    exact, light, bare = (rms(computed_torque(ur5, **x)) for x in ({}, {"mass_scale": 0.8}, {"payload": "unknown"}))
    assert exact < 0.1 * light
    assert exact < 0.1 * bare
    ppc = rms(Ppc(mbar=[0.62, 0.88, 0.65, 0.26, 0.21, 0.02], period=1e-3, **GAINS["computed_torque"]))
    assert exact < ppc < min(light, bare)


# What holds for every registered law


@pytest.fixture(params=BASELINES)
def law(request: pytest.FixtureRequest, ur5: Arm) -> Any:
    return BASELINES[request.param](arm=ur5, period=1e-3, **GAINS[request.param])


def batch_of(count: int) -> tuple[Sample, Setpoint]:
    fields = np.random.default_rng(0).uniform(-1.0, 1.0, (6, 7, 6))[:, :count]
    return Sample(*fields[:3]), Setpoint(*fields[3:])


def test_a_trial_gets_the_same_torque_to_the_last_bit_in_any_batch(law: Any) -> None:
    sample, setpoint = batch_of(7)
    whole, _ = law.step(law.init(sample), sample, setpoint)
    for k in range(7):
        row = slice(k, k + 1)
        part = Sample(sample.q[row], sample.v[row], sample.torque[row])
        alone, _ = law.step(law.init(part), part, Setpoint(setpoint.q[row], setpoint.v[row], setpoint.a[row]))
        assert np.array_equal(alone[0], whole[k])


def test_a_diverged_neighbour_touches_nobody(law: Any) -> None:
    sample, setpoint = batch_of(3)
    clean, _ = law.step(law.init(sample), sample, setpoint)
    bad = Sample(sample.q.copy(), sample.v.copy(), sample.torque)
    bad.q[1], bad.v[1] = np.nan, np.inf
    with np.errstate(all="ignore"):
        torque, _ = law.step(law.init(sample), bad, setpoint)
    assert np.array_equal(torque[[0, 2]], clean[[0, 2]])
    assert not np.isfinite(torque[1]).all()


def test_a_copy_in_another_process_gives_the_same_torque(law: Any) -> None:
    sample, setpoint = batch_of(2)
    copy = pickle.loads(pickle.dumps(law))
    torques = [one.step(one.init(sample), sample, setpoint)[0] for one in (copy, law)]
    assert np.array_equal(*torques)


def test_only_baselines_say_that_they_know_the_model() -> None:
    assert all(knows_model(law) for law in BASELINES.values())
    assert not any(knows_model(law) for law in CONTROLLERS.values())
    assert not set(BASELINES) & set(CONTROLLERS)
    assert all(MARK in row["what"] for row in baselines_table())


def test_the_table_lists_every_parameter_but_the_period() -> None:
    for row in baselines_table():
        names = set(parameters_of(BASELINES[row["law"]])) - {"period"}
        assert {item.split(" ")[0] for item in row["own parameters"].split(", ")} >= names
        assert row["equation"].startswith("τ = ")
        assert row["source"]


# Bad input


def test_without_an_arm_the_law_is_checked_but_does_not_run(ur5: Arm) -> None:
    law = ComputedTorque(period=1e-3, **GAINS["computed_torque"])
    sample, setpoint = batch_of(1)
    with pytest.raises(ParameterError, match="with_arm"):
        law.init(sample)
    torque = law.with_arm(ur5).step(None, sample, setpoint)[0]
    assert np.array_equal(torque, computed_torque(ur5).step(None, sample, setpoint)[0])


def test_parameters_for_another_arm_are_refused(ur5: Arm) -> None:
    law = PdGravity(period=1e-3, kp=[1.0, 2.0], kd=3.0)
    with pytest.raises(ParameterError, match="ur5 has 6 joints, the law's parameters are for 2"):
        law.with_arm(ur5)
    with pytest.raises(ParameterError, match=r"expected \(batch, 6\)"):
        computed_torque(ur5).init(Sample(*np.zeros((3, 1, 2))))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"mass_scale": 0.0}, "mass_scale: got 0.0; it must be above 0"),
        ({"mass_scale": math.nan}, "mass_scale"),
        ({"payload": "unkown"}, "did you mean 'unknown'"),
        ({"ks": -1.0}, "ks: .* must be above 0 1/s"),
        ({"coulomb": -1.0}, "at least 0"),
        ({"arm": "ur5"}, "expected an Arm"),
    ],
)
def test_a_wrong_parameter_is_named(change: dict[str, Any], text: str) -> None:
    with pytest.raises(ParameterError, match=text):
        ComputedTorque(**({"period": 1e-3, **GAINS["computed_torque"]} | change))
