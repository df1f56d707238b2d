"""Bounds of M(q), of its condition number and of the velocity forces: against exact arms, samples and known figures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from certificate_cases import random_box, random_tree
from condition_cases import chain, chain_urdf

from asmc_pin import BoundsReport, bounds, check, load_arm
from asmc_pin.arms import Arm
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.balls.velocity_forces import velocity_forces_in_balls
from asmc_pin.condition.checker.reading.urdf_text import description
from asmc_pin.condition.inertia_bounds.seen import christoffel
from asmc_pin.condition.inertia_bounds.velocity_force_bound import velocity_force_bound
from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.rigid_body.mass_matrix import mass_matrices

LENGTH, MASS = 0.7, 1.3
PENDULUMS = f"""<robot name="two_points"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/></joint>
<link name="l1"><inertial><origin xyz="{LENGTH} 0 0"/><mass value="{MASS}"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="{LENGTH} 0 0"/>
<axis xyz="0 1 0"/></joint>
<link name="l2"><inertial><origin xyz="{LENGTH} 0 0"/><mass value="{MASS}"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
"""Two equal point masses at the ends of two equal rods in a plane: all of it is known in closed form."""


@pytest.fixture(scope="module")
def ur5() -> BoundsReport:
    return bounds(load_arm("ur5", armature=0.1), gap=0.004)


