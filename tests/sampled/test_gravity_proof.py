"""Gravity at rest as a spring: the bound of it, and the small gain that keeps the frozen loop stable."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from condition_cases import chain, chain_urdf

from asmc_pin import SampledLoop, certify_loop, check, load_arm
from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.balls.gravity_gain import small_gain_holds, stiffness_in_balls
from asmc_pin.condition.checker.reading.urdf_text import description
from asmc_pin.sampled import spectral_radius
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.proof.gravity_proof import GravityForms, pieces_of, stiffness_bound

pytestmark = pytest.mark.xdist_group("test_gravity_proof")  # they share what `cache` keeps

LOOPS = [(20.0, 20.0, 1e-3, 0.05, 1.2), (5.0, 40.0, 2e-3, 0.2, 1.6), (1.0, 200.0, 1e-3, 0.03, 1.1)]


@cache
def _most(ks: float, beta: float, period: float, low: float, high: float) -> float:
    """The largest spring for which there are forms, by bisection."""
    least, most = 1e-3, 2.0 / (high * period**2)
    for _ in range(18):
        middle = float(np.sqrt(least * most))
        found = pieces_of(ks, beta, period, middle, low, high) is not None
        least, most = (middle, most) if found else (least, middle)
    return least


def _file(ks: float, beta: float, period: float) -> Any:
    return SimpleNamespace(ks=ks, beta=beta, period=period)


def _said(pieces: GravityForms) -> Any:
    rows = pieces.forms.reshape(-1, 9)[:, [0, 1, 2, 4, 5, 8]].tolist()
    return SimpleNamespace(ends=tuple(pieces.ends.tolist()), forms=tuple(map(tuple, rows)))


def _springs(rng: np.random.Generator, n: int, size: float) -> Array:
    """Symmetric matrices of that norm: any, of one sign, and of rank one."""
    A = rng.normal(size=(30, n, n))
    A = A + np.swapaxes(A, 1, 2)
    v = rng.normal(size=(30, n))
    signs = rng.choice([-1.0, 1.0], size=(30, 1, 1))
    found = np.concatenate((A, v[:, :, None] * v[:, None, :] * signs, np.stack((np.eye(n), -np.eye(n)))))
    return np.asarray(size * found / np.linalg.norm(found, ord=2, axis=(1, 2))[:, None, None])


@pytest.mark.parametrize("which", range(len(LOOPS)))
def test_no_spring_up_to_the_bound_makes_a_loop_unstable_however_it_lies_to_the_inertia(which: int) -> None:
    ks, beta, period, low, high = LOOPS[which]
    size = _most(ks, beta, period, low, high)
    rng = np.random.default_rng(which)
    worst = 0.0
    for n in (1, 2, 4):
        springs = _springs(rng, n, size)
        basis, _ = np.linalg.qr(rng.normal(size=(len(springs), n, n)))
        values = np.exp(rng.uniform(np.log(low), np.log(high), (len(springs), n)))
        values[:, 0] = np.where(rng.random(len(springs)) < 0.5, low, high)
        mass = (basis / values[:, None, :]) @ np.swapaxes(basis, 1, 2)
        mass = 0.5 * (mass + np.swapaxes(mass, 1, 2))
        loop = SampledLoop(np.ones(n), ks, beta, period)
        worst = max(worst, float(spectral_radius(mass, loop, stiffness=springs).max()))
    assert worst < 1.0


@pytest.mark.parametrize(("which", "price"), [(0, 6.0), (1, 6.0), (2, 100.0)])
def test_one_joint_really_bears_more_than_the_small_gain_by_a_factor_that_is_known(which: int, price: float) -> None:
    ks, beta, period, low, high = LOOPS[which]
    size = _most(ks, beta, period, low, high)
    loop = SampledLoop(np.ones(1), ks, beta, period)
    modes = np.geomspace(low, high, 40)
    mass = (1.0 / modes)[:, None, None]
    factors = np.geomspace(1.0, 100.0, 60)
    unstable = [
        factor
        for factor in factors
        if spectral_radius(mass, loop, stiffness=-factor * size * np.ones((40, 1, 1))).max() >= 1.0
    ]
    assert unstable
    assert 1.0 < unstable[0] < price


@pytest.mark.parametrize("which", range(len(LOOPS)))
def test_the_checker_takes_these_forms_for_this_loop_and_for_no_stronger_spring(which: int) -> None:
    ks, beta, period, low, high = LOOPS[which]
    size = 0.98 * _most(ks, beta, period, low, high)
    pieces = pieces_of(ks, beta, period, size, low, high)
    assert pieces is not None
    assert pieces.ends[0] == low
    assert pieces.ends[-1] == high
    said = _said(pieces)
    assert small_gain_holds(_file(ks, beta, period), said, size)
    assert not small_gain_holds(_file(ks, beta, period), said, 1.5 * size)
    assert not small_gain_holds(_file(ks, 50.0 * beta, period), said, size)
    assert not small_gain_holds(_file(ks, beta, 30.0 * period), said, size)
    wider = SimpleNamespace(ends=(*said.ends[:-1], 1.9 * said.ends[-1]), forms=said.forms)
    assert not small_gain_holds(_file(ks, beta, period), wider, size)
    turned = SimpleNamespace(ends=said.ends, forms=tuple(tuple(-x for x in row) for row in said.forms))
    assert not small_gain_holds(_file(ks, beta, period), turned, size)


@pytest.mark.parametrize("seed", range(10))
def test_gravity_s_spring_stays_below_its_bound_in_either_arithmetic(seed: int, tmp_path: Path) -> None:
    joints = 1 + seed % 5
    slides = seed % 2 == 1
    arm = chain(tmp_path, seed, joints, prismatic=slides)
    rng = np.random.default_rng(seed)
    lower, upper = arm.box
    mbar = 10.0 ** rng.uniform(-2.0, 0.0, joints)
    floats = stiffness_bound(arm.tree, lower, upper, mbar, 9.81)
    balls = BallArm(description(chain_urdf(seed, joints, slides)), [f"j{i}" for i in range(joints)], {}, None)
    enclosed = stiffness_in_balls(balls, lower.tolist(), upper.tolist(), mbar.tolist(), 9.81)
    assert enclosed <= floats <= enclosed * (1.0 + 1e-6)
    root = 1.0 / np.sqrt(mbar)
    for _ in range(3):
        direction = rng.normal(size=3)
        turned = arm.replace(gravity=9.81 * direction / np.linalg.norm(direction))
        q = rng.uniform(lower, upper, (300, joints))
        seen = np.linalg.norm(gravity_stiffness(turned, q) * root * root[:, None], ord=2, axis=(1, 2)).max()
        assert seen <= floats


def test_a_loop_proven_under_gravity_is_stable_at_rest_in_any_mounting(tmp_path: Path) -> None:
    arm = load_arm("ur5")
    mbar = 0.8 * np.array([0.1483264, 0.1674553, 0.1504278, 0.0810652, 0.0933441, 0.0171369])
    loop = SampledLoop(mbar, 10.0, 10.0, 1e-3)
    proof = certify_loop(arm, loop, armature=[(0.1, 0.3)] * 6, payload=(0.0, 2.0))
    assert proof.gravity == pytest.approx(9.81)
    found = check(proof.save(tmp_path / "loop.cert"))
    assert found.valid, found.problems
    assert "about rest at every q under gravity of up to 9.81 m/s²" in str(found)
    rng = np.random.default_rng(0)
    for gravity, load, armature in (([0, 0, -9.81], 2.0, 0.1), ([0, 9.81, 0], 1.0, 0.3), ([0, 0, 9.81], None, 0.2)):
        placed = arm.replace(gravity=gravity, payload=load, armature=armature)
        q = rng.uniform(*arm.box, (300, 6))
        stiffness = gravity_stiffness(placed, q)
        assert spectral_radius(placed.mass_matrix(q), loop, stiffness=stiffness).max() < 1.0


def test_where_gravity_wins_nothing_is_proven_of_it(tmp_path: Path) -> None:
    # Gains of the paper's Section III: stable by inertia alone, and the upright arm falls away.
    arm = load_arm("two_link")
    loop = SampledLoop(np.full(2, 0.01), 1.0, 1.0, 1e-3)
    proof = certify_loop(arm, loop)
    assert proof.verdict == "stable"
    assert proof.gravity is None
    assert any("of gravity nothing is proven" in line for line in proof.lines())
    found = check(proof.save(tmp_path / "loop.cert"))
    assert (found.valid, found.verdict) == (True, "stable")
    assert "under gravity it proves nothing" in str(found)
