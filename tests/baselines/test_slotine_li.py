"""Slotine and Li's adaptive law: its regressor, its Lyapunov function, and what it learns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plant_cases import Waving

from asmc_pin import load_arm
from asmc_pin.baselines import SlotineLi
from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant

Q0 = np.array([-1.2, 0.3])


@pytest.mark.parametrize("name", ["two_link", "ur5", "panda"])
def test_the_regressor_in_two_velocities_is_linear_in_the_arms_parameters(name: str) -> None:
    arm = load_arm(name, armature=0.2)
    q, v, v_r, a_r = np.random.default_rng(1).standard_normal((4, 5, arm.nv))
    wanted = np.einsum("...ij,...j", arm.mass_matrix(q), a_r)
    wanted += np.einsum("...ij,...j", arm.coriolis(q, v), v_r) + arm.gravity(q)
    found = arm.regressor(q, v, v_r, a_r) @ arm.inertial_parameters
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-12 * np.abs(wanted).max())


class Watched:
    """The law, with what it believed at each tick."""

    def __init__(self, law: SlotineLi) -> None:
        self.law, self.period, self.ks = law, law.period, law.ks
        self.believed: list[np.ndarray] = []

    def init(self, sample: Any) -> Any:
        return self.law.init(sample)

    def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
        torque, state = self.law.step(state, sample, setpoint)
        self.believed.append(state.parameters[0].copy())
        return torque, state


def rise_of_v(period: float) -> tuple[float, float, float]:
    """How much V rises altogether in a run with parameters 40 % too small, V at its start, and the share learned."""
    arm = load_arm("two_link")
    law = Watched(SlotineLi(arm=arm, period=period, ks=8.0, kd=20.0, rate=2.0, mass_scale=0.6))
    run = rollout(Plant(arm, friction=Friction(), substeps=1), law, Waving(Q0), 2.0)
    assert run.status == ("ok",)
    s = run.s[0]
    missing = np.array(law.believed) - arm.inertial_parameters
    kinetic = 0.5 * np.einsum("ti,tij,tj->t", s, arm.mass_matrix(run.q[0]), s)
    v = kinetic[1:] + 0.5 * np.sum(missing[:-1] ** 2, axis=1) / law.law.rate
    return float(np.maximum(np.diff(v), 0.0).sum()), float(v[0]), float(v[-1] / v[0])


def test_v_rises_by_no_more_than_what_sampling_adds_and_falls_on_the_whole() -> None:
    coarse, start, left = rise_of_v(2e-3)
    fine, _, _ = rise_of_v(1e-3)
    assert left < 0.99
    assert coarse < 1e-4 * start
    assert fine < 0.6 * coarse


def test_learning_reduces_the_error_of_a_wrong_model() -> None:
    arm = load_arm("two_link")
    errors = []
    for rate in (0.0, 5.0):
        law = SlotineLi(arm=arm, period=1e-3, ks=8.0, kd=20.0, rate=rate, mass_scale=0.6)
        run = rollout(Plant(arm, friction=Friction()), law, Waving(Q0), 3.0)
        errors.append(np.abs(run.s[0, -500:]).max())
    assert errors[1] < 0.5 * errors[0]