@pytest.fixture(scope="module")
def ur5_certificate(ur5: BoundsReport, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return ur5.save(tmp_path_factory.mktemp("bounds") / "ur5.cert")


def _contradictions(report: BoundsReport, arms: list[Arm], seed: int = 0) -> list[str]:
    rng = np.random.default_rng(seed)
    lower, upper = np.array(list(report.about.box.values())).T
    found = []
    for arm in arms:
        q = rng.uniform(lower, upper, (2000, arm.nv))
        values = np.linalg.eigvalsh(arm.mass_matrix(q) * report.scaling * report.scaling[:, None])
        x = rng.normal(size=q.shape)
        x /= np.linalg.norm(x, axis=1)[:, None]
        forces = report.scaling * (arm.bias(q, report.scaling * x) - arm.gravity(q))
        seen = {
            "lower": values.min() > report.lower.proven,
            "upper": values.max() < report.upper.proven,
            "ratio": (values[:, -1] / values[:, 0]).max() < report.condition_number.proven,
            "forces": np.linalg.norm(forces, axis=1).max() < report.coriolis.proven,
        }
        found += [name for name, good in seen.items() if not good]
    return found


# Known figures ------------------------------------------------------------------------------------------------------


def test_the_ends_of_the_ur5_are_those_that_were_found_before_by_other_means(ur5: BoundsReport) -> None:
    assert ur5.lower.found == pytest.approx(0.115824, abs=2e-6)
    assert 0.996 * ur5.lower.found * 0.999999 <= ur5.lower.proven <= ur5.lower.found
    assert 4.835 <= ur5.upper.found <= ur5.upper.proven <= 5.090
    assert ur5.verdict == "holds"
    assert _contradictions(ur5, [load_arm("ur5", armature=0.1)]) == []


def test_two_point_masses_in_a_plane_have_the_bounds_of_their_closed_form(tmp_path: Path) -> None:
    path = tmp_path / "points.urdf"
    path.write_text(PENDULUMS)
    report = bounds(load_arm(path, armature=0.05), gap=0.003)
    unit = MASS * LENGTH**2
    c = np.cos(np.linspace(0.0, np.pi, 4001))
    M = unit * np.array([[3.0 + 2.0 * c, 1.0 + c], [1.0 + c, np.ones_like(c)]]).transpose(2, 0, 1) + 0.05 * np.eye(2)
    values = np.linalg.eigvalsh(M)
    assert report.lower.found == pytest.approx(values.min(), rel=1e-6)
    assert report.upper.found == pytest.approx(values.max(), rel=1e-6)
    assert report.condition_number.found == pytest.approx((values[:, 1] / values[:, 0]).max(), rel=1e-4)
    # Γ₁₁₂ = −m l² sin q₂, Γ₁₂₂ = −m l² sin q₂, Γ₂₁₁ = m l² sin q₂; worst at q₂ = ±π/2.
    angle = np.linspace(0.0, 2.0 * np.pi, 200_001)
    x, y = np.cos(angle), np.sin(angle)
    exact = unit * np.hypot(2.0 * x * y + y**2, x**2).max()
    assert report.coriolis.found == pytest.approx(exact, rel=1e-5)
    # The bound's own price: the one factor that it takes for its largest is reached by none of the others there.
    assert exact <= report.coriolis.proven <= 4.0 * exact


def test_joints_that_slide_along_the_axes_have_no_velocity_forces(tmp_path: Path) -> None:
    parts = ['<robot name="gantry"><link name="base"/>']
    for i, axis in enumerate(("1 0 0", "0 1 0", "0 0 1")):
        parent = "base" if i == 0 else f"l{i - 1}"
        parts.append(
            f'<link name="l{i}"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
            f'</inertial></link><joint name="j{i}" type="prismatic"><parent link="{parent}"/><child link="l{i}"/>'
            f'<axis xyz="{axis}"/><limit lower="-1" upper="1" effort="9" velocity="1"/></joint>'
        )
    path = tmp_path / "gantry.urdf"
    path.write_text("".join(parts) + "</robot>")
    report = bounds(load_arm(path))
    assert report.coriolis.proven == report.coriolis.found == 0.0
    assert report.lower.found == pytest.approx(2.0)
    assert report.upper.found == pytest.approx(6.0)
    assert report.lower.proven == pytest.approx(2.0, rel=0.011)


# Samples never contradict -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_no_sample_of_a_random_chain_contradicts_its_bounds(seed: int, tmp_path: Path) -> None:
    joints = 2 + seed
    arm = chain(tmp_path, seed, joints, prismatic=seed % 2 == 1)
    rng = np.random.default_rng(seed)
    scaling = 10.0 ** rng.uniform(-0.7, 0.7, joints)
    armature = [(0.01, 0.05)] * joints
    report = bounds(arm, scaling=scaling, payload=(0.0, 1.5), armature=armature, gap=0.2, budget=20.0)
    assert report.verdict == "holds"
    ends = [arm.replace(payload=load, armature=a) for load in (None, 0.7, 1.5) for a in (0.01, 0.03, 0.05)]
    assert _contradictions(report, ends) == []
    path = report.save(tmp_path / "chain.cert")
    replayed = check(path)
    assert replayed.valid, replayed.problems
    said = replayed.to_json_dict()
    assert said["lower"][0] == pytest.approx(report.lower.proven, rel=1e-12)
    assert said["upper"][0] == pytest.approx(report.upper.proven, rel=1e-12)
    assert said["coriolis"][0] == pytest.approx(report.coriolis.proven, rel=1e-6)


@pytest.mark.parametrize("seed", range(60))
def test_christoffel_symbols_of_random_trees_stay_below_the_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, int(rng.integers(1, 7)))
    centre, half = random_box(rng, tree)
    lower, upper = centre - half, centre + half
    scaling = 10.0 ** rng.uniform(-0.5, 0.5, tree.nv)
    q = rng.uniform(lower, upper, (40, tree.nv))
    step = 1e-5
    moves = step * np.eye(tree.nv)
    around = (q[:, None] + moves, q[:, None] - moves)
    slope = np.stack([mass_matrices(tree, side.reshape(-1, tree.nv)) for side in around])
    slope = ((slope[0] - slope[1]) / (2.0 * step)).reshape(len(q), tree.nv, tree.nv, tree.nv)  # ∂_k M_ij at [k, i, j]
    symbols = 0.5 * (np.einsum("bkij->bijk", slope) + np.einsum("bjik->bijk", slope) - np.einsum("bijk->bijk", slope))
    symbols = symbols * scaling[:, None, None] * scaling[:, None] * scaling
    x = rng.normal(size=(len(q), 200, tree.nv))
    x /= np.linalg.norm(x, axis=-1)[..., None]
    forces = np.linalg.norm(np.einsum("bijk,bxj,bxk->bxi", symbols, x, x), axis=-1).max()
    mass = mass_matrices(tree, np.concatenate((q, rng.uniform(lower, upper, (500, tree.nv)))))
    largest = 1.05 * float(np.linalg.eigvalsh(mass * scaling * scaling[:, None])[:, -1].max())
    for bound in (largest, None):
        proven = velocity_force_bound(tree, lower, upper, scaling, bound)
        # A bound of λ_max that samples stand for is none everywhere, but it is where the forces are looked at.
        assert forces <= proven * (1.0 + 1e-6) + 1e-9


@pytest.mark.parametrize("seed", range(8))
def test_the_bound_of_the_velocity_forces_is_the_same_in_balls(seed: int, tmp_path: Path) -> None:
    joints = 1 + seed % 5
    slides = seed % 3 == 0
    arm = chain(tmp_path, seed, joints, prismatic=slides)
    lower, upper = arm.box
    scaling = 10.0 ** np.random.default_rng(seed).uniform(-0.5, 0.5, joints)
    names = [f"j{i}" for i in range(joints)]
    balls = BallArm(description(chain_urdf(seed, joints, slides)), names, {}, None)
    for largest in (None, 3.0):
        floats = velocity_force_bound(arm.tree, lower, upper, scaling, largest)
        enclosed = velocity_forces_in_balls(balls, lower.tolist(), upper.tolist(), scaling.tolist(), largest)
        # That in floats is raised, and counts twice the lack of the moments.
        assert enclosed <= floats <= enclosed * (1.0 + 1e-6) + 1e-11


