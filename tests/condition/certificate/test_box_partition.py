"""A joint box cut into boxes that are proven, refuted or open: what each says is so, whatever the arm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import two_arms, write
from certificate_cases import climb, norms
from condition_cases import chain
from coupled_urdf import parallelogram

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.condition.certificate.box_partition import OPEN, PROVEN, REFUTED, BoxPartition, partition
from asmc_pin.condition.domain.arm_ranges import cases
from asmc_pin.condition.search.samples import Domain
from asmc_pin.condition.search.worst_of_arm import scale_refuted, search_worst
from asmc_pin.errors import ParameterError
from asmc_pin.words.choices import Condition


def leaves(record: Array, lower: Array, upper: Array) -> list[tuple[int, Array, Array]]:
    """Mark and ends of every box of one bisection."""
    found, stack = [], [(lower, upper)]
    for byte in record.tolist():
        low, high = stack.pop()
        if byte >= OPEN:
            found.append((byte, low, high))
            continue
        middle = 0.5 * (low[byte] + high[byte])
        below, above = high.copy(), low.copy()
        below[byte] = above[byte] = middle
        stack += [(above, high), (low, below)]
    assert not stack
    return found


def cut(domain: Domain, mbar: Array, condition: Condition, *, most: int = 300) -> BoxPartition:
    return partition(domain, mbar, condition, budget=20.0, most=most)


def domain_of(folder: Path, kind: str) -> Domain:
    if kind == "two arms":
        arm = load_arm(write(folder, two_arms(2)))
    else:
        arm = chain(folder, 5, 3, prismatic=kind == "one that slides")
    return cases(arm, None, None, None, None)[0].domain


@pytest.mark.parametrize("kind", ["a chain", "one that slides", "two arms"])
@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
def test_proven_boxes_hold_no_violation_and_refuted_ones_do(tmp_path: Path, kind: str, condition: Condition) -> None:
    domain = domain_of(tmp_path, kind)
    arm, box = domain.arm, domain.box
    rng = np.random.default_rng(1)
    mass = arm.mass_matrix(rng.uniform(box.lower, box.upper, (256, arm.nv)))
    mbar = np.full(arm.nv, 0.5 * np.linalg.eigvalsh(mass)[:, 0].min())
    # A little more than holds everywhere.
    mbar *= 1.1 * scale_refuted(arm, mbar, condition, samples=2048)[0]
    found = cut(domain, mbar, condition)
    assert found.boxes(PROVEN) + found.boxes(REFUTED) + found.boxes(OPEN) == sum(
        len(leaves(record, box.lower, box.upper)) for record in found.records
    )
    parts = domain.by_branch()
    assert len(found.records) == len(parts)
    assert found.boxes(PROVEN) > 0
    assert found.boxes(REFUTED) > 0
    for record, part in zip(found.records, parts, strict=True):
        boxes = leaves(record, box.lower, box.upper)
        for mark, low, high in boxes:
            q = np.concatenate(
                (rng.uniform(low, high, (40, arm.nv)), rng.choice([0.0, 1.0], (20, arm.nv)) * (high - low) + low)
            )
            block = arm.mass_matrix(q)[:, part.joints[:, None], part.joints]
            largest = norms(condition)(block, mbar[part.joints]).max()
            assert not (mark == PROVEN and largest >= 1.0)
        here, own = part.joints, mbar[part.joints]
        for _, low, high in [item for item in boxes if item[0] == REFUTED][:3]:
            largest = climb(part.tree, low[here], high[here], lambda M, own=own: norms(condition)(M, own), 0)
            assert largest >= 1.0
        volume = sum(float(np.prod((high - low) / (box.upper - box.lower))) for _, low, high in boxes)
        assert volume == pytest.approx(1.0)


def test_where_all_boxes_are_proven_it_holds_and_where_one_is_refuted_it_does_not(tmp_path: Path) -> None:
    arm = load_arm("two_link")
    domain = cases(arm, None, None, None, None)[0].domain
    good = cut(domain, np.array([0.02, 0.02]), "lemma1")
    assert good.holds
    bad = cut(domain, np.array([0.05, 0.09]), "lemma1")
    assert not bad.holds
    assert bad.boxes(REFUTED) > 0
    assert bad.boxes(PROVEN) > 0


def test_a_violation_that_is_known_is_in_a_refuted_box_however_short_the_time(tmp_path: Path) -> None:
    arm = load_arm("ur5")
    mbar = np.array([0.3, 0.3, 0.3, 0.08, 0.09, 0.02])
    worst, q = search_worst(arm, mbar, samples=512)
    assert worst > 1.0
    domain = cases(arm, None, None, None, None)[0].domain
    found = partition(domain, mbar, "lemma1", budget=1e-9, known=q)
    ((mark, low, high),) = [
        item for item in leaves(found.records[0], *arm.box) if (item[1] <= q).all() and (q <= item[2]).all()
    ]
    assert mark == REFUTED
    assert found.boxes(OPEN) > 0
    assert (low < high).all()


def test_of_joints_that_mimic_others_no_boxes_are_promised(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, parallelogram()))
    with pytest.raises(ParameterError, match="mimic others"):
        cut(cases(arm, None, None, None, None)[0].domain, np.array([0.1]), "weighted")
