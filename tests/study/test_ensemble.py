"""Claims about the ensemble: what its trials share, what a figure says of them, and what is kept."""

from __future__ import annotations

import dataclasses
import json
import sys
import tomllib

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PolyCollection
from short_experiment import SHORT

from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.pages.comparison_figures import errors_figure, gains_and_s_figure, torques_figure
from asmc_pin.pages.tables.text_table import number
from asmc_pin.results import result_folder
from asmc_pin.study import compare
from asmc_pin.study.ensemble import bands, check_size, first_trial, starts
from asmc_pin.study.notes.sensitivity_notes import limit_lines, sensitivity_lines

LAWS = {
    "PPC": {"law": "ppc"},
    "Proposed": {"law": "baek2016", "phi": 400.0, "alpha": 0.05, "epsilon": 0.01},
}
TRIALS = 9


def experiment(**changes):
    data = tomllib.loads(SHORT)
    data |= {
        "controllers": LAWS,
        "ensemble": {"trials": TRIALS},
        "metrics": {"tool": load_arm("two_link").link_names[-1]},
    }
    return Experiment.from_dict({**data, **changes})


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    seen = {}
    found = compare(
        experiment(), out=tmp_path_factory.mktemp("ensemble") / "e", each=lambda label, run: seen.update({label: run})
    )
    return found, seen


@pytest.fixture
def unillustrated(monkeypatch):
    """Without figures and report, which take most of the time and are not what is looked at."""
    monkeypatch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
    monkeypatch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)


# The starts -----------------------------------------------------------------------------------------------------------


def test_sixteen_trials_are_run_where_nobody_says_otherwise():
    data = tomllib.loads(SHORT)
    del data["ensemble"]
    default = Experiment.from_dict(data)
    assert (default.ensemble.trials, default.ensemble.q0_deviation) == (16, 1e-6)
    assert starts(default).shape == (16, 2)


def test_the_first_trial_starts_where_the_experiment_says_and_the_others_off_by_the_deviation():
    many = experiment(ensemble={"trials": 4000, "q0_deviation": 1e-3})
    q0 = starts(many)
    assert q0[0].tolist() == many.build_reference().evaluate(np.zeros(1)).q[0].tolist()
    off = q0[1:] - q0[0]
    assert off.std(axis=0) == pytest.approx([1e-3, 1e-3], rel=0.05)
    assert np.abs(off.mean(axis=0)).max() < 1e-4
    assert abs(np.corrcoef(off.T)[0, 1]) < 0.05
    given = many.with_plant(q0=[0.1, 0.2])
    assert starts(given)[0].tolist() == [0.1, 0.2]


def test_more_trials_add_starts_and_change_none_and_another_seed_changes_all_but_the_first():
    few, more = starts(experiment()), starts(experiment(ensemble={"trials": 30}))
    assert np.array_equal(more[:TRIALS], few)
    other = starts(experiment(seed=1))
    assert np.array_equal(other[0], few[0])
    assert (other[1:] != few[1:]).all()


def test_all_controllers_meet_the_same_starts_the_same_noise_and_the_same_plant(tmp_path, unillustrated):
    noisy = experiment().with_plant(sensor={"position_noise": 1e-3}, spread={"friction": 0.3})
    seen = {}
    compare(noisy, out=tmp_path / "n", each=lambda label, run: seen.update({label: run}))
    one, other = seen.values()
    assert np.array_equal(one.q[:, 0], other.q[:, 0])
    assert np.array_equal(one.q[:, 0], starts(noisy))
    noise = one.q_measured - one.q
    assert noise.std() == pytest.approx(1e-3, rel=0.1)
    # What is random besides is that of trial 0 in each: the figures' spread is the start's alone.
    assert np.abs(noise - noise[0]).max() < 1e-12
    sliding = np.abs(one.v[:, 50]).min() > 1e-3
    assert sliding
    assert np.ptp(one.friction_torque[:, 50], axis=0).max() < 1e-3


# What is kept ---------------------------------------------------------------------------------------------------------


