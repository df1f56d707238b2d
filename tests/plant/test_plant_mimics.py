"""Arms with joints that mimic others move in the plant as the dynamics of their driven joints say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import write
from coupled_urdf import WIDE, coupled_tree, gripper, mimic, parallelogram
from plant_cases import Waving

from asmc_pin.arms import load_arm
from asmc_pin.controllers import Ppc
from asmc_pin.engine import rollout
from asmc_pin.plant import Disturbance, Friction, Plant, Spread
from asmc_pin.plant.energy import energy_balance, mechanical_energy
from asmc_pin.plant.free_dynamics import FreeDynamics
from asmc_pin.plant.world.spread import vary_links


def test_the_plant_accelerates_as_the_arm_says_whoever_its_neighbours_are(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, coupled_tree(np.random.default_rng(4), joints=6, followers=2)), armature=0.1)
    heavy = arm.replace(payload={"mass": 2.0, "link": "l4"})
    q, v, torque = np.random.default_rng(5).uniform(-1.0, 1.0, (3, 6, arm.nv))
    arms = [arm, heavy, arm, arm, heavy, heavy]
    found = FreeDynamics(arms, 6, 1).acceleration(q, v, torque)
    for k, one in enumerate(arms):
        assert found[k] == pytest.approx(one.forward_dynamics(q[k], v[k], torque[k]), rel=1e-9, abs=1e-9)
        alone = FreeDynamics([one], 1, 1).acceleration(q[k : k + 1], v[k : k + 1], torque[k : k + 1])
        assert np.array_equal(alone[0], found[k])
    together = FreeDynamics([arm], 32, 2).acceleration(*(np.tile(x, (6, 1))[:32].copy() for x in (q, v, torque)))
    assert np.array_equal(together[0], found[0])


def test_a_free_coupled_arm_keeps_its_energy(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, coupled_tree(np.random.default_rng(6), joints=5, followers=2)))
    q, v = np.full((1, arm.nv), 0.2), np.full((1, arm.nv), 0.8)
    plant = Plant(arm, substeps=1, integrator="rk4", friction=Friction(), start="relaxed")
    motion = plant.begin(q, v, 5e-4)
    first = mechanical_energy(arm, q, v)
    for _ in range(400):
        motion.advance()
    moved = np.abs(motion.q - q).max()
    assert moved > 0.1
    assert mechanical_energy(arm, motion.q, motion.v) == pytest.approx(first, abs=1e-6 * np.abs(first).max())


def test_energy_of_a_controlled_gripper_is_accounted_for(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()), armature=[0.1, 0.02, 0.5])
    law = Ppc(mbar=[0.1, 0.02, 0.5], ks=8.0, beta=8.0, period=1e-3)
    push = Disturbance(profile="step", link="right", force=[0.0, 1.0, 2.0])
    plant = Plant(arm, friction=Friction([0.1, 0.05, 0.2], 0.3), effort_limit=np.inf, disturbances=[push])
    reference = Waving(np.array([0.2, 0.1, 0.02]), 0.01)
    run = rollout(plant, law, reference, 1.0, q0=reference.q)
    assert run.status == ("ok",)
    balance = energy_balance(plant, run)
    assert np.abs(balance.residual).max() < 0.02 * balance.turnover.max()
    assert np.abs(run.q - run.q_ref).max() < 0.01


def test_friction_of_a_mimicking_joint_slows_the_driven_one(tmp_path: Path) -> None:
    text = parallelogram().replace(
        mimic("lift", -1.0), mimic("lift", -1.0, before=WIDE + '<dynamics damping="0.7" friction="1.5"/>')
    )
    arm = load_arm(write(tmp_path, text), gravity=(0.0, 0.0, 0.0))
    motion = Plant(arm, substeps=1, start="relaxed", integrator="midpoint").begin(
        np.zeros((1, 1)), np.full((1, 1), 2.0), 1e-3
    )
    inertia = arm.mass_matrix([0.0])[0, 0]
    for _ in range(200):
        motion.advance()
    # J dv/dt = -1.5 - 0.7 v
    expected = (2.0 + 1.5 / 0.7) * np.exp(-0.7 * 0.2 / inertia) - 1.5 / 0.7
    assert motion.v[0, 0] == pytest.approx(expected, rel=1e-6)


def test_links_of_a_coupled_arm_scatter_one_by_one(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()))
    drawn = Spread(mass=0.2).arms((arm,), 1, [0])[0]
    assert drawn.tree.joints == 4
    assert np.all(drawn.tree.mass != arm.tree.mass)
    assert drawn.mass_matrix([0.1, 0.2, 0.01])[2, 2] == pytest.approx(drawn.tree.mass[2] + drawn.tree.mass[3])
    light, heavy = Spread(mass=0.1).ends(arm)
    assert light.tree.mass.sum() < arm.tree.mass.sum() < heavy.tree.mass.sum()
    one = np.array([1.0, 1.0, 1.0, 2.0])
    assert vary_links(arm, one, np.zeros((4, 3)), np.ones((4, 3))).tree.mass[3] == pytest.approx(0.24)
