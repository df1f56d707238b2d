"""[sweep]: what may vary, by the path of its key; what a trial is made of; and what is said about mistakes."""

import json

import jsonschema
import numpy as np
import pytest
from scipy import stats
from sweep_cases import DATA, tiny

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import experiment_schema
from asmc_pin.experiment.toml_text import parse_toml
from asmc_pin.experiment.variation.key_paths import parts_of
from asmc_pin.experiment.variation.key_units import unit_of_key


def drawn(sweep, path, count=400):
    variation = tiny(sweep).variation
    return np.array([variation.quantities(trial)[path] for trial in range(count)])


@pytest.mark.parametrize(
    ("given", "distribution"),
    [
        ({"uniform": [1.0, 3.0]}, stats.uniform(1.0, 2.0)),
        ({"normal": [2.0, 0.3]}, stats.norm(2.0, 0.3)),
        ({"normal": 0.1}, stats.norm(0.5, 0.1)),
        ({"lognormal": [2.0, 0.4]}, stats.lognorm(0.4, scale=2.0)),
        ({"lognormal": 0.4}, stats.lognorm(0.4, scale=0.5)),
        ({"normal": [0.0, 1.0], "at_least": 0.5, "at_most": 2.0}, stats.truncnorm(0.5, 2.0)),
        ({"factor": {"lognormal": 0.2}}, stats.lognorm(0.2)),
        ({"factor": {"normal": 0.2, "at_least": 0.1}}, stats.truncnorm(-4.5, np.inf, 1.0, 0.2)),
    ],
)
def test_what_is_drawn_has_the_distribution_that_was_asked_for(given, distribution):
    assert stats.kstest(drawn({"arm.payload": given}, "arm.payload"), distribution.cdf).pvalue > 0.01


def test_a_draw_depends_on_the_seed_its_number_and_its_key_alone():
    one = {"arm.payload": {"uniform": [0.0, 1.0]}}
    more = {"defaults.ks": {"uniform": [1.0, 2.0]}, **one, "defaults.beta": {"factor": {"values": [1.0, 2.0]}}}
    alone, among = tiny(one).variation, tiny(more).variation
    for draw in range(5):
        here = alone.quantities(draw)["arm.payload"]
        for point in range(2):
            assert among.quantities(2 * draw + point)["arm.payload"] == here
    assert tiny(one, seed=6).variation.quantities(0) != alone.quantities(0)
    both = tiny({"defaults.ks": {"uniform": [0.0, 1.0], "at_least": 1e-9}, **one}).variation.quantities(0)
    assert both["defaults.ks"] != both["arm.payload"]


def test_each_draws_for_every_joint_and_without_it_one_draw_serves_all():
    variation = tiny({"plant.friction.coulomb": {"factor": {"lognormal": 0.3, "each": True}}}).variation
    first, second = variation.tables(variation.quantities(0))["plant"]["friction"]["coulomb"]
    assert first / 1.0 != second / 0.5
    variation = tiny({"plant.friction.coulomb": {"factor": {"lognormal": 0.3}}}).variation
    first, second = variation.tables(variation.quantities(0))["plant"]["friction"]["coulomb"]
    assert first / 1.0 == second / 0.5 != 1.0


def test_grids_multiply_and_one_that_goes_along_adds_no_points():
    sweep = {
        "arm.source": {"values": ["two_link", "so100"]},
        "defaults.ks": {"values": [1.0, 2.0, 3.0]},
        "defaults.beta": {"values": [5.0, 7.0], "with": "arm.source"},
    }
    variation = tiny(sweep).variation
    assert variation.points == 6
    at = [variation.quantities(point) for point in range(6)]
    assert [x["defaults.ks"] for x in at] == [1.0, 2.0, 3.0] * 2
    assert {(x["arm.source"], x["defaults.beta"]) for x in at} == {("two_link", 5.0), ("so100", 7.0)}


def test_a_scan_is_a_point_of_its_own_where_grids_stand_at_the_files_own_value():
    sweep = {"defaults.ks": {"values": [1.0, 2.0]}, "arm.payload": {"scan": [0.0, 9.0]}}
    variation = tiny(sweep).variation
    assert variation.points == 3
    assert variation.quantities(2) == {"defaults.ks": 5.0, "arm.payload": 0.0}
    assert variation.quantities(0)["arm.payload"] == 0.5


def test_the_files_tables_are_left_as_they_are():
    experiment = tiny()
    before = json.dumps(experiment.variation.data, sort_keys=True)
    experiment.variation.tables(experiment.variation.quantities(3))
    assert json.dumps(experiment.variation.data, sort_keys=True) == before


