"""docs/controllers.md and docs/references.md: what they show is run as it stands there."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import numpy as np
import pytest
from paths import DOCS

import asmc_pin
from asmc_pin.controllers import CONTROLLERS, parameters_of
from asmc_pin.references import REFERENCES


def blocks(language: str) -> list[str]:
    text = (DOCS / "controllers.md").read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_your_own_law_in_30_lines_runs_from_an_experiment_and_follows_better_than_ppc(tmp_path: Path) -> None:
    (law,), (toml,) = blocks("python"), blocks("toml")
    assert len(law.splitlines()) <= 30
    (tmp_path / "my_law.py").write_text(law, encoding="utf-8")
    path = tmp_path / "own_law.toml"
    path.write_text(toml, encoding="utf-8")

    experiment = asmc_pin.load_experiment(path)
    arm, reference, controllers = experiment.build_arm(), experiment.build_reference(), experiment.build_controllers()
    assert (
        asmc_pin.lemma1_norm(arm.mass_matrix(reference.evaluate(experiment.time).q), controllers["PPC"].mbar).max() < 1
    )
    error = {}
    for label, controller in controllers.items():
        run = asmc_pin.rollout(experiment.build_plant(), controller, reference, experiment.duration)
        assert run.status == ("ok",)
        error[label] = np.sqrt(np.mean((run.q_ref - run.q[0]) ** 2, axis=0))
    # It takes the error that a drifting load leaves to PPC down by far more than a matter of taste.
    assert (error["SuperTwisting"] < 0.25 * error["PPC"]).all()


def test_a_wrong_parameter_of_your_own_law_is_named(tmp_path: Path) -> None:
    (tmp_path / "my_law.py").write_text(blocks("python")[0], encoding="utf-8")
    path = tmp_path / "own_law.toml"
    path.write_text(blocks("toml")[0].replace("k1 = 4.0", "k1 = -4.0"), encoding="utf-8")
    with pytest.raises(asmc_pin.AsmcPinError, match=r"controllers.SuperTwisting.k1: got -4.0; it must be at least 0"):
        asmc_pin.load_experiment(path)


def test_every_law_and_every_parameter_is_documented() -> None:
    text = (DOCS / "controllers.md").read_text(encoding="utf-8")
    for name, law in CONTROLLERS.items():
        for word in (name, *parameters_of(law)):
            assert re.search(rf"`{word}`|\*\*{word}\*\*", text), f"{word} is not explained"


def test_every_kind_of_reference_and_every_parameter_is_documented() -> None:
    text = (DOCS / "references.md").read_text(encoding="utf-8")
    for kind, cls in REFERENCES.items():
        for name in inspect.signature(cls).parameters:
            (meaning,) = re.findall(rf"^\| `{kind}` \| `{name}` \| (.*?) \|", text, re.MULTILINE)
            assert meaning, f"{kind}: {name} is not explained"
