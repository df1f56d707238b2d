"""Logs of the simulated plant, whose parameters are known: they are found again, and what is wrong is named."""

from __future__ import annotations

import dataclasses
import json
from functools import cache
from pathlib import Path

import needs
import numpy as np
import pandas as pd
import pytest
from simulated_logs import SO101, UR5, Truth, simulated_logs, true_parameters

import asmc_pin
from asmc_pin import JointLog, LogOptions, identify
from asmc_pin.cli import main
from asmc_pin.errors import ParameterError
from asmc_pin.identification.filtered_motion import filter_log
from asmc_pin.identification.plant_file import plant_tables, plant_text
from asmc_pin.identification.suspects import suspect
from asmc_pin.identification.torque_model import point_mass, torque_model

pytestmark = pytest.mark.xdist_group("test_identify")  # they share what `cache` keeps

ARMS = {"ur5": UR5, "so101": SO101}


def run(capsys, *words: str) -> tuple[int, str]:
    """Exit status and standard output of the command line."""
    with pytest.raises(SystemExit) as ended:
        main(words)
    return int(ended.value.code or 0), capsys.readouterr().out


@cache
def log_of(name: str) -> JointLog:
    return simulated_logs(ARMS[name], range(1))[0]


@cache
def found_of(name: str) -> asmc_pin.Identification:
    return identify(ARMS[name].nominal, log_of(name))


@cache
def filtered(name: str):
    return filter_log(log_of(name))


@pytest.mark.parametrize("name", ARMS)
def test_what_the_plant_has_is_found_again_within_a_few_deviations(name: str) -> None:
    found, truth = found_of(name), true_parameters(ARMS[name])
    assert not found.suspicions
    missing = set(truth) - set(found.parameters)
    given_up = {each.name.replace(":", ".") for each in found.confusions}
    assert {kind.split(".")[0] for kind in missing - given_up} <= {"breakaway", "stribeck_velocity"}
    assert len(missing) <= 0.2 * len(truth)
    far = {
        key: (each.value - truth[key]) / max(each.high - each.value, 1e-12)
        for key, each in found.parameters.items()
        if abs(each.value - truth[key]) > 2.5 * (each.high - each.value)
    }
    assert not far
    inside = [each.low <= truth[key] <= each.high for key, each in found.parameters.items()]
    assert np.mean(inside) > 0.75


@pytest.mark.parametrize("name", ARMS)
def test_what_is_left_is_the_noise_and_no_more_on_rows_that_were_held_out(name: str) -> None:
    found = found_of(name)
    assert found.fit is not None
    assert found.residual_held_out is not None
    np.testing.assert_allclose(found.residual_held_out, found.fit.sigma, rtol=0.35)
    assert found.explained.min() > 0.8
    assert found.whiteness is not None
    assert found.whiteness.max() < 3.0


def test_of_a_joint_about_a_vertical_axis_constant_and_rotor_cannot_be_told_apart_or_are_both_told() -> None:
    found = found_of("ur5")
    constant = found.parameters.get("torque_constant.shoulder_pan_joint")
    assert constant is None or constant.high - constant.low < 0.3


def altered(log: JointLog, **arrays: np.ndarray) -> JointLog:
    return dataclasses.replace(log, **arrays)


@pytest.mark.parametrize(
    ("change", "named", "mended"),
    [
        (
            lambda log: altered(log, torque=log.torque * [1, 1, -1, 1, 1, 1]),
            "torque of joint elbow_joint has the opp",
            "--motor-constant 1,1,-1,1,1,1",
        ),
        (
            lambda log: altered(log, q=log.q * [1, -1, 1, 1, 1, 1], v=log.v * [1, -1, 1, 1, 1, 1]),
            "angle of joint shoulder_lift_joint has the opposite sign",
            "",
        ),
        (
            lambda log: altered(log, torque=log.torque[:, [0, 2, 1, 3, 4, 5]]),
            "torques of joints elbow_joint and shoulder_",
            "",
        ),
        (lambda log: altered(log, torque=log.torque[:, ::-1]), "reverse order", ""),
        (lambda log: altered(log, torque=1e3 * log.torque), "N·mm", "--motor-constant 0.001"),
        (lambda log: altered(log, torque=-log.torque), "all torques have the opposite sign", "--motor-constant -1"),
        (lambda log: altered(log, q=np.rad2deg(log.q), v=None), "angles are in degrees", "--degrees"),
        (
            lambda log: altered(log, v=-log.v),
            "velocity of joint shoulder_pan_joint has the opposite sign",
            "--columns v=-",
        ),
        (lambda log: altered(log, v=np.rad2deg(log.v)), "degrees/s", "--columns v=-"),
        (lambda log: altered(log, v=log.v[:, [1, 0, 2, 3, 4, 5]]), "that of shoulder_lift_joint", "--columns v=-"),
    ],
)
def test_a_wrong_sign_order_or_unit_is_named_with_the_option_that_mends_it(change, named: str, mended: str) -> None:
    log = change(log_of("ur5"))
    found = suspect(UR5.nominal, filter_log(log), log)
    assert found
    assert named in "; ".join(each.text for each in found)
    assert " ".join(found[0].options) == mended


