"""Repair on request: the nearest possible tensor, told wherever the arm goes."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import cvxpy
import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, two_joints, write
from hypothesis import given, settings
from hypothesis import strategies as st

from asmc_pin import agree, certify, check, load_arm, load_experiment, verify
from asmc_pin._typing import Array
from asmc_pin.arms.urdf.rigid_inertia import nearest_inertia, tensor_problem
from asmc_pin.errors import ArmError
from asmc_pin.results.provenance import provenance

SKEWED = np.array([[0.02, 0.004, 0.0], [0.004, 0.01, 0.001], [0.0, 0.001, 0.05]])
BROKEN = two_joints(tip=inertial(1.0, "0.1 0.03 0.02", SKEWED, rpy="0.3 -0.2 0.9"))
Q = np.array([0.4, -0.8])


def pseudo_inertia(mass: float, com: Array, about_com: Array) -> Array:
    """The 4 × 4 matrix of zeroth, first and second moments about the frame's origin, by its definition."""
    second = 0.5 * np.trace(about_com) * np.eye(3) - about_com + mass * np.outer(com, com)
    return np.block([[second, mass * com[:, None]], [mass * com[None, :], np.array([[mass]])]])


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_the_repair_is_the_nearest_by_a_semidefinite_program(entries: list[float]) -> None:
    given_tensor = np.zeros((3, 3))
    given_tensor[np.triu_indices(3)] = entries
    given_tensor += np.triu(given_tensor, 1).T
    mass, com = 1.3, np.array([0.2, -0.1, 0.4])
    tensor = cvxpy.Variable((3, 3), symmetric=True)
    second = 0.5 * cvxpy.trace(tensor) * np.eye(3) - tensor + mass * np.outer(com, com)
    first = mass * com[:, None]
    pseudo = cvxpy.bmat([[second, first], [first.T, np.array([[mass]])]])
    cvxpy.Problem(cvxpy.Minimize(cvxpy.sum_squares(tensor - given_tensor)), [pseudo >> 0]).solve(solver="CLARABEL")
    found = nearest_inertia(given_tensor)
    assert found == pytest.approx(tensor.value, abs=1e-4)
    assert np.linalg.eigvalsh(pseudo_inertia(mass, com, found))[0] >= -1e-12
    assert np.linalg.norm(found - given_tensor) <= np.linalg.norm(tensor.value - given_tensor) + 1e-6


def test_what_is_possible_stays_as_it_is(tmp_path: Path) -> None:
    plate = np.diag([0.01, 0.02, 0.03])
    assert nearest_inertia(plate) == pytest.approx(plate, abs=1e-15)
    path = write(tmp_path, two_joints())
    arm = load_arm(path, repair=True)
    assert arm.provisos == ()
    assert arm.urdf_text == path.read_text()


def test_without_the_option_it_is_refused_and_the_message_names_the_option(tmp_path: Path) -> None:
    with pytest.raises(ArmError, match="repair=True takes the nearest"):
        load_arm(write(tmp_path, BROKEN))


def test_a_repaired_arm_has_the_nearest_body_and_the_same_mass_and_centre(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, BROKEN), repair=True)
    wanted = nearest_inertia(SKEWED)
    assert np.linalg.eigvalsh(arm.tree.inertia[1]) == pytest.approx(np.linalg.eigvalsh(wanted), rel=1e-12)
    assert arm.tree.mass[1] == 1.0
    assert arm.tree.com[1] == pytest.approx([0.1, 0.03, 0.02], rel=1e-14)
    assert not tensor_problem(1.0, arm.tree.inertia[1])
    (proviso,) = arm.provisos
    change = np.linalg.norm(wanted - SKEWED)
    assert proviso.kind == "repaired inertia"
    assert (
        f"tensor of lower changed by {change:.3g} kg·m², {100 * change / np.linalg.norm(SKEWED):.2g} %" in proviso.text
    )


