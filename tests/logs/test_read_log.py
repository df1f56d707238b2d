"""Logs as people record them: every common form reads the same, and what is odd about one is said or refused."""

from __future__ import annotations

import gzip
from pathlib import Path

import needs
import numpy as np
import pandas as pd
import pytest

from asmc_pin.errors import ParameterError
from asmc_pin.logs import LogOptions, read_log
from asmc_pin.logs.resampling import at_equal_steps, low_passed, smoothing_curve, white_noise
from asmc_pin.words.interface import speaking

JOINTS = ("shoulder", "elbow")


def table(rows: int = 200) -> pd.DataFrame:
    t = np.arange(rows) * 0.01
    columns = {"t": t}
    for kind, phase in (("q", 0.0), ("v", 1.0), ("tau", 2.0)):
        for n in (1, 2):
            columns[f"{kind}{n}"] = np.sin(n * t + phase)
    return pd.DataFrame(columns)


def saved(folder: Path, form: str) -> Path:
    path = folder / f"log.{form}"
    if form == "comma":
        table().to_csv(path, index=False)
    elif form == "semicolon":
        table().to_csv(path, index=False, sep=";")
    elif form == "decimal comma":
        table().to_csv(path, index=False, sep=";", decimal=",")
    elif form == "tabs":
        table().to_csv(path, index=False, sep="\t")
    elif form == "gzip":
        path.write_bytes(gzip.compress(table().to_csv(index=False).encode()))
    else:
        table().to_parquet(path)
    return path


@pytest.mark.parametrize("form", ["comma", "semicolon", "decimal comma", "tabs", "gzip", "parquet"])
def test_every_form_of_a_table_reads_the_same(tmp_path: Path, form: str) -> None:
    log = read_log(saved(tmp_path, form), JOINTS)
    wanted = table()
    np.testing.assert_allclose(log.time, wanted["t"], atol=1e-12)
    np.testing.assert_allclose(log.q, wanted[["q1", "q2"]], atol=1e-12)
    assert log.v is not None
    assert log.torque is not None
    np.testing.assert_allclose(log.v, wanted[["v1", "v2"]], atol=1e-12)
    np.testing.assert_allclose(log.torque, wanted[["tau1", "tau2"]], atol=1e-12)


@pytest.mark.parametrize(
    ("names", "options"),
    [
        (("time", "q_{joint}", "v_{joint}", "tau_{joint}"), {}),
        (("timestamp", "{joint}/position", "{joint}/velocity", "{joint}/effort"), {}),
        (("t", "pos[{i}]", "vel[{i}]", "eff[{i}]"), {}),
        (
            ("clock", "A{n}.act", "A{n}.speed", "A{n}.cur"),
            {"t": "clock", "q": "A{n}.act", "v": "A{n}.speed", "tau": "A{n}.cur"},
        ),
    ],
)
def test_columns_are_known_by_common_names_or_as_they_are_told(tmp_path: Path, names: tuple[str, ...], options) -> None:
    renamed = {"t": names[0]}
    for kind, pattern in zip(("q", "v", "tau"), names[1:], strict=True):
        for i, joint in enumerate(JOINTS):
            renamed[f"{kind}{i + 1}"] = pattern.format(joint=joint, i=i, n=i + 1)
    path = tmp_path / "log.csv"
    table().rename(columns=renamed).sample(frac=1.0, axis=1, random_state=1).to_csv(path, index=False)
    log = read_log(path, JOINTS, LogOptions(columns=options))
    np.testing.assert_allclose(log.q, table()[["q1", "q2"]])
    assert log.torque is not None
    np.testing.assert_allclose(log.torque, table()[["tau1", "tau2"]])


def test_degrees_milliseconds_and_motor_constants_become_si_units(tmp_path: Path) -> None:
    raw = table()
    raw["t"] *= 1e3
    raw[["q1", "v1"]] = np.rad2deg(raw[["q1", "v1"]])
    path = tmp_path / "log.csv"
    raw.to_csv(path, index=False)
    options = LogOptions(degrees=True, time_unit="ms", motor_constant=[2.0, -3.0])
    log = read_log(path, JOINTS, options, kinds=("revolute", "prismatic"))
    np.testing.assert_allclose(log.time, table()["t"], atol=1e-12)
    np.testing.assert_allclose(log.q, table()[["q1", "q2"]])  # the second slides: metres stay metres
    assert log.torque is not None
    np.testing.assert_allclose(log.torque, table()[["tau1", "tau2"]] * [2.0, -3.0])


def test_rows_that_say_nothing_new_are_left_out_and_counted(tmp_path: Path) -> None:
    raw = table()
    again = raw.iloc[[10, 50, 90]].copy()
    again["t"] += 0.004  # the logger asked before there was anything new
    twice = raw.iloc[[120]]
    holed = raw.iloc[[150]].copy()
    holed["t"] += 0.003
    holed["tau1"] = np.nan
    path = tmp_path / "log.csv"
    pd.concat([raw, again, twice, holed]).sort_values("t", kind="stable").to_csv(path, index=False)
    log = read_log(path, JOINTS)
    np.testing.assert_allclose(log.time, raw["t"], atol=1e-12)
    told = "\n".join(log.found)
    assert "3 rows (1.5%) that repeat all values of the row before" in told
    assert "1 row (0.5%) with an empty cell" in told
    assert "1 row (0.5%) whose time is not later" in told