def test_a_base_that_hangs_or_leans_is_named_with_the_direction_of_gravity() -> None:
    turned = UR5.nominal.replace(gravity=(0.0, 6.94, 6.94))
    found = suspect(turned, filtered("ur5"), log_of("ur5"))
    assert len(found) == 1
    assert "gravity points along" in found[0].text
    numbers = [float(x) for x in found[0].text.split("(")[1].split(")")[0].split(",")]
    np.testing.assert_allclose(numbers, [0.0, 0.0, -9.81], atol=0.6)
    option, given = found[0].options
    assert option == "--gravity"
    assert [float(x) for x in given.split(",")] == numbers


@pytest.mark.parametrize("name", ARMS)
def test_a_right_log_raises_no_suspicion(name: str) -> None:
    assert not suspect(ARMS[name].nominal, filtered(name), log_of(name))


def test_a_log_that_contradicts_its_urdf_is_told_and_nothing_is_estimated() -> None:
    log = log_of("so101")
    found = identify(SO101.nominal, altered(log, torque=-log.torque))
    assert "contradicts" in found.headline()
    assert not found.parameters
    assert found.to_json_dict()["residual_train"] is None


def test_a_sensor_on_the_links_side_hides_the_rotor() -> None:
    found = identify(SO101.nominal, altered(log_of("so101"), torque_side="link"))
    assert not any(name.startswith("armature") for name in found.parameters)


def test_what_is_fixed_is_not_estimated_and_unknown_groups_are_refused() -> None:
    found = identify(SO101.nominal, log_of("so101"), fix=("payload", "stribeck"))
    assert not any(name.startswith(("payload", "breakaway", "stribeck")) for name in found.parameters)
    with pytest.raises(ParameterError, match="coulomb"):
        identify(SO101.nominal, log_of("so101"), fix=("friction",))


def test_a_joint_that_stands_still_is_told() -> None:
    log = log_of("so101")
    q, v = log.q.copy(), log.v.copy()
    q[:, 3], v[:, 3] = 0.1, 0.0
    with pytest.raises(ParameterError, match="'wrist_flex' hardly moves"):
        identify(SO101.nominal, altered(log, q=q, v=v))


def test_the_derivatives_of_the_residual_are_its_difference_quotients() -> None:
    model = torque_model(SO101.nominal, filtered("so101"), np.full(5, 0.02))
    rng = np.random.default_rng(3)
    at = model.start() + rng.uniform(0.02, 0.1, len(model.names))
    _, jacobian = model.residual(at)
    for i in range(len(model.names)):
        step = np.zeros(len(at))
        step[i] = 1e-6
        slope = (model.residual(at + step)[0] - model.residual(at - step)[0]) / 2e-6
        inner = slice(10, -10)  # the log ends where a delay would look further
        scale = max(1.0, np.abs(slope[inner]).max())
        np.testing.assert_allclose(jacobian[inner, :, i], slope[inner], atol=1e-5 * scale)


def test_a_point_mass_weighs_as_a_payload_does() -> None:
    arm = asmc_pin.load_arm("ur5")
    com = np.array([0.03, -0.02, 0.1])
    laden = arm.replace(payload={"mass": 1.3, "com": tuple(com)})
    q, v, a = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 6))
    links = arm.regressor(q, v, v, a)[:, 50:60]
    added = links @ point_mass(1.3, 1.3 * com)[0]
    wanted = (laden.mass_matrix(q) - arm.mass_matrix(q)) @ a + laden.bias(q, v) - arm.bias(q, v)
    np.testing.assert_allclose(added, wanted, atol=1e-10)


