"""Conditions on M̄ for arms with joints that mimic others: searched in the driven joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arm_urdf import write
from coupled_urdf import coupled_tree, gripper, parallelogram

from asmc_pin.arms import load_arm
from asmc_pin.condition import lemma1_norm, verify
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.rigid_body.recursion import links_of


@pytest.mark.parametrize("kind", [compiled_norms.LEMMA1, compiled_norms.WEIGHTED, compiled_norms.BANDWIDTH])
def test_the_gradient_of_a_coupled_arm_is_that_of_its_figure(tmp_path: Path, kind: int) -> None:
    arm = load_arm(write(tmp_path, coupled_tree(np.random.default_rng(3), joints=7, followers=3, chained=True)))
    links, mbar, armature = links_of(arm.tree), np.array([0.5, 0.1, 0.3, 0.2]), np.full(4, 0.05)
    q, step = np.array([0.3, -0.8, 0.5, 1.1]), 1e-6
    by_angle, by_armature = np.empty(4), np.empty(4)
    compiled_norms.figure_gradient(kind, links, armature, q, mbar, by_angle, by_armature)
    value = np.empty((8,))
    points = np.concatenate([q + step * np.eye(4), q - step * np.eye(4)])
    compiled_norms.figures(kind, links, armature[None], points, mbar, value)
    slope = (value[:4] - value[4:]) / (2.0 * step)
    np.testing.assert_allclose(by_angle, slope, rtol=1e-5, atol=1e-5 * np.abs(slope).max())


def test_the_worst_that_a_search_finds_is_a_norm_of_the_coupled_arm(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, coupled_tree(np.random.default_rng(5), joints=6, followers=2)), armature=0.1)
    report = verify(arm, 0.2, samples=2048, starts=8)
    norms = lemma1_norm(arm.mass_matrix(report.worst_q), np.full(arm.nv, 0.2))
    assert report.lower == pytest.approx(float(norms), rel=1e-10)
    assert report.lower >= report.samples.max()


def test_a_parallelogram_is_judged_by_its_one_inertia(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, parallelogram(0.4, 3.0, 2.0, 0.05)))
    inertia = 0.05 + 5.0 * 0.4**2
    assert verify(arm, 1.0, samples=64).lower == pytest.approx(abs(1.0 - 1.0 / inertia), rel=1e-12)
    # As two motors the second bar's turning counts: another arm, and another answer.
    freed = load_arm(arm.source, lock={"level": "free"})
    assert verify(freed, 1.0, samples=64).lower > 1.0


def test_what_follows_what_is_among_the_hypotheses(tmp_path: Path) -> None:
    report = verify(load_arm(write(tmp_path, gripper())), 0.05, samples=64)
    assert report.to_json_dict()["mimics"] == {
        "right_finger": {"joint": "left_finger", "multiplier": 1.0, "offset": 0.0}
    }
    assert "Mimicking joints: right_finger = 1 · left_finger" in report.lines()
    assert "mimics" not in verify(load_arm("two_link"), 0.05, samples=64).to_json_dict()


def test_a_joint_on_the_base_matters_where_a_joint_further_out_follows_it(tmp_path: Path) -> None:
    text = gripper().replace('mimic joint="left_finger" multiplier="1.0"', 'mimic joint="lift" multiplier="0.01"')
    text = text.replace('lower="0" upper="0.04"', 'lower="-1" upper="1"')
    box = resolve_box(load_arm(write(tmp_path, text)))
    assert not box.idle.any()
    assert not box.periodic.any()
    assert resolve_box(load_arm(write(tmp_path, gripper()))).idle.tolist() == [True, False, False]
