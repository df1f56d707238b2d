"""The paper's page: made from data, data that a run gives again, and verdicts that can turn."""

from __future__ import annotations

import copy
import dataclasses
import json
import math

import numpy as np
import pytest
from paths import DOCS
from recorded_runs import recorded_run

from asmc_pin import load_experiment, rollout
from asmc_pin.disk.resources import shipped
from asmc_pin.errors import ExperimentError, ResultError
from asmc_pin.metrics import METRICS, evaluate
from asmc_pin.reproduction.error_bounds import break_away, limits, needed_gain
from asmc_pin.reproduction.joint_figures import medians
from asmc_pin.reproduction.measured_figures import certainly_above, measure
from asmc_pin.reproduction.paper_claims import CLAIMS, judged_claims
from asmc_pin.reproduction.printed_tables import NAMES, PAPER, TUNED_SUFFIX
from asmc_pin.reproduction.reading_search import factor, nearest_readings, reconciled
from asmc_pin.reproduction.readings import AXES, ReadingOutcome, as_read, readings
from asmc_pin.reproduction.reproducing import READINGS, SETS, reading_of, reproduce
from asmc_pin.reproduction.reproduction_page import page
from asmc_pin.reproduction.tuned_rows import untuned
from asmc_pin.results.result_writing import trajectories
from asmc_pin.study.ensemble import starts
from asmc_pin.study.tuning import tune_own_gains


@pytest.fixture(scope="module")
def data():
    return json.loads((DOCS / "reproduction" / "reproduction.json").read_text(encoding="utf-8"))


def test_the_page_is_what_its_data_give(data):
    assert page(data, "reproduction") == (DOCS / "reproduction.md").read_text(encoding="utf-8"), (
        "run asmc-pin reproduce --docs docs"
    )


def test_the_page_has_every_table_and_figure_of_the_paper_and_every_claim(data):
    assert set(data["experiments"]) == set(NAMES)
    assert list(data["figures"]) == [f"fig{number:02d}" for number in (3, 4, 5, 6, 7, 8, 10, 11, 12, 13)]
    for item in data["experiments"].values():
        assert set(item["claims"]) == set(CLAIMS)
    text = page(data, "reproduction")
    for title in ("Table I, as printed", "Table II, as printed", "Table III, as printed", "Table III, reconciled"):
        assert f"### {title}" in text
    for claim in CLAIMS:
        assert f"### {claim[:1].upper()}{claim[1:]}" in text


def test_every_line_and_table_of_measured_figures_has_an_interval_where_trials_differ(data):
    wide = copy.deepcopy(data)
    for item in wide["experiments"].values():
        for run in item["controllers"].values():
            for name in ("rms_deg", "mean_rms_deg", "max_error_deg", "torque_max", "peak_gain", "max_s"):
                run[f"{name}_low"], run[f"{name}_high"] = (
                    [None if x is None else share * x for x in run[name]] for share in (0.5, 2.0)
                )
    text = page(wide, "reproduction").replace("\n  ", " ")
    lines = [line for line in text.splitlines() if "measured over printed RMS" in line or "same budget and" in line]
    assert len(lines) == 2 * len(wide["experiments"])
    for line in lines:
        assert line.count("[") == line.count("…") >= 2, line
    ranges = [part for part in text.split("\n\n") if part.startswith("Ranges of the figures")]
    assert all(part.count("[") >= 2 * part.count("here") for part in ranges)


@pytest.mark.parametrize(
    ("name", "label", "duration"),
    [
        ("baek2016_experiment", "PPC", 8.0),
        ("baek2016_experiment_reconciled", "Existing tuned", 8.0),
        ("baek2016_simulation_step", "PPC", 2.0),  # Table II is over the first 2 s
        ("baek2016_simulation_step_reconciled", "Proposed", 2.0),
    ],
)
def test_a_cell_of_the_page_comes_out_of_a_run_again(data, name, label, duration):
    experiment = load_experiment(name)
    run = ensemble_of(experiment, label, duration)
    rms = np.degrees(np.sqrt(np.mean((run.q_ref - run.q) ** 2, axis=1)))
    told = data["experiments"][name]["controllers"][label]
    assert told["rms_deg"] == pytest.approx(np.median(rms, axis=0).tolist(), rel=1e-6)
    assert told["rms_deg_low"] == pytest.approx(np.quantile(rms, 0.05, axis=0).tolist(), rel=1e-6)
    assert told["rms_deg_high"] == pytest.approx(np.quantile(rms, 0.95, axis=0).tolist(), rel=1e-6)
    assert (told["trials"], told["failed"]) == (16, 0)


