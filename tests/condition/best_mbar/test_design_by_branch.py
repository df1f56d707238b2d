"""Arms on one base: search and design of each block of M are problems of their own, and give what the whole does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from arm_urdf import two_arms, write

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.condition import CONDITIONS, DesignReport, design, lemma1_norm, verify, weighted_norm
from asmc_pin.condition.best_mbar.by_branch import blocks_of, exchange_all
from asmc_pin.condition.best_mbar.convex_program import Bounds
from asmc_pin.condition.best_mbar.exchange import TOLERANCE, Active, Pace, exchange
from asmc_pin.condition.domain.along_motion import norms_along
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.search.samples import domain_of
from asmc_pin.condition.search.worst_case import maximise

MBAR = np.array([0.02, 0.03, 0.006, 0.018, 0.03, 0.005])
NORMS: dict[str, Any] = {"lemma1": lemma1_norm, "weighted": weighted_norm}
LEFT, RIGHT = ([f"{side}{k}_joint" for k in (1, 2, 3)] for side in ("left", "right"))


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    return load_arm(write(tmp_path_factory.mktemp("pair"), two_arms(3)))


@pytest.fixture(scope="module")
def alone(pair: Arm) -> list[Arm]:
    """Each arm with the other one locked."""
    return [load_arm(pair.source, lock=dict.fromkeys(other, 0.4)) for other in (RIGHT, LEFT)]


@pytest.fixture(scope="module", params=CONDITIONS)
def designed(pair: Arm, request: pytest.FixtureRequest) -> DesignReport:
    return design(pair, condition=request.param, explain=False)


def free(nv: int) -> Bounds:
    return Bounds(np.zeros(nv), np.full(nv, np.inf))


@pytest.mark.parametrize("kind", range(5))
def test_worst_of_two_arms_is_the_worst_of_either_and_costs_the_search_of_both(
    pair: Arm, alone: list[Arm], kind: int
) -> None:
    found = maximise(kind, domain_of(pair), MBAR, samples=2048, starts=16)
    each = [
        maximise(kind, domain_of(arm), mbar, samples=2048, starts=16)
        for arm, mbar in zip(alone, (MBAR[:3], MBAR[3:]), strict=True)
    ]
    assert found.value == pytest.approx(max(item.value for item in each), rel=1e-9)
    assert found.configurations <= 1.5 * sum(item.configurations for item in each)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_every_figure_of_a_search_over_two_arms_is_that_of_the_whole_arm(pair: Arm, condition: str) -> None:
    kind = {"lemma1": compiled_norms.LEMMA1, "weighted": compiled_norms.WEIGHTED}[condition]
    also = pair.box[0][None] * 0.7, np.zeros((1, 6))
    found = maximise(kind, domain_of(pair), MBAR, samples=512, starts=8, also=also)
    assert NORMS[condition](pair.mass_matrix(found.q[None]), MBAR)[0] == pytest.approx(found.value, rel=1e-9)
    np.testing.assert_allclose(NORMS[condition](pair.mass_matrix(found.maxima_q), MBAR), found.maxima, rtol=1e-9)
    assert found.maxima.max() == pytest.approx(found.value, rel=1e-12)
    seen = NORMS[condition](pair.mass_matrix(np.random.default_rng(3).uniform(*pair.box, (20_000, 6))), MBAR)
    assert seen.max() <= found.value * (1.0 + 1e-12)
    assert found.samples.shape == (512,)


def test_armature_ranges_of_two_arms_are_searched_arm_by_arm(pair: Arm) -> None:
    lower, upper = np.zeros(6), np.linspace(0.01, 0.06, 6)
    q = np.random.default_rng(5).uniform(*pair.box, (40, 6))
    norms, armature = norms_along(pair, MBAR, "lemma1", q, lower, upper)
    expected = np.full(len(q), -np.inf)
    for corner in np.ndindex(*[2] * 6):
        mass = pair.mass_matrix(q) + np.diag(np.where(corner, upper, lower))
        expected = np.maximum(expected, lemma1_norm(mass, MBAR))
    np.testing.assert_allclose(norms, expected, rtol=1e-9)
    at = pair.mass_matrix(q) + armature[:, :, None] * np.eye(6)
    np.testing.assert_allclose(lemma1_norm(at, MBAR), norms, rtol=1e-9)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_design_by_branches_is_that_of_one_program_over_the_whole(pair: Arm, condition: Any) -> None:
    domains = [domain_of(pair)]
    whole = exchange(Active(domains, 0), condition, free(6))
    parts = exchange_all(blocks_of(domains, free(6), 0), condition, free(6))
    assert whole is not None
    assert parts is not None
    assert whole.masses.shape[-1] == 6
    assert [part.masses.shape[-1] for part in parts.parts] == [3, 3]
    assert parts.norm == pytest.approx(whole.norm, abs=2.0 * TOLERANCE * (1.0 - whole.norm))
    assert parts.bound == pytest.approx(whole.solution.bound, abs=2.0 * TOLERANCE * (1.0 - whole.norm))
    assert parts.bound <= whole.norm
    assert whole.solution.bound <= parts.norm


def test_design_of_two_arms_is_the_designs_of_both_and_costs_what_they_cost(
    designed: DesignReport, alone: list[Arm]
) -> None:
    each = [design(arm, condition=designed.condition, explain=False) for arm in alone]
    assert [list(branch.joints) for branch in designed.branches] == [LEFT, RIGHT]
    assert designed.rounds <= 1.5 * sum(report.rounds for report in each)
    assert designed.bound == pytest.approx(max(report.bound or 0.0 for report in each), rel=1e-6)
    for branch, report in zip(designed.branches, each, strict=True):
        assert report.check is not None
        assert branch.norm == pytest.approx(report.check.lower, abs=2.0 * TOLERANCE * (1.0 - branch.norm))
        assert branch.bound <= report.check.lower
    assert designed.mbar is not None
    assert [m for report in each for m in np.asarray(report.mbar)] == pytest.approx(designed.mbar, rel=0.02)


def test_report_says_that_it_is_put_together_and_of_what(designed: DesignReport) -> None:
    assert designed.check is not None
    largest = max(branch.norm for branch in designed.branches)
    assert designed.check.lower == pytest.approx(largest, rel=1e-6)
    said = next(line for line in designed.lines() if "put together" in line)
    assert "block diagonal" in said
    assert all(f"{branch.norm:.6g}" in said for branch in designed.branches)
    content = designed.to_json_dict()["branches"]
    assert [item["joints"] for item in content] == [LEFT, RIGHT]
    # What limits is of a branch that is as bad as the worst, and its joint is one that the configuration moves.
    for limit in designed.limits:
        mine = slice(0, 3) if limit.joint in LEFT else slice(3, 6)
        assert np.abs(limit.q[mine]).max() > 0.0


def test_one_m_for_both_arms_ties_them_and_is_one_program(pair: Arm) -> None:
    report = design(pair, form="scalar", explain=False)
    assert report.branches == ()
    assert report.mbar is not None
    assert np.ptp(report.mbar) == 0.0
    values = np.linalg.eigvalsh(pair.mass_matrix(np.random.default_rng(0).uniform(*pair.box, (20_000, 6))))
    low, high = values.min(), values.max()
    assert report.bound == pytest.approx((high - low) / (high + low), abs=2e-3)


def test_largest_bandwidth_keeps_the_level_on_both_arms_and_is_the_smaller_of_theirs(
    pair: Arm, alone: list[Arm]
) -> None:
    report = design(pair, objective="bandwidth", level=0.97, explain=False)
    each = [design(arm, objective="bandwidth", level=0.97, explain=False) for arm in alone]
    assert report.bandwidth == pytest.approx(min(item.bandwidth or 0.0 for item in each), rel=2e-3)
    assert report.mbar is not None
    assert verify(pair, report.mbar, samples=4096).lower <= 0.97 + 1e-4


def test_one_branch_that_allows_no_mbar_makes_the_whole_infeasible(pair: Arm) -> None:
    report = design(pair, bounds={"right2_joint": (50.0, None)}, explain=False)
    assert report.verdict == "infeasible"
    assert report.bound is not None
    assert report.bound >= 1.0
    assert [branch.bound >= 1.0 for branch in report.branches] == [False, True]
    assert all(limit.joint in RIGHT for limit in report.limits)


def test_each_branch_gets_its_share_of_the_budget(pair: Arm) -> None:
    seen: list[str] = []
    pace = Pace(1e-9, lambda now: seen.append(now.doing), doing="least norm")
    found = exchange_all(blocks_of([domain_of(pair)], free(6), 0), "lemma1", free(6), pace=pace)
    assert found is not None
    # Even without time there is an M̄ of every branch.
    assert [part.rounds for part in found.parts] == [1, 1]
    assert found.stopped == "time"
    assert {"least norm, branch 1 of 2", "least norm, branch 2 of 2"} == set(seen)
    mbar: Array = found.mbar
    assert np.all(mbar > 0.0)
