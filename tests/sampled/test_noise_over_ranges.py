"""Noise over ranges of payload and armature: that of the worst arm of the range, in analysis, design and warnings."""

from __future__ import annotations

import json
from itertools import product
from typing import Any

import numpy as np
import pytest

from asmc_pin.arms import Arm, load_arm
from asmc_pin.cli import main
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.experiment import Experiment
from asmc_pin.plant import moving_arms
from asmc_pin.sampled import stability
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.noise.noise_response import noise_rms
from asmc_pin.sampled.noise.noise_warnings import noise_warnings
from asmc_pin.sampled.noise.sensor_model import loop_sensor
from asmc_pin.study.notes.comparison_notes import before_the_run

MBAR = [0.02, 0.006]
GAINS: dict[str, Any] = {"mbar": MBAR, "ks": 8.0, "beta": 15.0, "period": 0.001}
SENSOR = loop_sensor(2, encoder_bits=17)
PAYLOADS, ARMATURES = (0.0, 0.5), (0.0, 0.05)


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


def rms_of(arm: Arm, **ranges: Any) -> Any:
    return stability(arm, **GAINS, sensor=SENSOR, limits=False, samples=512, **ranges).noise


def test_noise_over_ranges_is_that_of_the_noisiest_arm_at_their_ends(two_link: Arm) -> None:
    ranged = rms_of(two_link, payload=PAYLOADS, armature=ARMATURES)
    corners = [rms_of(two_link, payload=kg, armature=own) for kg, own in product(PAYLOADS, ARMATURES)]
    each = np.array([noise.torque_rms for noise in corners])
    np.testing.assert_allclose(ranged.torque_rms, each.max(axis=0), rtol=1e-2)
    np.testing.assert_allclose(ranged.error_rms, np.max([noise.error_rms for noise in corners], axis=0), rtol=1e-2)
    # The range matters: the quietest corner makes less.
    assert each.min(axis=0)[1] < 0.98 * ranged.torque_rms[1]
    for noise in corners:
        assert (ranged.torque_bound >= 0.99 * np.asarray(noise.torque_bound)).all()


def test_no_arm_within_the_ranges_is_noisier_than_what_was_found(two_link: Arm) -> None:
    ranged = rms_of(two_link, payload=PAYLOADS, armature=ARMATURES)
    loop = stability(two_link, **GAINS, sensor=SENSOR, limits=False, samples=16).loop
    rng = np.random.default_rng(3)
    for _ in range(8):
        arm = two_link.replace(payload=float(rng.uniform(*PAYLOADS)), armature=rng.uniform(*ARMATURES, 2).tolist())
        torque, error = noise_rms(arm.mass_matrix(rng.uniform(*arm.box, (64, 2))), loop, SENSOR)
        # Without gravity, which is within a hundredth here.
        assert (torque.max(axis=0) <= 1.02 * ranged.torque_rms).all()
        assert (error.max(axis=0) <= 1.02 * ranged.error_rms).all()


def test_the_report_says_with_which_payload_and_armature_the_noise_is_worst(two_link: Arm) -> None:
    ranged = rms_of(two_link, payload=PAYLOADS, armature=ARMATURES)
    (line,) = [line for line in ranged.lines(stability(two_link, **GAINS, limits=False, samples=16).loop)
               if "torque RMS" in line]  # fmt: skip
    assert "over the ranges; the torques at payload 0 kg, armature (0, 0) kg·m²" in line
    places = ranged.to_json_dict()["torque_noise_worst"]
    assert [place["worst_payload"] for place in places] == [None, None] or all(
        place["worst_payload"]["mass"] == 0.0 for place in places
    )
    assert [place["worst_armature"] for place in places] == [[0.0, 0.0]] * 2
    plain = rms_of(two_link)
    assert plain.among == ()
    assert not any(
        "ranges" in line for line in plain.lines(stability(two_link, **GAINS, limits=False, samples=16).loop)
    )


def test_gains_keep_their_noise_budget_on_every_arm_of_the_ranges(two_link: Arm) -> None:
    found = suggest_gains(
        two_link,
        [0.02, 0.006],
        0.001,
        sensor=SENSOR,
        noise_budget=0.3,
        gain_margin=1.5,
        delay_margin=0.5,
        payload=PAYLOADS,
        armature=ARMATURES,
        samples=256,
    )
    assert found.report is not None
    assert found.quiet
    loop = found.loop
    rng = np.random.default_rng(4)
    largest = np.zeros(2)
    for kg, own in product(PAYLOADS, ARMATURES):
        arm = two_link.replace(payload=kg, armature=own)
        torque, _ = noise_rms(arm.mass_matrix(rng.uniform(*arm.box, (256, 2))), loop, SENSOR)
        largest = np.maximum(largest, torque.max(axis=0))
    assert (largest <= 0.3 * 1.01).all()
    assert found.report.noise is not None
    np.testing.assert_allclose(found.report.noise.torque_rms, largest, rtol=0.05)
    # The budget binds, or the light arm would not have mattered.
    heavy = two_link.replace(payload=PAYLOADS[1], armature=ARMATURES[1])
    assert noise_rms(heavy.mass_matrix(np.zeros((1, 2))), loop, SENSOR)[0].max() < largest.max()


def test_commands_take_ranges_and_noise_together(capsys: pytest.CaptureFixture[str]) -> None:
    base = ["stability", "two_link", "--mbar", "0.02,0.006", "--ks", "8", "--beta", "15", "--period", "0.001"]
    with pytest.raises(SystemExit) as end:
        main([*base, "--encoder-bits", "17", "--payload", "0:0.5", "--armature", "0:0.05", "--json"])
    assert end.value.code == 0
    told = json.loads(capsys.readouterr().out)
    ranged = rms_of(load_arm("two_link"), payload=PAYLOADS, armature=ARMATURES)
    np.testing.assert_allclose(told["torque_noise_rms"], ranged.torque_rms, rtol=1e-2)
    assert len(told["torque_noise_worst"]) == 2


def test_before_a_run_the_noise_told_is_that_of_the_noisiest_arm_of_the_run() -> None:
    experiment = Experiment.from_dict(
        {
            "name": "lighter",
            "period": 0.001,
            "duration": 1.0,
            "arm": {"source": "two_link", "payload": 0.5},
            "plant": {"payload_changes": [{"time": 0.5, "payload": 0.0}], "sensor": {"bits": 17}},
            "reference": {"kind": "quintic", "start": [0.0, 0.5], "move": 0.8, "targets": [0.2, 0.6]},
            "defaults": {"mbar": MBAR, "ks": 8.0, "beta": 15.0},
            "controllers": {"PPC": {"law": "ppc"}},
        }
    )
    plant = experiment.build_plant()
    moving = moving_arms(plant, experiment.period, experiment.duration)
    lines = before_the_run(experiment, plant, moving, experiment.build_controllers(), {})
    (told,) = [line for line in lines if "one count" in line]
    assert "the largest over the 2 arms of the run" in told
    law = CONTROLLERS["ppc"](mbar=MBAR, ks=8.0, beta=15.0, period=0.001)
    limit = plant.effort_limit

    def torque(arm: Any) -> str:
        (line,) = noise_warnings(arm, {"PPC": law}, SENSOR, effort_limit=limit)
        return line.split("makes a torque of ")[1].split(" N·m RMS")[0]

    light, heavy = (load_arm("two_link", payload=kg) for kg in (0.0, 0.5))
    assert torque(light) != torque(heavy)
    assert torque({"light": light, "heavy": heavy}) == torque(light) == torque({"heavy": heavy, "light": light})