@pytest.mark.parametrize(
    ("path", "given", "told"),
    [
        (
            "arm.paylod",
            {"uniform": [0.0, 1.0]},
            "there is no such key: arm.paylod: unknown key: did you mean 'payload'",
        ),
        ("plant.frction.coulomb", {"uniform": [0.0, 1.0]}, "did you mean 'friction'"),
        ("plant.friction.colomb", {"factor": {"lognormal": 0.1}}, "did you mean 'coulomb'"),
        ("controllers.PCP.beta", {"uniform": [0.0, 1.0]}, "there is no controller 'PCP': did you mean 'PPC'"),
        ("controllers.PPC.bta", {"uniform": [1.0, 2.0]}, "did you mean 'beta'"),
        ("defaults.bta", {"uniform": [1.0, 2.0]}, "did you mean 'beta'"),
        ("perod", {"values": [0.001]}, "did you mean 'period'"),
        ("arm.payload.com[0]", {"values": [0.1]}, "'arm.payload.com' is not in this file"),
        ("reference.targets[3]", {"values": [[0.1, 0.1]]}, "a list of 1, counted from [0]"),
        ("seed", {"values": [1]}, "does not vary"),
        ("arm.payload", 3.0, "must be a table such as"),
        ("arm.payload", {}, "it says nothing"),
        ("arm.payload", {"unifrm": [0.0, 1.0]}, "did you mean 'uniform'"),
        ("arm.payload", {"uniform": [0.0, 1.0], "values": [1.0]}, "got uniform and values"),
        ("arm.payload", {"uniform": [1.0, 0.0]}, "the lowest value first"),
        ("arm.payload", {"uniform": 1.0}, "two numbers"),
        ("arm.payload", {"normal": [1.0, -1.0]}, "cannot be negative"),
        ("arm.payload", {"normal": [0.0, "x"]}, "got [0.0, 'x']"),
        ("arm.payload", {"normal": [0.0, 1.0], "at_last": 0.0}, "did you mean 'at_least'"),
        ("arm.payload", {"normal": [-50.0, 1.0]}, "at_least and at_most bound what is drawn"),
        ("arm.payload", {"normal": [-50.0, 1.0], "at_least": 0.0}, "none lies within its bounds"),
        ("arm.payload", {"factor": {"scan": [0.0, 1.0]}, "each": True}, "factor is the only key"),
        ("arm.payload", {"values": []}, "at least one"),
        ("arm.payload", {"values": [1.0, -1.0]}, "at -1.0: arm.payload.mass"),
        ("arm.payload", {"values": [1.0], "with": "defaults.ks"}, "there is no grid 'defaults.ks'"),
        ("arm.payload", {"scan": [1.0, 1.0]}, "which differ"),
        ("arm.payload", {"scan": [0.0, 1.0], "until": {"max_eror": 1.0}}, "did you mean 'max_error'"),
        ("plant.friction.breakaway", {"factor": {"lognormal": 0.1}}, "has no value in this file"),
        ("defaults.ks", {"normal": 1.0, "each": True}, "give defaults.ks a list of numbers"),
    ],
)
def test_a_mistake_names_the_line_and_how_to_mend_it(path, given, told):
    with pytest.raises(ExperimentError) as error:
        tiny({path: given})
    assert f'sweep."{path}"' in str(error.value)
    assert told in str(error.value)


def test_one_key_within_another_cannot_vary_by_itself():
    with pytest.raises(ExperimentError, match="lies within 'arm'"):
        tiny({"arm": {"values": ["two_link"]}, "arm.payload": {"uniform": [0.0, 1.0]}})


def test_the_table_survives_being_written_and_fits_the_schema():
    experiment = tiny()
    assert parse_toml(experiment.to_toml(), "tiny")["sweep"] == DATA["sweep"]
    jsonschema.validate(DATA, experiment_schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**DATA, "sweep": {"arm.payload": {"unifrm": [0.0, 1.0]}}}, experiment_schema())


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("arm.payload", "kg"),
        ("period", "s"),
        ("plant.drive.delay", "periods"),
        ("plant.friction.coulomb", "N·m (N)"),
        ("defaults.mbar", "kg·m²"),
        ("controllers.B.S.beta", "1/s"),
        ("reference.offset", "rad"),
        ("plant.substeps", ""),
        ("controllers.own.gain", ""),
    ],
)
def test_the_unit_of_a_key_is_what_its_class_says_of_it(path, unit):
    laws = {"B.S": {"law": "bsmc"}, "own": {"law": "my_law:Mine"}}
    data = {"controllers": laws, "reference": {"kind": "multisine"}}
    assert unit_of_key(data, parts_of(path, data)) == unit
