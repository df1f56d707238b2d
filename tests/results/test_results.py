"""What lies on disk: named axes and units, reading back, taking a place as a whole."""

import json
import os
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.errors import ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.pages.comparison_page import report_html
from asmc_pin.results import result_folder
from asmc_pin.results.result_folder import load_result
from asmc_pin.results.result_writing import (
    VARIABLES,
    check_target,
    trajectories,
    whole_or_not_at_all,
    write_trajectories,
)
from asmc_pin.study import compare

SLIDER = """
<robot name="slider">
  <link name="base"/>
  <link name="cart"><inertial><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="pole"><inertial><origin xyz="0 0 0.2"/><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="50" velocity="2"/></joint>
  <joint name="hinge" type="revolute"><parent link="cart"/><child link="pole"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="20" velocity="4"/></joint>
</robot>
"""


def data(arm, **changes):
    return {
        "name": "small",
        "arm": str(arm),
        "period": 0.002,
        "duration": 0.05,
        "ensemble": {"trials": 1},
        "reference": {"kind": "quintic", "start": [0.1, 0.2], "targets": [[0.12, 0.15]], "move": 0.05},
        "defaults": {"mbar": [0.5, 0.1], "ks": 8.0, "beta": 8.0},
        "controllers": {"PPC": {"law": "ppc"}, "Q": {"law": "baek2016", "phi": 9.0, "alpha": 0.1, "epsilon": 0.1}},
        **changes,
    }


def runs_of(experiment, batch=1):
    plant, reference = experiment.build_plant(), experiment.build_reference()
    laws = experiment.build_controllers()
    return {label: rollout(plant, law, reference, experiment.duration, batch=batch) for label, law in laws.items()}


def plain(monkeypatch):
    """Without figures and report, which take most of the time and are not what is looked at."""
    monkeypatch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
    monkeypatch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)


@pytest.fixture(scope="module")
def slider(tmp_path_factory):
    path = tmp_path_factory.mktemp("slider") / "slider.urdf"
    path.write_text(SLIDER)
    return path


@pytest.fixture(scope="module")
def dataset(slider):
    experiment = Experiment.from_dict(data(slider))
    laws = {label: table["law"] for label, table in experiment.controllers.items()}
    return trajectories(experiment.build_arm(), runs_of(experiment, batch=3), laws)


def test_trajectories_have_named_axes_and_every_variable_its_unit(dataset):
    assert dict(dataset.sizes) == {"controller": 2, "trial": 3, "time": 26, "joint": 2}
    assert dataset.joint.values.tolist() == ["rail", "hinge"]
    for name in VARIABLES:
        assert dataset[name].attrs["units"], name
        assert dataset[name].dims[-2:] == ("time", "joint")
    assert dataset.q.dims == ("controller", "trial", "time", "joint")
    assert dataset.torque.attrs["units"] == "N m (revolute), N (prismatic)"
    assert dataset.time.attrs["units"] == "s"
    assert dataset.joint_kind.values.tolist() == ["prismatic", "revolute"]
    assert dataset.law.values.tolist() == ["ppc", "baek2016"]


def test_units_name_one_kind_of_joint_where_there_is_only_one():
    experiment = Experiment.from_dict(data("two_link", defaults={"mbar": 0.01, "ks": 1.0, "beta": 1.0}))
    made = trajectories(experiment.build_arm(), runs_of(experiment), {"PPC": "ppc", "Q": "baek2016"})
    assert made.q.attrs["units"] == "rad"
    assert made.gain.attrs["units"] == "rad/s2"


def test_trajectories_survive_the_disk_bit_by_bit(dataset, tmp_path):
    for name in ("a.nc", "b.nc"):
        write_trajectories(dataset, tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    back = xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf")
    xr.testing.assert_identical(back, dataset)
    with h5py.File(tmp_path / "a.nc") as file:
        assert "_NCProperties" not in file.attrs
        assert file["q"].dtype == np.float64


def test_errors_of_a_sliding_joint_are_in_mm_and_of_a_turning_one_in_deg(slider, tmp_path, monkeypatch):
    plain(monkeypatch)
    comparison = compare(Experiment.from_dict(data(slider)), out=tmp_path / "out")
    told = comparison.to_json_dict()
    assert told["error_units"] == ["mm", "deg"]
    rows = comparison.rows[comparison.rows.controller == "PPC"].rms_error.to_numpy()
    assert told["controllers"]["PPC"]["rms_error"] == pytest.approx(rows * [1e3, np.degrees(1.0)])
    text = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert "| controller | rail [mm] | hinge [deg] |" in text
    assert "rail [N]" in text


def test_a_result_reads_back_with_its_relative_paths_from_anywhere(slider, tmp_path, monkeypatch):
    plain(monkeypatch)
    monkeypatch.chdir(slider.parent)
    compare(Experiment.from_dict(data("slider.urdf")))
    monkeypatch.chdir(tmp_path)
    result = load_result(slider.parent / "results" / "small")
    assert result.experiment.build_arm().joint_names == ("rail", "hinge")
    assert result.summary.controller.tolist() == ["PPC", "PPC", "Q", "Q"]
    assert result.dataset.sizes["time"] == 26
    assert result.provenance["arm"]["sha256"] == load_arm(slider).sha256
    monkeypatch.chdir(slider.parent)
    assert load_result("small").path == Path("results/small")


def texts(value):
    if isinstance(value, dict):
        return [text for key, item in value.items() for text in (*texts(key), *texts(item))]
    return [value] if isinstance(value, str) else []


def test_a_result_tells_of_no_folders_of_its_maker(slider, tmp_path, monkeypatch):
    plain(monkeypatch)
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "home" / "ada")
    far, near = tmp_path / "elsewhere", tmp_path / "home" / "ada" / "work"
    near.mkdir(parents=True)
    experiment = Experiment.from_dict(data(slider), folder=near)
    for out, way in ((near / "results" / "small", "../.."), (far / "small", None), (near.parent / "small", "../work")):
        made = compare(experiment, out=out).out
        provenance = json.loads((made / "provenance.json").read_text(encoding="utf-8"))
        assert provenance["experiment"]["folder"] == way
        assert provenance["arm"]["urdf"] == "slider.urdf"
        private = {str(slider.parent), "/ada", str(tmp_path), str(Path.cwd())}
        assert not [text for text in texts(provenance) if text.startswith("/") or any(x in text for x in private)]