def ensemble_of(experiment, label, duration):
    law, q0 = experiment.build_controllers()[label], starts(experiment)
    plant, reference = experiment.build_plant(), experiment.build_reference()
    return rollout(plant, law, reference, duration, batch=len(q0), q0=q0, trials=[0] * len(q0))


def test_the_tuned_rows_of_the_files_are_those_of_the_page(data):
    for name, item in data["experiments"].items():
        for label, values in item["tuned"].items():
            table = load_experiment(name).controllers[label]
            assert {key: value for key, value in table.items() if key != "law"} == values


def test_both_untuned_and_tuned_rows_are_shown_for_every_law_with_gains(data):
    for item in data["experiments"].values():
        plain = [label for label in item["controllers"] if not label.endswith(TUNED_SUFFIX)]
        assert set(item["controllers"]) == {*plain, *(label + TUNED_SUFFIX for label in plain if label != "PPC")}


def test_a_tuned_row_is_better_than_its_untuned_one_by_the_stated_objective(data):
    for item in data["experiments"].values():
        if item["window"] is not None:
            continue  # the table is over a part of the run that was tuned
        limit = item["controllers"]["Proposed"]["torque_variation"]

        def objective(label, item=item, limit=limit):
            run = item["controllers"][label]
            excess = max(a / b for a, b in zip(run["torque_variation"], limit, strict=True))
            return math.sqrt(math.prod(run["rms_deg"])) * max(1.0, excess) ** 2

        for label in item["tuned"]:
            assert objective(label) < objective(label.removesuffix(TUNED_SUFFIX))


def test_a_place_in_the_ordering_counts_only_where_the_paired_ratios_are_certain_of_it():
    sure = {"certainly_above": [["PPC", "Existing"]] * 2}
    open_ = {"certainly_above": [["PPC"]] * 2}
    least = {"certainly_above": [[]] * 2}
    runs = {"PPC": figures((3.0, 3.0)) | least, "Existing": figures((2.0, 2.0)) | open_}
    claim = "ordering of the controllers: proposed first"

    def judged(**changes):
        own = figures((1.0, 1.0)) | changes
        return judged_claims({**runs, "Proposed": own}, (0.9, 0.99), PAPER["baek2016_experiment"])[claim]

    assert judged(**sure)["verdict"] == "holds"
    unsure = judged(**open_)
    assert unsure["verdict"] == "in part"
    assert "1 to 2 (not certain) and 1 to 2 (not certain) of 3" in unsure["evidence"]
    beaten = {**runs, "Existing": figures((2.0, 2.0)) | {"certainly_above": [["PPC", "Proposed"]] * 2}}
    lost = judged_claims({**beaten, "Proposed": figures((1.0, 1.0)) | open_}, (0.9, 0.99), PAPER["baek2016_experiment"])
    assert lost[claim]["verdict"] == "does not hold"


def test_what_is_certainly_larger_is_told_joint_by_joint_and_a_trial_that_diverged_is_larger_than_any():
    draw = np.linspace(1.0, 1.2, 16)
    rms = {"A": np.stack([draw, draw], axis=1), "B": np.stack([1.1 * draw, draw[::-1]], axis=1)}
    assert certainly_above(rms) == {"A": [["B"], []], "B": [[], []]}
    gone = {"A": rms["A"], "C": np.full((16, 2), np.nan)}
    assert certainly_above(gone) == {"A": [["C"], ["C"]], "C": [[], []]}


def test_a_row_of_the_page_has_its_medians_with_the_range_where_that_is_printed_differently():
    run = {"x": [1.0, 2.0, None], "x_low": [1.0, 1.5, None], "x_high": [1.0001, None, None]}
    assert medians(run, "x") == "1.00 / 2.00 [1.50 … ∞] / –"