def test_the_trajectories_are_those_of_the_first_trial_and_of_a_single_run_to_the_last_bit(done, tmp_path):
    comparison, seen = done
    single = compare(experiment(ensemble={"trials": 1}), out=tmp_path / "one")
    assert comparison.dataset.sizes["trial"] == 1
    for name in ("q", "v", "torque", "s", "gain", "friction_torque", "energy", "tool_error_position"):
        assert np.array_equal(comparison.dataset[name], single.dataset[name], equal_nan=True), name
    first = first_trial(seen["Proposed"])
    assert np.array_equal(first.q_measured, first.q)
    assert first.ideal_sensor
    assert np.array_equal(first.torque_measured, seen["Proposed"].torque_measured[:1])
    rows = comparison.rows[comparison.rows.trial == 0].reset_index(drop=True)
    for name in METRICS:
        np.testing.assert_array_equal(rows[name], single.rows[name], err_msg=name)
    assert not [name for name in single.dataset if str(name).endswith(("_low", "_high"))]


def test_the_bands_are_the_quantiles_of_all_trials_tick_by_tick(done):
    comparison, seen = done
    for label, run in seen.items():
        error = run.q_ref - run.q
        for name, values in {"error": error, "error_size": np.abs(error), "torque": run.torque, "s": run.s}.items():
            for end, share in (("low", 0.05), ("high", 0.95)):
                band = comparison.dataset[f"{name}_{end}"].sel(controller=label)
                assert band.dims == ("time", "joint")
                exact = np.quantile(values, share, axis=0)
                np.testing.assert_allclose(band, exact, rtol=1e-3, atol=1e-12, err_msg=name)
    assert comparison.dataset.error_low.attrs["units"] == "rad"


def bands_in(figure):
    return [each for axis in figure.axes for each in axis.collections if isinstance(each, PolyCollection)]


@pytest.mark.parametrize(("draw", "drawn"), [(errors_figure, 4), (gains_and_s_figure, 6), (torques_figure, 4)])
def test_every_figure_draws_the_band_of_each_controller_and_joint_and_that_of_a_single_run_none(done, draw, drawn):
    """Two controllers and two joints; one of them has a gain."""
    dataset = done[0].dataset.isel(trial=0)
    assert len(bands_in(draw(dataset, np.full(2, np.inf)))) == drawn
    ends = [name for name in dataset if str(name).endswith(("_low", "_high"))]
    assert bands_in(draw(dataset.drop_vars(ends), np.full(2, np.inf))) == []


def test_a_band_is_drawn_where_its_quantiles_are(done):
    dataset = done[0].dataset.isel(trial=0)
    for axis, place in zip(torques_figure(dataset, np.full(2, np.inf)).axes, np.ndindex(2, 2), strict=True):
        joint, controller = place
        (band,) = axis.collections
        height = band.get_paths()[0].vertices[:, 1]
        low, high = (dataset[f"torque_{end}"].to_numpy()[controller, :, joint] for end in ("low", "high"))
        assert (height.min(), height.max()) == pytest.approx((low.min(), high.max()), rel=1e-6)


def test_a_band_ends_where_a_trial_that_diverged_would_be_part_of_it():
    short = experiment(duration=0.02, ensemble={"trials": 21})
    law = short.build_controllers()["PPC"]
    run = rollout(short.build_plant(), law, short.build_reference(), 0.02, batch=21)
    q = run.q.copy()
    q[20, 10:] = np.nan
    once = bands(dataclasses.replace(run, q=q))
    assert np.isfinite(once["error"]).all()  # one of 21 is above the 95 % quantile
    q[19, 10:] = np.nan
    twice = bands(dataclasses.replace(run, q=q))
    assert np.isnan(twice["error"][1, 10:]).all()
    assert np.isfinite(twice["error"][:, :10]).all()


def test_a_result_is_little_larger_than_that_of_a_single_run(done, tmp_path, unillustrated):
    comparison, _ = done
    single = compare(experiment(ensemble={"trials": 1}), out=tmp_path / "one")
    sizes = [(item.out / "trajectories.nc").stat().st_size for item in (comparison, single)]
    assert sizes[0] < 2.0 * sizes[1]


