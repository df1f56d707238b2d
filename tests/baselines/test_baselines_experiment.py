"""Laws that know the model in an experiment: they get its arm, and are marked wherever their results appear."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asmc_pin.baselines import MARK, ComputedTorque
from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment, load_experiment
from asmc_pin.results.result_folder import load_result
from asmc_pin.study import Comparison, compare

EXPERIMENT: dict[str, Any] = {
    "name": "known",
    "arm": {"source": "two_link", "payload": 1.5},
    "period": 0.002,
    "duration": 0.1,
    "ensemble": {"trials": 1},
    "plant": {"friction": {"coulomb": 0.0}},
    "reference": {"kind": "multisine", "offset": [-1.2, 0.3], "amplitude": [0.4, 0.6], "frequency": [0.5, 0.7]},
    "defaults": {"mbar": [0.04, 0.03], "ks": 10.0, "beta": 10.0},
    "controllers": {
        "PPC": {"law": "ppc"},
        "CT": {"law": "computed_torque"},
        "CT 20 % light": {"law": "computed_torque", "mass_scale": 0.8, "payload": "unknown"},
        "PD": {"law": "pd_gravity", "kp": 500.0, "kd": [50.0, 20.0]},
    },
}


def with_controller(**table: Any) -> dict[str, Any]:
    return {**EXPERIMENT, "controllers": {"X": table}}


@pytest.fixture(scope="module")
def comparison(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    return compare(Experiment.from_dict(EXPERIMENT), out=tmp_path_factory.mktemp("known") / "out")


def test_they_are_given_the_arm_of_the_experiment_with_its_payload() -> None:
    experiment = Experiment.from_dict(EXPERIMENT)
    laws = experiment.build_controllers()
    law = laws["CT"]
    assert isinstance(law, ComputedTorque)
    assert law.model is experiment.build_arm()
    light = laws["CT 20 % light"]
    assert isinstance(light, ComputedTorque)
    assert light.model.payload is None


def test_an_exact_model_follows_best_of_all(comparison: Comparison) -> None:
    error = comparison.rows.groupby("controller", sort=False).rms_error.max()
    assert error.idxmin() == f"CT ({MARK})"


def test_the_mark_stands_in_every_table_figure_and_page(comparison: Comparison) -> None:
    marked = [f"{label} ({MARK})" for label in ("CT", "CT 20 % light", "PD")]
    expected = ["PPC", *marked]
    assert list(comparison.rows.controller.unique()) == expected
    assert [row[0] for row in comparison.overview().rows] == expected
    result = load_result(comparison.out)
    assert list(result.dataset.controller.to_numpy()) == expected  # figures and the replay take their labels from here
    for name in ("summary.md", "summary.tex", "report.html"):
        text = (comparison.out / name).read_text(encoding="utf-8")
        for label in marked:
            assert label.replace("%", r"\%") in text if name.endswith("tex") else label in text
        assert f"PPC ({MARK})" not in text


def test_json_keeps_the_labels_of_the_file_and_says_which_know_the_model(comparison: Comparison) -> None:
    controllers = json.loads(json.dumps(comparison.to_json_dict(), allow_nan=False))["controllers"]
    assert {label: item["knows_model"] for label, item in controllers.items()} == {
        "PPC": False,
        "CT": True,
        "CT 20 % light": True,
        "PD": True,
    }
    assert controllers["PD"]["law"] == "pd_gravity"


def test_a_law_of_ones_own_may_ask_for_the_model_and_is_marked(tmp_path: Path) -> None:
    (tmp_path / "own_gravity.py").write_text(
        "from dataclasses import dataclass, replace\n"
        "@dataclass(frozen=True)\n"
        "class Hold:\n"
        "    period: float\n"
        "    arm: object = None\n"
        "    knows_model = True\n"
        "    def with_arm(self, arm): return replace(self, arm=arm)\n"
        "    def init(self, sample): return None\n"
        "    def step(self, state, sample, setpoint): return self.arm.gravity(sample.q), None\n"
    )
    data = {**with_controller(law="own_gravity:Hold"), "defaults": {}}
    result = compare(Experiment.from_dict(data, folder=tmp_path), out=tmp_path / "out")
    assert list(result.dataset.controller.to_numpy()) == [f"X ({MARK})"]
    q, torque = (result.dataset[name].to_numpy()[0, 0] for name in ("q", "torque"))
    assert torque == pytest.approx(result.arm.gravity(q), rel=1e-12)


def test_the_shipped_experiment_shows_what_a_model_is_worth() -> None:
    experiment = load_experiment("ur5_with_a_model").replace(duration=2.0)
    plant, motion = experiment.build_plant(), experiment.build_reference()
    rms = {}
    for label, law in experiment.build_controllers().items():
        run = rollout(plant, law, motion, experiment.duration)
        rms[label] = np.sqrt(np.mean((run.q_ref - run.q[0]) ** 2))
    exact = rms.pop("CT, friction too")
    assert exact < min(rms.values())
    # Without knowing the model the TDE laws do far better than a model without friction, or 20 % off.
    assert max(rms["PPC"], rms["Proposed"]) < 0.1 * min(rms["CT"], rms["CT, 20 % light"])


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ({"law": "computed_torque", "arm": "ur5"}, "controllers.X.arm: stands once, at the top"),
        ({"law": "computed_torqe"}, "did you mean 'computed_torque'"),
        ({"law": "pd_gravity", "kp": 1.0}, "controllers.X.kd: is missing"),
        (
            {"law": "pd_gravity", "kp": [1.0, 2.0, 3.0], "kd": 1.0},
            "controllers.X.kp: 3 values given, but two_link has 2",
        ),
        ({"law": "computed_torque", "mass_scale": -1.0}, "controllers.X.mass_scale: got -1.0; it must be above 0"),
        ({"law": "computed_torque", "mass_skale": 1.0}, "did you mean 'mass_scale'"),
    ],
)
def test_a_mistake_is_named_with_its_key(table: dict[str, Any], text: str) -> None:
    with pytest.raises(ExperimentError, match=text):
        Experiment.from_dict(with_controller(**table)).build_controllers()