@pytest.mark.parametrize("name", PAPER)
def test_a_reconciled_file_differs_from_the_printed_one_in_its_reading_only(name):
    printed, found = (load_experiment(name + suffix) for suffix in ("", "_reconciled"))
    assert found.reference == printed.reference
    assert (found.period, found.duration, found.plant) == (printed.period, printed.duration, printed.plant)
    reading = reading_of(name + "_reconciled")
    for label in ("PPC", "Proposed"):
        expected = vars(as_read(printed.build_controllers()[label], reading))
        for key, value in vars(found.build_controllers()[label]).items():
            if isinstance(value, (float, np.ndarray)):
                assert np.allclose(value, expected[key], rtol=1e-12), key


def test_the_reading_of_the_files_is_the_one_that_the_search_takes(data):
    for key, members in SETS.items():
        assert data["readings"][key]["members"] == list(members)
        assert data["readings"][key]["taken"]["reading"] == READINGS[key]


def outcome(distance, torque=50.0, **changes):
    base = {axis: options[0] for axis, options in AXES.items()}
    return (ReadingOutcome({**base, **changes}, {}, torque, 1.0, (1.0, 1.0), (distance**2,)),)


def test_a_departure_is_taken_only_if_it_halves_the_distance():
    printed = outcome(math.log(40.0))
    one = outcome(math.log(10.0), errors="rad")
    two_good = outcome(math.log(4.9), errors="rad", friction="none")
    two_poor = outcome(math.log(5.1), errors="rad", friction="none")
    assert reconciled([printed, one, two_good]) is two_good
    assert reconciled([printed, one, two_poor]) is one


def test_a_reading_that_needs_too_much_torque_is_out():
    told = [PAPER["baek2016_simulation_smooth"]]
    good, better = outcome(math.log(5.0), torque=179.0), outcome(math.log(3.0), torque=181.0)
    assert nearest_readings([good, better], told) == [good]


def test_a_reading_with_a_law_that_diverges_is_infinitely_far():
    assert factor(outcome(math.inf)) == math.inf


def test_the_first_reading_is_what_is_printed():
    first = next(readings(combined=False))
    law = load_experiment("baek2016_experiment").build_controllers()["Proposed"]
    same = as_read(law, first)
    assert all(np.array_equal(vars(law)[key], vars(same)[key]) for key in ("phi", "alpha", "epsilon", "mbar", "ks"))


# Claims can turn ----------------------------------------------------------------------------------------------------


def figures(rms, chatter=(1.0, 1.0), late=(1.0, 1.0), times=(0.1, 0.1)):
    return {
        "status": "ok",
        "end_time": 8.0,
        "rms_deg": list(rms),
        "torque_variation": list(chatter),
        "peak_gain_before": [1.0, 1.0],
        "peak_gain_last_quarter": list(late),
        "gain_times": list(times),
    }


def verdicts(**changes):
    runs = {
        "PPC": figures((0.1001, 0.0539)),
        "Existing": figures((0.0707, 0.0406), chatter=(2.0, 2.0), times=(1.0, 1.0)),
        "Proposed": figures((0.0432, 0.0357)),
        **changes,
    }
    return {
        key: item["verdict"] for key, item in judged_claims(runs, (0.9, 0.99), PAPER["baek2016_experiment"]).items()
    }


def test_the_papers_own_numbers_hold():
    assert set(verdicts().values()) == {"holds", "not applicable"}  # the norm is not printed for the robot


@pytest.mark.parametrize(
    ("claim", "run"),
    [
        ("ordering of the controllers: PPC last", figures((0.0432, 0.06))),
        ("ordering of the controllers: proposed first", figures((0.0432, 0.05))),
        ("size of the improvement over PPC", figures((0.01, 0.001))),
        ("size of the improvement over the existing law", figures((0.08, 0.09))),
        ("less chatter", figures((0.0432, 0.0357), chatter=(1.0, 3.0))),
        ("bounded gains", figures((0.0432, 0.0357), late=(1.0, 9.0))),
        ("bounded gains", {**figures((0.0432, 0.0357)), "status": "diverged"}),
        ("fast adaptation", figures((0.0432, 0.0357), times=(2.0, None))),
    ],
)
def test_a_claim_is_broken_by_figures_that_break_it(claim, run):
    assert verdicts(Proposed=run)[claim] != "holds"


def test_a_law_that_diverged_is_behind_every_other():
    gone = {**figures((None, None)), "status": "diverged", "torque_variation": [None, None]}
    assert verdicts(Existing=gone)["ordering of the controllers: PPC last"] == "does not hold"
    assert verdicts(Existing=gone)["ordering of the controllers: proposed first"] == "holds"
    assert verdicts(Proposed=gone)["ordering of the controllers: proposed first"] == "does not hold"
    assert verdicts(Proposed=gone)["less chatter"] == "does not hold"


