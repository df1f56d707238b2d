"""Joints that follow others as the checker takes them apart: what each bears, and which cells it looks at again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, two_arms
from check_cases import KINDS, arm, case, condition_of, hexed, parsed_statement, statement, told
from coupled_urdf import WIDE, coupled_tree, mimic
from flint import arb, ctx

from asmc_pin._typing import Array
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.boxes.pieces_of_statement import StatementPart, image, parts_of
from asmc_pin.condition.checker.boxes.quadratic_form import form_of, joint_space, least_eigenvalues
from asmc_pin.condition.checker.boxes.statements import _some_of, replay_statement
from asmc_pin.condition.checker.reading.certificate_schema import Contents
from asmc_pin.condition.checker.reading.header_parts import Malformed
from asmc_pin.condition.checker.reading.link_chain import Chain, chain_of
from asmc_pin.condition.checker.reading.urdf_text import description

ONE_BOX = np.array([255, 255], dtype=np.uint8)
"""One piece of the coordinates' box, and one box of the joints in it."""


def _coupled(seed: int, joints: int = 4) -> tuple[Chain, BallArm, list[str], list[str]]:
    """A serial arm, half of whose joints follow others."""
    text = coupled_tree(np.random.default_rng(seed), joints=joints, followers=joints // 2, serial=True)
    robot_of = description(text)
    moving = [f"j{k}" for k in range(joints)]
    follows = {each.name for on in robot_of.children.values() for each in on if each.mimic is not None}
    own = [name for name in moving if name not in follows]
    read = robot_of, own, {}, None, moving
    return chain_of(*read), BallArm(*read), own, moving


def _said(kind: str, own: list[str], moving: list[str], mbar: Array, weights: Array, **more: Any) -> Contents:
    n = len(own)
    rows = {"weights": hexed([weights]), **more}
    cases = [case(n, lower=[0.1] * n, upper=[0.2] * n, armature_upper=[5.0] * n)]
    stated = [statement(n, kind, **rows)]
    return told(
        n, joints=own, moving=moving, mbar=hexed(mbar), condition=condition_of(kind), cases=cases, statements=stated
    )


def _part(made: Contents, chain: Chain, balls: BallArm) -> StatementPart:
    (part,) = parts_of(made, made.statements[0], ONE_BOX, chain, balls.follow)
    return part


def _of_the_arm(kind: str, M: Array, mbar: Array, f: float, gamma: float) -> Array:
    """The statement's matrix in docs/certificate.md, of the arm itself; velocities of two in units of √m̄."""
    if kind == "weighted":
        return np.asarray(M - f / (1.0 + gamma) * np.diag(mbar))
    if kind == "bounded":
        return np.asarray(f / (1.0 - gamma) * np.diag(mbar) - M)
    root = np.sqrt(mbar)
    first = M * (root[:, None] / root + root / root[:, None]) - f * np.diag(mbar)
    if kind == "lemma1":
        return np.asarray(first)
    s = np.sqrt(1.0 - gamma**2)
    mixed = s * M * root[:, None] / root
    whole = np.block([[first, mixed], [mixed.T, f * np.diag(mbar)]])
    order = np.arange(2 * mbar.size).reshape(2, -1).T.ravel()
    return np.asarray(whole[np.ix_(order, order)])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_what_joints_bear_is_taken_only_where_the_proof_of_the_joints_is_one_of_the_arm(kind: str, seed: int) -> None:
    chain, balls, own, moving = _coupled(seed)
    rng = np.random.default_rng(seed)
    mbar, armature = rng.uniform(0.5, 2.0, len(own)), rng.uniform(0.1, 1.0, len(own))
    f, gamma = 0.7, {"weighted": 1.0, "bounded": 0.3, "lemma1": 1.0, "level": 0.6}[kind]
    S, e = chain.spread, 2 if kind == "level" else 1
    q = rng.uniform(0.1, 0.2, len(own))
    M = chain.arm_mass(q) + np.diag(armature)
    for share in (0.7, 1.0 - 1e-6, 1.0 + 1e-6, 1.3):
        # Any weights, some below nothing, that come to m̄ times a share on what S allows.
        weights = rng.uniform(-1.0, 2.0, len(moving))
        for c in range(len(own)):
            squares = chain.ratio**2 * (chain.coordinate == c)
            weights[squares > 0.0] += (share * mbar[c] - weights @ squares) / squares.sum()
        made = _said(kind, own, moving, mbar, weights, scale=f, level=gamma, armature=armature)
        # `bounded` alone grows with what is borne.
        if (share > 1.0) == (kind == "bounded"):
            with pytest.raises(Malformed, match="do not bear its m̄"):
                _part(made, chain, balls)
            continue
        spread = np.kron(S, np.eye(e))
        proven = spread.T @ joint_space(_part(made, chain, balls).form, chain.joints(q)) @ spread
        beyond = _of_the_arm(kind, M, mbar, f, gamma) - proven
        assert np.linalg.eigvalsh(beyond)[0] > -1e-11 * np.abs(proven).max()


def test_a_row_that_is_not_of_the_branch_s_joints_is_refused() -> None:
    chain, balls, own, moving = _coupled(0)
    for count in (1, 3, 5):
        made = _said("weighted", own, moving, np.ones(2), np.full(count, 9.0))
        with pytest.raises(Malformed, match="not one number for each joint"):
            _part(made, chain, balls)


def test_the_box_of_the_joints_holds_every_value_that_they_have_rounding_included() -> None:
    rng = np.random.default_rng(0)
    for seed in range(30):
        chain, balls, own, _ = _coupled(seed)
        # From nothing to far away: what is rounded is as large as the far end.
        far = 10.0 ** rng.uniform(-3.0, 3.0, len(own))
        lower, upper = (np.zeros_like(far), far) if seed % 2 else (-far, np.zeros_like(far))
        low, high = image(chain, lower, upper)
        follow = balls.follow
        for i, (c, ratio, offset) in enumerate(zip(follow.coordinate, follow.ratio, follow.offset, strict=True)):
            with ctx.workprec(256):
                ends = [ratio * arb(float(end[c])) + offset for end in (lower, upper)]
                assert all(arb(float(low[i])) <= value <= arb(float(high[i])) for value in ends)
            assert high[i] - low[i] <= abs(chain.ratio[i]) * far[c] + 1e-13 * (abs(chain.ratio[i]) * far[c] + 1.0)


def test_a_statement_of_two_branches_is_proven_of_each_while_the_other_stands_in_the_middle() -> None:
    names = ["left1_joint", "left2_joint", "right1_joint", "right2_joint"]
    read = description(two_arms(2)), names, {}, None
    chain, balls = chain_of(*read), BallArm(*read)
    ends = case(4, lower=[0.0, -1.0, 1.0, -2.0], upper=[1.0, 2.0, 4.0, 1.0])
    made = told(4, joints=names, mbar=hexed([1.0] * 4), cases=[ends], statements=[statement(4)])
    parts = list(parts_of(made, made.statements[0], ONE_BOX, chain, balls.follow))
    assert [part.joints.tolist() for part in parts] == [[0, 1], [2, 3]]
    centre, half = np.array([0.3, 0.2]), np.array([0.1, 0.4])
    for part, expected, still in (
        (parts[0], [0.3, 0.2, 2.5, -0.5], [0.1, 0.4, 0.0, 0.0]),
        (parts[1], [0.5, 0.5, 1.0, 0.2], [0.0, 0.0, 0.1, 0.4]),  # put into the box, as a cell's rounded centre is
    ):
        middle, width = part.among(centre, half, made.cases[0])
        assert (middle.tolist(), width.tolist()) == (expected, still)


@pytest.mark.parametrize("kind", ["weighted", "lemma1"])
def test_a_follower_that_moves_no_mass_is_proven_again(kind: str) -> None:
    text = robot(
        link("base"),
        link("bar", inertial(2.0, "0 0 0", np.diag([0.3, 0.3, 0.4]))),
        link("pointer"),
        joint("turn", "base", "bar"),
        joint("show", "bar", "pointer", axis="0 1 0", extra=mimic("turn", before=WIDE)),
    )
    read = description(text), ["turn"], {}, None, ["turn", "show"]
    chain, balls = chain_of(*read), BallArm(*read)
    assert chain.arm_mass(np.array([0.15])) == pytest.approx(0.4)
    # M = 0.4 of one joint: both conditions hold up to M̄ = 0.8, and the pointer has to bear less than nothing.
    for scale, proven in ((0.79, True), (0.81, False)):
        made = _said(kind, ["turn"], ["turn", "show"], np.ones(1), np.array([1.002, -0.001]), scale=scale)
        result, problem = replay_statement(made, made.statements[0], ONE_BOX, chain, balls, "", 0, lambda share: None)
        assert (result.proven, problem == "") == (proven, proven)


@pytest.mark.parametrize(("many", "count"), [(100, 8), (9, 8), (64, 4), (5, 8), (37, 5)])
def test_the_cells_that_balls_are_asked_of_are_the_hardest_and_some_from_all_the_others(many: int, count: int) -> None:
    chain, _ = arm(0, 3)
    form = form_of(chain, np.ones(3), parsed_statement(3, "weighted"), -np.ones(3), np.ones(3))
    centres = np.random.default_rng(many).uniform(-1.0, 1.0, (many, 3))
    halves = np.arange(many, dtype=float)[:, None] * np.ones(3)
    chosen, same = _some_of(form, centres, halves, count)
    numbers = same[:, 0].astype(int)
    assert np.array_equal(chosen, centres[numbers])
    assert len(set(numbers.tolist())) == len(numbers) <= count
    rank = np.sort(np.argsort(np.argsort(least_eigenvalues(form, centres)))[numbers])
    hardest = count // 2
    assert rank[:hardest].tolist() == list(range(min(hardest, many)))
    # Of the others no long run is left out.
    gaps = np.diff([*rank[hardest:], many])
    assert gaps.max(initial=0) <= -(-(many - hardest) // (count - hardest))
