"""Designing M̄: optimal where the optimum is known, never worse than a guess, and honest about what limits it."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import two_arms, write
from condition_cases import UR5_MBAR, chain, explained_two_link_design
from hypothesis import given, settings
from hypothesis import strategies as st

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.condition import CONDITIONS, DesignReport, design, lemma1_norm, search_worst, verify, weighted_norm
from asmc_pin.condition.best_mbar.convex_program import Bounds, bandwidth_program, contraction_program
from asmc_pin.condition.best_mbar.dual_bound import dual_bound
from asmc_pin.condition.best_mbar.exchange import DesignProgress
from asmc_pin.errors import ParameterError

FREE = Bounds(np.zeros(2), np.full(2, np.inf))


@pytest.fixture(scope="module")
def ur5_design() -> DesignReport:
    return design(load_arm("ur5"), explain=False)


def test_ur5_reaches_the_known_optimum_by_an_independent_search(ur5_design: DesignReport) -> None:
    assert ur5_design.mbar is not None
    norm, _ = search_worst(load_arm("ur5"), ur5_design.mbar, seed=77, samples=2**15, starts=128)
    assert norm <= 0.9668
    assert ur5_design.bound == pytest.approx(0.96658, abs=2e-5)
    assert ur5_design.bound <= norm + 1e-9
    assert search_worst(load_arm("ur5"), np.array(UR5_MBAR))[0] > norm


def test_one_joint_designs_to_the_closed_form(tmp_path: Path) -> None:
    # One configuration-independent inertia: M̄ = M gives a norm of 0.
    arm = chain(tmp_path, 3, 1)
    report = design(arm, explain=False)
    assert report.check is not None
    assert report.check.lower < 1e-4
    # With armature between a and b the best is the harmonic middle: 1 − m/λ₁ and m/λ₀ − 1 are equal.
    base = float(arm.mass_matrix(np.zeros(1))[0, 0])
    ranged = design(arm, armature=(0.5, 2.0), explain=False)
    low, high = base + 0.5, base + 2.0
    assert ranged.mbar is not None
    assert ranged.mbar[0] == pytest.approx(2 * low * high / (low + high), rel=1e-3)
    assert ranged.bound == pytest.approx((high - low) / (high + low), rel=1e-4)


def test_scalar_mbar_is_twice_the_harmonic_middle_of_the_extreme_eigenvalues() -> None:
    # For M̄ = m·I the norm is max|1 − m/λ|, least at m = 2/(1/λ_min + 1/λ_max).
    arm = load_arm("two_link")
    values = np.linalg.eigvalsh(arm.mass_matrix(np.stack((np.zeros(721), np.linspace(-np.pi, np.pi, 721)), axis=-1)))
    low, high = values.min(), values.max()
    report = design(arm, form="scalar", explain=False)
    assert report.mbar is not None
    assert report.mbar == pytest.approx(np.full(2, 2 / (1 / low + 1 / high)), rel=1e-3)
    assert report.check is not None
    assert report.check.lower == pytest.approx((high - low) / (high + low), abs=1e-5)


@given(st.integers(0, 10_000), st.sampled_from(CONDITIONS))
@settings(max_examples=12, deadline=None)
def test_program_is_never_worse_than_any_scaled_diagonal(seed: int, condition: str) -> None:
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(4, 3, 3))
    masses = roots @ np.swapaxes(roots, 1, 2) + 0.05 * np.eye(3)
    norm_of = {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
    best = contraction_program(masses, condition, Bounds(np.zeros(3), np.full(3, np.inf)))
    assert best is not None
    assert norm_of(masses, best.mbar).max() == pytest.approx(best.value, abs=1e-5)
    guesses = [np.diagonal(masses, axis1=1, axis2=2).mean(axis=0), np.diag(masses[0]), *rng.uniform(0.1, 3, (20, 3))]
    for guess in guesses:
        for scale in np.geomspace(1e-3, 2, 60):
            assert norm_of(masses, scale * guess).max() >= best.value - 1e-6


@pytest.mark.parametrize("condition", CONDITIONS)
def test_design_beats_scaled_diagonals_on_random_chains(tmp_path: Path, condition: str) -> None:
    arm = chain(tmp_path, 11, 3).replace(armature=0.01)
    report = design(arm, condition=condition, explain=False)
    assert report.check is not None
    mass = arm.mass_matrix(np.random.default_rng(0).uniform(*arm.box, (500, 3)))
    diagonals = [
        np.diagonal(mass, axis1=1, axis2=2).mean(axis=0),
        np.diagonal(mass, axis1=1, axis2=2).min(axis=0),
        np.ones(3),
    ]
    norm_of = {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
    for diagonal in diagonals:
        for scale in np.geomspace(1e-3, 2, 80):
            assert norm_of(mass, scale * diagonal).max() >= report.check.lower - 1e-6 or (
                search_worst(arm, scale * diagonal, condition, samples=1024)[0] >= report.check.lower - 1e-6
            )


def test_weighted_design_reaches_further_than_lemma1s_and_is_another_number(ur5_design: DesignReport) -> None:
    weighted = design(load_arm("ur5"), condition="weighted", explain=False)
    assert weighted.check is not None
    assert ur5_design.check is not None
    assert weighted.check.lower < ur5_design.check.lower - 0.02
    # Its M̄ breaks Lemma 1: the two are not to be confused.
    assert weighted.mbar is not None
    assert verify(load_arm("ur5"), weighted.mbar, samples=4096).verdict == "violated"


def test_bandwidth_design_trades_norm_for_the_slowest_mode() -> None:
    report = explained_two_link_design()
    least = report.trade_off[0]
    assert report.check is not None
    assert report.level is not None
    assert report.check.lower <= report.level + 1e-6
    norms = [point.norm for point in report.trade_off]
    speeds = [point.bandwidth for point in report.trade_off]
    assert norms == sorted(norms)
    assert speeds == sorted(speeds)
    assert report.bandwidth == speeds[-1] > 1.3 * least.bandwidth
    # λ_min(M⁻¹M̄) ≥ 1 − ‖I − M⁻¹M̄‖ always.
    assert all(speed >= 1.0 - norm - 1e-9 for norm, speed in zip(norms, speeds, strict=True))


def test_bandwidth_program_meets_its_level_and_its_bound() -> None:
    masses = np.stack([np.diag([1.0, 2.0]), np.diag([3.0, 2.0])])
    best = bandwidth_program(masses, "lemma1", FREE, 0.9)
    assert best is not None
    # Joint by joint: m̄₁ ≤ 1.9·1, so λ_min is min(1.9/3, m̄₂/2).
    assert best.value == pytest.approx(1.9 / 3.0, abs=1e-6)
    assert bandwidth_program(masses, "lemma1", FREE, 0.2) is None


@pytest.mark.parametrize("condition", CONDITIONS)
def test_sensitivity_to_armature_is_that_of_a_redesign(condition: str) -> None:
    rng = np.random.default_rng(2)
    roots = rng.normal(size=(3, 2, 2))
    masses = roots @ np.swapaxes(roots, 1, 2) + 0.3 * np.eye(2)
    here = contraction_program(masses, condition, FREE)
    assert here is not None
    for joint in range(2):
        step = 1e-3 * np.diag(np.eye(2)[joint])
        up, down = (contraction_program(masses + sign * step, condition, FREE) for sign in (1, -1))
        assert up is not None
        assert down is not None
        assert here.by_armature[joint] == pytest.approx((up.value - down.value) / 2e-3, rel=2e-2, abs=2e-3)


def test_design_over_ranges_holds_at_every_end(tmp_path: Path) -> None:
    arm = load_arm("two_link")
    report = design(arm, payload=(0.0, 2.0), armature=[(0.0, 0.05), 0.01], explain=False)
    assert report.check is not None
    assert report.mbar is not None
    assert report.check.lower < 1.0
    assert report.check.lower == pytest.approx(report.bound, abs=1e-3 * (1 - report.check.lower))
    for mass in (0.0, 1.0, 2.0):
        for extra in (0.0, 0.03, 0.05):
            one = arm.replace(payload=mass, armature=[extra, 0.01])
            assert search_worst(one, report.mbar, samples=512)[0] <= report.check.lower + 1e-9


def test_bounds_are_kept_and_impossible_ones_are_said_to_be(tmp_path: Path) -> None:
    arm = load_arm("two_link")
    report = design(arm, bounds={"joint_1": (0.05, 0.06), "joint_2": (None, 0.04)}, explain=False)
    assert report.mbar is not None
    assert 0.05 <= report.mbar[0] <= 0.06
    assert report.mbar[1] <= 0.04
    assert report.check is not None
    assert report.check.lower > 0.9494  # above the free optimum
    hopeless = design(arm, bounds=(1.0, None), explain=False)
    assert (hopeless.verdict, hopeless.mbar) == ("infeasible", None)
    assert hopeless.bound is not None
    assert hopeless.bound >= 1.0
    content = hopeless.to_json_dict()
    assert content["mbar"] is None
    json.dumps(content, allow_nan=False)
    assert "no M̄ within the bounds" in hopeless.lines()[0]


def test_report_explains_what_limits_it_and_what_would_help() -> None:
    report = explained_two_link_design()
    assert report.check is not None
    assert report.weighted is not None
    # The norm of the stretched arm or of the folded one limits M̄, and there the second joint's small inertia.
    assert report.limits[0].joint == "joint_2"
    assert sum(limit.share for limit in report.limits) == pytest.approx(1.0, abs=0.05)
    assert all(item.norm < report.check.lower for item in report.armature_buys)
    assert report.weighted.least.norm < report.check.lower
    assert report.weighted.scale * (1 + 1e-9) >= report.weighted.scale_lemma1 > 1.0
    assert report.by_armature is not None
    assert np.all(report.by_armature <= 1e-6)
    content = json.loads(json.dumps(report.to_json_dict(), allow_nan=False))
    assert content["mbar"] == report.mbar.tolist()  # type: ignore[union-attr]
    text = "\n".join(report.lines())
    assert repr(content["mbar"][0]) in text
    assert "not Lemma 1" in text


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"objective": "speed"}, "contraction, bandwidth"),
        ({"form": "full"}, "diagonal, scalar"),
        ({"level": 1.5}, "between 0 and 1"),
        ({"bounds": {"elbow": (0, 1)}}, "not a joint"),
        ({"bounds": (2.0, 1.0)}, "no positive"),
        ({"bounds": (-1.0, 1.0)}, "leave the least out"),
        ({"bounds": (0.0, 1e20)}, "leave the largest out"),
        ({"bounds": {"joint_1": 3.0}}, r"\(least, largest\) expected"),
        ({"bounds": {"joint_1": (1.0, 2.0), "joint_2": (0.1, 0.2)}, "form": "scalar"}, "no single"),
        ({"box": {"joint_2": (1.0, 0.0)}}, "empty"),
    ],
)
def test_bad_input_is_one_clear_message(options: dict, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        design(load_arm("two_link"), **options)


def test_same_seed_gives_the_same_design() -> None:
    arm: Arm = load_arm("double_pendulum")
    first, second = (design(arm, explain=False, seed=4).mbar for _ in range(2))
    np.testing.assert_array_equal(first, second)


@given(st.integers(0, 10_000), st.sampled_from(CONDITIONS), st.floats(1.0, 15.0))
@settings(max_examples=25, deadline=None)
def test_no_mbar_beats_the_dual_bound_however_near_to_singular_the_inertia(
    seed: int, condition: str, digits: float
) -> None:
    rng = np.random.default_rng(seed)
    turns = np.linalg.qr(rng.normal(size=(3, 3, 3)))[0]
    masses = (turns * np.geomspace(1.0, 10.0**-digits, 3)) @ np.swapaxes(turns, 1, 2)
    masses = 0.5 * (masses + np.swapaxes(masses, 1, 2))
    if np.linalg.eigvalsh(masses).min() <= 0.0:
        return  # rounding left no inertia
    best = contraction_program(masses, condition, Bounds(np.zeros(3), np.full(3, np.inf)))
    bandwidth_program(masses, condition, Bounds(np.zeros(3), np.full(3, np.inf)), 0.999)
    assert best.bound >= 0.0
    below = best.bound * (1.0 - 1e-12)
    assert not all(has_less(mass, best.mbar, condition, below) for mass in masses)
    for scale in np.geomspace(1e-6, 1.0, 13):
        guess = scale * np.diagonal(masses, axis1=1, axis2=2).min(axis=0) * rng.uniform(0.3, 1.0, 3)
        assert not all(has_less(mass, guess, condition, below) for mass in masses)
    if digits < 4.0:
        assert best.bound == pytest.approx(best.value, abs=1e-5)


def has_less(mass: Array, mbar: Array, condition: str, level: float) -> bool:
    """Whether the norm is below a level, in exact fractions: float64 has no digits left near singular inertia."""
    n, g = len(mbar), Fraction(level)
    M = [[Fraction(float(x)) for x in row] for row in mass]
    D = [Fraction(float(m)) for m in mbar]
    if condition == "weighted":
        above = [[(1 + g) * M[i][j] - (D[i] if i == j else 0) for j in range(n)] for i in range(n)]
        below = [[(D[i] if i == j else 0) - (1 - g) * M[i][j] for j in range(n)] for i in range(n)]
        return positive(above) and positive(below)
    # N M + M N − I − (1 − γ²) M N² M, with N = M̄⁻¹.
    rest = 1 - g * g
    return positive(
        [
            [
                M[i][j] / D[i]
                + M[i][j] / D[j]
                - (i == j)
                - rest * sum((M[i][k] * M[k][j] / D[k] ** 2 for k in range(n)), Fraction(0))
                for j in range(n)
            ]
            for i in range(n)
        ]
    )


def positive(S: list[list[Fraction]]) -> bool:
    """Whether a symmetric matrix is positive definite, by its pivots."""
    for k in range(len(S)):
        if S[k][k] <= 0:
            return False
        for i in range(k + 1, len(S)):
            share = S[i][k] / S[k][k]
            S[i] = [a - share * b for a, b in zip(S[i], S[k], strict=True)]
    return True


@pytest.mark.parametrize("condition", CONDITIONS)
def test_the_dual_bound_holds_whatever_multipliers_a_solver_gives(condition: str) -> None:
    rng = np.random.default_rng(5)
    roots = rng.normal(size=(3, 2, 2))
    masses = roots @ np.swapaxes(roots, 1, 2) + 0.3 * np.eye(2)
    inverse_roots = [np.linalg.inv(np.linalg.cholesky(mass)) for mass in masses]
    best = contraction_program(masses, condition, FREE)
    blocks, size = (1, 4) if condition == "lemma1" else (2, 2)
    for _ in range(200):
        duals = [[rng.normal(size=(size, size)) for _ in range(blocks)] for _ in masses]
        bound = dual_bound(masses, inverse_roots, duals, condition, (FREE.lower, FREE.upper), False, 1.0)
        assert bound <= best.value + 1e-6


def test_where_the_solver_fails_there_is_a_cautious_mbar_and_no_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    import cvxpy as cp

    def fail(self: object, **options: object) -> None:
        raise cp.error.SolverError("failed")

    monkeypatch.setattr(cp.Problem, "solve", fail)
    masses = np.stack([np.diag([1.0, 2.0]), np.array([[3.0, 1.0], [1.0, 2.0]])])
    found = contraction_program(masses, "weighted", FREE)
    assert found.bound == 0.0
    assert weighted_norm(masses, found.mbar).max() < 1.0
    assert bandwidth_program(masses, "weighted", FREE, 0.9) is None


def test_a_design_whose_time_is_up_says_what_it_has(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_arms(4, torso=True)))
    told: list[DesignProgress] = []
    report = design(arm, condition="weighted", budget=1e-3, progress=told.append)
    assert report.mbar is not None
    assert report.bound is not None
    assert report.check is not None
    assert report.rounds == 1
    assert "a better M̄ than that of 1 programs (the budget of 0.001 s was up)" in report.unfinished
    assert "all that explains it (the budget of 0.001 s was up)" in report.unfinished
    assert any("not all was done" in line for line in report.lines())
    assert report.to_json_dict()["bound_kind"] == "rigorous dual bound"
    # One program knows too little, and its M̄ is shrunk until the search finds nothing against it.
    assert report.bound <= report.check.lower < 1.0
    assert told
    assert told[-1].doing == "least norm"


def test_a_search_and_a_program_that_did_not_meet_are_not_said_to_be_out_of_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("asmc_pin.condition.best_mbar.exchange.ROUNDS", 1)
    monkeypatch.setattr("asmc_pin.condition.best_mbar.designing.ROUNDS", 1)
    report = design(load_arm("two_link"), explain=False)
    assert "(search and program did not meet in 1 programs)" in report.unfinished
    assert "budget" not in report.unfinished
    monkeypatch.setattr("asmc_pin.condition.best_mbar.exchange.bandwidth_program", lambda *_: None)
    failed = design(load_arm("two_link"), objective="bandwidth", explain=False)
    assert "(the solver found no optimum)" in failed.unfinished
