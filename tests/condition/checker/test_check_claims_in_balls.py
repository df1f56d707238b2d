"""The parts, in balls, of what is claimed about bounds of M and about a sampled loop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import two_arms, write
from certificate_files import rewrite
from coupled_urdf import coupled_tree
from flint import arb, arb_mat
from pydantic import ValidationError

from asmc_pin import Arm, BoundsReport, SampledLoop, bounds, certify_loop, check, load_arm
from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.balls.gravity_gain import _change
from asmc_pin.condition.checker.balls.velocity_forces import (
    _lack,
    eigenvalue_bound,
    largest_eigenvalue,
    velocity_forces_in_balls,
)
from asmc_pin.condition.checker.reading.certificate_schema import Pieces
from asmc_pin.condition.checker.reading.urdf_text import description
from asmc_pin.condition.inertia_bounds.velocity_force_bound import velocity_force_bound


@pytest.mark.parametrize("seed", range(5))
def test_any_positive_vector_bounds_the_largest_eigenvalue_and_the_one_that_is_chosen_closely(seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.random((4, 4)) * 10.0 ** rng.integers(-2, 3, (4, 4))
    matrix = matrix + matrix.T
    balls = [[arb(x) for x in row] for row in matrix.tolist()]
    true = float(np.linalg.eigvalsh(matrix)[-1])
    for _ in range(20):
        assert float(eigenvalue_bound(balls, 10.0 ** rng.uniform(-3.0, 0.0, 4)).mid()) >= true * (1.0 - 1e-12)
    assert true * (1.0 - 1e-12) <= float(largest_eigenvalue(balls).mid()) <= 1.05 * true


def test_moments_that_are_not_known_well_are_made_up_for_by_as_much_as_that_takes() -> None:
    unsure = arb_mat([[arb(0.0, 1e-6) if i == j else arb(0) for j in range(3)] for i in range(3)])
    assert float(_lack(unsure, arb(1)).mid()) > 1e-6


def _forces_bound(loaded: Arm, scaling: Array, largest: float | None) -> float:
    balls = BallArm(description(loaded.urdf_text), loaded.joint_names, loaded.locked, None)
    lower, upper = loaded.box
    return velocity_forces_in_balls(balls, lower.tolist(), upper.tolist(), scaling.tolist(), largest)


@pytest.mark.parametrize("seed", range(6))
def test_no_motion_of_a_tree_has_larger_velocity_forces_than_the_bound_in_balls(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    loaded = load_arm(write(tmp_path, coupled_tree(rng, joints=2 + seed, followers=0)))
    scaling = 10.0 ** rng.uniform(-0.5, 0.5, loaded.nv)
    q, x = rng.uniform(*loaded.box, (400, loaded.nv)), rng.normal(size=(400, loaded.nv))
    x /= np.linalg.norm(x, axis=1)[:, None]
    forces = scaling * (loaded.bias(q, scaling * x) - loaded.gravity(q))
    most = float(np.linalg.norm(forces, axis=1).max())
    # A bound of λ_max at these configurations is one for what is looked at.
    largest = float(np.linalg.eigvalsh(loaded.mass_matrix(q) * scaling * scaling[:, None]).max())
    for bound in (None, largest):
        enclosed = _forces_bound(loaded, scaling, bound)
        assert most <= enclosed
        # The prover has the same bound by other arithmetic, raised for its rounding.
        floats = velocity_force_bound(loaded.tree, *loaded.box, scaling, bound)
        assert enclosed <= floats <= enclosed * (1.0 + 1e-6) + 1e-11


def test_of_two_arms_on_one_base_the_stronger_alone_bounds_the_velocity_forces(tmp_path: Path) -> None:
    pair = load_arm(write(tmp_path, two_arms(3)))
    left, right = (
        load_arm(pair.source, lock={name: 0.0 for name in pair.joint_names if name.startswith(side)})
        for side in ("right", "left")
    )
    ones = np.ones(3)
    alone = [_forces_bound(each, ones, None) for each in (left, right)]
    assert _forces_bound(pair, np.ones(6), None) == pytest.approx(max(alone), rel=1e-6)
    assert min(alone) < 0.99 * max(alone)


def test_what_an_error_does_within_a_period_is_its_integral() -> None:
    rng = np.random.default_rng(0)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    t, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    for _ in range(5):
        a, damping, square = rng.uniform(0.1, 1.9), *rng.uniform(0.01, 1.0, 2)
        z = rng.standard_normal(3)
        found = _change(arb_mat(3, 3), arb(a), arb(damping), arb(square), arb(0))
        value = sum(z[i] * z[j] * float(found[i, j].mid()) for i in range(3) for j in range(3))
        push = a * (-square * z[0] - damping * z[1] + z[2])
        error = z[0] + z[1] * t + 0.5 * push * t**2
        assert value == pytest.approx(weights @ error**2, rel=1e-12)


@pytest.fixture(scope="module")
def report() -> BoundsReport:
    return bounds(load_arm("two_link"), gap=0.05)


@pytest.mark.parametrize(
    ("name", "factor", "says"),
    [("lower", 1.5, "no eigenvalue is below {:.9g}"), ("upper", 0.5, "no eigenvalue is above {:.9g}")],
)
def test_a_bound_beyond_what_is_proven_is_named_and_refused(
    report: BoundsReport, name: str, factor: float, says: str, tmp_path: Path
) -> None:
    claimed = factor * getattr(report, name).proven

    def change(header: dict[str, object], _records: object) -> None:
        told = list(header[name])  # type: ignore[call-overload]
        header[name] = [claimed if isinstance(told[0], float) else claimed.hex(), told[1]]

    found = check(rewrite(report.save(tmp_path / "true.cert"), tmp_path / "false.cert", change))
    assert not found.valid
    assert any(says.format(claimed) in line for line in found.problems), found.problems


def test_a_bound_within_what_is_proven_is_true_too(report: BoundsReport, tmp_path: Path) -> None:
    def weaker(header: dict[str, object], _records: object) -> None:
        for name, factor in (("lower", 0.5), ("upper", 2.0)):
            told = list(header[name])  # type: ignore[call-overload]
            header[name] = [factor * told[0], told[1]]

    found = check(rewrite(report.save(tmp_path / "true.cert"), tmp_path / "weak.cert", weaker))
    assert found.valid, found.problems
    said = found.to_json_dict()
    assert (said["lower"][0], said["upper"][0]) == (report.lower.proven, report.upper.proven)


def test_the_range_that_is_proven_of_a_loop_encloses_what_is_there_within_the_stable_one(
    tmp_path: Path,
) -> None:
    proof = certify_loop(load_arm("two_link"), SampledLoop([0.02, 0.02], 12.0, 12.0, 0.001))
    assert proof.verdict == "stable"
    said = check(proof.save(tmp_path / "loop.cert")).to_json_dict()
    (low, high), (least, most) = said["proven_between"], proof.seen_between
    assert said["stable_between"][0] <= low < least < 1.5 * low
    assert high / 1.5 < most < high <= said["stable_between"][1]


@pytest.mark.parametrize("name", ["lower", "upper"])
def test_an_eigenvalue_that_is_said_to_be_found_below_zero_breaks_the_schema(
    report: BoundsReport, name: str, tmp_path: Path
) -> None:
    def negative(header: dict[str, object], _records: object) -> None:
        told = list(header[name])  # type: ignore[call-overload]
        header[name] = [told[0], -0.5]

    found = check(rewrite(report.save(tmp_path / "true.cert"), tmp_path / "false.cert", negative))
    assert not found.valid
    assert any(name in line and "greater than 0" in line for line in found.problems), found.problems


def test_pieces_of_eigenvalues_begin_above_zero() -> None:
    form = ((1.0).hex(),) * 6
    Pieces(ends=((0.5).hex(), (1.0).hex()), forms=(form,))
    with pytest.raises(ValidationError, match="greater than 0"):
        Pieces(ends=((-0.5).hex(), (1.0).hex()), forms=(form,))
