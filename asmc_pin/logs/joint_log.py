"""The log of an arm's joints, cleaned: one time stamp a row, each later than the one before, nothing said twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.disk.reading import Fail, user_path
from asmc_pin.errors import ParameterError
from asmc_pin.logs.bag_table import is_bag, read_bag
from asmc_pin.logs.log_columns import clock_column, joint_columns
from asmc_pin.logs.log_options import TIME_UNITS, LogOptions
from asmc_pin.logs.log_table import numbers, read_table

_MOST_BACK = 0.01  # of the rows; more that go back in time are no slips of a logger
_LEAST_ROWS = 16


@dataclass(frozen=True, eq=False)
class JointLog:
    """What was logged while an arm moved, in SI units.

    Attributes:
        name: The file's name.
        joint_names: Of the arm, base first.
        time: From 0 on, increasing, not regular, shape (T,), s.
        q: Shape (T, nv), rad (m where prismatic).
        v: Velocities, shape (T, nv), rad/s; None where not logged.
        torque: At the joints, shape (T, nv), N·m; None where not logged.
        torque_side: ``"motor"`` or ``"link"``, as `LogOptions` says.
        found: What was found in the file and what became of it, a sentence each.
    """

    name: str
    joint_names: tuple[str, ...]
    time: Array
    q: Array
    v: Array | None
    torque: Array | None
    torque_side: str
    found: tuple[str, ...]

    @property
    def step(self) -> float:
        """Median distance of the rows, s."""
        return float(np.median(np.diff(self.time)))


def read_log(
    path: str | Path,
    joints: Sequence[str],
    options: LogOptions | None = None,
    *,
    kinds: Sequence[str] | None = None,
) -> JointLog:
    """Read the log of an arm's joints.

    Rows that repeat all values of the row before, that go back in time, or that have a gap in them are left out; how
    many, `JointLog.found` says. Without options columns are known by common names: ``t`` or ``time``; ``q1`` …,
    ``q_<joint>`` or ``<joint>/position`` and the like; the same with ``v`` and ``tau``. Others are ignored.

    Args:
        path: CSV with ``,``, ``;`` or tabs, also gzipped, Parquet, or a ROS 2 bag with `sensor_msgs/JointState`: its
            folder, or a file of it in MCAP or SQLite.
        joints: Names of the arm's joints, base first.
        options: Names of columns, units, kind of torque.
        kinds: ``"revolute"`` or ``"prismatic"``, per joint; all turn when omitted.

    Returns:
        The log.

    Raises:
        ParameterError: It cannot be read, a column is missing, a cell is no number, or too little is left.
        MissingDependencyError: It is a bag, and the package that reads bags is not installed.
    """

    def fail(message: str) -> ParameterError:
        return ParameterError("log", message)

    path, options = user_path(path), options or LogOptions()
    bag = read_bag(path, joints, options, fail) if is_bag(path) else None
    if bag is None and options.topic is not None:
        raise ParameterError("topic", f"'{options.topic}' given, and {path.name} is no bag: only a bag has topics")
    table = read_table(path, fail) if bag is None else bag.table
    columns = list(table.columns)
    clock = clock_column(columns, options, path.name, fail)
    names = {kind: joint_columns(columns, kind, joints, options, path.name, fail) for kind in ("q", "v", "tau")}
    if names["q"] is None:
        expected = ", ".join(f"q{i + 1}" for i in range(len(joints)))
        raise fail(f"{path.name} lacks joint columns; {expected} or q_<joint> expected, one per joint, or name them")
    wanted = [clock, *(column for kind in ("q", "v", "tau") for column in names[kind] or ())]
    values = numbers(path, table, wanted, fail, gaps=True)
    told = list(() if bag is None else bag.told)
    told += [f"{path.name}: {len(values)} rows, columns {', '.join(wanted[:1] + _ends(names))}"]
    values, notes = _cleaned(values, path.name, fail)
    told += notes
    time = (values[:, 0] - values[0, 0]) * TIME_UNITS[options.time_unit]
    nv, start = len(joints), 1
    parts: dict[str, Array | None] = {}
    for kind in ("q", "v", "tau"):
        parts[kind] = values[:, start : start + nv].copy() if names[kind] is not None else None
        start += nv if names[kind] is not None else 0
    turning = np.array([kind == "revolute" for kind in kinds or ("revolute",) * nv])
    if options.degrees:
        for kind in ("q", "v"):
            part = parts[kind]
            if part is not None:
                part[:, turning] = np.deg2rad(part[:, turning])
        told.append("angles and velocities are in degrees")
    torque = parts["tau"]
    if torque is not None and options.motor_constant is not None:
        torque *= _constants(options, nv)
        told.append("torque is what was logged times the motor constant that was given")
    told += about_torque(options, parts["v"] is None, torque is None)
    told += _about_time(time, path.name, fail)
    assert parts["q"] is not None
    return JointLog(path.name, tuple(joints), time, parts["q"], parts["v"], torque, options.torque_side, tuple(told))


def _ends(names: dict[str, list[str] | None]) -> list[str]:
    return [f"{found[0]} … {found[-1]}" if len(found) > 1 else found[0] for found in names.values() if found]


def _constants(options: LogOptions, nv: int) -> Array:
    constants = np.asarray(options.motor_constant, dtype=np.float64)
    if constants.shape not in ((), (1,), (nv,)) or not np.isfinite(constants).all() or np.any(constants == 0.0):
        raise ParameterError(
            "motor_constant", f"{options.motor_constant!r} given; expected one number that is not 0, or {nv} of them"
        )
    return constants


def _cleaned(values: Array, name: str, fail: Fail) -> tuple[Array, list[str]]:
    """Rows that say something, and what was left out."""
    notes = []

    def keep(rows: BoolArray, what: str) -> None:
        nonlocal values
        if not rows.all():
            left = int((~rows).sum())
            notes.append(f"{left} row{'s' if left > 1 else ''} ({left / len(rows):.1%}) {what}: left out")
            values = values[rows]

    keep(np.asarray(np.isfinite(values).all(axis=1)), "with an empty cell")
    if len(values) > 1:
        late = np.concatenate([[True], values[1:, 0] > np.maximum.accumulate(values[:, 0])[:-1]])
        same = np.concatenate([[False], (values[1:] == values[:-1]).all(axis=1)])
        if (~late & ~same).mean() > _MOST_BACK:
            row = int(np.flatnonzero(~late & ~same)[0])
            raise fail(
                f"{name}: the time of {(~late & ~same).mean():.0%} of its rows does not increase, first at row "
                f"{row + 2}, {values[row, 0]:g} after {values[row - 1, 0]:g}; is it one log, and is this its time?"
            )
        keep(late, "whose time is not later than one before")
        repeats = np.concatenate([[False], (values[1:, 1:] == values[:-1, 1:]).all(axis=1)])
        keep(~repeats, "that repeat all values of the row before")
    if len(values) < _LEAST_ROWS:
        raise fail(f"{name} has {len(values)} rows that say something, at least {_LEAST_ROWS} expected")
    return values, notes


def about_torque(options: LogOptions, no_velocity: bool, no_torque: bool) -> list[str]:
    """What `JointLog.found` says of velocities and torques, which a path has no use for."""
    told = []
    if no_velocity:
        told.append("no velocities were logged: they are differenced from the angles")
    if no_torque:
        told.append("no torques were logged")
    elif options.torque_side == "link":
        told.append(
            "the torque is that of sensors on the link's side: they do not feel the rotor, so armature and friction "
            "of motor and gear are hidden from this log"
        )
    return told


def _about_time(time: Array, name: str, fail: Fail) -> list[str]:
    gaps = np.diff(time)
    step = float(np.median(gaps))
    if step >= 0.5:
        raise fail(
            f"{name}: its rows are {step:g} s apart; a log of an arm has many a second. If its time is in ms, us or "
            "ns, say so (time unit)"
        )
    told = [
        f"{time[-1]:.4g} s, rows {gaps.min():.3g} to {gaps.max():.3g} s apart, {step:.4g} s in the median"
        + ("" if gaps.max() - gaps.min() <= 0.01 * step else ": not regular")
    ]
    wide = np.flatnonzero(gaps > max(10.0 * step, 0.02))
    if wide.size:
        told.append(
            f"{wide.size} gap{'s' if wide.size > 1 else ''} of more than ten rows, the first at {time[wide[0]]:.4g} s"
        )
    return told
