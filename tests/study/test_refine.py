"""Claims about --refine: it finds what is an artefact of the step, and only that; and about the tool's error."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest
from plant_cases import OpenLoop, Still
from scipy.spatial.transform import Rotation
from short_experiment import SHORT

from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.plant import Friction, Plant
from asmc_pin.plant.energy import mechanical_energy
from asmc_pin.results.result_folder import load_result
from asmc_pin.study import compare
from asmc_pin.tool_error import tool_error


def experiment(**changes):
    data = tomllib.loads(SHORT)
    del data["controllers"]["Wild"]
    data["controllers"]["Slow"] = {"law": "ppc", "ks": 3.0}
    return Experiment.from_dict({**data, **changes})


@pytest.fixture(scope="module")
def refined(tmp_path_factory):
    out = tmp_path_factory.mktemp("refine") / "r"
    base = experiment(metrics={"tool": load_arm("two_link").link_names[-1]}, seed=4)
    return compare(base.with_plant(sensor={"position_noise": 1e-6}), out=out, refine=True)


def test_the_moves_are_the_differences_to_a_run_with_twice_the_substeps(refined, tmp_path):
    finer = compare(refined.experiment.with_plant(substeps=4, sensor={"position_noise": 1e-6}), out=tmp_path / "f")
    assert refined.refinement.substeps == 2
    for name in METRICS:
        np.testing.assert_array_equal(refined.refinement.finer[name], finer.rows[name])
        moved = finer.rows[name].to_numpy() - refined.rows[name].to_numpy()
        np.testing.assert_array_equal(refined.refinement.moved[name], moved)


def test_they_are_in_the_summary_and_in_the_json(refined):
    text = (refined.out / "summary.md").read_text(encoding="utf-8")
    assert "How far the metrics move from 2 to 4 substeps" in text
    assert "Tool-centre error of" in text
    assert any(line.startswith("half the step moves") and "(Slow)" in line for line in refined.notes)
    printed = json.loads(json.dumps(refined.to_json_dict(), allow_nan=False))
    moves = printed["controllers"]["Slow"]["refinement"]
    assert set(moves) == set(METRICS)
    assert moves["rms_error"] == pytest.approx(refined.refinement.relative.rms_error[2:4].tolist())
    tool = printed["controllers"]["PPC"]["tool"]
    assert tool["rms_position_mm"] > 0.0
    assert tool["max_rotation_rad"] >= tool["rms_rotation_rad"] > 0.0


def test_the_trajectories_carry_the_tools_error(refined):
    dataset = refined.dataset
    assert dataset.tool_error_position.dims == ("controller", "trial", "time")
    assert dataset.tool_error_position.attrs["units"] == "m"
    rms = float(np.sqrt(np.mean(dataset.tool_error_position.sel(controller="PPC").to_numpy() ** 2)))
    assert rms * 1e3 == pytest.approx(refined.to_json_dict()["controllers"]["PPC"]["tool"]["rms_position_mm"])


def test_the_summary_on_disk_and_the_report_carry_the_tools_error_under_the_labels_of_the_rest(tmp_path):
    marked = {"PPC": {"law": "ppc"}, "CT": {"law": "computed_torque", "mass_scale": 0.9}}
    base = experiment(metrics={"tool": load_arm("two_link").link_names[-1]}, controllers=marked)
    result = compare(base, out=tmp_path / "r", refine=True)
    rows = load_result(result.out).summary
    printed = result.to_json_dict()["controllers"]
    for label, shown in (("PPC", "PPC"), ("CT", "CT (knows the model)")):
        own = rows[rows.controller == shown]
        assert (own.tool == base.metrics.tool).all()
        for what, unit in (("position", 1e3), ("rotation", 1.0)):
            figure = printed[label]["tool"][f"rms_{what}_{'mm' if what == 'position' else 'rad'}"]
            assert own[f"tool_rms_{what}"].to_numpy() * unit == pytest.approx([figure] * 2)
    summary = (result.out / "summary.md").read_text(encoding="utf-8")
    table = summary.split("## Tool-centre error of")[1].split("##")[0]
    assert "| CT (knows the model) |" in table
    assert "| CT |" not in table
    assert "Tool, RMS position" in summary.split("How far the metrics move")[1]
    page = (result.out / "report.html").read_text(encoding="utf-8")
    assert f"Tool-centre error of {base.metrics.tool}" in page


def test_the_report_gives_the_inertia_that_moves_rotors_included(tmp_path):
    geared = experiment().with_plant(drive={"gear": 100.0, "rotor_inertia": 7.31e-5})
    page = (compare(geared, out=tmp_path / "g").out / "report.html").read_text(encoding="utf-8")
    assert page.split('id="conditions"')[1].count(">0.731<") == 2


def test_the_trajectories_carry_what_was_measured_and_the_energy(refined, tmp_path):
    dataset = refined.dataset
    noise = (dataset.q_measured - dataset.q).to_numpy()
    assert noise.std() == pytest.approx(1e-6, rel=0.1)
    np.testing.assert_allclose(noise[0], noise[1], atol=1e-15, err_msg="the same noise for every law")
    state = (dataset[name].sel(controller="PPC", trial=0).to_numpy() for name in ("q", "v"))
    np.testing.assert_allclose(dataset.energy.sel(controller="PPC", trial=0), mechanical_energy(refined.arm, *state))
    plain = compare(experiment(), out=tmp_path / "plain").dataset
    assert "q_measured" not in plain
    assert "external_torque" not in plain


@pytest.mark.long
def test_a_step_that_is_too_long_is_told_and_a_short_one_is_not(tmp_path):
    fast = {"kind": "multisine", "offset": [0.3, 0.2], "amplitude": [[0.8], [0.8]], "frequency": [[2.0], [3.0]]}
    rough = experiment(period=0.04, reference=fast, defaults={"mbar": 0.01, "ks": 1.0, "beta": 1.0})
    coarse = compare(rough.with_plant(substeps=1), out=tmp_path / "coarse", refine=True)
    fine = compare(rough.with_plant(substeps=64, integrator="midpoint"), out=tmp_path / "fine", refine=True)
    assert any("half the step moves" in line for line in coarse.warnings)
    assert "±" in str(coarse.overview().rows)
    assert "±" not in str(fine.overview().rows)
    written = [(coarse.out / name).read_text(encoding="utf-8") for name in ("summary.md", "report.html")]
    cells = [cell for row in coarse.overview().rows for cell in row if "±" in cell]
    assert all(cell in text and "it is not converged" in text for text in written for cell in cells)
    assert not any("half the step" in line for line in fine.warnings)


def test_without_it_nothing_is_said(tmp_path):
    plain = compare(experiment(), out=tmp_path / "p")
    assert not [name for name in load_result(plain.out).summary if name.startswith("moved_")]
    assert plain.refinement is None
    assert "refinement" not in plain.to_json_dict()["controllers"]["PPC"]
    assert "substeps" not in (plain.out / "summary.md").read_text(encoding="utf-8")


# The tool


def test_the_tools_error_is_distance_and_angle_between_the_two_poses():
    arm = load_arm("ur5")
    q = np.array([0.3, -1.0, 1.2, 0.4, 0.8, 0.2])
    run = rollout(
        Plant(arm, friction=Friction(), start="relaxed"), OpenLoop(lambda t: np.zeros(6), 1e-3), Still(q), 0.4
    )
    found = tool_error(arm, run, "tool0")
    index = arm.link_names.index("tool0")
    poses, wanted = arm.link_poses(run.q[0])[:, index], arm.link_poses(q)[index]
    np.testing.assert_allclose(found.position[0], np.linalg.norm(poses[:, :3, 3] - wanted[:3, 3], axis=1), atol=1e-14)
    turns = Rotation.from_matrix(wanted[:3, :3]).inv() * Rotation.from_matrix(poses[:, :3, :3])
    np.testing.assert_allclose(found.rotation[0], turns.magnitude(), atol=1e-9)
    assert found.rotation.max() > 0.01
    assert found.position[0, 0] == 0.0
    assert found.rotation[0, 0] == 0.0


def test_a_trial_that_diverged_has_no_tool_error():
    arm = load_arm("two_link")
    run = rollout(Plant(arm), OpenLoop(lambda t: np.full(2, np.nan), 1e-3), Still(np.zeros(2)), 0.05)
    assert all(np.isnan(x).all() for x in tool_error(arm, run, arm.link_names[-1]).figures().values())


def test_an_unknown_tool_is_answered_before_anything_runs(tmp_path):
    with pytest.raises(ExperimentError, match=r"metrics.tool: no link 'hand'"):
        compare(experiment(metrics={"tool": "hand"}), out=tmp_path / "t")
    with pytest.raises(ParameterError, match=r"tool: no link 'hand'"):
        tool_error(load_arm("two_link"), None, "hand")
