"""Claims about `log_every`: a result is smaller, and says so; what was found is the same to the last bit."""

from __future__ import annotations

import copy
import json
import sys

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from recorded_runs import recorded_run

from asmc_pin.errors import ExperimentError, ParameterError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.pages.comparison_page import report_text
from asmc_pin.results.kept_ticks import reference_range
from asmc_pin.results.result_folder import load_result
from asmc_pin.study import compare
from asmc_pin.sweeping.sweep_plan import sweep_plan
from asmc_pin.sweeping.trial_replay import replay
from asmc_pin.sweeping.trial_runs import TrialRuns
from asmc_pin.viewer.time_marks import time_marks

N, PERIODS = 7, 250
DATA = {
    "name": "small",
    "arm": "two_link",
    "period": 0.002,
    "duration": 0.002 * PERIODS,
    "ensemble": {"trials": 3},
    "plant": {"friction": {"coulomb": [2.0, 1.0]}, "effort_limit": [120.0, 60.0]},
    "metrics": {"tool": "link_2"},
    # Its largest angle lies between two kept ticks.
    "reference": {"kind": "multisine", "offset": [0.3, 0.2], "amplitude": [0.3, 0.3], "frequency": [1.13, 1.29]},
    "defaults": {"mbar": [0.05, 0.02], "ks": 8.0, "beta": 8.0},
    "controllers": {
        "PPC": {"law": "ppc"},
        "Proposed": {"law": "baek2016", "phi": 400.0, "alpha": 0.1, "epsilon": 0.01},
    },
}


