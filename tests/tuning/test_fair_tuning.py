"""Tuning is fair: one budget, objective and set of draws for all, and a verdict on draws that nobody was tuned on."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pyarrow.parquet as pq
import pytest
from law_settings import required_of
from sweep_cases import contents
from tune_cases import repeatable, small

import asmc_pin
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.errors import ExperimentError, ParameterError, ResultError
from asmc_pin.experiment import load_experiment
from asmc_pin.pages.tunings.tune_tables import pair_rows
from asmc_pin.sampled import stability
from asmc_pin.statistics.rank_tests import probability_of_improvement
from asmc_pin.sweeping.trial_runs import TrialOutcome
from asmc_pin.tuning.candidate_runs import CandidateRuns, draws_of
from asmc_pin.tuning.controller_tuning import ControllerTuning
from asmc_pin.tuning.fair_score import Judge
from asmc_pin.tuning.gain_study import BATCH
from asmc_pin.tuning.search_space import SPAN, search_space

BUDGET = BATCH + 4


@pytest.fixture(scope="module")
def tuned(tmp_path_factory):
    return asmc_pin.tune(small(), BUDGET, tmp_path_factory.mktemp("tune") / "out")


def by_label(tuned):
    return {item.label: item for item in tuned.findings.controllers}


def test_every_controller_has_the_same_budget_and_every_candidate_of_it_was_run(tuned):
    rows = pq.read_table(tuned.out / "candidates.parquet").to_pandas()
    assert rows.groupby("controller").candidate.nunique().to_dict() == {"PPC": BUDGET, "BSMC": BUDGET}
    assert {label: item.trials for label, item in by_label(tuned).items()} == {"PPC": BUDGET, "BSMC": BUDGET}
    assert rows.error.gt(0.0).all()


def test_a_planted_bad_gain_is_mended_also_on_draws_that_were_held_out(tmp_path):
    defaults = {"mbar": [0.002, 0.001], "ks": 5.0, "beta": 4.0}  # a tenth of what this arm takes
    planted = by_label(asmc_pin.tune(small(defaults=defaults), BATCH, tmp_path / "out"))
    for item in planted.values():
        assert item.errors[item.winner] < 0.5 * item.errors[0]
        assert item.change.high < 0.5
        assert np.all(item.held_out < 0.5 * item.held_out_start)
        assert item.setting["mbar"][0] > 0.002


def test_training_and_held_out_draws_share_nothing(tuned):
    rows = pq.read_table(tuned.out / "held_out.parquet").to_pandas()
    tuning = ControllerTuning(small(), "PPC")
    assert sorted(rows.draw.unique()) == list(tuning.held_out)
    assert not set(tuning.train) & set(tuning.held_out)
    drawn = draws_of(small())
    values = [tuple(drawn.quantities(draw).values()) for draw in (*tuning.train, *tuning.held_out)]
    assert len(set(values)) == len(values), "each draw has a load and a move of its own"


def test_the_value_that_is_claimed_is_that_of_the_tuned_file_run_by_itself(tuned):
    again = load_experiment(tuned.path)
    assert again.name == "small-tuned"
    for label, item in by_label(tuned).items():
        space = search_space(again, label)
        score = Judge(again).score(CandidateRuns(again, space)([space.start()], range(2))[0])
        assert score.error == pytest.approx(item.errors[item.winner], rel=1e-12)


@pytest.mark.long
def test_compare_runs_the_tuned_file_and_it_is_better_than_the_given_one(tuned, tmp_path):
    single = {"ensemble": {"trials": 1}}
    runs = [asmc_pin.compare(x.replace(**single), tmp_path / x.name) for x in (small(), load_experiment(tuned.path))]
    worse, better = (run.rows.groupby("controller").rms_error.max() for run in runs)
    assert (better < worse).all()


def test_the_first_candidate_is_the_files_own_and_the_winner_is_not_worse(tuned):
    for label, item in by_label(tuned).items():
        space = search_space(small(), label)
        runs = CandidateRuns(small(), space)
        assert Judge(small()).score(runs([space.start()], range(2))[0]).error == item.errors[0]
        assert item.errors[item.winner] <= item.errors[0]


def test_candidates_do_not_depend_on_who_else_is_tuned(tuned, tmp_path):
    alone = small(controllers={"BSMC": {"law": "bsmc", "gain": 5.0, "boundary": 0.05}})
    again = by_label(asmc_pin.tune(alone, BUDGET, tmp_path / "alone"))["BSMC"]
    assert np.array_equal(again.errors, by_label(tuned)["BSMC"].errors)
    assert again.setting == by_label(tuned)["BSMC"].setting


def test_a_larger_budget_goes_on_from_the_smaller_one_as_if_it_had_been_asked_for_at_once(tuned, tmp_path):
    asmc_pin.tune(small(), BATCH - 2, tmp_path / "grown")
    asmc_pin.tune(small(), BUDGET, tmp_path / "grown")
    assert repeatable(tmp_path / "grown") == repeatable(tuned.out)


def test_an_interrupted_tuning_goes_on_and_ends_with_the_same_bytes(tuned, tmp_path):
    told = []

    def stop(what, _share):
        told.append(what)
        if what.startswith(f"BSMC: {BATCH} "):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        asmc_pin.tune(small(), BUDGET, tmp_path / "cut", progress=stop)
    before = len(told)
    asmc_pin.tune(small(), BUDGET, tmp_path / "cut", progress=lambda what, _: told.append(what))
    assert not [line for line in told[before:] if line.startswith("PPC: 0 ")], "what was done is not done again"
    assert repeatable(tmp_path / "cut") == repeatable(tuned.out)


def test_a_controller_that_always_fails_is_infinite_ranks_last_and_is_never_dropped(tmp_path):
    wild = {"law": "ppc", "ks": 9000.0, "beta": 9000.0}
    experiment = small(
        plant={"effort_limit": math.inf},
        controllers={"Wild": wild, "PPC": {"law": "ppc"}},
        tune={"train": 1, "held_out": 7, "search": {"controllers.Wild.ks": {"factor": [0.9, 1.1]}}},
    )
    found = asmc_pin.tune(experiment, 4, tmp_path / "out")
    item = by_label(found)["Wild"]
    assert np.isinf(item.errors).all()
    assert np.isinf(item.held_out).all()
    assert item.failed == 7
    assert item.setting["ks"] == 9000.0, "where all fail the file's own gains stand"
    (pair,) = found.findings.comparisons
    assert (pair.better, pair.worse, pair.ratio, pair.certain) == ("PPC", "Wild", 0.0, True)
    assert probability_of_improvement(by_label(found)["PPC"].held_out, item.held_out) == 1.0
    told = json.loads(json.dumps(found.to_json_dict(), allow_nan=False))["controllers"]["Wild"]
    assert (told["train"], told["held_out"], told["failed"]) == (None, None, 7)
    assert "Wild: every candidate failed in training; the file's gains stand" in found.lines()


def test_the_winner_keeps_a_limit_that_more_accurate_candidates_break(tuned, tmp_path):
    free = by_label(tuned)["BSMC"]
    limit = 0.5 * free.chatters[free.winner]
    experiment = small(tune={"train": 2, "held_out": 6, "limits": {"chatter": limit}})
    held = by_label(asmc_pin.tune(experiment, BUDGET, tmp_path / "out"))["BSMC"]
    assert held.keeps_limits
    assert held.errors[held.winner] > free.errors[free.winner]
    assert np.any(~held.within & (held.errors < held.errors[held.winner]))


def test_who_is_better_and_kept_no_limit_is_told_with_that(tuned):
    """Else it would look as if a law were better by fair means."""
    first, *others = tuned.findings.controllers
    loose = dataclasses.replace(first, within=np.zeros_like(first.within))
    rows = pair_rows(dataclasses.replace(tuned.findings, controllers=[loose, *others])).rows
    for row, fair in zip(rows, pair_rows(tuned.findings).rows, strict=True):
        assert fair[:2] == [cell.removesuffix(" (over a limit)") for cell in row[:2]]
        assert all(cell.endswith(" (over a limit)") == cell.startswith(first.shown) for cell in row[:2])


def test_each_limit_is_about_its_own_figure_and_that_of_a_rate_is_the_largest_step_over_the_period():
    figures = {"rms_error": [0.01, 0.04], "torque_variation": [50.0, 20.0], "torque_noise": [0.3, 0.2]}
    figures["torque_step"] = [0.5, 0.9]  # in 2 ms: 250 and 450 N·m/s
    run = TrialOutcome("a", (), "ppc", "PPC", False, "ok", 0.2, {name: np.array(x) for name, x in figures.items()})
    for limits, excess in (
        ({"chatter": 100.0}, 0.5),
        ({"chatter": [100.0, 10.0]}, 2.0),
        ({"torque_noise": [0.6, 0.1]}, 2.0),
        ({"torque_rate": 300.0}, 1.5),
        ({"torque_rate": [500.0, 450.0]}, 1.0),
        ({"chatter": 100.0, "torque_rate": 900.0}, 0.5),
    ):
        score = Judge(small(tune={"train": 2, "held_out": 6, "limits": limits})).score([run])
        assert score.excess == pytest.approx(excess)
        assert score.within == (excess <= 1.0)
        assert score.error == pytest.approx(0.02)
        assert score.value == pytest.approx(0.02 * max(1.0, excess) ** 2)
    failed = dataclasses.replace(run, status="diverged")
    assert Judge(small()).score([run, failed]).excess == math.inf


def test_no_candidate_of_the_front_is_beaten_in_both_error_and_chatter(tuned):
    for item in by_label(tuned).values():
        front = item.front()
        assert len(front) >= 1
        for i in front:
            assert not np.any((item.errors < item.errors[i]) & (item.chatters < item.chatters[i]))


def test_sensitivity_is_one_at_the_winner_and_its_runs_cannot_win(tuned):
    for item in by_label(tuned).values():
        assert set(item.sensitivity) == set(item.setting)
        for factors, ratios in item.sensitivity.values():
            assert ratios[factors == 1.0] == [1.0]
        assert item.trials == BUDGET


# What is searched -----------------------------------------------------------------------------------------------------


def test_one_rule_gives_every_law_its_ranges_within_what_it_takes():
    own = {"ppc": {}, "implicit": {"gain": 2.0, "share": 0.2}, "adrc": {"observer_hz": math.inf}}
    experiment = small(controllers={name: {"law": name, **values} for name, values in own.items()})
    spaces = {name: search_space(experiment, name) for name in own}
    loop = {name: (1.0 / SPAN, SPAN) for name in ("mbar", "ks", "beta")}
    assert spaces["ppc"].ranges == loop
    assert spaces["implicit"].ranges == {**loop, "gain": (1.0 / SPAN, SPAN), "share": (1.0 / SPAN, 5.0)}
    assert spaces["adrc"].ranges == loop, "no range is a factor on infinity"


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_law_of_the_package_can_be_tuned_from_what_its_card_suggests(name):
    space = search_space(
        small(controllers={name: {"law": name, **required_of(name, 1.0), **CONTROLLERS[name].typical}}), name
    )
    runs = CandidateRuns(small(), space, ("rms_error",))
    for end in (0, 1):
        factors = {key: ends[end] for key, ends in space.ranges.items()}
        assert not runs.refused(space.setting(factors)), "both ends of every range are gains that the law takes"


def test_a_list_is_searched_by_one_factor_unless_each_joint_is_asked_for():
    line = {"defaults.mbar": {"factor": [0.5, 2.0], "each": True}, "controllers.PPC.beta": {"range": [2.0, 8.0]}}
    space = search_space(small(tune={"search": line}), "PPC")
    assert space.ranges == {"mbar[0]": (0.5, 2.0), "mbar[1]": (0.5, 2.0), "ks": (0.1, 10.0), "beta": (0.5, 2.0)}
    assert space.setting({"mbar[0]": 2.0, "mbar[1]": 0.5, "ks": 1.0, "beta": 2.0})["mbar"] == [0.04, 0.005]
    assert search_space(small(), "PPC").setting({"mbar": 2.0, "ks": 1.0, "beta": 1.0})["mbar"] == [0.04, 0.02]


def test_gains_outside_the_ranges_that_were_asked_for_do_not_win_even_if_they_are_the_files_own(tmp_path):
    experiment = small(tune={"train": 1, "held_out": 2, "search": {"defaults.beta": {"range": [0.4, 0.5]}}})
    item = by_label(asmc_pin.tune(experiment, 3, tmp_path / "out"))["PPC"]
    assert item.winner != 0
    assert 0.4 <= item.setting["beta"] <= 0.5


def test_asked_to_stay_stable_nothing_outside_the_region_is_run(tmp_path):
    line = {"defaults.ks": {"range": [5.0, 3000.0]}}
    experiment = small(tune={"train": 1, "held_out": 2, "stable": True, "search": line})
    item = by_label(asmc_pin.tune(experiment, 12, tmp_path / "out"))["PPC"]
    assert 0 < item.refused < 12
    assert item.trials == 12, "what was refused counts"
    gains = item.setting["mbar"], item.setting["ks"], item.setting["beta"]
    arm = experiment.replace(tune=None, **draws_of(experiment).tables(draws_of(experiment).quantities(0))).build_arm()
    assert stability(arm, *gains, 0.002, samples=256).stable


# What is refused ------------------------------------------------------------------------------------------------------


def test_mistakes_are_told():
    with pytest.raises(ExperimentError, match="did you mean 'beta'"):
        small(tune={"search": {"defaults.betta": {"factor": [0.5, 2.0]}}})
    with pytest.raises(ExperimentError, match="no controller 'PCC': did you mean 'PPC'"):
        small(tune={"search": {"controllers.PCC.beta": {"factor": [0.5, 2.0]}}})
    with pytest.raises(ExperimentError, match="both positive"):
        small(tune={"search": {"defaults.beta": {"factor": [2.0, 0.5]}}})
    with pytest.raises(ExperimentError, match="did you mean 'rms_error'"):
        small(tune={"objective": "rms_eror"})
    with pytest.raises(ExperimentError, match="has 3 values, and the arm 2 joints"):
        Judge(small(tune={"limits": {"chatter": [1.0, 2.0, 3.0]}}))
    with pytest.raises(ExperimentError, match="nothing in it is drawn at random"):
        asmc_pin.tune(small(sweep={}))
    with pytest.raises(ExperimentError, match="varies gains, which tune searches"):
        asmc_pin.tune(small(sweep={"defaults.beta": {"uniform": [1.0, 2.0]}}))
    with pytest.raises(ParameterError, match="trials"):
        asmc_pin.tune(small(), 0)


def test_candidates_of_another_experiment_are_refused_until_they_may_be_replaced(tmp_path):
    asmc_pin.tune(small(), 1, tmp_path / "out")
    before = contents(tmp_path / "out")
    other = small(duration=0.19)
    with pytest.raises(ResultError, match="another experiment, URDF or version"):
        asmc_pin.tune(other, 1, tmp_path / "out")
    assert contents(tmp_path / "out") == before  # its experiment too: else the result would be said to be of the other
    asmc_pin.tune(other, 1, tmp_path / "out", force=True)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    with pytest.raises(ResultError, match="holds files that are no tuning"):
        asmc_pin.tune(small(), 1, tmp_path / "mine", force=True)