def test_several_links_of_one_body_are_repaired_as_a_whole(tmp_path: Path) -> None:
    flange = link("flange", inertial(0.5, "0 0.2 0", np.diag([0.001, 0.002, 0.001]), rpy="1 0 0"))
    text = BROKEN.replace("</robot>", flange + joint("weld", "lower", "flange", "fixed", rpy="0 0.4 0") + "</robot>")
    arm = load_arm(write(tmp_path, text), repair=True)
    body = arm.tree.inertia[1]
    assert np.linalg.eigvalsh(0.5 * np.trace(body) * np.eye(3) - body)[0] == pytest.approx(0.0, abs=1e-15)
    (proviso,) = arm.provisos
    assert "tensor of lower" in proviso.text


def test_the_repaired_text_is_the_same_arm_and_says_that_it_was_repaired(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, BROKEN), repair=True)
    again = load_arm(write(tmp_path, arm.urdf_text, "again.urdf"))
    assert np.array_equal(again.mass_matrix(Q), arm.mass_matrix(Q))
    assert again.provisos == arm.provisos


def test_mujoco_reads_the_repaired_text_the_same(tmp_path: Path) -> None:
    assert agree(load_arm(write(tmp_path, BROKEN), repair=True)).verdict == "agrees"


def test_a_wrong_sign_of_a_mass_is_not_repaired(tmp_path: Path) -> None:
    with pytest.raises(ArmError, match="correct the sign"):
        load_arm(write(tmp_path, two_joints(tip=inertial(-1.0))), repair=True)


def test_verdict_and_replayed_certificate_say_the_repair(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, BROKEN), repair=True)
    assert "repaired inertia" in verify(arm, 0.01, samples=20).hypotheses.title
    found = certify(arm, 0.02, condition="weighted", gap=0.2, budget=60.0, levels=False)
    replayed = check(found.save(tmp_path / "repaired.cert"))
    assert replayed.valid, replayed.problems
    (said,) = found.hypotheses.to_json_dict()["provisos"]
    assert said["text"] in replayed.to_json_dict()["provisos"][0]["text"]
    assert any("Repaired inertia" in line and "tensor of lower" in line for line in replayed.lines())


def test_all_choices_of_a_lock_have_one_repaired_urdf(tmp_path: Path) -> None:
    finger = inertial(0.1, "0.1 0 0", np.diag([0.0, 0.0, 0.01]))
    text = two_joints().replace(
        "</robot>", link("finger", finger) + joint("grip", "lower", "finger", axis="0 1 0") + "</robot>"
    )
    path = write(tmp_path, text)
    arm = load_arm(path, lock={"grip": 0.0}, repair=True)
    other = arm.replace(lock={"grip": 1.2})
    assert "tensor of finger" in arm.provisos[0].text
    assert arm.urdf_text == other.urdf_text
    found = certify(arm, 0.02, condition="weighted", lock={"grip": [0.0, 1.2]}, gap=0.3, budget=60.0, levels=False)
    replayed = check(found.save(tmp_path / "choices.cert"))
    assert replayed.valid, replayed.problems


def test_an_experiment_repairs_and_its_provenance_says_so(tmp_path: Path) -> None:
    path = write(tmp_path, BROKEN)
    arm = {"source": str(path)}
    ramps = {"kind": "ramps", "points": [[0.0, 0.0], [0.2, 0.3]], "times": [0.0, 1.0]}
    experiment = load_experiment("demo").replace(arm=arm, reference=ramps)
    with pytest.raises(ArmError, match=r"arm\.repair = true"):
        experiment.build_arm()
    mended = experiment.replace(arm={**arm, "repair": True})
    told = provenance(mended, mended.build_arm(), datetime.now(UTC), {}, tmp_path)
    assert told["arm"]["provisos"][0]["kind"] == "repaired inertia"


def test_a_record_that_says_nothing_is_refused(tmp_path: Path) -> None:
    text = robot(two_joints().removeprefix('<robot name="r">\n').removesuffix("</robot>\n"), "<asmc_pin_repair/>")
    with pytest.raises(ArmError, match="does not say what was repaired"):
        load_arm(write(tmp_path, text))
