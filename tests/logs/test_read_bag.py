"""A ROS 2 bag reads as the same log in CSV does, whatever the order of its joints; what is odd about it is said."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from asmc_pin import identify, load_arm
from asmc_pin.cli import main
from asmc_pin.errors import MissingDependencyError, ParameterError
from asmc_pin.logs import LogOptions, read_log
from asmc_pin.words.interface import speaking

TYPES = get_typestore(Stores.ROS2_JAZZY)
State, Header, Stamp = (
    TYPES.types[name] for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
)
JOINTS = ("joint_1", "joint_2")
BEGIN = 1_795_000_000 * 10**9  # ns since 1970, of which a float in s keeps no microseconds


def message(when: int, joints, position, velocity=(), effort=(), *, stamped: bool = True):
    stamp = Stamp(sec=when // 10**9, nanosec=when % 10**9) if stamped else Stamp(sec=0, nanosec=0)
    values = (np.asarray(each, dtype=np.float64) for each in (position, velocity, effort))
    return State(Header(stamp=stamp, frame_id=""), list(joints), *values)


def written(folder: Path, topics: dict[str, list], *, storage=StoragePlugin.MCAP, kind=State) -> Path:
    with Writer(folder, version=9, storage_plugin=storage) as writer:
        for topic, messages in topics.items():
            connection = writer.add_connection(topic, kind.__msgtype__, typestore=TYPES)
            for k, each in enumerate(messages):
                stamp = each.header.stamp if hasattr(each, "header") else Stamp(sec=0, nanosec=0)
                when = stamp.sec * 10**9 + stamp.nanosec or BEGIN + k * 4_000_000
                writer.write(connection, when, TYPES.serialize_cdr(each, kind.__msgtype__))
    return folder


def columns(rows: int = 2000) -> dict[str, np.ndarray]:
    """Angles, velocities and the torque of the two-link arm with friction."""
    arm = load_arm("two_link")
    t = np.arange(rows) * 0.004
    rate, size = 2.0 * np.pi * np.array([[0.31, 0.83], [0.41, 0.97]]), np.array([[0.8, 0.2], [0.9, 0.3]])
    angle = rate[:, :, None] * t
    q, v, a = (
        np.einsum("jk,jkt->tj", size * rate**order, wave)
        for order, wave in ((0, np.sin(angle)), (1, np.cos(angle)), (2, -np.sin(angle)))
    )
    torque = np.einsum("tij,tj->ti", arm.mass_matrix(q), a) + arm.bias(q, v) + 0.3 * np.sign(v) + 0.2 * v
    torque += 0.02 * np.random.default_rng(1).normal(size=torque.shape)
    return {"t": t, "q": q, "v": v, "tau": torque}


def states(data: dict[str, np.ndarray], *, effort: bool = True, stamped: bool = True) -> list:
    """One message a row, joints in another order in every second, a finger among them; each tenth is sent twice."""
    made = []
    for k, t in enumerate(data["t"]):
        names = ("joint_2", "finger", "joint_1") if k % 2 else ("joint_1", "joint_2", "finger")
        place = [{"joint_1": 0, "joint_2": 1, "finger": 2}[name] for name in names]
        values = [np.append(data[kind][k], 0.02)[place] for kind in ("q", "v", "tau")]
        when = BEGIN + round(t * 1e9)
        made.append(message(when, names, *values[: 3 if effort else 2], stamped=stamped))
        if k % 10 == 0:
            made.append(message(when + 1_000_000, names, *values[: 3 if effort else 2], stamped=stamped))
    return made


@pytest.mark.parametrize("storage", StoragePlugin)
def test_a_bag_identifies_the_same_as_the_table_of_its_messages(tmp_path: Path, storage) -> None:
    data = columns()
    bag = written(tmp_path / "bag", {"/joint_states": states(data)}, storage=storage)
    table = {"t": data["t"]} | {f"{kind}{j + 1}": data[kind][:, j] for kind in ("q", "v", "tau") for j in (0, 1)}
    pd.DataFrame(table).to_csv(tmp_path / "log.csv", index=False)
    log, plain = read_log(bag, JOINTS), read_log(tmp_path / "log.csv", JOINTS)
    for own, other in ((log.time, plain.time), (log.q, plain.q), (log.v, plain.v), (log.torque, plain.torque)):
        np.testing.assert_allclose(own, other, atol=1e-9)
    told = "\n".join(log.found)
    assert "2200 messages of /joint_states, at the times of their headers" in told
    assert "200 rows (9.1%) that repeat all values" in told
    (inner,) = (path for path in bag.iterdir() if path.suffix in (".mcap", ".db3"))
    np.testing.assert_array_equal(read_log(inner, JOINTS).q, log.q)  # a file of it without its folder
    if storage is StoragePlugin.MCAP:
        arm = load_arm("two_link")
        wanted = identify(arm, plain).parameters
        for key, each in identify(arm, log).parameters.items():
            assert each.value == pytest.approx(wanted[key].value, rel=1e-4, abs=1e-6)


def test_without_efforts_no_torque_was_logged_and_without_stamps_the_arrival_counts(tmp_path: Path) -> None:
    made = states(columns(60), effort=False, stamped=False)
    log = read_log(written(tmp_path / "bag", {"/joint_states": made}), JOINTS)
    assert log.torque is None
    assert any("no torques were logged" in line for line in log.found)
    assert any("at the times of their arrival" in line for line in log.found)
    assert log.step == pytest.approx(0.004)


def test_of_several_topics_one_has_to_be_chosen(tmp_path: Path) -> None:
    data = columns(60)
    bag = written(tmp_path / "bag", {"/left/joint_states": states(data), "/right/joint_states": states(data)})
    with (
        speaking("command line"),
        pytest.raises(ParameterError, match=r"/left/joint_states, /right/joint_states.*--topic"),
    ):
        read_log(bag, JOINTS)
    assert len(read_log(bag, JOINTS, LogOptions(topic="/left/joint_states")).time) == 60
    with pytest.raises(ParameterError, match=r"no topic '/middle'.*it has /left"):
        read_log(bag, JOINTS, LogOptions(topic="/middle"))


def test_a_joint_that_no_message_names_is_named_and_one_of_another_name_can_be_told(tmp_path: Path) -> None:
    made = [message(BEGIN + k * 4_000_000, ("r_joint_1", "r_joint_2"), (0.1 * k, 0.2)) for k in range(40)]
    bag = written(tmp_path / "bag", {"/joint_states": made})
    with pytest.raises(ParameterError, match="has no joint 'joint_1'; its joints: r_joint_1, r_joint_2"):
        read_log(bag, JOINTS)
    told = read_log(bag, JOINTS, LogOptions(columns={"q": "r_{joint}/position"}))
    np.testing.assert_allclose(told.q[:, 0], 0.1 * np.arange(40))


def test_what_is_no_bag_of_joints_is_one_message(tmp_path: Path) -> None:
    wrong = [message(BEGIN, JOINTS, (0.1,))]
    with pytest.raises(ParameterError, match="message 1 of /joint_states has 2 names and 1 values of position"):
        read_log(written(tmp_path / "uneven", {"/joint_states": wrong}), JOINTS)
    other = written(tmp_path / "other", {"/clock": [Stamp(sec=1, nanosec=0)]}, kind=Stamp)
    with pytest.raises(ParameterError, match=r"has no topic of sensor_msgs/msg/JointState; in it: /clock"):
        read_log(other, JOINTS)
    bag = written(tmp_path / "cut", {"/joint_states": states(columns(200))})
    (inner,) = bag.glob("*.mcap")
    inner.write_bytes(inner.read_bytes()[: inner.stat().st_size // 2])
    with pytest.raises(ParameterError, match="cannot be read"):
        read_log(inner, JOINTS)
    with pytest.raises(ParameterError, match="says its own time"):
        read_log(bag, JOINTS, LogOptions(time_unit="ms"))
    (tmp_path / "log.csv").write_text("t,q1,q2\n0,0,0\n")
    with pytest.raises(ParameterError, match="only a bag has topics"):
        read_log(tmp_path / "log.csv", JOINTS, LogOptions(topic="/joint_states"))


def test_without_the_extra_it_is_said_which_one_brings_the_reader(tmp_path: Path, monkeypatch, capsys) -> None:
    bag = written(tmp_path / "bag", {"/joint_states": states(columns(30))})
    for name in [each for each in sys.modules if each.split(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(MissingDependencyError, match=r"asmc-pin\[ros\]"):
        read_log(bag, JOINTS)
    with pytest.raises(SystemExit) as ended:
        main(["identify", "two_link", str(bag)])
    assert ended.value.code == 2
    assert "asmc-pin[ros]" in capsys.readouterr().err
    shutil.rmtree(bag)