# Bounds -------------------------------------------------------------------------------------------------------------


def test_the_needed_gain_breaks_away_within_the_error_and_a_smaller_one_does_not():
    t = np.arange(0.0, 2.0, 1e-3)
    pace = (0.5 * t**2, t, np.ones_like(t))
    gain = needed_gain(pace, 100.0, 0.01, 1e-3, 0.01)
    assert break_away(*pace, 100.0, 0.01, 1e-3, gain, gain) <= 0.01
    assert break_away(*pace, 100.0, 0.01, 1e-3, 0.99 * gain, 0.99 * gain) > 0.01


def test_a_stuck_joint_breaks_away_where_the_torque_has_moved_by_twice_the_friction():
    # q̈_d = 1 from rest, β = k_s → 0: the torque moves by m̄/L per second, so 2F = 5 N·m takes 0.5 s, and e is 1/8 rad.
    t = np.arange(0.0, 2.0, 1e-3)
    error = break_away(0.5 * t**2, t, np.ones_like(t), 5.0, 0.01, 1e-3, 1e-9, 1e-9)
    assert error == pytest.approx(0.125, rel=5e-3)


def test_the_printed_gains_cannot_reach_the_printed_error_but_those_of_the_robot_can():
    smooth, robot = PAPER["baek2016_simulation_smooth"], PAPER["baek2016_experiment"]
    assert min(limits(load_experiment(smooth.name), smooth)["drift_deg"]) > 100.0 * max(smooth.rms_deg["PPC"])
    found = limits(load_experiment(robot.name), robot)["drift_deg"]
    assert found == pytest.approx(robot.rms_deg["PPC"], rel=0.5)


# Measuring and tuning -----------------------------------------------------------------------------------------------


def short_run(**changes):
    experiment = load_experiment("baek2016_experiment")
    laws = {label: {**experiment.controllers[label], **changes} for label in ("PPC", "Proposed")}
    return experiment.replace(controllers=laws, duration=1.0, plant={"effort_limit": math.inf})


def recorded(experiment):
    runs = {
        label: rollout(experiment.build_plant(), law, experiment.build_reference(), experiment.duration)
        for label, law in experiment.build_controllers().items()
    }
    laws = {label: table["law"] for label, table in experiment.controllers.items()}
    return runs, trajectories(experiment.build_arm(), runs, laws)


def test_a_run_read_back_from_its_trajectories_has_the_same_metrics():
    runs, dataset = recorded(short_run())
    for label, run in runs.items():
        for name, values in evaluate(run).items():
            assert np.array_equal(evaluate(recorded_run(dataset, label))[name], values, equal_nan=True), name


def test_what_is_measured_is_what_the_metrics_say_of_the_run_and_of_its_parts():
    runs, _ = recorded(short_run())
    run, found = runs["Proposed"], measure(runs["Proposed"], "baek2016", 0.5)
    assert found["max_error_deg"] == np.degrees(METRICS["max_error"](run)[0]).tolist()
    assert found["torque_variation"] == METRICS["torque_variation"](run)[0].tolist()
    error = (run.q_ref - run.q[0])[run.time <= 0.5 + 1e-9]
    assert found["rms_deg"] == pytest.approx(np.degrees(np.sqrt(np.mean(error**2, axis=0))).tolist(), rel=1e-14)
    late = 3 * run.time.size // 4
    assert found["peak_gain_before"] == run.gain[0, :late].max(axis=0).tolist()
    assert found["peak_gain_last_quarter"] == run.gain[0, late:].max(axis=0).tolist()
    assert found["max_error_deg_high"] == found["max_error_deg"]  # a single trial
    assert measure(runs["PPC"], "ppc", None)["peak_gain"] == [None, None]
    assert measure(runs["PPC"], "ppc", None)["gain_times"] == [None, None]