# What comes out ------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_the_measured_plant_is_read_by_comparisons_sweeps_and_the_condition(tmp_path: Path, capsys) -> None:
    found = found_of("ur5")
    path = tmp_path / "measured.toml"
    path.write_text(plant_text(found), encoding="utf-8")
    tables = plant_tables(found)
    measured = asmc_pin.load_experiment("demo", plant=path)
    arm = measured.build_arm()
    assert arm.payload is not None
    assert arm.payload.mass == pytest.approx(tables["arm"]["payload"]["mass"]["value"], rel=1e-5)
    np.testing.assert_allclose(arm.armature, [each["value"] for each in tables["arm"]["armature"]], rtol=1e-5)
    plant = measured.build_plant()
    assert plant.friction.coulomb[0] == pytest.approx(found.parameters["coulomb.shoulder_pan_joint"].value, rel=1e-5)
    assert "arm.armature[0]" in measured.sweep
    said = json.loads(run(capsys, "verify", "ur5", "--mbar", "0.3", "--plant", str(path), "--json")[1])
    low, high = said["armature"][0]
    assert low == pytest.approx(tables["arm"]["armature"][0]["low"], rel=1e-5)
    assert high == pytest.approx(tables["arm"]["armature"][0]["high"], rel=1e-5)


def test_the_command_says_it_as_json_with_the_contracts_keys(tmp_path: Path, capsys) -> None:
    log = log_of("so101")
    assert log.v is not None
    assert log.torque is not None
    table = pd.DataFrame({"t": log.time})
    for i in range(5):
        table[f"q{i + 1}"], table[f"tau{i + 1}"] = log.q[:, i], log.torque[:, i]
    path, out, page = tmp_path / "log.csv.gz", tmp_path / "plant.toml", tmp_path / "page.html"
    table.to_csv(path, index=False)
    status, told = run(capsys, "identify", "so101", str(path), "--json", "--out", str(out), "--report", str(page))
    assert status == 0
    said = json.loads(told)
    assert {"arm", "rows", "parameters", "residual_train", "residual_held_out"} <= set(said)
    assert set(said["parameters"]["coulomb.elbow_flex"]) == {"low", "value", "high"}
    assert out.read_text().startswith("# What the log 'log.csv.gz' says of so101")
    assert "Is the URDF of so101 right?" in page.read_text()


# A real arm ----------------------------------------------------------------------------------------------------------


def test_of_a_real_arm_it_is_told_how_right_the_urdf_is_and_that_the_hand_was_not_mounted() -> None:
    found = identify(
        asmc_pin.load_arm("panda"), needs.real_log("panda_exciting.csv.gz"), options=LogOptions(torque_side="link")
    )
    assert not found.suspicions
    left = found.stages["URDF"] / found.stages["logged"]
    assert left[1:3].max() < 0.25
    assert left[6] > 0.9
    assert found.explained.min() > 0.8
    mass = found.parameters["payload.mass"]
    assert -0.75 < mass.value < -0.4
    assert mass.high < 0.0
    told = next(line for line in found.lines() if "less than the URDF says" in line)
    assert "panda_hand 0.73 kg" in told
    # It is no white noise, and that is said.
    assert found.whiteness is not None
    assert found.whiteness.max() > 3.0
    assert any("something is left" in line for line in found.remarks())


# Statistics ----------------------------------------------------------------------------------------------------------


def coverage(truth: Truth, seeds: int) -> dict[str, tuple[float, int]]:
    """How often the interval of each parameter holds the truth, and of how many."""
    wanted = true_parameters(truth)
    inside: dict[str, list[bool]] = {}
    for first in range(0, seeds, 20):
        for log in simulated_logs(truth, range(first, min(first + 20, seeds))):
            found = identify(truth.nominal, log)
            assert not found.suspicions
            for key, each in found.parameters.items():
                inside.setdefault(key, []).append(each.low <= wanted[key] <= each.high)
    return {key: (float(np.mean(held)), len(held)) for key, held in inside.items()}


@pytest.mark.long
@pytest.mark.parametrize("name", ARMS)
def test_intervals_of_95_percent_hold_the_truth_in_90_to_99_of_100_seeds_and_none_in_fewer_than_80(name: str) -> None:
    found = coverage(ARMS[name], 100)
    shares = {key: share for key, (share, count) in found.items() if count >= 50}
    assert len(shares) > 0.8 * len(true_parameters(ARMS[name]))
    assert 0.90 <= np.mean(list(shares.values())) <= 0.99, shares
    assert not {key: share for key, share in shares.items() if share < 0.80}
