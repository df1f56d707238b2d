"""No certificate is ever contradicted: what is proven is never more than what a search finds to be true.

Each case asks for the strongest statement that is proven about one box of a random arm, so that a bound that is wrong
by a hair somewhere shows as a proof of something false. `make soundness` runs thousands, `make test-all` every third
block of them; a few run always.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from certificate_cases import Question, blocks, largest_proven, norms, proven_in_one_box, question
from condition_cases import chain

from asmc_pin._typing import Array
from asmc_pin.condition import CONDITIONS, search_worst
from asmc_pin.condition.certificate import certify
from asmc_pin.condition.certificate.statement import Kind
from asmc_pin.condition.certificate.statement_forms import canonical
from asmc_pin.condition.checker import check
from asmc_pin.condition.checker.boxes.box_bounds import holds
from asmc_pin.condition.checker.boxes.quadratic_form import form_of
from asmc_pin.condition.checker.reading.header_parts import WrittenStatement
from asmc_pin.condition.checker.reading.link_chain import Chain
from asmc_pin.rigid_body.tree import Tree

KINDS: tuple[Kind, ...] = ("weighted", "bounded", "lemma1", "level")
FEW, MANY = 12, 900
ABOVE = 1.0 + 1e-8
"""The search's own last digits."""


def checker_proves(asked: Question, x: float) -> bool:
    if x <= 0.0 or (asked.kind in ("bounded", "level") and x >= 1.0):
        return False
    s = asked.statement(x)
    statement = WrittenStatement.model_construct(
        kind=s.kind, scale=s.scale, level=s.level, case=0, armature=tuple(s.armature), slack=tuple(s.slack)
    )
    chain = chain_of_tree(asked.tree)
    form = form_of(chain, asked.mbar, statement, asked.lower, asked.upper)
    half = 0.5 * (asked.upper - asked.lower)
    half = np.where(chain.parent < 0, 0.0, half)
    if form.exact:
        half[1] = 0.0
    return bool(holds(form, (0.5 * (asked.lower + asked.upper))[None], half[None])[0][0])


def chain_of_tree(tree: Tree) -> Chain:
    """A tree in the checker's own form; its inertias are compared with the prover's elsewhere."""
    place = np.zeros((tree.nv, 4, 4))
    place[:, :3, :3], place[:, :3, 3], place[:, 3, 3] = tree.rotation, tree.translation, 1.0
    inertia = np.empty((tree.nv, 6, 6))
    for i in range(tree.nv):
        x, y, z = tree.com[i]
        c = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        inertia[i, :3, :3] = tree.inertia[i] + tree.mass[i] * c @ c.T
        inertia[i, :3, 3:], inertia[i, 3:, :3] = tree.mass[i] * c, tree.mass[i] * c.T
        inertia[i, 3:, 3:] = tree.mass[i] * np.eye(3)
    return Chain(tree.parent, place, tree.axis, tree.prismatic, inertia)


def most_proven(seeds: range, kind: Kind, proven: object) -> list[float]:
    """Strongest proven statement over strongest true one, per case that has one."""
    shares = []
    for seed in seeds:
        asked = question(seed, kind)
        if asked is not None:
            shares.append(largest_proven(asked, proven) / asked.worst)  # type: ignore[arg-type]
    return shares


@pytest.mark.parametrize("kind", KINDS)
def test_no_box_is_proven_beyond_what_search_finds(kind: Kind) -> None:
    shares = most_proven(range(FEW), kind, proven_in_one_box)
    assert max(shares) <= ABOVE
    # And the bound is worth something: at small boxes it is next to the truth.
    assert np.quantile(shares, 0.8) > 0.99


@pytest.mark.parametrize("kind", KINDS)
def test_at_one_configuration_what_is_proven_is_what_is_true(kind: Kind) -> None:
    # Without cells nothing is lost: lift and recursion give M's own inequality, branches and slides included.
    tried = 0
    for seed in range(40):
        asked = question(seed, kind, point=True)
        if asked is not None and (kind in ("weighted", "lemma1") or asked.worst < 0.99):
            tried += 1
            assert largest_proven(asked, proven_in_one_box, 30) == pytest.approx(asked.worst, rel=1e-6)
    assert tried >= 10