def test_what_was_not_logged_is_said(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    table()[["t", "q1", "q2"]].to_csv(path, index=False)
    log = read_log(path, JOINTS)
    assert log.v is None
    assert log.torque is None
    assert any("no velocities" in line for line in log.found)
    saved(tmp_path, "comma")
    linked = read_log(tmp_path / "log.comma", JOINTS, LogOptions(torque_side="link"))
    assert any("do not feel the rotor" in line for line in linked.found)


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda t: t.rename(columns={"t": "x"}), {}, "no column 't' or 'time'"),
        (lambda t: t.drop(columns="q2"), {}, "no column 'q2' or 'q_elbow'"),
        (lambda t: t.assign(q_elbow=0.0), {}, "both 'q2' and 'q_elbow'"),
        (lambda t: t[["t", "v1", "v2"]], {}, "lacks joint columns"),
        (lambda t: t.assign(t=t["t"] * 1e3), {}, "time unit"),
        (lambda t: t.assign(t=t["t"].to_numpy()[::-1]), {}, "does not increase"),
        (lambda t: t.head(5), {}, "at least 16"),
        (lambda t: t.assign(q1=["abc", *t["q1"][1:]]), {}, "line 2, column 'q1'.*'abc'"),
        (lambda t: t, {"columns": {"q": "q1"}}, "the same for all joints"),
        (lambda t: t, {"columns": {"q": "angle{n}"}}, "no column 'angle1'"),
        (lambda t: t, {"motor_constant": [1.0, 2.0, 3.0]}, "expected one number"),
    ],
)
def test_a_log_that_cannot_be_meant_is_refused_with_a_remedy(tmp_path: Path, change, options, message: str) -> None:
    path = tmp_path / "log.csv"
    change(table()).to_csv(path, index=False)
    with pytest.raises(ParameterError, match=message):
        read_log(path, JOINTS, LogOptions(**options))


@pytest.mark.parametrize(
    # Without its time, which would give the test another name in each process.
    "data",
    [b"\x1f\x8bnonsense", b"PAR1nonsense", b"", gzip.compress(b"t,q1,q2\n" * 3, mtime=0)[:-9]],
)
def test_a_damaged_file_is_one_message(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    with pytest.raises(ParameterError, match="cannot be read"):
        read_log(path, JOINTS)


def test_what_is_no_file_is_told_once() -> None:
    with pytest.raises(ParameterError) as refused:
        read_log("/dev/zero", JOINTS)
    assert str(refused.value).startswith("log: /dev/zero cannot be read: is no file but a device")
    assert str(refused.value).count("cannot be read") == 1


def test_a_column_under_another_name_is_asked_for_in_the_words_of_the_interface(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    table().rename(columns={"t": "x"}).to_csv(path, index=False)
    for interface, said in (("command line", "--columns t=NAME"), ("Python", "columns={'t': 'NAME'}")):
        with speaking(interface), pytest.raises(ParameterError) as refused:  # type: ignore[arg-type]
            read_log(path, JOINTS)
        assert said in str(refused.value)


@pytest.mark.parametrize("options", [{"columns": {"torque": "x"}}, {"time_unit": "min"}, {"torque_side": "gear"}])
def test_unknown_words_are_refused_with_the_known_ones(options) -> None:
    with pytest.raises(ParameterError, match="expected one of"):
        LogOptions(**options)


def test_the_filter_shifts_nothing_and_takes_what_is_above_its_cutoff() -> None:
    t = np.arange(4000) * 1e-3
    slow, fast = np.sin(2 * np.pi * 1.0 * t), np.sin(2 * np.pi * 80.0 * t)
    left = low_passed((slow + fast)[:, None], 1e-3, 10.0)[:, 0]
    assert np.abs(left - slow)[500:-500].max() < 2e-3


def test_white_noise_is_measured_beside_a_motion() -> None:
    t = np.arange(5000) * 1e-3
    noise = np.random.default_rng(1).normal(0.0, 1e-4, (5000, 1))
    assert white_noise(t, np.sin(3.0 * t)[:, None] + noise)[0] == pytest.approx(1e-4, rel=0.05)


def test_resampling_keeps_a_straight_line_whatever_the_time_stamps() -> None:
    t = np.cumsum(np.random.default_rng(2).uniform(0.5e-3, 4e-3, 1000))
    grid, values = at_equal_steps(t, np.column_stack([2.0 * t, -t]), 1e-3)
    np.testing.assert_allclose(values, np.column_stack([2.0 * grid, -grid]), rtol=1e-12)
    np.testing.assert_allclose(np.diff(grid), 1e-3)


def test_a_smoothing_spline_is_as_far_from_the_rows_as_their_rounding() -> None:
    t = np.arange(400) * 0.01
    count = 1e-3
    rounded = count * np.round(np.sin(t) / count)
    smooth = smoothing_curve(t, rounded, count / np.sqrt(12.0))(t)
    assert np.sqrt(np.mean((smooth - rounded) ** 2)) == pytest.approx(count / np.sqrt(12.0), rel=0.1)
    assert np.sqrt(np.mean((smooth - np.sin(t)) ** 2)) < 0.6 * count / np.sqrt(12.0)
    np.testing.assert_allclose(smoothing_curve(t, rounded, 0.0)(t), rounded, atol=1e-12)


def test_the_log_of_a_real_arm_is_read_and_its_oddities_are_counted() -> None:
    joints = [f"panda_joint{i}" for i in range(1, 8)]
    log = read_log(needs.real_log("panda_exciting.csv.gz"), joints, LogOptions(torque_side="link"))
    told = "\n".join(log.found)
    assert "20544 rows" in told
    assert "that repeat all values" in told
    assert "not regular" in told
    assert 20.9 < log.time[-1] < 21.1
    assert np.all(np.diff(log.time) > 0.0)
