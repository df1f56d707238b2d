"""Claims about the plant's keys in an experiment file."""

from __future__ import annotations

import inspect
import re
import tomllib

import numpy as np
import pytest
from paths import DOCS

from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment, experiment_schema, load_experiment
from asmc_pin.experiment.toml_keys import PlantTable
from asmc_pin.plant import (
    INTEGRATORS,
    Disturbance,
    Drive,
    EndStops,
    Friction,
    PayloadChange,
    Plant,
    Sensor,
    Spread,
)
from asmc_pin.tool_error import tool_error

PLANT = {
    "substeps": 4,
    "integrator": "midpoint",
    "friction": {"coulomb": 2.0, "breakaway": [3.0, 4.0], "coulomb_backward": 2.5},
    "drive": {"delay": 1.5, "current_hz": 200.0, "gear": [80.0, 50.0], "rotor_inertia": 1e-6},
    "sensor": {"bits": 17, "side": "motor", "position_noise": 1e-6},
    "end_stops": {},
    "spread": {"mass": 0.1, "friction": 0.2},
    "disturbances": [
        {"profile": "pulse", "torque": [1.0, 0.0], "start": 0.1, "duration": 0.05},
        {"profile": "noise", "link": "tool", "force": [0.0, 0.0, 2.0], "frequency": 5.0},
    ],
    "payload_changes": [{"time": 0.2, "payload": 1.0}],
}


def experiment(plant, seed=3):
    return Experiment.from_dict(
        {
            "name": "x",
            "arm": "two_link",
            "period": 0.001,
            "duration": 0.3,
            "seed": seed,
            "plant": plant,
            "reference": {"kind": "multisine", "offset": [0.0, 0.0], "amplitude": [0.1, 0.1], "frequency": [1.0, 1.0]},
            "controllers": {"PPC": {"law": "ppc", "mbar": 0.05, "ks": 5.0, "beta": 5.0}},
        }
    )


def with_link(plant, arm):
    name = arm.link_names[-1]
    return {
        **plant,
        "disturbances": [{**item, "link": name} if "link" in item else item for item in plant["disturbances"]],
    }


def test_every_part_of_the_plant_is_built_from_the_file():
    plant = experiment(with_link(PLANT, experiment({}).build_arm())).build_plant()
    assert (plant.substeps, plant.integrator, plant.seed) == (4, "midpoint", 3)
    assert plant.friction.breakaway.tolist() == [3.0, 4.0]
    assert plant.friction.breakaway_backward.tolist() == [3.0, 4.0]
    assert plant.friction.coulomb_backward == 2.5
    assert plant.drive.delay == 1.5
    assert plant.sensor.side == "motor"
    assert plant.end_stops.stiffness == 1e4
    assert plant.spread.mass == 0.1
    assert [item.profile for item in plant.disturbances] == ["pulse", "noise"]
    assert plant.payload_changes[0].payload.mass == 1.0
    bare = experiment({}).build_arm()
    np.testing.assert_allclose(plant.arm.armature, bare.armature + np.array([6400.0, 2500.0]) * 1e-6)


def test_without_these_keys_the_plant_is_the_ideal_one():
    plant = experiment({}).build_plant()
    assert plant.drive is plant.sensor is plant.end_stops is plant.spread is None
    assert plant.disturbances == plant.payload_changes == ()


@pytest.mark.parametrize(
    ("plant", "said"),
    [
        ({"drive": {"dealy": 1.0}}, r"plant.drive.dealy: unknown key: did you mean 'delay'\?"),
        ({"drive": {"delay": -1.0}}, r"plant.drive.delay: got -1.0"),
        ({"drive": 3}, r"plant.drive: .*got 3"),
        ({"sensor": {"velocity": "filtr"}}, r"plant.sensor.velocity: .*did you mean 'filter'"),
        ({"disturbances": [{"profile": "sine", "torque": 1.0}]}, r"plant.disturbances\[0\].frequency: is missing"),
        ({"disturbances": [7]}, r"plant.disturbances\[0\]: must be a table"),
        ({"payload_changes": [{"payload": 1.0}]}, r"plant.payload_changes\[0\].time: is missing"),
        ({"integrator": "euler"}, r"plant.integrator"),
        ({"friction": {"coulomb": 2.0, "breakaway": 1.0}}, r"friction.breakaway: .*must not be below coulomb"),
        ({"drive": {"current_hz": [1.0, 2.0, 3.0]}}, r"plant.drive.current_hz: 3 values"),
    ],
)
def test_a_mistake_is_named_by_its_key(plant, said):
    with pytest.raises(ExperimentError, match=said):
        experiment(plant).build_plant()