def test_an_ensemble_is_the_same_to_the_last_bit_when_it_is_run_again(done, tmp_path):
    comparison, _ = done
    again = compare(experiment(), out=tmp_path / "again")
    for name in ("trajectories.nc", "summary.parquet", "summary.md", "report.html", "figures/errors.png"):
        assert (again.out / name).read_bytes() == (comparison.out / name).read_bytes(), name


def test_the_result_read_back_has_all_trials_in_its_summary(done):
    comparison, _ = done
    result = result_folder.load_result(comparison.out)
    assert sorted(set(result.summary.trial)) == list(range(TRIALS))
    assert result.dataset.sizes["trial"] == 1
    page = (comparison.out / "report.html").read_text(encoding="utf-8")
    assert f"each ran {TRIALS} times" in page
    assert f"all {TRIALS} trials ran to the end" in page
    assert "How sure the order of two controllers is" in page


# What is said ---------------------------------------------------------------------------------------------------------


def test_the_json_has_median_low_and_high_of_every_metric_over_the_trials(done):
    comparison, _ = done
    told = json.loads(json.dumps(comparison.to_json_dict(), allow_nan=False))
    assert (told["trials"], told["q0_deviation"]) == (TRIALS, 1e-6)
    law = told["controllers"]["Proposed"]
    assert (law["status"], law["failed"]) == ("ok", 0)
    rows = comparison.rows[comparison.rows.controller == "Proposed"]
    for name, factor in (("rms_error", 180.0 / np.pi), ("torque_rms", 1.0), ("peak_gain", 1.0)):
        figures = factor * rows[name].to_numpy().reshape(TRIALS, 2)
        for end, share in (("", 0.5), ("_low", 0.05), ("_high", 0.95)):
            assert law[name + end] == pytest.approx(np.quantile(figures, share, axis=0).tolist()), name + end
    assert told["controllers"]["PPC"]["peak_gain_high"] == [None, None]
    pairs = [item for item in told["comparisons"] if item["metric"] == "rms_error"]
    assert {(item["better"], item["worse"]) for item in pairs} == {("Proposed", "PPC")}
    assert 0.0 < pairs[0]["low"] <= pairs[0]["ratio"] <= pairs[0]["high"]


def test_the_path_of_the_tool_is_judged_over_the_trials_as_passes(done):
    comparison, _ = done
    tool = comparison.to_json_dict()["controllers"]["PPC"]["tool"]
    assert 0.0 < tool["path_accuracy_mm"] < tool["max_position_mm_high"] * 1.001
    assert 0.0 < tool["path_repeatability_mm"] < 0.1
    assert "path repeatability [mm]" in (comparison.out / "summary.md").read_text(encoding="utf-8")


def test_numerical_sensitivity_is_called_so_and_said_in_percent_of_the_figure(done):
    comparison, _ = done
    (line,) = [line for line in comparison.notes if line.startswith("numerical sensitivity")]
    assert "for this plant and these gains: a start 1e-06 rad away moves" in line
    rows = comparison.rows[comparison.rows.controller == "Proposed"]
    low, high = np.quantile(rows.rms_error.to_numpy().reshape(TRIALS, 2), [0.05, 0.95], axis=0)
    worst = int(np.argmax(high / low))
    moved = number(100.0 * (high / low - 1.0)[worst], 2)
    assert f"of Proposed by {moved} % ({comparison.arm.joint_names[worst]})" in line


def test_a_figure_that_moves_by_more_than_itself_is_said_in_plain_digits():
    rows = pd.DataFrame(
        {
            "controller": "Torn",
            "trial": np.repeat(np.arange(3), 2),
            "joint": ["a", "b"] * 3,
            "status": "ok",
            "rms_error": [1.0, 1.0, 2.0, 1.0, 3.0, 1.0],
        }
    )
    (line,) = sensitivity_lines(experiment(), rows)
    assert line.endswith("5 % to 95 % of 3 trials, of Torn by 164 % (a)")  # 2.9 over 1.1


