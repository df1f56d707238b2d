"""Where a proof gives up, the reason that it prints is the cause: a case for each, made so that the cause is known."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from condition_cases import UR5_MBAR

from asmc_pin import load_arm
from asmc_pin.arms import Arm
from asmc_pin.cli import main
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.certificate.statement import Statement
from asmc_pin.condition.certificate.statement_forms import problem_of
from asmc_pin.condition.certificate.stopping import (
    GAP_MET,
    LEVEL_PROVEN,
    NEAREST,
    NO_MULTIPLE,
    NORM_REFUTED,
    OUT_OF_TIME,
    SHARE_SPENT,
    Obstacle,
)
from asmc_pin.condition.certificate.strategy import Prover
from asmc_pin.condition.certificate.walk import prove
from asmc_pin.condition.certificate.worst_known import STRICT, Worst
from asmc_pin.condition.domain.arm_ranges import cases
from asmc_pin.sampled.proof.loop_certificate import certify_loop
from asmc_pin.sampled.sampled_loop import SampledLoop


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


def point_masses(folder: Path, first: float) -> Arm:
    """Two joints in a plane, links of 1 m, a point mass at the end of each: 1 kg at the tip."""
    parts = [link("base")]
    for k, (parent, mass) in enumerate((("base", first), ("l0", 1.0))):
        parts += [
            link(f"l{k}", inertial(mass, "1 0 0", np.zeros((3, 3)))),
            joint(f"j{k}", parent, f"l{k}", axis="0 0 1", xyz="0 0 0" if k == 0 else "1 0 0"),
        ]
    return load_arm(write(folder, robot(*parts)))


def test_a_gap_that_is_met_is_the_reason_and_the_gap_is_met(two_link: Arm) -> None:
    found = certify(two_link, 0.01, gap=0.02, levels=False)
    assert found.reason == GAP_MET
    assert found.gap <= 0.02


def test_out_of_time_is_said_when_the_budget_was_spent() -> None:
    began = time.monotonic()
    found = certify(load_arm("panda"), 0.02, gap=1e-4, budget=0.5, levels=False)
    assert found.reason == OUT_OF_TIME
    assert time.monotonic() - began >= 0.5
    assert found.gap > 1e-4


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_a_gap_finer_than_the_margin_ends_too_near_to_what_is_refuted(two_link: Arm, condition: Any) -> None:
    found = certify(two_link, 0.01, condition=condition, gap=1e-11, levels=False)
    assert "too near to be told" in found.reason
    assert found.gap <= NEAREST
    assert found.seconds < 30.0


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_an_mbar_at_the_edge_of_the_condition_is_undecided_because_it_is_too_near(
    two_link: Arm, condition: Any
) -> None:
    edge = certify(two_link, 0.01, condition=condition, levels=False).scale_refuted / (1.0 + STRICT)
    found = certify(two_link, 0.01 * edge * (1.0 - 2e-10), condition=condition, levels=False)
    assert found.verdict == "undecided"
    assert "too near to be told" in found.reason
    # A little further away it is decided, either way.
    for share, verdict in ((1.0 - 1e-8, "holds"), (1.0 + 1e-8, "violated")):
        again = certify(two_link, 0.01 * edge * share, condition=condition, levels=False)
        assert again.verdict == verdict
        assert again.reason == GAP_MET


def test_rounding_is_the_reason_where_the_condition_holds_by_less_than_rounding_takes(tmp_path: Path) -> None:
    arm, mbar = point_masses(tmp_path, 1e-11), 1e-12
    found = certify(arm, mbar, condition="weighted", levels=False)
    assert found.verdict == "undecided"
    assert found.scale_proven == 0.0
    assert found.reason == "near q = (0, 0) the condition holds by less than is allowed for rounding"
    # M − M̄/2 stretched out, exactly: positive definite, and by 1e-12 of its size.
    m, half = Fraction(1e-11), Fraction(mbar) / 2
    a, b, d = m + 4 - half, Fraction(2), 1 - half
    assert a * d - b * b > 0
    assert a * d - b * b < Fraction(1, 10**10) * a * d
    # With a thousand times the inertia the same arm is proven.
    assert certify(point_masses(tmp_path, 1e-8), 1e-9, condition="weighted", levels=False).reason == GAP_MET


def test_the_floor_of_width_is_the_reason_only_where_the_configuration_itself_is_proven(two_link: Arm) -> None:
    tree, mbar = two_link.tree, np.full(2, 0.01)
    edge = certify(two_link, 0.01, condition="weighted", levels=False).scale_refuted
    statement = Statement("weighted", 0.999 * edge, 1.0, 0, np.zeros(2), np.zeros(2))
    # A second joint that is not followed exactly, over so many turns that the narrowest cell is more than one.
    wide = problem_of(tree, np.full(2, -1e13), np.full(2, 1e13), mbar, statement)._replace(exact=False)
    walk = prove(wide)
    assert walk.status == "narrow"
    assert walk.q is not None
    near = wide._replace(lower=walk.q.copy(), upper=walk.q.copy())
    assert prove(near).status == "proven"
    said = Obstacle(walk.status, statement, walk.q).reason(near=False)
    assert "halved 40 times" in said
    assert "rounding" not in said
    # The same over one turn is proven.
    assert prove(wide._replace(lower=np.full(2, -np.pi), upper=np.full(2, np.pi))).status == "proven"


def test_no_multiple_is_the_reason_where_lemma_1_has_none(two_link: Arm) -> None:
    found = certify(two_link, np.array([1e-3, 1e3]), levels=False)
    assert found.reason == NO_MULTIPLE
    q = found.refuted_q
    mass = two_link.mass_matrix(q)
    inverse = 1.0 / found.mbar
    assert np.linalg.eigvalsh(mass * (inverse + inverse[:, None]))[0] <= 0.0


@pytest.mark.parametrize("blind", [False, True], ids=["at once", "on the way"])
def test_a_level_below_a_norm_that_was_found_is_refuted_and_so_it_is_said(two_link: Arm, blind: bool) -> None:
    # A search of one sample sees little; the proof then finds the place, and the search goes on from there.
    search: dict[str, Any] = {"samples": 1, "starts": 0} if blind else {}
    found = certify(two_link, 0.01, level=0.985, **search)
    assert found.verdict == "violated"
    assert found.lower >= 0.985
    assert found.reason == NORM_REFUTED


def test_a_level_that_is_proven_is_the_reason_to_stop(two_link: Arm) -> None:
    found = certify(two_link, 0.01, level=0.99)
    assert found.verdict == "holds"
    assert found.reason == LEVEL_PROVEN


def test_one_bound_for_the_corners_of_an_armature_range_is_named_where_it_is_too_weak() -> None:
    arm, wide = load_arm("ur5"), (10.0, 12.0)
    norm = certify(arm, 11.0, armature=wide, level=0.01).lower
    level = norm + 0.02 * (1.0 - norm)
    found = certify(arm, 11.0, armature=wide, level=level, budget=20.0)
    assert found.verdict == "undecided"
    assert "one bound for all ends of the armature's range" in found.reason
    # With few corners each is proven for itself.
    few = {**dict.fromkeys(arm.joint_names, 11.0), "elbow_joint": wide}
    assert certify(arm, 11.0, armature=few, level=level, budget=20.0).reason == LEVEL_PROVEN


@pytest.mark.parametrize(("more", "said"), [((), GAP_MET), (("--gap", "1e-11"), "too near to be told")])
def test_verify_and_design_print_the_reason_and_have_it_in_json(
    capsys: pytest.CaptureFixture[str], more: tuple[str, ...], said: str
) -> None:
    for command in (["verify", "two_link", "--mbar", "0.01"], ["design", "two_link", "--budget", "120"]):
        for as_json in (False, True):
            with pytest.raises(SystemExit) as end:
                main([*command, "--certify", *more, *(["--json"] if as_json else [])])
            assert end.value.code == 0
            out = capsys.readouterr().out
            assert said in (json.loads(out)["reason"] if as_json else out)
            assert as_json or "the proof stopped because: " in out


def prover_of(arm: Arm, mbar: Any, budget: float = 60.0) -> Prover:
    found = cases(arm)
    values = np.array(np.broadcast_to(mbar, (arm.nv,)), dtype=np.float64)
    worst = Worst(found, values, "lemma1", 1024, 8, 0)
    return Prover(found, values, "lemma1", worst, began=time.monotonic(), budget=budget, threads=1, progress=None)


def test_levels_that_took_more_than_their_share_of_the_time_are_not_said_to_be_out_of_it() -> None:
    prover = prover_of(load_arm("ur5"), UR5_MBAR)
    prover.reason = GAP_MET
    prover.lower_level(1e-3)
    assert prover.reason == f"{GAP_MET}; the bound of the norm is not lower because: {SHARE_SPENT}"
    late = prover_of(load_arm("ur5"), UR5_MBAR, budget=1e-3)
    late.reason = GAP_MET
    late.lower_level(10.0)
    assert late.reason.endswith(OUT_OF_TIME)


def test_news_smaller_than_the_margin_does_not_keep_a_proof_going_round(two_link: Arm) -> None:
    prover = prover_of(two_link, 0.01)
    climb: Callable[..., None] = prover.worst.climb

    def restless(*args: Any) -> None:
        climb(*args)
        prover.worst.scale *= 1.0 - 1e-13

    prover.worst.climb = restless  # type: ignore[method-assign]
    began = time.monotonic()
    prover.raise_scale(1e-11)
    assert "too near" in prover.reason
    assert time.monotonic() - began < 30.0


def test_a_loop_that_is_stable_by_a_hair_is_not_proven_because_it_is_too_near(two_link: Arm) -> None:
    loop = SampledLoop(np.full(2, 0.01), np.full(2, 5.0), np.full(2, 300.0), 1e-3)
    proof = certify_loop(two_link, loop)
    assert proof.verdict == "stable"
    factor = proof.stable_between[1] / proof.seen_between[1]
    near = certify_loop(two_link, SampledLoop(np.full(2, 0.01 * factor * (1.0 - 2e-10)), loop.ks, loop.beta, 1e-3))
    assert near.verdict == "undecided"
    assert "too near to be told" in near.reason
    assert near.reason in near.lines()[0]
    assert near.to_json_dict()["reason"] == near.reason


def test_a_loop_says_why_nothing_is_proven_of_gravity(two_link: Arm) -> None:
    light = certify_loop(two_link, SampledLoop(np.full(2, 0.01), np.full(2, 0.05), np.full(2, 0.5), 1e-3))
    assert light.verdict == "stable"
    assert light.gravity is None
    assert light.no_gravity == "the small gain is too weak even between the eigenvalues found"
    assert light.no_gravity in light.lines()[-1]
    floating = certify_loop(
        two_link.replace(gravity=(0.0, 0.0, 0.0)),
        SampledLoop(np.full(2, 0.01), np.full(2, 5.0), np.full(2, 300.0), 1e-3),
    )
    assert floating.no_gravity == "there is none"
