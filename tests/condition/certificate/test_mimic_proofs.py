"""Proofs about joints that mimic others: sufficient, never more than what a search finds to be true."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import write
from coupled_urdf import coupled_tree, gripper, parallelogram

from asmc_pin.arms import Arm, load_arm
from asmc_pin.cli import main
from asmc_pin.condition import bounds
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.certificate.mimic_shares import halved, unfold
from asmc_pin.condition.certificate.statement import Kind, Statement
from asmc_pin.condition.certificate.statement_forms import problem_of
from asmc_pin.condition.certificate.walk import prove
from asmc_pin.condition.domain.base_branches import branch_of, branches
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.rigid_body.mass_matrix import mass_matrices
from asmc_pin.sampled import SampledLoop, certify_loop


def bearable(arm: Arm, share: float) -> np.ndarray[Any, Any]:
    """An M̄ that satisfies the conditions at that share of what single joints feel least."""
    mass = arm.mass_matrix(np.random.default_rng(0).uniform(*arm.box, (2000, arm.nv)))
    return np.asarray(share / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2).max(axis=0))


def statement(arm: Arm, kind: Kind, scale: float, level: float = 1.0) -> Statement:
    return Statement(kind, scale, level, 0, arm.armature, np.zeros(arm.nv))


@pytest.mark.parametrize("kind", ["weighted", "bounded", "lemma1", "level"])
@pytest.mark.parametrize("seed", range(4))
def test_on_motions_that_are_allowed_the_free_form_is_the_statement(tmp_path: Path, kind: Kind, seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = load_arm(write(tmp_path, coupled_tree(rng, joints=6, followers=3, chained=True)), armature=0.05)
    box, mbar = resolve_box(arm), rng.uniform(0.1, 0.5, arm.nv)
    told = statement(arm, kind, 0.9, 0.7)
    tree, lower, upper, own_mbar, own, share, even = unfold(arm.tree, box.lower, box.upper, mbar, told)
    coupling = arm.tree.coupling
    for part in (share, even):
        assert np.bincount(coupling.coordinate, coupling.ratio**2 * part) == pytest.approx(np.ones(arm.nv), abs=1e-12)
    q = rng.uniform(box.lower, box.upper, (50, arm.nv))
    joints = coupling.joints(q)
    assert np.all((joints >= lower) & (joints <= upper))
    x = rng.normal(size=(50, arm.nv))
    z = coupling.rates(x)
    ours = np.einsum("bi,bij,bj->b", x, arm.mass_matrix(q) - 0.9 * np.diag(mbar), x)
    form = mass_matrices(tree, joints) - 0.9 * np.diag(own_mbar * share)
    assert np.einsum("bi,bij,bj->b", z, form, z) == pytest.approx(ours, abs=1e-10)
    assert own.armature.sum() == pytest.approx(arm.model.armature.sum())


@pytest.mark.parametrize("kind", ["weighted", "lemma1"])
@pytest.mark.parametrize("seed", range(8))
def test_no_proof_of_a_coupled_arm_contradicts_a_configuration(tmp_path: Path, kind: Kind, seed: int) -> None:
    rng = np.random.default_rng(50 + seed)
    arm = load_arm(write(tmp_path, coupled_tree(rng, joints=4, followers=2)), armature=0.02)
    mbar, box = bearable(arm, 0.9), resolve_box(arm)
    width = rng.uniform(0.05, 0.5) * (box.upper - box.lower)
    lower = box.lower + rng.random(arm.nv) * (box.upper - box.lower - width)
    proven = 0.0
    for scale in np.linspace(0.1, 4.0, 14):
        problem = problem_of(arm.tree, lower, lower + width, mbar, statement(arm, kind, float(scale)))
        if prove(problem, watch=lambda tests, _: tests > 3000).status == "proven":
            proven = float(scale)
    mass = arm.mass_matrix(rng.uniform(lower, lower + width, (20_000, arm.nv)))
    if kind == "weighted":
        values = np.linalg.eigvalsh(mass / np.sqrt(mbar) / np.sqrt(mbar)[:, None])[:, 0] * 2.0
    else:
        values = np.linalg.eigvalsh(mass / mbar + mass / mbar[:, None])[:, 0]
    assert proven == 0.0 or proven <= values.min()
    if kind == "weighted":
        # The inertia of the free tree is positive, so that something is always proven.
        assert prove(problem_of(arm.tree, lower, lower, mbar, statement(arm, kind, 0.01))).status == "proven"


def test_a_parallelogram_is_proven_to_what_holds(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, parallelogram()), armature=0.02)
    for condition in ("weighted", "lemma1"):
        result = certify(arm, bearable(arm, 0.9), condition=condition, budget=20.0, levels=False)  # type: ignore[arg-type]
        assert result.verdict == "holds"
        assert result.gap < 0.05
        assert any("proven as if each moved freely" in note for note in result.notes)
    found = bounds(arm, budget=20.0)
    assert found.lower.proven is not None
    assert 0.95 * found.lower.found < found.lower.proven < found.lower.found
    assert found.coriolis.proven is None


def test_a_gripper_is_proven_and_a_file_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, gripper())
    arm = load_arm(path, armature=0.02)
    mbar = bearable(arm, 0.9)
    result = certify(arm, mbar, budget=20.0, levels=False)
    assert result.verdict == "holds"
    assert result.scale_proven < result.scale_refuted
    asked = ["--mbar", ",".join(map(repr, mbar.tolist())), "--armature", "0.02", "--certify", "--budget", "10"]
    with pytest.raises(SystemExit) as end:
        raise SystemExit(main(["verify", str(path), *asked, "--certificate", str(tmp_path / "proof.cert")]))
    said = capsys.readouterr()
    assert end.value.code == 0
    assert "bore a share of its m̄" in said.out.replace("\n", " ")
    assert "certificate: " in said.err
    with pytest.raises(SystemExit) as end:
        raise SystemExit(main(["check", str(tmp_path / "proof.cert")]))
    said = capsys.readouterr()
    assert end.value.code == 0
    assert "Mimicking joints: right_finger = 1 · left_finger" in said.out


def test_a_loop_is_proven_without_gravity_where_its_eigenvalues_are(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()), armature=0.02)
    proof = certify_loop(arm, SampledLoop(0.5 * bearable(arm, 0.9), 5.0, 5.0, 1e-3), budget=20.0)
    assert (proof.verdict, proof.gravity) == ("stable", None)


def test_more_than_what_holds_is_refuted_by_a_configuration(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()), armature=0.02)
    assert certify(arm, bearable(arm, 3.0), budget=10.0).verdict == "violated"


def test_halves_of_a_box_cover_it_and_begin_with_what_is_followed(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, gripper()))
    box = resolve_box(arm)
    (low, middle), (again, high) = halved(arm.tree, box, (box.lower, box.upper))
    assert np.array_equal(low, box.lower)
    assert np.array_equal(high, box.upper)
    assert np.flatnonzero(middle != box.upper).tolist() == np.flatnonzero(again != box.lower).tolist() == [2]
    assert middle[2] == again[2]
    assert halved(arm.tree, box, (box.centre, box.centre)) == []


def test_branches_that_a_mimic_joint_ties_are_one(tmp_path: Path) -> None:
    text = gripper().replace('parent link="hand"/><child link="left"', 'parent link="base"/><child link="left"')
    arm = load_arm(write(tmp_path, text))
    assert [part.tolist() for part in branches(arm.tree)] == [[0, 1, 2]]
    freed = load_arm(arm.source, lock={"right_finger": "free"})
    assert [part.tolist() for part in branches(freed.tree)] == [[0, 1, 3], [2]] or len(branches(freed.tree)) == 2
    pair = load_arm(write(tmp_path, gripper().replace("</robot>", "") + twin() + "</robot>", "pair.urdf"))
    parts = branches(pair.tree)
    q = np.random.default_rng(1).uniform(*pair.box)
    mass = pair.mass_matrix(q)
    assert sorted(np.concatenate(parts).tolist()) == list(range(pair.nv))
    for part in parts:
        tree = branch_of(pair.tree, part)
        assert mass_matrices(tree, q[part]) == pytest.approx(mass[np.ix_(part, part)], abs=1e-14)


def twin() -> str:
    """The links and joints of a second gripper beside the first, on the same base."""
    text = gripper().split("\n", 2)[2].rsplit("</robot>", 1)[0]
    for name in ("arm", "hand", "left", "right", "lift", "roll", "left_finger", "right_finger"):
        text = text.replace(f'"{name}"', f'"other_{name}"')
    return text