@pytest.mark.parametrize("kind", KINDS)
def test_the_checker_proves_no_box_beyond_what_search_finds(kind: Kind) -> None:
    shares = most_proven(range(100, 100 + FEW // 2), kind, checker_proves)
    assert max(shares) <= ABOVE
    assert max(shares) > 0.9


@pytest.mark.parametrize("condition", CONDITIONS)
def test_no_certificate_of_a_random_arm_is_contradicted(condition: str, tmp_path: Path) -> None:
    for seed in range(2):
        contradict(condition, seed, tmp_path)


def contradict(condition: str, seed: int, folder: Path) -> None:
    """Certify a random arm; then search harder than it did, and replay its file."""
    rng = np.random.default_rng(seed)
    arm = chain(folder, seed, int(rng.integers(2, 5)), prismatic=bool(rng.random() < 0.3))
    q = rng.uniform(*arm.box, (200, arm.nv))
    mbar: Array = np.full(arm.nv, 1.2 * np.linalg.eigvalsh(arm.mass_matrix(q)).min()) * rng.uniform(0.9, 1.1, arm.nv)
    result = certify(arm, mbar, condition=condition, gap=0.05, budget=3.0, seed=seed)  # type: ignore[arg-type]
    assert result.scale_proven < result.scale_refuted
    norm_of = norms(condition)
    if result.scale_proven > 0.0:
        norm, worst = search_worst(arm, result.scale_proven * mbar, condition, seed=seed + 1)  # type: ignore[arg-type]
        assert norm < 1.0
        assert norm_of(arm.mass_matrix(worst), result.scale_proven * mbar) < 1.0
        replayed = check(result.save(folder / f"{seed}.cert"))
        assert replayed.valid, replayed.problems
    assert norm_of(arm.mass_matrix(result.refuted_q), result.scale_refuted * mbar) > 1.0 - 1e-12
    norm, _ = search_worst(arm, mbar, condition, seed=seed + 1)  # type: ignore[arg-type]
    if result.upper is not None:
        assert norm < result.upper
    assert (result.verdict == "holds") <= (norm < 1.0)
    assert (result.verdict == "violated") <= (result.lower >= 1.0)


@pytest.mark.soundness
@pytest.mark.parametrize("block", blocks(range(30)))
@pytest.mark.parametrize("kind", KINDS)
def test_thousands_of_boxes_are_never_proven_beyond_what_search_finds(kind: Kind, block: int) -> None:
    each = MANY // 30
    assert max(most_proven(range(1000 + block * each, 1000 + (block + 1) * each), kind, proven_in_one_box)) <= ABOVE


@pytest.mark.soundness
@pytest.mark.parametrize("block", blocks(range(10)))
@pytest.mark.parametrize("kind", KINDS)
def test_hundreds_of_boxes_are_never_proven_beyond_that_by_the_checker(kind: Kind, block: int) -> None:
    assert max(most_proven(range(9000 + 30 * block, 9030 + 30 * block), kind, checker_proves)) <= ABOVE


@pytest.mark.soundness
@pytest.mark.parametrize("block", blocks(range(10)))
@pytest.mark.parametrize("condition", CONDITIONS)
def test_hundreds_of_certificates_are_never_contradicted(condition: str, block: int, tmp_path: Path) -> None:
    for seed in range(100 + 20 * block, 120 + 20 * block):
        contradict(condition, seed, tmp_path)


def test_the_canonical_frames_carry_the_same_inertia() -> None:
    asked = question(3, "weighted")
    assert asked is not None
    _, rigid = canonical(asked.tree)
    # Turning a frame leaves the mass, and the inertia's trace about the origin, as they were.
    theirs = chain_of_tree(asked.tree).inertia
    assert np.trace(rigid, axis1=1, axis2=2) == pytest.approx(np.trace(theirs, axis1=1, axis2=2), rel=1e-12)