def test_a_result_that_moves_with_its_project_is_whole_and_one_that_moves_alone_says_what_it_lacks(
    slider, tmp_path, monkeypatch
):
    plain(monkeypatch)
    before, after, alone = tmp_path / "before", tmp_path / "after", tmp_path / "alone"
    before.mkdir()
    shutil.copy(slider, before)
    compare(Experiment.from_dict(data("slider.urdf"), folder=before), out=before / "results" / "small")
    before.rename(after)
    assert load_result(after / "results" / "small").experiment.build_arm().joint_names == ("rail", "hinge")
    (after / "results").rename(alone)
    result = load_result(alone / "small")
    assert result.summary.controller.tolist() == ["PPC", "PPC", "Q", "Q"]
    with pytest.raises(ResultError, match=r"the arm of .* cannot be loaded any more: slider\.urdf: no such file"):
        report_html(result, tmp_path / "report.html")
    monkeypatch.chdir(after)
    report_html(result, tmp_path / "report.html")


def test_what_is_no_result_says_what_is_missing(tmp_path):
    with pytest.raises(ResultError, match=r"there is no result .*; asmc-pin compare makes one"):
        load_result(tmp_path / "nowhere")
    (tmp_path / "experiment.toml").write_text("")
    with pytest.raises(ResultError, match=r"it has no trajectories\.nc, summary\.parquet, provenance\.json"):
        load_result(tmp_path)
    for name in ("trajectories.nc", "summary.parquet", "provenance.json"):
        (tmp_path / name).write_text("{}")
    with pytest.raises(ResultError, match="cannot be read, run the comparison again"):
        load_result(tmp_path)


def old_result(path):
    path.mkdir()
    for name in (result_folder.EXPERIMENT, result_folder.PROVENANCE):
        (path / name).write_text("old")


def test_a_folder_takes_its_place_only_when_it_is_complete(tmp_path):
    out = tmp_path / "a" / "result"
    with whole_or_not_at_all(out, force=False) as made:
        (made / "x").write_text("new")
        assert not out.exists()
        assert made.parent == out.parent
    assert [path.name for path in out.iterdir()] == ["x"]
    assert out.stat().st_mode & 0o777 == (tmp_path / "a").stat().st_mode & 0o777


@pytest.mark.parametrize("at", [1, 2])
def test_an_old_result_comes_back_when_the_move_itself_is_interrupted(tmp_path, monkeypatch, at):
    out = tmp_path / "result"
    old_result(out)
    moves = []

    def replace(source, target):
        moves.append(source)
        if len(moves) == at:
            raise KeyboardInterrupt
        os.rename(source, target)

    monkeypatch.setattr(os, "replace", replace)

    def write():
        with whole_or_not_at_all(out, force=True) as made:
            (made / "x").write_text("new")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert (out / result_folder.PROVENANCE).read_text() == "old"
    assert not (out / "x").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["result"]


def test_a_result_that_appeared_meanwhile_is_not_overwritten(tmp_path):
    out = tmp_path / "result"

    def write_while_another_run_is_quicker():
        with whole_or_not_at_all(out, force=False) as made:
            (made / "x").write_text("mine")
            old_result(out)

    with pytest.raises(ResultError, match="force=True"):
        write_while_another_run_is_quicker()
    assert (out / result_folder.PROVENANCE).read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["result"]


def test_an_empty_folder_is_a_place_for_a_result(tmp_path):
    check_target(tmp_path, force=False)
    out = tmp_path / "empty"
    out.mkdir()
    with whole_or_not_at_all(out, force=False) as made:
        (made / "x").write_text("new")
    assert (out / "x").read_text() == "new"
