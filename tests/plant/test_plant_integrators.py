"""Claims about the time-stepping schemes: each has the order that it claims, and none makes a resting joint creep."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from paths import DOCS
from plant_cases import OpenLoop, Still, slider

from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.plant import INTEGRATORS, ORDERS, Disturbance, EndStops, Friction, Plant

Q = np.array([[0.3, -1.0, 1.2, 0.4, 0.8, 0.2]])
V = np.array([[0.8, -0.6, 0.9, 1.5, -1.2, 2.0]])
LEVEL = np.array([2.0, 2.0, 1.5, 0.1, 0.1, 0.02])
FRICTION = Friction(LEVEL, 0.1 * LEVEL, breakaway=1.6 * LEVEL, stribeck_velocity=0.5)


def end_of(integrator, steps, arm="ur5", q=Q, v=V, friction=FRICTION, duration=0.08, **options):
    plant = Plant(load_arm(arm), substeps=steps, friction=friction, integrator=integrator, **options)
    motion = plant.begin(q, v, duration)
    motion.apply(motion.torque)
    motion.advance()
    assert np.all(np.sign(motion.v) == np.sign(v)), "no joint may turn, or the order is that of the events"
    return np.concatenate([motion.q, motion.v])


def order(ends):
    """From the gaps between one step and its half: no reference needed that would share the error."""
    gaps = [np.abs(a - b).max() for a, b in pairwise(ends)]
    return np.polyfit(-np.log(2.0) * np.arange(len(gaps)), np.log(gaps), 1)[0]


def test_every_scheme_claims_an_order_that_is_measured_here():
    assert set(ORDERS) == set(INTEGRATORS)


@pytest.mark.parametrize("friction", [Friction(), FRICTION], ids=["frictionless", "sliding"])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_scheme_has_the_order_that_it_claims(integrator, friction):
    first = 16 if ORDERS[integrator] < 4 else 6
    ends = [end_of(integrator, first * 2**i, friction=friction) for i in range(5)]
    assert order(ends) == pytest.approx(ORDERS[integrator], abs=0.2)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_all_schemes_come_to_the_same_motion(integrator):
    exact = end_of("rk4", 400)
    gap = np.abs(end_of(integrator, 1600) - exact).max()
    assert gap < {1: 2e-4, 2: 5e-8, 4: 1e-11}[ORDERS[integrator]]


@pytest.mark.parametrize("integrator", ["midpoint", "rk4"])
def test_the_guide_of_the_docs_is_right_about_cost_and_error(integrator):
    """Per evaluation of the dynamics, the higher order pays at a step of 1 ms already."""
    exact = end_of("rk4", 1000)
    evaluations = {"semi_implicit": 1, "midpoint": 2, "rk4": 4}
    cheap = np.abs(end_of("semi_implicit", 160) - exact).max()
    same_cost = np.abs(end_of(integrator, 160 // evaluations[integrator]) - exact).max()
    assert same_cost < 0.1 * cheap


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_no_scheme_lets_a_resting_arm_creep(integrator):
    arm = load_arm("ur5")
    load = np.abs(arm.gravity(Q))
    plant = Plant(arm, substeps=1, friction=Friction(1.000001 * load + 1e-9), start="relaxed", integrator=integrator)
    motion = plant.begin(Q.copy(), np.zeros_like(Q), 0.02)
    for _ in range(3000):  # 60 s
        friction = motion.advance()
    np.testing.assert_array_equal(motion.q, Q)
    np.testing.assert_array_equal(motion.v, 0.0)
    np.testing.assert_allclose(friction, arm.gravity(Q), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_through_stops_and_starts_every_scheme_comes_to_the_same_motion(integrator, tmp_path):
    arm = slider(tmp_path, 2.0)

    def at(scheme, substeps):
        plant = Plant(arm, substeps=substeps, friction=Friction(3.0, 0.5), integrator=scheme, start="relaxed")
        law = OpenLoop(lambda t: 6.0 * np.sin(9.0 * t), 1e-3)
        return rollout(plant, law, Still(np.zeros(1)), 1.0)

    exact = at("midpoint", 24)
    assert np.mean(exact.v == 0.0) > 0.02
    gaps = [np.abs(at(integrator, n).q - exact.q).max() for n in (1, 6)]
    assert gaps[0] < 2e-4
    assert gaps[1] < 0.3 * gaps[0]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_trial_has_the_same_bits_in_any_batch_with_every_scheme(integrator):
    rng = np.random.default_rng(4)
    q, v = Q + rng.uniform(-0.1, 0.1, (4, 6)), rng.normal(0.0, 0.3, (4, 6)) * (rng.random((4, 6)) < 0.6)
    options = {
        "friction": Friction(2.0, 0.3, breakaway=2.5),
        "integrator": integrator,
        "end_stops": EndStops(),
        "disturbances": [Disturbance(profile="noise", torque=3.0, frequency=20.0)],
        "seed": 5,
    }
    plant = Plant(load_arm("ur5"), **options)

    def play(trials):
        motion = plant.begin(q[trials].copy(), v[trials].copy(), 1e-3, trials)
        for _ in range(40):
            friction = motion.advance()
        return np.stack([motion.q, motion.v, friction, motion.external])

    together = play([0, 1, 2, 3])
    for trials in ([2], [3, 0]):
        np.testing.assert_array_equal(play(trials), together[:, trials])


def test_the_docs_name_every_scheme_with_its_order():
    text = (DOCS / "plant.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (\d)", text, re.MULTILINE))
    assert {name: int(rows[name]) for name in INTEGRATORS} == ORDERS