def test_the_schemes_of_the_file_are_those_that_are_registered():
    schema = experiment_schema()["$defs"]["PlantTable"]["properties"]
    assert schema["integrator"]["enum"] == list(INTEGRATORS)
    parts = {"drive", "sensor", "end_stops", "spread", "disturbances", "payload_changes"}
    assert parts <= set(PlantTable.model_fields)
    assert parts <= set(Plant.__dataclass_fields__)


PAGE = (DOCS / "plant.md").read_text(encoding="utf-8")


def test_the_example_of_the_docs_builds_and_runs():
    (example,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    start = [0.0, -1.3, 1.6, -1.2, -1.4, 0.0]
    data = {
        "name": "docs",
        "arm": "ur5",
        "period": 0.002,
        "duration": 0.02,
        "reference": {"kind": "quintic", "start": start, "targets": [start], "move": 1.0},
        "controllers": {"PPC": {"law": "ppc", "mbar": 0.1, "ks": 5.0, "beta": 5.0}},
        **tomllib.loads(example),
    }
    experiment = Experiment.from_dict(data)
    plant = experiment.build_plant()
    assert plant.payload_changes
    assert plant.disturbances
    run = rollout(plant, experiment.build_controllers()["PPC"], experiment.build_reference(), experiment.duration)
    assert run.status == ("ok",)


@pytest.mark.parametrize("cls", [Drive, Sensor, EndStops, Spread, Disturbance, PayloadChange, Friction])
def test_every_parameter_of_the_plants_parts_is_documented(cls):
    for name in inspect.signature(cls).parameters:
        assert re.search(rf"[`\"]{name}[`\"]", PAGE), f"{cls.__name__}.{name} is not explained in docs/plant.md"


@pytest.mark.parametrize(
    ("sensor", "law", "mean"),
    [
        (None, {}, False),
        ({"velocity": "exact", "bits": 17}, {}, False),
        ({"bits": 17}, {}, True),
        ({"velocity": "filter"}, {}, True),
        ({"bits": 17}, {"pairing": "last"}, False),
        (None, {"pairing": "mean"}, True),
        ({"velocity": "exact"}, {"acceleration": "position"}, True),
        ({"bits": 17}, {"pairing": "last", "acceleration": "position"}, False),
    ],
    ids=str,
)
def test_the_torque_that_goes_with_an_estimate_follows_from_how_the_plant_makes_its_velocities(sensor, law, mean):
    experiment = load_experiment("demo")
    chosen = experiment.replace(controllers={"PPC": {"law": "ppc", **law}})
    if sensor is not None:
        chosen = chosen.with_plant(sensor=sensor)
    assert chosen.build_controllers()["PPC"].averages_torque == mean


def test_the_shipped_experiment_of_the_whole_plant_has_every_part_and_the_proposed_law_carries_it_through():
    experiment = load_experiment("ur5_full_plant")
    plant = experiment.build_plant()
    for part in ("drive", "sensor", "end_stops", "spread", "disturbances", "payload_changes"):
        assert getattr(plant, part), part
    assert experiment.metrics.tool == "tool0"
    run = rollout(plant, experiment.build_controllers()["Proposed"], experiment.build_reference(), experiment.duration)
    assert run.status == ("ok",)
    error = tool_error(plant.arm, run, "tool0").position[0]
    alone = experiment.with_plant(disturbances=[]).build_plant()
    calm = rollout(alone, experiment.build_controllers()["Proposed"], experiment.build_reference(), experiment.duration)
    untouched = tool_error(plant.arm, calm, "tool0").position[0]
    push = (run.time > 5.2) & (run.time < 5.5)
    assert error.max() < 4e-3
    assert error[push].max() > 1.5 * untouched[push].max(), "the push is felt"
    assert (run.v[0] == 0.0).mean(axis=0).min() > 0.02, "every joint sticks at times"
    assert not np.array_equal(run.q_measured, run.q)
