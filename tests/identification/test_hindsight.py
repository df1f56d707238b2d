"""What an M̄ and a law would have done along a log: against the log's own accelerations, and against its own law."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from next_command import next_words
from two_link_log import EXPERIMENT, PERIOD, found, logged

import asmc_pin
from asmc_pin import JointLog, identify, law_on_log, mbar_on_log
from asmc_pin.cli import main
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.identification.measured_load import measured_arm, measured_load
from asmc_pin.identification.plant_file import plant_tables
from asmc_pin.identification.torque_model import point_mass
from asmc_pin.pages.identified.identification_page import write_identification_page


@pytest.fixture
def experiment(tmp_path: Path) -> str:
    path = tmp_path / "two.toml"
    path.write_text(EXPERIMENT)
    return str(path)


def test_the_error_of_an_mbar_along_a_log_is_the_change_of_acceleration_less_that_of_torque_over_mbar() -> None:
    along = mbar_on_log(found(), [0.06, 0.025], period=PERIOD)
    log = logged()
    assert log.torque is not None
    wanted = np.gradient(log.v, PERIOD, axis=0)
    assert along.recording.acceleration is not None
    inside = slice(400, -400)
    error = along.recording.acceleration[inside] - wanted[inside]
    assert np.sqrt(np.mean(error**2)) < 0.1 * np.std(wanted)
    np.testing.assert_allclose(
        along.error,
        np.diff(along.recording.acceleration, axis=0) - np.diff(along.recording.torque, axis=0) / [0.06, 0.025],
        atol=1e-9,
    )


def test_the_norm_along_a_log_is_that_of_the_arm_as_measured_and_its_worst_is_where_it_is_said() -> None:
    along = mbar_on_log(found(), [0.06, 0.025], period=PERIOD)
    arm, left_out = measured_arm(found())
    assert not left_out
    assert arm.payload is not None
    assert arm.payload.mass == pytest.approx(0.5, rel=0.1)
    report = along.report
    assert report.norms is not None
    assert report.times is not None
    at = int(np.searchsorted(report.times, report.worst_time))
    mass = arm.mass_matrix(along.recording.q[at])
    assert report.lower == pytest.approx(np.linalg.norm(np.eye(2) - np.linalg.solve(mass, np.diag([0.06, 0.025])), 2))
    assert report.lower == report.norms.max()
    assert "largest value" in along.headline()


def test_an_mbar_ten_times_too_large_is_seen_to_fail_along_the_log() -> None:
    along = mbar_on_log(found(), [9.0, 2.0], period=PERIOD)
    assert along.report.verdict == "violated"
    norms = along.report.norms
    assert norms is not None
    assert f"held at {np.sum(norms < 1.0)} of its {len(norms)} ticks" in along.headline()


def test_a_law_that_knows_the_measured_plant_needs_the_torque_of_the_log_and_one_that_fails_is_told(
    experiment: str,
) -> None:
    exact = law_on_log(found(), experiment, "Model")
    assert exact.run.status == ("ok",)
    assert exact.measured.torque is not None
    inside = slice(500, -500)
    gap = np.sqrt(np.mean((exact.torque - exact.measured.torque)[inside] ** 2, axis=0))
    assert np.all(gap < 0.03 * np.std(exact.measured.torque[inside], axis=0))
    lost = law_on_log(found(), experiment, "Soft")
    assert lost.run.status == ("diverged",)
    assert "diverged at t =" in lost.headline()
    assert lost.to_json_dict()["torque_rms_simulated"] is None
    with pytest.raises(ExperimentError, match=r"no controller PID; it has TDC, Soft, Model"):
        law_on_log(found(), experiment, "PID")


def test_what_the_logs_motion_asks_beyond_a_torque_limit_is_said(experiment: str) -> None:
    path = Path(experiment)
    path.write_text(path.read_text().replace('arm = "two_link"', 'arm = "two_link"\nplant = { effort_limit = 0.5 }'))
    ran = law_on_log(found(), experiment, "TDC")
    assert any("asks for more than there is" in line and "torque" in line for line in ran.lines())


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "N·mm"), (1e2, "N·cm"), (1e-3, "kN·m")])
def test_torques_in_another_unit_are_no_payload_of_tonnes(factor: float, unit: str) -> None:
    """On few joints a payload beyond measure would explain them as well as their unit."""
    wrong = identify(asmc_pin.load_arm("two_link"), replace(logged(), torque=factor * logged().torque))
    assert f"the torques are in {unit}, not N·m" in wrong.headline()


def test_what_makes_no_torque_in_the_log_is_named_as_not_estimated() -> None:
    """Both axes are along y: no log of this arm tells where along them the payload is."""
    assert found().to_json_dict()["given_up"] == [{"name": "payload.moment.y", "for": []}]
    assert "payload.com.y" not in found().parameters
    assert sum("payload.moment.y was not estimated: it makes no torque" in line for line in found().remarks()) == 1


def test_a_payload_that_was_known_and_the_one_that_the_log_adds_are_one_in_the_measured_plant() -> None:
    arm = asmc_pin.load_arm(
        "two_link", payload={"mass": 0.3, "com": [0.02, 0.0, 0.1], "inertia": [1e-3, 0, 0, 1e-3, 0, 1e-3]}
    )
    rest = identify(arm, logged(), fix=("stribeck", "torque_constant", "torque_offset"))
    assert rest.parameters["payload.mass"].value == pytest.approx(0.2, abs=0.06)
    load = measured_load(rest)
    assert load is not None
    assert load.mass.value == pytest.approx(0.3 + rest.parameters["payload.mass"].value)
    assert plant_tables(rest)["arm"]["payload"]["mass"]["value"] == load.mass.value
    # One body in the place of two: the same mass matrix as of the arm with its own and the point beside it.
    whole, _ = measured_arm(rest)
    q = np.array([0.3, 0.7])
    added = rest.fit.values[[rest.model.index(f"payload.{k}") for k in ("mass", "moment.x", "moment.y", "moment.z")]]
    unit = np.eye(2)
    point = np.column_stack(
        [
            arm.replace(gravity=(0.0, 0.0, 0.0)).regressor(q, 0 * q, 0 * q, e)[:, 10:20]
            @ point_mass(added[0], added[1:])[0]
            for e in unit
        ]
    )
    np.testing.assert_allclose(
        whole.mass_matrix(q), arm.mass_matrix(q) + point + np.diag(whole.armature - arm.armature)
    )


def test_a_sensor_on_the_links_side_gets_the_rotors_that_the_arm_was_loaded_with(experiment: str) -> None:
    rotors = np.array([0.2, 0.1])
    arm = asmc_pin.load_arm("two_link", armature=rotors.tolist())
    linked = identify(arm, replace(logged(), torque_side="link"), fix=("stribeck", "torque_constant", "torque_offset"))
    assert not linked.suspicions
    assert linked.parameters["payload.mass"].value == pytest.approx(0.5, rel=0.02)  # no rotor is in this log
    bare = mbar_on_log(found(), [0.06, 0.025], period=PERIOD)
    whole = mbar_on_log(linked, [0.06, 0.025], period=PERIOD)
    assert whole.recording.torque is not None
    assert bare.recording.torque is not None
    added = whole.recording.torque - bare.recording.torque
    inside = slice(400, -400)
    wanted = (rotors * whole.recording.acceleration)[inside]
    assert np.sqrt(np.mean((added[inside] - wanted) ** 2)) < 0.05 * np.std(wanted)
    assert any("do not feel rotors" in line for line in whole.lines())
    path = Path(experiment)
    path.write_text(
        path.read_text().replace('arm = "two_link"', 'arm = { source = "two_link", armature = [0.2, 0.1] }')
    )
    ran = law_on_log(linked, experiment, "Model")
    assert ran.measured.torque is not None
    gap = np.sqrt(np.mean((ran.torque - ran.measured.torque)[500:-500] ** 2, axis=0))
    assert np.all(gap < 0.03 * np.std(ran.measured.torque[500:-500], axis=0))


def test_nothing_is_said_of_an_mbar_where_the_log_contradicts_its_urdf() -> None:
    log = logged()
    turned = identify(asmc_pin.load_arm("two_link"), JointLog(**{**vars(log), "torque": -log.torque}))
    assert turned.suspicions
    with pytest.raises(ParameterError, match="contradicts"):
        mbar_on_log(turned, 0.02)
    with pytest.raises(ParameterError, match="a tenth of the log"):
        mbar_on_log(found(), 0.02, period=5.0)


@pytest.fixture
def saved(tmp_path: Path) -> str:
    log = logged()
    assert log.v is not None
    assert log.torque is not None
    kinds = (("q", log.q), ("v", log.v), ("tau", log.torque))
    columns = {f"{kind}{j + 1}": x[:, j] for kind, x in kinds for j in (0, 1)}
    pd.DataFrame({"t": log.time} | columns).to_csv(tmp_path / "log.csv", index=False)
    return str(tmp_path / "log.csv")


def test_the_command_says_what_the_law_and_its_mbar_would_have_done(experiment: str, saved: str, capsys) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["identify", "two_link", saved, "--law", experiment, "TDC", "--json"])
    assert ended.value.code == 0
    said = json.loads(capsys.readouterr().out)
    assert said["mbar"]["mbar"] == [0.06, 0.025]  # the law's own
    assert said["mbar"]["period"] == PERIOD
    assert len(said["mbar"]["tde_error_rms"]) == len(said["mbar"]["tde_error_max"]) == 2
    assert said["law"]["status"] == "ok"
    with pytest.raises(SystemExit) as refused:
        main(["identify", "two_link", saved, "--period", "0.002"])
    assert refused.value.code == 2
    assert "--mbar" in capsys.readouterr().err


def test_what_follows_a_contradiction_puts_it_right_and_then_come_the_measured_plant_and_its_mbar(
    saved: str, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    table = pd.read_csv(saved)
    table[["tau1", "tau2"]] *= -1.0
    table.to_csv("wrong.csv", index=False)
    words = ["identify", "two_link", "wrong.csv", "--fix", "stribeck", "--fix", "torque_offset"]
    for status, option in ((1, "--motor-constant"), (0, "--out"), (0, "--plant")):
        with pytest.raises(SystemExit) as ended:
            main(words)
        assert ended.value.code == status
        words = next_words(capsys.readouterr().out)
        assert option in words
    assert words[:2] == ["design", "two_link"]
    assert Path(words[words.index("--plant") + 1]).is_file()


@pytest.mark.long
def test_the_page_shows_it_over_time(experiment: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    ran = law_on_log(found(), experiment, "TDC")
    write_identification_page(found(), page, along=mbar_on_log(found(), ran.mbar), ran=ran)
    assert "What would M̄ have done?" in page.read_text()
    for figure in ("lemma1", "tde_error", "law_torque", "law_tracking"):
        assert (tmp_path / f"page_{figure}.png").stat().st_size > 1000
    write_identification_page(found(), page.with_suffix(".html"), along=mbar_on_log(found(), ran.mbar), ran=ran)
    assert page.with_suffix(".html").read_text().count("<figure>") == 6