def test_of_several_trials_medians_and_quantiles_are_told_and_a_failure_opens_the_range():
    experiment = short_run().replace(duration=0.2, ensemble={"trials": 5, "q0_deviation": 1e-3})
    run = ensemble_of(experiment, "PPC", 0.2)
    found, each = measure(run, "ppc", None), np.degrees(METRICS["rms_error"](run))
    assert found["rms_deg"] == pytest.approx(np.median(each, axis=0).tolist())
    assert found["rms_deg_low"] == pytest.approx(np.quantile(each, 0.05, axis=0).tolist())
    means = np.sqrt(each[:, 0] * each[:, 1])
    assert found["mean_rms_deg"] == pytest.approx([np.median(means)])
    assert found["mean_rms_deg_high"] == pytest.approx([np.quantile(means, 0.95)])
    status, end = ("ok", "ok", "diverged", "ok", "ok"), np.array([0.2, 0.2, 0.1, 0.2, 0.2])
    q = run.q.copy()
    q[2, 100:] = np.nan
    gone = dataclasses.replace(run, q=q, status=status, end_time=end)
    told = measure(gone, "ppc", None)
    assert (told["status"], told["failed"], told["trials"], told["end_time"]) == ("diverged", 1, 5, 0.1)
    assert told["rms_deg_high"] == [None, None]
    assert told["rms_deg"] == pytest.approx(np.median(np.where(np.arange(5) == 2, np.inf, each.T), axis=1).tolist())
    # Over the time before it diverged the trial has an error like any other.
    assert all(x is not None for x in measure(gone, "ppc", 0.09)["rms_deg_high"])


def test_a_law_that_diverges_after_the_window_of_its_table_still_has_an_rms_error_over_it():
    run = recorded(short_run(ks=3000.0, beta=3000.0))[0]["PPC"]
    assert run.status == ("diverged",)
    before = float(run.end_time[0]) - 0.008
    assert all(x is not None for x in measure(run, "ppc", before)["rms_deg"])
    assert measure(run, "ppc", float(run.end_time[0]))["rms_deg"] == [None, None]
    found = measure(run, "ppc", before)
    assert (found["status"], found["max_error_deg"]) == ("diverged", [None, None])


def test_tuning_anew_writes_into_the_users_folder_and_runs_what_lies_there(tmp_path, monkeypatch):
    name = "baek2016_experiment"
    files = sorted(path for path in shipped("experiments").rglob("*") if path.is_file())
    before = {path: path.read_bytes() for path in files}
    ran = []

    class Enough(Exception):
        pass

    def stop(experiment, *_, **__):
        ran.append(experiment)
        raise Enough

    def quickly(experiment, _progress):
        plain = experiment.replace(controllers=untuned(experiment), duration=0.4)
        return tune_own_gains(plain, ["Existing"], trials=2, batch=2)

    monkeypatch.setattr("asmc_pin.reproduction.reproducing.tune_rows", quickly)
    monkeypatch.setattr("asmc_pin.reproduction.reproducing.compare", stop)
    with pytest.raises(Enough):
        reproduce([name], tmp_path / "out", tune=True)
    path = tmp_path / "out" / "tuned" / f"{name}.toml"
    assert ran[0].to_toml() == load_experiment(path).to_toml()
    assert [label for label in ran[0].controllers if label.endswith(TUNED_SUFFIX)] == ["Existing" + TUNED_SUFFIX]
    assert "# 2 trials for each law" in path.read_text(encoding="utf-8")
    assert {path: path.read_bytes() for path in files} == before


# The whole ----------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_one_experiment_can_be_reproduced_by_itself(tmp_path, data):
    name = "baek2016_experiment"
    shares = []
    found = reproduce([name], tmp_path / "out", progress=lambda _, share: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert list(found.data["figures"]) == ["fig10", "fig11", "fig12", "fig13"]
    assert all(
        (tmp_path / "out" / "figures" / f"{name}.{kind}").is_file()
        for name in found.data["figures"]
        for kind in ("pdf", "png")
    )
    assert found.data["experiments"][name]["claims"] == data["experiments"][name]["claims"]
    assert (tmp_path / "out" / "reproduction.md").read_text(encoding="utf-8") == page(found.data, "figures")
    json.dumps(found.to_json_dict(), allow_nan=False)
    assert any("Table III" in line for line in found.lines())
    with pytest.raises(ResultError, match="force=True"):
        reproduce([name], tmp_path / "out")


def test_an_unknown_name_is_told_the_nearest(tmp_path):
    with pytest.raises(ExperimentError, match="did you mean 'baek2016_experiment'"):
        reproduce(["baek2016_experimet"], tmp_path)
    assert not list(tmp_path.iterdir())
