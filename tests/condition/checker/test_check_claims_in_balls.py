"""The parts, in balls, of what is claimed about bounds of M and about a sampled loop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from certificate_files import rewrite
from flint import arb, arb_mat
from pydantic import ValidationError

from asmc_pin import BoundsReport, SampledLoop, bounds, certify_loop, check, load_arm
from asmc_pin.condition.checker.balls.gravity_gain import _change
from asmc_pin.condition.checker.balls.velocity_forces import _lack, eigenvalue_bound, largest_eigenvalue
from asmc_pin.condition.checker.reading.certificate_schema import Pieces


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
