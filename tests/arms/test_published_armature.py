"""Rotor inertias that somebody has published: each has a source, and says so wherever the arm appears."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import two_joints, write

from asmc_pin import Experiment, design, load_arm
from asmc_pin.arms import ARMS
from asmc_pin.arms.published_armature import PUBLISHED_ARMATURE
from asmc_pin.cli import main
from asmc_pin.errors import ParameterError


@pytest.mark.parametrize("name", PUBLISHED_ARMATURE)
def test_what_is_published_is_of_the_arms_own_joints_and_has_a_source(name: str) -> None:
    known, bare = PUBLISHED_ARMATURE[name], load_arm(name)
    assert name in ARMS
    assert set(bare.joint_names) <= set(known.armature)
    assert set(known.armature) <= set(bare.joint_names) | set(bare.locked)
    assert known.source
    assert known.certainty
    arm = load_arm(name, armature="published")
    assert arm.armature.tolist() == [known.armature[joint] for joint in arm.joint_names]
    q = np.full(arm.nv, 0.3)
    np.testing.assert_allclose(arm.mass_matrix(q) - bare.mass_matrix(q), np.diag(arm.armature), atol=1e-14)
    assert [proviso.kind for proviso in arm.provisos] == [
        "simulated armature" if known.simulated else "published armature"
    ]
    assert arm.provisos[0].headline == known.simulated
    assert known.simulated == ("not measured" in known.certainty)
    assert known.source in arm.provisos[0].text


def test_it_stays_with_the_arm_through_other_options_and_goes_when_it_is_replaced() -> None:
    arm = load_arm("panda", armature="published")
    held = arm.replace(lock={"panda_joint3": 0.0}, payload=1.0)
    rest = [value for joint, value in PUBLISHED_ARMATURE["panda"].armature.items() if joint != "panda_joint3"]
    assert held.armature.tolist() == rest
    assert held.provisos == arm.provisos
    assert not arm.replace(armature=0.1).provisos


def test_where_nothing_is_published_it_is_said_how_to_measure_it(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"no published rotor inertia is known for ur3 .*include_rotors_inertia"):
        load_arm("ur3", armature="published")
    with pytest.raises(ParameterError, match=r"known for z1 .*To measure it, hold all other joints"):
        load_arm("z1", armature="published")
    with pytest.raises(ParameterError, match="rv4fd has its own already, leave it out"):
        load_arm("rv4fd", armature="published")
    # A file of that name may be another robot.
    with pytest.raises(ParameterError, match="no published rotor inertia is known for panda"):
        load_arm(write(tmp_path, two_joints(), "panda.urdf"), armature="published")
    with pytest.raises(ParameterError, match="'most' given, numbers in kg·m² or 'published' expected"):
        load_arm("panda", armature="most")  # type: ignore[arg-type]


def test_the_command_line_and_experiments_take_the_word(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["verify", "so100", "--mbar", "0.03", "--samples", "10", "--armature", "published", "--json"])
    content = json.loads(capsys.readouterr().out)
    assert content["armature"] == [0.028] * 5
    assert content["provisos"][0]["kind"] == "published armature"
    with pytest.raises(SystemExit) as stop:
        main(["verify", "so100", "--mbar", "0.03", "--armature", "publish"])
    assert stop.value.code == 2
    assert "'publish' given, numbers in kg·m², ranges lo:hi, or 'published' expected" in capsys.readouterr().err
    experiment = Experiment.from_dict(
        {
            "name": "x",
            "arm": {"source": "so100", "armature": "published"},
            "period": 0.001,
            "duration": 0.01,
            "reference": {"kind": "quintic", "start": [0.0] * 5, "targets": [[0.0] * 5], "times": [0.01], "move": 0.01},
            "controllers": {"a": {"law": "ppc", "mbar": 0.03, "ks": 1.0, "beta": 1.0}},
        }
    )
    assert experiment.build_arm().armature.tolist() == [0.028] * 5


@pytest.mark.long
def test_rotors_of_a_simulation_stand_in_every_headline_and_are_never_proposed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        main(["verify", "ur5", "--mbar", "0.1", "--samples", "16", "--armature", "published"])
    said = capsys.readouterr()
    assert "ur5 with simulated armature, " in said.out
    assert "from a simulation model, not measured: one round number at every joint" in said.err
    bare = design(load_arm("ur5"), budget=10.0)
    assert not any(item.where == "the published rotors" for item in bare.armature_buys)


@pytest.mark.long
def test_a_design_says_what_the_published_rotors_would_allow() -> None:
    bare = design(load_arm("so100"), budget=20.0)
    with_rotors = design(load_arm("so100", armature="published"), budget=20.0, explain=False)
    bought = [item for item in bare.armature_buys if item.where == "the published rotors"]
    assert len(bought) == 1
    assert with_rotors.check is not None
    assert bought[0].norm == pytest.approx(with_rotors.check.lower, abs=1e-3)
    assert "with the published rotors, (0.028, 0.028, 0.028, 0.028, 0.028) kg·m², a norm of 0.37" in str(bare)
    assert not any(item.where == "the published rotors" for item in with_rotors.armature_buys)
