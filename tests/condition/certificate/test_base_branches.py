"""Arms on one base: M is block diagonal, and each block is proven as a problem of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import two_arms, write
from certificate_files import rewrite

from asmc_pin import check, load_arm
from asmc_pin.arms import Arm
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.certificate.compiled.bisection_tree import LEAF
from asmc_pin.condition.checker.boxes.bisection import Broken, by_branch
from asmc_pin.condition.domain.base_branches import branch_of, branches


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    return load_arm(write(tmp_path_factory.mktemp("pair"), two_arms(3)))


def test_inertia_of_a_branch_is_its_block_of_the_whole_and_nothing_couples_them(pair: Arm) -> None:
    parts = branches(pair.tree)
    assert [part.tolist() for part in parts] == [[0, 1, 2], [3, 4, 5]]
    mass = pair.mass_matrix(np.random.default_rng(0).uniform(*pair.box, (50, 6)))
    assert np.abs(mass[:, :3, 3:]).max() < 1e-14
    for part in parts:
        tree = branch_of(pair.tree, part)
        assert tree.parent.tolist() == [-1, 0, 1]
        assert tree.mass == pytest.approx(pair.tree.mass[part])


def test_arms_on_a_torso_that_turns_are_one_branch(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_arms(2, torso=True)))
    assert len(branches(arm.tree)) == 1
    assert np.abs(arm.mass_matrix(np.full(5, 0.3))[1:3, 3:]).max() < 1e-12
    assert np.abs(arm.mass_matrix(np.full(5, 0.3))[0, 1:]).max() > 1e-3


@pytest.mark.parametrize("condition", ["weighted", "lemma1"])
def test_two_arms_need_the_boxes_of_each_and_not_their_product(pair: Arm, condition: Any, tmp_path: Path) -> None:
    mass = pair.mass_matrix(np.random.default_rng(1).uniform(*pair.box, (4000, 6)))
    mbar = 0.9 / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2).max(axis=0)
    found = certify(pair, mbar, condition=condition, gap=0.01, budget=30.0, levels=False)
    assert found.gap <= 0.01
    alone = 0
    for other in (("right1_joint", "right2_joint", "right3_joint"), ("left1_joint", "left2_joint", "left3_joint")):
        one = load_arm(pair.source, lock=dict.fromkeys(other, 0.0))
        mine = mbar[:3] if other[0].startswith("right") else mbar[3:]
        # What is proven of both together is what is proven of the weaker one.
        result = certify(one, mine, condition=condition, gap=0.01, budget=30.0, levels=False)
        assert result.scale_refuted >= found.scale_refuted * (1.0 - 1e-9)
        alone += result.boxes
    assert found.boxes <= 2 * alone
    replayed = check(found.save(tmp_path / "pair.npz"))
    assert replayed.valid, replayed.problems


def test_a_record_in_which_one_branch_halves_the_others_joint_is_broken() -> None:
    parent = np.array([-1, 0, -1, 2])
    good = np.array([1, LEAF, LEAF, 3, LEAF, LEAF], dtype=np.uint8)
    found = list(by_branch(good, parent))
    assert [joints.tolist() for joints, _ in found] == [[0, 1], [2, 3]]
    assert [record.tolist() for _, record in found] == [[1, LEAF, LEAF]] * 2
    foreign = np.array([3, LEAF, LEAF, 1, LEAF, LEAF], dtype=np.uint8)
    for record, said in ((foreign, "not of its branch"), (good[:4], "open"), (np.append(good, good[1:2]), "goes on")):
        with pytest.raises(Broken, match=said):
            list(by_branch(record, parent))


def test_one_bisection_of_all_joints_is_not_cut_into_branches() -> None:
    parent = np.array([-1, 0, -1, 2])
    # Halved across the branches, and in one of them alone.
    for record in ([1, LEAF, 3, LEAF, LEAF], [1, LEAF, LEAF], [LEAF]):
        ((joints, found),) = by_branch(np.array(record, dtype=np.uint8), parent)
        assert (joints.tolist(), found.tolist()) == ([0, 1, 2, 3], record)


def test_a_record_of_all_joints_together_as_it_was_written_before_is_read_too(pair: Arm, tmp_path: Path) -> None:
    box = {name: (0.1, 0.11) for name in pair.joint_names}
    proof = certify(pair, 0.2 * np.linalg.eigvalsh(pair.mass_matrix(np.full(6, 0.1)))[0], box=box, levels=False)
    assert [record.tolist() for record in (p.record for p in proof.proofs)] == [[LEAF, LEAF]]

    def whole(_header: object, records: list[Any]) -> None:
        # Halved twice more than need be, across the branches.
        records[:] = [np.array([1, LEAF, 4, LEAF, LEAF], dtype=np.uint8)]

    replayed = check(rewrite(proof.save(tmp_path / "new.cert"), tmp_path / "old.cert", whole))
    assert replayed.valid, replayed.problems
    assert replayed.statements[0].boxes == 3

    def bolder(header: dict[str, Any], records: list[Any]) -> None:
        whole(header, records)
        header["statements"][0]["scale"] = 100.0

    assert not check(rewrite(tmp_path / "new.cert", tmp_path / "bold.cert", bolder)).valid
