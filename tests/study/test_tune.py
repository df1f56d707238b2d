"""Tuning: the same budget for every law, repeatable, and never worse than what it started from."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from law_settings import numbers_of, required_of

from asmc_pin import rollout
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.errors import ExperimentError, ParameterError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.study.law_study import own_parameters
from asmc_pin.study.stacked_settings import Stacked
from asmc_pin.study.tuning import tune_own_gains
from asmc_pin.study.tuning_objective import Objective


def experiment(**changes) -> Experiment:
    data = {
        "name": "short",
        "arm": "rv4fd",
        "period": 0.004,
        "duration": 1.0,
        "reference": {
            "kind": "multisine",
            "offset": [0.5, 0.5],
            "amplitude": [0.3, 0.3],
            "frequency": 1.0,
            "rise": 0.5,
        },
        "defaults": {"mbar": [0.07, 0.12], "ks": 20.0, "beta": 20.0},
        "controllers": {
            "PPC": {"law": "ppc"},
            "BSMC": {"law": "bsmc", "gain": [5.0, 5.0], "boundary": 0.5},
            "Existing": {"law": "plestan2010", "rate": 100.0, "epsilon": 0.2, "floor": 0.1},
            "Proposed": {"law": "baek2016", "phi": [400.0, 360.0], "alpha": [5.0, 3.0], "epsilon": 0.6},
        },
    }
    return Experiment.from_dict({**data, **changes})


@pytest.fixture(scope="module")
def tuning():
    return tune_own_gains(experiment(), trials=12, batch=5, seed=3)


def test_every_law_has_the_same_budget_and_one_without_gains_is_run_once(tuning):
    assert {label: law.trials for label, law in tuning.laws.items()} == {
        "PPC": 1,
        "BSMC": 12,
        "Existing": 12,
        "Proposed": 12,
    }
    assert tuning.laws["PPC"].value == tuning.laws["PPC"].untuned


def test_tuning_is_never_worse_than_the_file_and_here_better(tuning):
    for label in ("BSMC", "Existing", "Proposed"):
        assert tuning.laws[label].value < tuning.laws[label].untuned


def test_the_value_that_is_claimed_is_that_of_the_tuned_experiment_run_by_itself(tuning):
    tuned = tuning.tuned()
    for label, law in tuned.build_controllers().items():
        run = rollout(tuned.build_plant(), law, tuned.build_reference(), tuned.duration)
        rms = METRICS["rms_error"](run)[0]
        assert math.sqrt(rms[0] * rms[1]) == pytest.approx(tuning.laws[label].value, rel=1e-12)


def test_only_own_parameters_are_searched_and_shared_ones_stay(tuning):
    tuned = tuning.tuned().build_controllers()
    for law in tuned.values():
        assert law.mbar.tolist() == [0.07, 0.12]
        assert law.beta == 20.0
    assert set(tuning.laws["Proposed"].parameters) == {"phi", "alpha", "epsilon"}
    assert own_parameters(experiment(), "PPC") == {}


def test_a_list_is_searched_joint_by_joint_and_a_number_as_one(tuning):
    found = tuning.laws["BSMC"].parameters
    assert len(found["gain"]) == 2
    assert found["gain"][0] != found["gain"][1]
    assert isinstance(found["boundary"], float)


def test_the_same_seed_gives_the_same_tuning_whichever_laws_are_tuned_with_it(tuning):
    again = tune_own_gains(experiment(), ["Existing"], trials=12, batch=5, seed=3)
    assert again.laws["Existing"] == tuning.laws["Existing"]
    other = tune_own_gains(experiment(), ["Existing"], trials=12, batch=5, seed=4)
    assert other.laws["Existing"].parameters != again.laws["Existing"].parameters


def test_searched_values_stay_within_the_span():
    start = own_parameters(experiment(), "Existing")
    found = tune_own_gains(experiment(), ["Existing"], trials=8, span=1.5).laws["Existing"].parameters
    assert found.keys() == start.keys()
    assert found != start, "the file's own values, the first to be tried, would say nothing"
    for name, value in found.items():
        assert start[name] / 1.5 * (1 - 1e-3) <= value <= start[name] * 1.5 * (1 + 1e-3)


def test_an_interrupted_tuning_goes_on_from_its_journal(tmp_path):
    journal = tmp_path / "journal.log"
    calls = []

    def stop(what, share):
        calls.append(share)
        if len(calls) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tune_own_gains(experiment(), ["Existing"], trials=12, batch=4, storage=journal, progress=stop)
    calls.clear()
    found = tune_own_gains(
        experiment(), ["Existing"], trials=12, batch=4, storage=journal, progress=lambda _, share: calls.append(share)
    )
    assert calls[0] == pytest.approx(8 / 12)  # eight were done before the interrupt
    assert found.laws["Existing"].trials == 12
    assert (
        found.laws["Existing"].untuned == tune_own_gains(experiment(), ["Existing"], trials=1).laws["Existing"].untuned
    )


def test_a_journal_of_another_tuning_is_refused(tmp_path):
    journal = tmp_path / "journal.log"
    tune_own_gains(experiment(), ["Existing"], trials=1, storage=journal)
    with pytest.raises(ResultError, match="another experiment, objective or budget"):
        tune_own_gains(experiment(duration=0.8), ["Existing"], trials=1, storage=journal)


def test_a_limit_of_chatter_costs_accuracy_and_is_kept():
    free = tune_own_gains(experiment(), ["Existing"], trials=24, seed=1)
    limits = (520.0, 440.0)
    held = tune_own_gains(experiment(), ["Existing"], trials=24, seed=1, objective=Objective(limits))
    runs = []
    for item in (free.tuned(), held.tuned()):
        law = item.build_controllers()["Existing"]
        runs.append(rollout(item.build_plant(), law, item.build_reference(), item.duration))
    chatter = [METRICS["torque_variation"](run)[0] for run in runs]
    assert np.any(chatter[0] > limits)
    assert np.all(chatter[1] <= limits)
    assert held.laws["Existing"].value > free.laws["Existing"].value


def test_a_setting_that_diverges_ranks_behind_every_other_and_the_earlier_the_worse():
    item = experiment()
    base = {"mbar": [0.07, 0.12], "period": 0.004}
    laws = [CONTROLLERS["ppc"](ks=g, beta=g, **base) for g in (20.0, 3000.0, 1e6)]
    plant = experiment(plant={"effort_limit": math.inf}).build_plant()
    run = rollout(plant, Stacked(laws, 2), item.build_reference(), 1.0, batch=3)
    assert run.status == ("ok", "diverged", "diverged")
    assert run.end_time[1] > run.end_time[2]
    value = Objective()(run)
    assert value[0] < 1.0 < value[1] < value[2]


def settings_of(name):
    """Two settings of a registered law that differ in every number of its own, and in K_s and β."""
    law, base = CONTROLLERS[name], {"mbar": [0.07, 0.12], "period": 0.004}
    first, second = required_of(name, 0.4), numbers_of(name, 0.7)
    return law(**base, ks=20.0, beta=20.0, **first), law(**base, ks=10.0, beta=15.0, **second)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_stacked_setting_runs_as_it_would_alone(name):
    item = experiment()
    law, other = settings_of(name)
    plant, reference = item.build_plant(), item.build_reference()
    both = rollout(plant, Stacked([law, other], 2), reference, 1.0, batch=2)
    for trial, single in enumerate((law, other)):
        alone = rollout(plant, single, reference, 1.0)
        assert np.array_equal(both.q[trial], alone.q[0])
        assert np.array_equal(both.torque[trial], alone.torque[0])
        assert np.array_equal(both.gain[trial], alone.gain[0], equal_nan=True)
    assert not np.array_equal(both.torque[0], both.torque[1])


def test_laws_with_a_rule_for_epsilon_are_stacked_among_themselves_and_not_with_those_with_a_number():
    law, other = (replace(x, epsilon="4KL") for x in settings_of("plestan2010"))
    item = experiment()
    both = rollout(item.build_plant(), Stacked([law, other], 2), item.build_reference(), 0.5, batch=2)
    alone = rollout(item.build_plant(), other, item.build_reference(), 0.5)
    assert np.array_equal(both.gain[1], alone.gain[0])
    with pytest.raises(ParameterError, match="only numbers can be stacked"):
        Stacked([law, settings_of("plestan2010")[0]], 2)


def test_laws_that_differ_in_kind_are_not_stacked():
    laws = experiment().build_controllers()
    with pytest.raises(ParameterError, match="stack settings of one law"):
        Stacked([laws["PPC"], laws["BSMC"]], 2)


def test_what_is_told_is_valid_json_and_names_the_objective(tuning):
    told = json.loads(json.dumps(tuning.to_json_dict(), allow_nan=False))
    assert told["laws"]["Existing"]["parameters"] == tuning.laws["Existing"].parameters
    assert "geometric mean" in tuning.lines()[0]


def test_faults_are_told():
    with pytest.raises(ExperimentError, match="there is no 'Ppc'"):
        tune_own_gains(experiment(), ["Ppc"])
    with pytest.raises(ParameterError, match="span"):
        tune_own_gains(experiment(), span=1.0)
    with pytest.raises(ParameterError, match="chatter_limit"):
        Objective((0.0, 1.0))