@pytest.mark.long
def test_a_law_that_a_robot_with_a_torque_rate_limit_would_refuse_is_named(tmp_path, unillustrated):
    limited = experiment(metrics={"torque_rate_limit": 1e7})
    (line,) = [x for x in compare(limited, out=tmp_path / "a").notes if x.startswith("torque rate")]
    assert line == "torque rate: PPC, Proposed would have run on a 1e+07 N·m/s robot in every trial"
    strict = experiment(metrics={"torque_rate_limit": 1e-3})
    (line,) = [x for x in compare(strict, out=tmp_path / "b").notes if x.startswith("torque rate")]
    assert line == "torque rate: PPC, Proposed would have tripped a 0.001 N·m/s robot in at least one trial"
    free = experiment(metrics={"torque_rate_limit": float("inf")})
    assert not [x for x in compare(free, out=tmp_path / "c").notes if x.startswith("torque rate")]


def test_of_a_law_that_diverged_no_trip_is_told_that_nobody_saw():
    """A trial that diverged is worse than any figure; that a robot would have stopped it is another matter."""
    laws = np.repeat(["Calm", "Torn", "Lost"], 2)
    ticks = [0.0, 0.0, 3.0, 0.0, 0.0, np.nan]
    status = ["ok", "ok", "ok", "ok", "ok", "diverged"]
    rows = pd.DataFrame({"controller": laws, "trial": [0, 1] * 3, "joint": "a", "status": status})
    (line,) = limit_lines(experiment(), rows.assign(torque_rate_ticks=ticks))
    assert "Calm would have run on a 1000 N·m/s robot in every trial" in line
    assert "; Torn would have tripped a 1000 N·m/s robot in at least one trial" in line
    assert line.endswith("; of Lost it is not known, as trials diverged")


def test_three_of_sixteen_trials_that_diverge_are_a_status_and_a_count(tmp_path, monkeypatch, unillustrated):
    real = sys.modules["asmc_pin.study.comparing"].rollout

    def some_fail(plant, law, *args, **options):
        run = real(plant, law, *args, **options)
        if not hasattr(law, "phi"):
            return run
        q, end = run.q.copy(), run.end_time.copy()
        q[[4, 7, 11], 120:], end[[4, 7, 11]] = np.nan, [0.12, 0.13, 0.11]
        status = tuple("diverged" if k in (4, 7, 11) else "ok" for k in range(16))
        return dataclasses.replace(run, q=q, end_time=end, status=status)

    monkeypatch.setattr(sys.modules["asmc_pin.study.comparing"], "rollout", some_fail)
    found = compare(experiment(ensemble={}), out=tmp_path / "f")
    law = json.loads(json.dumps(found.to_json_dict(), allow_nan=False))["controllers"]["Proposed"]
    assert (law["status"], law["failed"], law["end_time"]) == ("diverged", 3, 0.11)
    assert all(np.isfinite(law["rms_error"]))
    assert all(np.isfinite(law["rms_error_low"]))
    assert law["rms_error_high"] == [None, None]
    assert law["tool"]["path_accuracy_mm"] is None
    assert any("Proposed diverged in 3 of 16 trials, the first at t = 0.110 s" in line for line in found.warnings)
    assert any("of Proposed by more than can be said, as 3 of 16 trials diverged" in line for line in found.notes)
    row = next(row for row in found.overview().rows if row[0] == "Proposed")
    assert row[-1] == "3 of 16 diverged, the first at 0.11 s"
    assert result_folder.load_result(found.out).summary.status.eq("diverged").sum() == 6


def test_an_ensemble_that_does_not_fit_into_memory_is_refused_before_anything_is_run():
    long = experiment(duration=1000.0, ensemble={"trials": 16})
    with pytest.raises(ExperimentError, match=r"ensemble\.trials: 16 trials of 1000000 control periods"):
        check_size(long)
    check_size(experiment(duration=1000.0, ensemble={"trials": 1}))


@pytest.mark.parametrize("trials", [0, -1, 1.5, 20_000])
def test_a_number_of_trials_that_makes_no_sense_is_told(trials):
    with pytest.raises(ExperimentError, match=r"ensemble\.trials"):
        experiment(ensemble={"trials": trials})
