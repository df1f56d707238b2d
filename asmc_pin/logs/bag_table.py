"""What a ROS 2 bag holds of joints, as a table: `sensor_msgs/JointState` from MCAP or SQLite, without ROS.

Each message names its joints, in whatever order; the table has a column ``<joint>/position`` and the like for each, so
that no order can be mistaken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.disk.reading import Fail, shown
from asmc_pin.errors import MissingDependencyError
from asmc_pin.logs.log_options import LogOptions
from asmc_pin.logs.log_table import LARGEST
from asmc_pin.words.interface import column_words, parameter_words
from asmc_pin.words.text import printable, quoted

JOINT_STATE = "sensor_msgs/msg/JointState"

_MAGIC = (b"\x89MCAP0\r\n", b"SQLite format 3\x00")
_METADATA = "metadata.yaml"
_KINDS = ("position", "velocity", "effort")


@dataclass(frozen=True)
class BagTable:
    """The joints of a bag.

    Attributes:
        table: A pandas table: ``t`` in s from the first message on, ``<joint>/position`` and the like.
        told: What was read, and from where.
    """

    table: Any
    told: tuple[str, ...]


def is_bag(path: Path) -> bool:
    """Whether it is a bag: a folder with its metadata, or a file that begins as MCAP or SQLite."""
    try:
        if path.is_dir():
            return (path / _METADATA).is_file()
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(16).startswith(_MAGIC)
    except OSError:
        return False


def read_bag(path: Path, joints: Sequence[str], options: LogOptions, fail: Fail) -> BagTable:
    """Read the joints' messages of a bag.

    Args:
        path: Its folder, or one of its files.
        joints: Names that are looked for, unless options name columns.
        options: Which topic, and names of columns.
        fail: Makes the error.

    Raises:
        AsmcPinError: What `fail` makes: it is damaged or too large, has no such messages, more than one topic of them
            and none was chosen, or lacks one of the joints.
        MissingDependencyError: The package that reads bags is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingDependencyError("rosbags", "ros", "to read ROS 2 bags and MCAP") from None
    if options.time_unit != "s":
        raise fail(f"{shown(path)} is a bag, which says its own time; leave the time unit away")
    files = [each for each in path.iterdir() if each.is_file()] if path.is_dir() else [path]
    if sum(each.stat().st_size for each in files) > LARGEST:
        raise fail(f"{shown(path)} cannot be read: a bag of more than {LARGEST / 1e6:.4g} MB")
    states: list[Any] = []
    received: list[int] = []
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            topic = _topic(path, reader.connections, options.topic, fail)
            chosen = [each for each in reader.connections if each.topic == topic and each.msgtype == JOINT_STATE]
            for connection, when, raw in reader.messages(connections=chosen):
                states.append(reader.deserialize(raw, connection.msgtype))
                received.append(int(when))
    except type(fail("")):
        raise
    except Exception as error:  # the readers of three formats raise classes that have nothing in common
        said = printable(" ".join(str(error).split())) or type(error).__name__
        raise fail(f"{shown(path)} cannot be read: its bag is damaged ({said})") from None
    if not states:
        raise fail(f"{shown(path)}: its topic {quoted(topic)} has no message")
    return _tabled(path, topic, states, received, joints, options, fail)


def _topic(path: Path, connections: Sequence[Any], asked: str | None, fail: Fail) -> str:
    found = sorted({str(each.topic) for each in connections if each.msgtype == JOINT_STATE})
    if not found:
        others = ", ".join(sorted({f"{each.topic} ({each.msgtype})" for each in connections})) or "nothing"
        raise fail(f"{shown(path)} has no topic of {JOINT_STATE}; in it: {printable(others)}")
    listed = ", ".join(quoted(topic) for topic in found)
    if asked is not None and asked not in found:
        raise fail(f"{shown(path)} has no topic '{printable(asked)}' of {JOINT_STATE}; it has {listed}")
    if asked is None and len(found) > 1:
        raise fail(f"{shown(path)} has several topics of {JOINT_STATE}: {listed}; choose: {parameter_words('topic')}")
    return asked or found[0]


def _tabled(
    path: Path,
    topic: str,
    states: Sequence[Any],
    received: Sequence[int],
    joints: Sequence[str],
    options: LogOptions,
    fail: Fail,
) -> BagTable:
    import pandas as pd

    names = list(dict.fromkeys(str(name) for state in states for name in state.name))
    missing = [joint for joint in joints if joint not in names]
    if missing and "q" not in options.columns:
        raise fail(
            f"{shown(path)}: topic {quoted(topic)} has no joint '{printable(missing[0])}'; its joints: "
            f"{printable(', '.join(names)) or 'none'}; where they have other names: {column_words('q')}, such as "
            "robot_{joint}/position, and so on"
        )
    place = {name: i for i, name in enumerate(names)}
    values = {kind: np.full((len(states), len(names)), np.nan) for kind in _KINDS}
    for row, state in enumerate(states):
        columns = [place[str(name)] for name in state.name]
        for kind in _KINDS:
            own = np.asarray(getattr(state, kind), dtype=np.float64)
            if own.size == len(columns):
                values[kind][row, columns] = own
            elif own.size:
                raise fail(
                    f"{shown(path)}: message {row + 1} of {quoted(topic)} has {len(columns)} names and {own.size} "
                    f"values of {kind}"
                )
    table = {"t": _times(states, received)}
    for kind in _KINDS:
        # What no message has is no column: nothing was logged.
        table |= {f"{name}/{kind}": values[kind][:, i] for name, i in place.items() if _logged(values[kind][:, i])}
    stamped = any(state.header.stamp.sec or state.header.stamp.nanosec for state in states)
    told = (
        f"{path.name}: {len(states)} messages of {topic}, at the times of their "
        + ("headers" if stamped else "arrival, for their headers have none"),
    )
    return BagTable(pd.DataFrame(table), told)


def _times(states: Sequence[Any], received: Sequence[int]) -> Array:
    stamps = [int(state.header.stamp.sec) * 1_000_000_000 + int(state.header.stamp.nanosec) for state in states]
    clock = stamps if any(stamps) else received
    # Nanoseconds since 1970 have more digits than a float.
    return np.array([(each - clock[0]) * 1e-9 for each in clock])


def _logged(values: Array) -> bool:
    return bool(np.isfinite(values).any())