def experiment_with(**changes):
    return Experiment.from_dict({**copy.deepcopy(DATA), **changes})


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The comparison with every tick kept and with one in N, without pictures, which take most of the time."""
    folder = tmp_path_factory.mktemp("kept")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
        patch.setattr("asmc_pin.study.run_monitors.draw_theorems", lambda *_: None)
        patch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)
        return [compare(experiment_with(log_every=n), out=folder / str(n)) for n in (1, N)]


@pytest.fixture(scope="module")
def read(made):
    return [load_result(each.out) for each in made]


def test_figures_verdicts_and_what_figures_are_drawn_from_are_the_same(made):
    whole, thin = made
    pd.testing.assert_frame_equal(whole.rows, thin.rows, check_exact=True)
    pd.testing.assert_frame_equal(whole.theorems.claims, thin.theorems.claims, check_exact=True)
    xr.testing.assert_equal(whole.dataset, thin.dataset)
    xr.testing.assert_equal(whole.theorems.dataset, thin.theorems.dataset)
    told = [each.to_json_dict() | {"out": ""} for each in made]
    assert json.dumps(told[0]) == json.dumps(told[1])
    for name in ("summary.parquet", "claims.parquet", "summary.tex"):
        assert (whole.out / name).read_bytes() == (thin.out / name).read_bytes(), name


def test_what_is_kept_is_every_nth_tick_to_the_last_bit_and_the_rest_of_the_file_is_as_it_was(made, read):
    for whole, thin in ((read[0].dataset, read[1].dataset), (read[0].monitors, read[1].monitors)):
        assert thin.sizes["time"] == len(range(0, PERIODS + 1, N))
        added = {"q_ref_low", "q_ref_high"} & set(thin.variables)
        xr.testing.assert_equal(thin.drop_vars(list(added)), whole.isel(time=slice(None, None, N)))
        assert thin.attrs["log_every"] == N
        assert "log_every" not in whole.attrs
        for name in whole.variables:
            assert str(thin[name].attrs) == str(whole[name].attrs), name
    assert read[1].dataset.time[1] == N * DATA["period"]
    assert read[1].dataset.attrs["period"] == DATA["period"]


@pytest.mark.parametrize("name", ["trajectories.nc", "monitors.nc"])
def test_the_files_are_smaller(made, read, name):
    """Of a run as short as this one, names and units are a large part of a file."""
    sizes = [(each.out / name).stat().st_size for each in made]
    assert sizes[1] < 0.75 * sizes[0]
    arrays = [each.dataset if name == "trajectories.nc" else each.monitors for each in read]
    assert arrays[1].nbytes < arrays[0].nbytes / (N - 1)


def test_the_arm_that_verdicts_are_about_is_told_along_all_of_the_reference(made, read):
    whole, thin = (each.dataset for each in read)
    np.testing.assert_array_equal(reference_range(whole), reference_range(thin))
    assert (thin.q_ref.max("time") < reference_range(thin)[1]).all()
    assert made[0].about == made[1].about


def test_a_result_says_how_much_it_keeps_wherever_a_figure_is_read_off_it(made, read):
    (note,) = set(made[1].notes) - set(made[0].notes)
    assert note.startswith(f"trajectories.nc and monitors.nc keep one control tick in {N}, as do the page's curves")
    assert note in (made[1].out / "summary.md").read_text(encoding="utf-8")
    page = report_text(read[1])
    for said in (note, f"drawn from every kept tick; one tick in {N} is kept", f"also those 6 of {N} not kept"):
        assert said.replace("'", "&#x27;") in page or said in page, said
    places = [mark.words for mark in time_marks(read[1], 0) if mark.kind == "place"]
    assert len(places) == 3
    assert all(f"of one tick in {N}" in words for words in places)
    assert not any("one tick" in mark.words for mark in time_marks(read[0], 0))


def test_no_metric_is_computed_from_kept_ticks(read):
    thin = recorded_run(read[1].dataset, "PPC")
    assert thin.log_every == N
    assert np.isnan(thin.torque_measured).all()
    with pytest.raises(ParameterError, match=f"one tick in {N}, and metrics are computed from every tick"):
        METRICS["rms_error"](thin)
    METRICS["rms_error"](recorded_run(read[0].dataset, "PPC"))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (lambda data: data.isel(time=slice(None, -1)), "along 'time', its experiment has 36"),
        (lambda data: data.assign_attrs(log_every=6), "says of 'log_every' something else"),
        (lambda data: data.assign(q_ref_low=data.q_ref_low * np.nan), "'q_ref_low' does not hold a number"),
    ],
)
def test_a_file_that_keeps_other_ticks_than_its_experiment_says_is_refused(made, tmp_path, changed, said):
    from asmc_pin.results.result_schema import check_trajectories

    data = changed(load_result(made[1].out).dataset)
    with pytest.raises(ResultError, match=said):
        check_trajectories(tmp_path / "trajectories.nc", data, made[1].experiment)


@pytest.mark.parametrize("given", [0, -3, 2.5, True, "2", PERIODS + 1])
def test_a_rate_that_no_log_has_is_a_mistake_of_its_key(given):
    with pytest.raises(ExperimentError, match="log_every") as found:
        experiment_with(log_every=given)
    assert len(str(found.value).strip().splitlines()) == 1
    experiment_with(log_every=PERIODS)


def test_a_sweep_takes_it_and_its_rows_stay_those_of_every_tick(tmp_path):
    short = {"duration": 0.04, "sweep": {"defaults.ks": {"values": [4.0, 8.0]}}, "metrics": {}}
    found = []
    for n in (1, N):
        plan = sweep_plan(experiment_with(log_every=n, **short), 1, None, "key")
        runs = TrialRuns(plan)
        found.append(runs(_jobs(plan)))
    assert found[0].keys() == found[1].keys()
    for place, outcome in found[0].items():
        for name, values in outcome.figures.items():
            np.testing.assert_array_equal(values, found[1][place].figures[name], err_msg=name)


def _jobs(plan):
    from asmc_pin.sweeping.lockstep import TrialTables

    variation = plan.variation
    return [TrialTables(trial, 0, variation.tables(variation.quantities(trial))) for trial in range(plan.trials)]


def test_it_is_nothing_that_a_sweep_may_vary():
    with pytest.raises(ExperimentError, match=r"log_every.*does not vary: it is about the files of a comparison"):
        experiment_with(sweep={"log_every": {"values": [1, 2]}})


def test_a_replay_of_a_trial_has_every_tick(tmp_path, monkeypatch):
    monkeypatch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
    monkeypatch.setattr("asmc_pin.study.run_monitors.draw_theorems", lambda *_: None)
    monkeypatch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)
    swept = experiment_with(log_every=N, duration=0.04, sweep={"defaults.ks": {"values": [4.0, 8.0]}})
    again = load_result(replay(swept, 1, 1, tmp_path / "sweep").out)
    assert again.experiment.log_every == 1
    assert again.dataset.sizes["time"] == 21