def test_the_symbols_of_the_search_are_the_arm_s_velocity_forces() -> None:
    arm = load_arm("ur5")
    rng = np.random.default_rng(0)
    q, x = rng.uniform(-3.0, 3.0, (20, 6)), rng.normal(size=(20, 6))
    scaling = rng.uniform(0.5, 2.0, 6)
    ours = np.einsum("bijk,bj,bk->bi", christoffel(arm, q, scaling), x, x)
    assert ours == pytest.approx(scaling * (arm.bias(q, scaling * x) - arm.gravity(q)), abs=1e-10)


# What it says -------------------------------------------------------------------------------------------------------


def test_what_was_found_is_really_there(ur5: BoundsReport) -> None:
    arm = load_arm("ur5", armature=0.1)
    assert np.linalg.eigvalsh(arm.mass_matrix(ur5.lower.q))[0] == pytest.approx(ur5.lower.found, rel=1e-9)
    assert np.linalg.eigvalsh(arm.mass_matrix(ur5.upper.q))[-1] == pytest.approx(ur5.upper.found, rel=1e-9)
    values = np.linalg.eigvalsh(arm.mass_matrix(ur5.condition_number.q))
    assert values[-1] / values[0] == pytest.approx(ur5.condition_number.found, rel=1e-9)
    assert ur5.condition_number.found <= ur5.condition_number.proven
    assert ur5.coriolis.found <= ur5.coriolis.proven


def test_a_scaling_of_joints_is_another_unit_of_their_velocities(ur5: BoundsReport) -> None:
    arm = load_arm("ur5", armature=0.1)
    twice = bounds(arm, scaling=2.0, gap=0.01)
    assert twice.lower.found == pytest.approx(4.0 * ur5.lower.found, rel=1e-6)
    assert twice.upper.found == pytest.approx(4.0 * ur5.upper.found, rel=1e-6)
    assert twice.condition_number.found == pytest.approx(ur5.condition_number.found, rel=1e-4)
    assert twice.coriolis.proven == pytest.approx(8.0 * ur5.coriolis.proven, rel=0.02)


def test_a_range_of_the_armature_is_covered_at_both_ends() -> None:
    arm = load_arm("two_link")
    ranged = bounds(arm, armature=[(0.01, 0.03), (0.0, 0.02)], gap=0.01)
    least, most = (bounds(arm, armature=end, gap=0.01) for end in ([0.01, 0.0], [0.03, 0.02]))
    assert ranged.lower.found == pytest.approx(least.lower.found, rel=1e-6)
    assert ranged.upper.found == pytest.approx(most.upper.found, rel=1e-6)
    assert ranged.lower.proven <= least.lower.found
    assert ranged.upper.proven >= most.upper.found


def test_the_json_has_each_bound_as_proven_and_found(ur5: BoundsReport) -> None:
    said = json.loads(json.dumps(ur5.to_json_dict(), allow_nan=False))
    for name, bound in (("lower", ur5.lower), ("upper", ur5.upper), ("coriolis", ur5.coriolis)):
        assert said[name] == [bound.proven, bound.found]
    ratio = ur5.upper.proven / ur5.lower.proven
    assert said["condition_number"] == pytest.approx([ratio, 41.48], rel=3e-4)
    assert said["arm"] == "ur5"
    assert said["joints"][0] == "shoulder_pan_joint"
    text = str(ur5)
    assert "≺ M(q) ≺" in text
    assert "certified" in text


def test_a_check_derives_the_bounds_from_what_it_proves_again(ur5: BoundsReport, ur5_certificate: Path) -> None:
    found = check(ur5_certificate)
    assert found.valid, found.problems
    said: dict[str, Any] = found.to_json_dict()
    assert said["lower"][0] == ur5.lower.proven
    assert said["upper"][0] == ur5.upper.proven
    assert said["coriolis"][0] == pytest.approx(ur5.coriolis.proven, rel=1e-6)
    assert said["condition_number"][0] == ur5.condition_number.proven
    assert any("over every q of the box" in line for line in found.lines())


def test_where_there_is_no_time_it_says_what_is_open_and_writes_nothing(tmp_path: Path) -> None:
    report = bounds(load_arm("panda"), budget=1e-4)
    assert report.verdict == "undecided"
    assert report.lower.proven is None
    assert report.condition_number.proven is None
    assert report.coriolis.proven is not None
    assert "out of time" in str(report)
    json.dumps(report.to_json_dict(), allow_nan=False)
    # What is proven of the other end by then is written, and no more is said of it.
    found = check(report.save(tmp_path / "half.cert"))
    assert (found.valid, found.verdict) == (True, "undecided")
    assert found.to_json_dict()["lower"][0] is None
    with pytest.raises(ResultError, match="nothing is proven"):
        replace(report, proofs=()).save(tmp_path / "none.cert")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scaling": [1.0, 2.0, 3.0]}, "scaling"),
        ({"scaling": 0.0}, "scaling"),
        ({"scaling": [1.0, float("nan")]}, "scaling"),
        ({"gap": 1.0}, "gap"),
        ({"budget": 0.0}, "budget"),
    ],
)
def test_what_cannot_be_meant_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        bounds(load_arm("two_link"), **options)
