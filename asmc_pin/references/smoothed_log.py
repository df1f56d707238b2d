"""The log of an arm as a path: read as logs are, and smoothed by as much as its rounding asks for."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.logs.bag_table import is_bag
from asmc_pin.logs.joint_log import about_torque, read_log
from asmc_pin.logs.log_columns import form_by_name
from asmc_pin.logs.log_options import LogOptions
from asmc_pin.logs.log_table import read_table
from asmc_pin.logs.resampling import smoothing_curve, white_noise
from asmc_pin.words.text import printable

_LEAST_COUNTS = 50
"""Counts that a joint has to go through before its smallest step is taken for one."""


@dataclass(frozen=True, eq=False)
class LoggedRows:
    """The angles of a log.

    Attributes:
        names: The joints, as asked for, or ``q1`` ….
        time: From 0 on, increasing, shape (T,), s.
        points: Shape (T, nv), rad (m).
        found: What was found in the file and what became of it, a sentence each.
    """

    names: tuple[str, ...]
    time: Array
    points: Array
    found: tuple[str, ...]


def logged_rows(path: Path, joints: Sequence[str] | None) -> LoggedRows:
    """The angles of a log, as `read_log` reads and cleans it.

    Args:
        path: The file.
        joints: The joints' names in it; ``q1`` … when omitted.

    Raises:
        ParameterError: it cannot be read, or has no such columns.
    """
    columns: dict[str, str] = {}
    try:
        if is_bag(path):
            if joints is None:
                raise ParameterError("joints", f"are missing; {path.name} is a bag, which knows joints by their names")
        else:
            joints, columns["q"] = _columns(path, joints)
        options = LogOptions(columns=columns)
        log = read_log(path, joints, options)
    except ParameterError as error:
        parameter = error.parameter if error.parameter == "joints" else "path"
        raise ParameterError(parameter, error.said) from error
    unused = about_torque(options, log.v is None, log.torque is None)
    return LoggedRows(tuple(joints), log.time, log.q, tuple(line for line in log.found if line not in unused))


def _columns(path: Path, joints: Sequence[str] | None) -> tuple[Sequence[str], str]:
    """The joints of a table and the form of their columns."""
    columns = [str(name) for name in read_table(path, lambda message: ParameterError("path", message)).columns]
    given = printable(", ".join(columns))
    if joints is None:
        joints = list(itertools.takewhile(lambda name: name in columns, (f"q{i}" for i in itertools.count(1))))
        if not joints:
            raise ParameterError("path", f"{path.name} has no column q1: give its joints = […]; it has {given}")
    form = form_by_name(columns, "q", joints)
    if form is None:
        asked = printable(", ".join(joints))
        raise ParameterError("path", f"{path.name} has no columns of {asked}, as q_NAME or NAME; it has {given}")
    return joints, form


def smallest_steps(points: Array) -> Array:
    """The smallest step between two angles of each joint, shape (nv,), rad; 0 for a joint that takes too few to tell.

    Of an encoder it is one count, of a file one unit of its last digit.
    """
    found = np.zeros(points.shape[1])
    for k, column in enumerate(points.T):
        levels = np.unique(column)
        gaps = np.diff(levels)
        gaps = gaps[gaps > 1e-12 * max(1.0, float(np.abs(levels).max()))]  # the same count, written twice
        if gaps.size and levels[-1] - levels[0] >= _LEAST_COUNTS * gaps.min():
            found[k] = gaps.min()
    return found


@dataclass(frozen=True, eq=False)
class Smoothed:
    """The smoothing spline of a log.

    Attributes:
        rows: What it goes through.
        steps: Δ, the rounding of each joint's angles, shape (nv,), rad; 0 where none is seen.
        noise: Standard deviation of what is white in the rows, shape (nv,), rad: rounding, noise, time stamps that are
            off; zeros where Δ was given.
        deviation: RMS distance of the spline from the rows, at most, shape (nv,), rad.
        curve: One spline with nv columns.
        apart: Its largest distance from the rows, shape (nv,), rad.
    """

    rows: LoggedRows
    steps: Array
    noise: Array
    deviation: Array
    curve: BSpline
    apart: Array

    def words(self, given: bool) -> tuple[str, ...]:
        """What was done to the log before it became a path, a sentence each."""
        how = "as given" if given else "the smallest step of each joint in the file"
        noise = ""
        if (self.noise > self.steps / np.sqrt(12.0)).any():
            noise = f"; of some joints more than that is white in the rows, and is smoothed: RMS {_listed(self.noise)}"
        return (
            *self.rows.found,
            "smoothed by a cubic spline, as smooth as an RMS distance of Δ/√12 from the rows lets it be; "
            f"Δ = {_listed(self.steps)} rad (m), {how}{noise}; RMS distance at most {_listed(self.deviation)}, largest "
            f"{_listed(self.apart)}",
        )


def smoothed_file(path: Path, joints: Sequence[str] | None, resolution: ArrayLike | None, stretch: float) -> Smoothed:
    """A log, smoothed; asked again for the same file as it lies there, it is not done again.

    Args:
        path: The file.
        joints: See `logged_rows`.
        resolution: Δ, a scalar or (nv,), rad; measured when omitted.
        stretch: What its times are multiplied by.

    Raises:
        ParameterError: as of `logged_rows`, or Δ is for another number of joints.
    """
    try:
        there = path.stat()
    except OSError:
        state = None  # the reader says why
    else:
        state = there.st_mtime_ns, there.st_size
    steps = None if resolution is None else tuple(np.atleast_1d(np.asarray(resolution, dtype=np.float64)).tolist())
    return _smoothed_file(path, state, None if joints is None else tuple(joints), steps, stretch)


@lru_cache(maxsize=8)
def _smoothed_file(
    path: Path,
    state: tuple[int, int] | None,
    joints: tuple[str, ...] | None,
    steps: tuple[float, ...] | None,
    stretch: float,
) -> Smoothed:
    rows = logged_rows(path, joints)
    rows = replace(rows, time=rows.time * stretch)
    for values in (rows.time, rows.points):
        values.setflags(write=False)
    if steps is None:
        return smoothed(rows, None)
    nv = len(rows.names)
    if len(steps) not in (1, nv):
        raise ParameterError("resolution", f"{len(steps)} values given; expected one, or {nv}")
    return smoothed(rows, np.array(np.broadcast_to(steps, (nv,))))


def smoothed(rows: LoggedRows, resolution: Array | None) -> Smoothed:
    """A cubic smoothing spline for each joint, as smooth as an RMS distance of Δ/√12 from its rows lets it be.

    Rounding to steps of Δ leaves an error of variance Δ²/12 in each row. Where Δ is not given and the rows hold more
    that is white, of noise or of time stamps that are off, the distance is that.

    Args:
        rows: The log.
        resolution: Δ, shape (nv,), rad; measured when omitted.
    """
    nv = rows.points.shape[1]
    steps = smallest_steps(rows.points) if resolution is None else resolution
    noise = white_noise(rows.time, rows.points) if resolution is None else np.zeros(nv)
    deviation = np.maximum(steps / np.sqrt(12.0), noise)
    curves = [smoothing_curve(rows.time, q, float(far)) for q, far in zip(rows.points.T, deviation, strict=True)]
    joined = BSpline(curves[0].t, np.column_stack([curve.c for curve in curves]), 3)
    apart = np.abs(joined(rows.time) - rows.points).max(axis=0)
    for values in (steps, noise, deviation, apart):
        values.setflags(write=False)
    return Smoothed(rows, steps, noise, deviation, joined, apart)


def _listed(values: Array) -> str:
    return f"({', '.join(f'{x:.2g}' for x in values)})"
