"""Energy balance on every arm: stored + dissipated = supplied, and where each part comes from."""

from __future__ import annotations

import numpy as np
import pytest
from plant_cases import OpenLoop, Still, Waving, slider

from asmc_pin.arms import arm_names, load_arm
from asmc_pin.engine import rollout
from asmc_pin.plant import Disturbance, Drive, EndStops, Friction, PayloadChange, Plant, Spread
from asmc_pin.plant.energy import energy_balance, mechanical_energy, stored_energy

L = 1e-3
# Of the energy that has changed hands. semi_implicit is of first order, the others lose it in the means over a period.
TOLERANCE = {"semi_implicit": 5e-3, "midpoint": 2e-4, "rk4": 2e-4}


def swing(arm, integrator, duration=0.3, **options):
    """An open-loop motion about the middle of the joints' ranges, gravity held, so that nothing needs tuning."""
    lower, upper = np.maximum(arm.lower, -1.0), np.minimum(arm.upper, 1.0)
    q0 = 0.5 * (lower + upper)
    scale = np.diag(arm.mass_matrix(q0))
    hold = arm.gravity(q0)
    law = OpenLoop(lambda t: hold + 20.0 * scale * np.sin(2 * np.pi * (4.0 + np.arange(arm.nv)) * t), L)
    friction = options.pop("friction", Friction(0.5 * scale, 0.5 * scale, breakaway=0.7 * scale))
    plant = Plant(arm, integrator=integrator, friction=friction, effort_limit=np.inf, **options)
    return plant, rollout(plant, law, Still(q0), duration)


@pytest.mark.parametrize("integrator", TOLERANCE)
@pytest.mark.parametrize("name", arm_names())
def test_stored_and_dissipated_energy_is_what_the_drives_supplied(name, integrator):
    plant, run = swing(load_arm(name), integrator)
    assert run.status == ("ok",)
    balance = energy_balance(plant, run)
    assert balance.dissipated[0, -1] > 0.0
    assert np.all(np.diff(balance.dissipated) >= -1e-6 * balance.turnover[0, -1])
    assert np.abs(balance.residual).max() < TOLERANCE[integrator] * balance.turnover[0, -1]


@pytest.mark.parametrize("name", ["ur5", "kinova"])
def test_the_balance_closes_with_delay_current_loop_push_and_payload(name):
    arm = load_arm(name)
    plant, run = swing(
        arm,
        "midpoint",
        drive=Drive(delay=0.6, current_hz=300.0),
        disturbances=[
            Disturbance(profile="sine", torque=2.0, frequency=11.0),
            Disturbance(profile="pulse", link=arm.link_names[-1], force=[5.0, 3.0, -8.0], start=0.05, duration=0.1),
        ],
        payload_changes=[PayloadChange(time=0.15, payload=0.5)],
    )
    balance = energy_balance(plant, run)
    assert np.abs(balance.external[0, -1]) > 1e-3
    assert balance.added[0, -1] != 0.0
    assert np.abs(balance.residual).max() < 2e-3 * balance.turnover[0, -1]


def test_a_payload_brings_the_energy_that_it_has_where_and_as_fast_as_it_is_when_it_is_taken_up():
    arm = load_arm("two_link")
    plant, run = swing(arm, "midpoint", payload_changes=[PayloadChange(time=0.15, payload=0.5)])
    k, loaded = 150, arm.replace(payload=0.5)
    here = run.q[0, k : k + 1], run.v[0, k : k + 1]
    brought = mechanical_energy(loaded, *here) - mechanical_energy(arm, *here)
    added = energy_balance(plant, run).added[0]
    assert np.abs(run.v[0, k]).max() > 0.1, "it moves"
    assert np.all(added[:k] == 0.0)
    np.testing.assert_allclose(added[k:] / brought, 1.0, rtol=1e-12)


def test_the_kinetic_energy_is_that_of_the_mass_matrix_armature_included():
    arm = load_arm("ur5", armature=0.3, payload=2.0)
    q, v = np.random.default_rng(1).normal(0.0, 1.0, (2, 4, 6))
    kinetic = mechanical_energy(arm, q, v) - mechanical_energy(arm, q, 0.0 * v)
    np.testing.assert_allclose(kinetic, 0.5 * np.einsum("bi,bij,bj->b", v, arm.mass_matrix(q), v), rtol=1e-12)


def test_what_a_run_stores_is_the_energy_of_each_trials_own_arm(tmp_path):
    arm = slider(tmp_path, 2.0)
    plant = Plant(arm, friction=Friction(), spread=Spread(mass=0.3), start="relaxed")
    run = rollout(plant, OpenLoop(lambda t: 0.0, L), Still(np.zeros(1)), 0.05, v0=[0.7], batch=2)
    own = [each.mass_matrix(np.zeros(1))[0, 0] for each in plant.for_trials(range(2)).arms]
    assert own[0] != own[1]
    expected = 0.5 * np.array(own)[:, None] * run.v[:, :, 0] ** 2
    np.testing.assert_allclose(stored_energy(plant, run), expected, rtol=1e-12)
    np.testing.assert_allclose(stored_energy(plant, run, (1, 0)), expected * [[own[1] / own[0]], [own[0] / own[1]]])


def test_a_wrong_account_of_friction_would_be_seen():
    plant, run = swing(load_arm("ur5"), "midpoint")
    balance = energy_balance(plant, run)
    assert balance.dissipated[0, -1] > 20 * TOLERANCE["midpoint"] * balance.turnover[0, -1]


def test_energy_in_undamped_stops_comes_back(tmp_path):
    arm = slider(tmp_path, 2.0)
    plant = Plant(
        arm, friction=Friction(), end_stops=EndStops(stiffness=2e4, damping=0.0), substeps=20, error_bound=1e6
    )
    run = rollout(plant, OpenLoop(lambda t: 0.0, L), Still(np.zeros(1)), 0.5, q0=[999.5], v0=[2.0])
    balance = energy_balance(plant, run)
    assert np.abs(balance.residual).max() < 1e-3 * 4.0
    assert mechanical_energy(arm, run.q, run.v).min() < 0.1


def test_the_residual_falls_with_the_step():
    residuals = []
    for substeps in (1, 4):
        plant, run = swing(load_arm("ur5"), "semi_implicit", substeps=substeps)
        residuals.append(np.abs(energy_balance(plant, run).residual).max())
    assert residuals[1] < 0.4 * residuals[0]


def test_energy_after_a_divergence_is_not_a_number():
    arm = load_arm("two_link")
    law = OpenLoop(lambda t: np.full(2, np.nan if t > 0.05 else 1.0), L)
    run = rollout(Plant(arm), law, Waving(np.zeros(2)), 0.1)
    energy = mechanical_energy(arm, run.q, run.v)
    assert np.isfinite(energy[0, :51]).all()
    assert np.isnan(energy[0, 52:]).all()
