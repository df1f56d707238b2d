"""Claims about energy and the order of the time-stepping schemes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from asmc_pin.arms import load_arm
from asmc_pin.plant import Friction, Plant


def energy(arm, q, v):
    """Kinetic and potential energy of a batch of states, J."""
    data = arm.model.createData()
    return np.array([pin.computeMechanicalEnergy(arm.model, data, x, y) for x, y in zip(q, v, strict=True)])


def coast(arm, q, v, duration, ticks, friction=None, substeps=1):
    """States of a torque-free motion at every tick, and friction's mean torque over each."""
    motion = Plant(arm, substeps=substeps, friction=friction or Friction(), start="relaxed").begin(
        q, v, duration / ticks
    )
    states, frictions = [(q, v)], []
    for _ in range(ticks):
        frictions.append(motion.advance())
        states.append((motion.q, motion.v))
    return states, frictions


def slope_of(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


START = np.array([[0.4, 0.9]]), np.array([[-1.0, 2.0]])


def test_a_free_two_link_conserves_energy_to_the_first_order_of_the_step():
    arm = load_arm("two_link")
    ticks = np.array([250, 500, 1000, 2000])
    drifts = []
    for n in ticks:
        states, _ = coast(arm, *START, 0.5, int(n))
        energies = np.concatenate([energy(arm, *state) for state in states])
        drifts.append(np.abs(energies - energies[0]).max())
    assert slope_of(1.0 / ticks, drifts) == pytest.approx(1.0, abs=0.15)
    assert drifts[-1] < 0.02 * np.ptp([0.5 * v[0] @ arm.mass_matrix(q)[0] @ v[0] for q, v in states])


def test_a_free_two_link_is_followed_to_the_first_order_of_the_step():
    arm = load_arm("two_link")
    end = [coast(arm, *START, 0.5, n)[0][-1][0] for n in (500, 1000, 2000, 4000)]
    # Between one step and its half: no reference needed that would share the error.
    gaps = [np.abs(a - b).max() for a, b in pairwise(end)]
    assert slope_of([1.0, 0.5, 0.25], gaps) == pytest.approx(1.0, abs=0.15)


def test_without_velocity_dependent_forces_the_scheme_is_of_second_order_and_its_energy_does_not_drift():
    arm = load_arm("two_link", lock={"joint_2": 0.3})  # a pendulum: constant inertia
    q, v = np.array([[0.4]]), np.array([[-1.0]])
    end = [coast(arm, q, v, 0.5, n)[0][-1][0] for n in (100, 200, 400, 800)]
    gaps = [np.abs(a - b).max() for a, b in pairwise(end)]
    assert slope_of([1.0, 0.5, 0.25], gaps) == pytest.approx(2.0, abs=0.1)

    energies = np.concatenate([energy(arm, *state) for state in coast(arm, q, v, 60.0, 12000)[0]])
    early, late = np.abs(energies[:1000] - energies[0]).max(), np.abs(energies[-1000:] - energies[0]).max()
    assert late < 1.5 * early


def test_friction_only_takes_energy_and_takes_all_of_it():
    arm = load_arm("ur5", gravity=(0.0, 0.0, 0.0))
    rng = np.random.default_rng(3)
    q, v = rng.uniform(-2.0, 2.0, (5, 6)), rng.normal(0.0, 1.0, (5, 6))
    states, _ = coast(arm, q, v, 4.0, 800, Friction(3.0, 0.5))
    kinetic = np.array([energy(arm, *state) for state in states])
    assert np.all(np.diff(kinetic, axis=0) <= 0.0)
    assert np.all(kinetic[-1] == kinetic[-1, 0]), "at rest, exactly"
    np.testing.assert_array_equal(states[-1][1], 0.0)


def test_the_logged_friction_accounts_for_the_energy_that_is_lost_to_the_order_of_the_step():
    arm = load_arm("ur5")
    q, v = np.array([[0.3, -1.0, 1.2, 0.4, 0.8, 0.2]]), np.array([[1.0, -0.5, 0.8, 1.5, -1.0, 2.0]])
    gaps = []
    ticks = np.array([100, 200, 400, 800])
    for n in ticks:
        states, frictions = coast(arm, q, v, 0.2, int(n), Friction([4.0, 4.0, 3.0, 1.0, 1.0, 0.5], 0.3))
        work = sum(
            float(np.sum(f * (after[0] - before[0])))
            for f, before, after in zip(frictions, states[:-1], states[1:], strict=True)
        )
        lost = energy(arm, *states[-1])[0] - energy(arm, *states[0])[0]
        assert work < 0.0
        gaps.append(abs(lost - work))
    assert slope_of(1.0 / ticks, gaps) > 0.9
    assert gaps[-1] < 5e-3 * abs(work)
