"""A plant that was measured is read by every command that is about an arm or a loop: ranges there, draws in a sweep."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import asmc_pin
from asmc_pin.cli import main

PLANT = """
[arm]
source = "two_link"
payload = { mass = { low = 0.4, value = 0.5, high = 0.6 }, com = [0.0, 0.0, 0.1], link = "link_2" }
armature = [{ low = 0.1, value = 0.12, high = 0.15 }, 0.05]
[plant.friction]
coulomb = [{ low = 0.2, value = 0.3, high = 0.4 }, 0.1]
"""


@pytest.fixture
def measured(tmp_path: Path) -> str:
    path = tmp_path / "measured.toml"
    path.write_text(PLANT)
    return str(path)


@pytest.mark.parametrize(
    "words",
    [
        ("verify", "two_link", "--mbar", "0.1,0.05", "--samples", "64"),
        ("bounds", "two_link", "--gap", "0.5"),
        ("design", "two_link", "--budget", "2"),
        ("stability", "two_link", "--mbar", "0.1,0.05", "--ks", "8", "--beta", "8", "--period", "0.001"),
    ],
    ids=lambda words: words[0],
)
def test_payload_and_armature_of_a_measured_plant_are_ranges(words: tuple[str, ...], measured: str, capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*words, "--plant", measured, "--json"])
    assert ended.value.code in (0, 1)
    said = json.loads(capsys.readouterr().out)
    about = said.get("domain", said)
    assert about["armature"] == [[0.1, 0.15], 0.05]
    assert about["payload"]["mass"] == [0.4, 0.6]


def test_an_experiment_takes_the_values_and_draws_within_the_intervals(measured: str, tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(
        'name = "two"\nperiod = 0.002\nduration = 0.1\narm = "two_link"\n'
        '[reference]\nkind = "multisine"\noffset = [0.1, 0.1]\namplitude = [[0.2], [0.2]]\nfrequency = [[0.5], [0.5]]\n'
        'phase = [[0.0], [0.0]]\n[controllers.TDC]\nlaw = "ppc"\nmbar = [0.1, 0.05]\nks = 8.0\nbeta = 8.0\n'
    )
    taken = asmc_pin.load_experiment(path, plant=measured)
    arm = taken.build_arm()
    assert arm.payload is not None
    assert arm.payload.mass == 0.5
    np.testing.assert_allclose(arm.armature, [0.12, 0.05])
    np.testing.assert_allclose(taken.build_plant().friction.coulomb, [0.3, 0.1])
    assert set(taken.sweep) == {"arm.payload.mass", "arm.armature[0]", "plant.friction.coulomb[0]"}
    drawn = [taken.variation.quantities(trial) for trial in range(20)]
    for key, low, high in (("arm.payload.mass", 0.4, 0.6), ("arm.armature[0]", 0.1, 0.15)):
        values = np.array([each[key] for each in drawn])
        assert len(np.unique(values)) == 20
        assert low <= values.min() < values.max() <= high
