"""Path accuracy and repeatability against values computed by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from asmc_pin import load_arm
from asmc_pin.engine import rollout
from asmc_pin.errors import ParameterError
from asmc_pin.experiment import load_experiment
from asmc_pin.tool_path import path_figures, tool_path

T = np.linspace(0.0, 1.0, 1001)
LINE = np.stack([T, 0.0 * T, 0.0 * T], axis=1)


def passes(offsets, lag=0.0):
    """Straight passes beside the line, each with its own distance and behind by a lag."""
    return np.stack([np.stack([T - lag, 0.0 * T + y, 0.0 * T], axis=1) for y in offsets])


def test_accuracy_is_the_distance_of_the_mean_and_repeatability_the_spread_about_it():
    offsets = np.array([1e-3, 2e-3, 6e-3])
    away = np.abs(offsets - 3e-3)
    accuracy, repeatability = path_figures(LINE, passes(offsets))
    assert accuracy == pytest.approx(3e-3, rel=1e-9)
    assert repeatability == pytest.approx(away.mean() + 3.0 * np.std(away, ddof=1), rel=1e-9)


def test_a_lag_along_the_path_is_no_error_of_the_path():
    accuracy, repeatability = path_figures(LINE, passes([0.0, 0.0], lag=4e-3))
    assert accuracy < 1e-12
    assert repeatability < 1e-12


def test_what_a_pass_falls_short_of_at_the_end_counts():
    # The last point is at 0.995, where a pass that lags by 0.1 never comes.
    assert path_figures(LINE, passes([0.0], lag=0.1))[0] == pytest.approx(0.1)


def test_passes_that_err_to_both_sides_are_accurate_in_the_mean_and_do_not_repeat():
    accuracy, repeatability = path_figures(LINE, passes([-2e-3, 2e-3]))
    assert accuracy < 1e-12
    assert repeatability == pytest.approx(2e-3)


def test_the_worst_point_of_the_path_counts():
    bump = passes([0.0])
    bump[0, :, 2] = 4e-3 * np.exp(-(((T - 0.5) / 0.05) ** 2))
    accuracy, repeatability = path_figures(LINE, bump)
    assert accuracy == pytest.approx(4e-3, rel=1e-2)
    assert np.isnan(repeatability)  # one pass repeats nothing


def test_on_a_path_that_comes_back_each_leg_is_judged_by_its_own():
    there = np.concatenate([LINE, LINE[::-1]])
    shifted = there.copy()
    shifted[:1001, 1], shifted[1001:, 1] = 1e-3, 3e-3
    assert path_figures(there, shifted[None])[0] == pytest.approx(3e-3, rel=1e-6)


def test_a_tool_that_is_to_stand_still_has_no_path():
    assert np.isnan(path_figures(np.zeros((9, 3)), np.zeros((2, 9, 3)))).all()


def test_a_run_is_judged_pass_by_pass_and_one_that_diverged_fails_it():
    experiment = load_experiment("baek2016_experiment").replace(duration=1.0)
    plant, law = experiment.build_plant(), experiment.build_controllers()["PPC"]
    run = rollout(plant, law, experiment.build_reference(), 1.0, batch=3)
    tool = plant.arm.link_names[-1]
    found = tool_path(plant.arm, run, tool)
    assert found.passes == 3
    assert found.repeatability < 1e-12  # the same pass three times
    assert 0.0 < found.accuracy < 0.1
    failed = dataclasses.replace(run, status=("ok", "diverged", "ok"))
    assert tool_path(plant.arm, failed, tool).accuracy == np.inf
    with pytest.raises(ParameterError, match="no link 'nothing'"):
        tool_path(load_arm("rv4fd"), run, "nothing")
