"""A joint path from a CSV file, made smooth by a spline."""

from __future__ import annotations

import csv
import io
import math
import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.disk.reading import read_file, shown
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import AsGiven, Choice, OptionalPerJoint, Scalar
from asmc_pin.references.reference import as_times, held_outside, reference_kind
from asmc_pin.references.smoothed_log import smoothed_file
from asmc_pin.words.mistyped import other_separator
from asmc_pin.words.text import as_number, printable

LARGEST = 100_000_000
"""Bytes of a path's CSV file at most."""

_MOST_COLUMNS = 1_000
_FURTHEST = 1e6
_LEAST_STEP = 1e-9  # s; what happens faster has derivatives that overflow
_DEGREE = {"cubic": 3, "quintic": 5}


@reference_kind("csv")
@dataclass(frozen=True, kw_only=True, eq=False)
class CsvPath:
    """A joint path through the rows of a CSV file, with the header ``t,q1,…,qn`` or ``t`` and the joints' names.

    Times are in s, angles in rad (m for prismatic joints). A spline goes through every row and gives velocity and
    acceleration: a cubic one (acceleration continuous) or a quintic one (its next two derivatives too). Before the
    first and after the last row the path holds that row.

    With ``smoothing="quantisation"`` the file is the log of a robot: read as `read_log` does, with repeated rows and
    irregular times, and smoothed by as much as its rounding asks for (`asmc_pin.references.smoothed_log`).

    Attributes:
        path: The file.
        joints: Which columns to take, in this order; default all in the order of the file.
        spline: ``"cubic"`` or ``"quintic"``.
        ends: ``"free"``: the rows alone shape the ends (not-a-knot); ``"rest"``: it starts and ends with velocity 0,
            and with ``"quintic"`` acceleration 0 too.
        smoothing: ``"none"``: a spline through every row; ``"quantisation"``: a smoothing spline, for a log.
        resolution: Step to which the angles of a log are rounded, rad; the smallest one in the file when omitted.
        stretch: What the file's times are multiplied by; above 1 the motion is slower.
        columns: The joints' names as the header has them, in the order taken.
        times: The times of the rows, s, read-only.
        points: The rows, (rows, nv), rad, read-only.
        deviation: RMS distance of the path from the rows, at most, (nv,), rad; zeros without smoothing.
        told: What was found in a log and how it was smoothed, a sentence each; nothing without smoothing.

    Raises:
        ParameterError: the file cannot be read, or a row is malformed; the message names the line.
    """

    motion: ClassVar[str] = "a spline through the rows of a file"

    path: AsGiven = AsGiven("the file, as seen from the experiment", shape="text")
    joints: AsGiven = AsGiven("columns to take; all when omitted", shape="a list of names", default=None)
    spline: Choice = Choice("spline through the rows", ("cubic", "quintic"), default="cubic")
    ends: Choice = Choice("how it starts and ends", ("free", "rest"), default="free")
    smoothing: Choice = Choice(
        "none: a spline through every row; the other: a log, smoothed as its rounding asks for",
        ("none", "quantisation"),
        default="none",
    )
    resolution: OptionalPerJoint = OptionalPerJoint(
        "step to which a log's angles are rounded; the smallest in it when omitted", "rad (m)", above=0.0
    )
    stretch: Scalar = Scalar("what the file's times are multiplied by", "", above=0.0, default=1.0)
    columns: tuple[str, ...] = field(init=False)
    times: Array = field(init=False, repr=False)
    points: Array = field(init=False, repr=False)
    deviation: Array = field(init=False, repr=False)
    told: tuple[str, ...] = field(init=False, repr=False)
    _curve: CubicSpline | BSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.smoothing == "quantisation":
            self._take_log()
            return
        if self.resolution is not None:
            raise ParameterError("resolution", 'is of a log; give smoothing = "quantisation" too, or leave it out')
        names, times, points = _read(Path(self.path))
        if self.joints is not None:
            missing = [name for name in self.joints if name not in names]
            if missing or not self.joints:
                raise ParameterError(
                    "joints", f"{self.path} has no column {', '.join(missing)}; it has {', '.join(names)}"
                )
            points = np.ascontiguousarray(points[:, [names.index(name) for name in self.joints]])
            names = list(self.joints)
        times = times * self.stretch
        curve = _interpolate(str(self.path), times, points, _DEGREE[self.spline], self.ends == "rest")
        self._keep(tuple(names), times, points, np.zeros(points.shape[1]), (), curve)

    def _take_log(self) -> None:
        for name, plain in (("spline", "cubic"), ("ends", "free")):
            if getattr(self, name) != plain:
                given = getattr(self, name)
                raise ParameterError(name, f"'{given}' is for a spline through every row, and smoothing has none of it")
        made = smoothed_file(Path(self.path), self.joints, self.resolution, self.stretch)
        rows, told = made.rows, made.words(self.resolution is not None)
        self._keep(rows.names, rows.time, rows.points, made.deviation, told, made.curve)

    def _keep(
        self,
        columns: tuple[str, ...],
        times: Array,
        points: Array,
        deviation: Array,
        told: tuple[str, ...],
        curve: CubicSpline | BSpline,
    ) -> None:
        for rows in (times, points, deviation):
            rows.setflags(write=False)
        made = {
            "columns": columns,
            "times": times,
            "points": points,
            "deviation": deviation,
            "told": told,
            "_curve": curve,
        }
        for name, value in made.items():
            object.__setattr__(self, name, value)

    def smoother(self) -> Iterator[CsvPath]:
        """The same motion smoothed more and more: as its rows ask for, four times that, and within 0.5 % of its range.

        Nothing where the rows are no log.
        """
        try:
            made = replace(self, smoothing="quantisation", spline="cubic", ends="free")
        except ParameterError:
            return
        if self.smoothing == "none":
            yield made
        most = 0.005 * np.maximum(np.ptp(made.points, axis=0), 1e-9)
        for further in (np.minimum(4.0 * made.deviation, most), most):
            yield replace(made, resolution=np.sqrt(12.0) * np.maximum(further, made.deviation))

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.points.shape[1])

    @property
    def duration(self) -> float:
        """Time of the last row, s."""
        return float(self.times[-1])

    @property
    def joint_names(self) -> tuple[str, ...] | None:
        """The joints that the header names; None where it only numbers them."""
        numbered = all(re.fullmatch(r"q\d+", name) for name in self.columns)
        return None if numbered else self.columns

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv)."""
        t = as_times(t)
        first, last = self.times[0], self.times[-1]
        inside = (t >= first) & (t <= last)
        q, v, a = (np.asarray(self._curve(np.clip(t, first, last), nu)) for nu in range(3))
        return held_outside(inside, q, v, a)


def _interpolate(path: str, times: Array, points: Array, degree: int, rest: bool) -> CubicSpline | BSpline:
    least = 2 if rest else degree + 1
    if len(times) < least:
        raise ParameterError(
            "path", f"{path} has {len(times)} row(s); a spline of degree {degree} needs at least {least}"
        )
    still = np.zeros(points.shape[1])
    ends: Any = ([(1, still), (2, still)],) * 2 if rest else None
    curve: CubicSpline | BSpline | None
    try:
        with np.errstate(all="ignore"):
            if degree == 3:
                curve = CubicSpline(times, points, bc_type="clamped" if rest else "not-a-knot")
            else:
                curve = make_interp_spline(times, points, k=degree, bc_type=ends)
    except (ValueError, np.linalg.LinAlgError):
        curve = None
    if curve is None or not np.isfinite(curve.c).all():
        raise ParameterError("path", f"{path}: no spline can be put through its rows; are some times all but the same?")
    return curve


def _read(path: Path) -> tuple[list[str], Array, Array]:
    """Column names, times (rows,) and angles (rows, nv)."""
    data = read_file(path, LARGEST, "a path's CSV", lambda message: ParameterError("path", message))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ParameterError("path", f"{shown(path)}: cannot be read, it is not UTF-8 text") from None
    reader = csv.reader(io.StringIO(text, newline=""))
    names: list[str] = []
    values = array("d")  # a number takes eight bytes here, and ten times as many in a list of texts
    try:
        for row in reader:
            if not any(cell.strip() for cell in row):
                continue
            if not names:
                names = _header(path, reader.line_num, row)
                continue
            numbers = _numbers(path, reader.line_num, row, len(names))
            if values and numbers[0] <= values[-len(names)]:
                place, before = f"{shown(path)}, line {reader.line_num}", values[-len(names)]
                raise ParameterError("path", f"{place}: time {numbers[0]:g} s follows {before:g} s; it must increase")
            if values and numbers[0] - values[-len(names)] < _LEAST_STEP:
                place = f"{shown(path)}, line {reader.line_num}"
                raise ParameterError("path", f"{place}: is less than {_LEAST_STEP:g} s after the row before it")
            values.extend(numbers)
    except csv.Error as error:
        raise ParameterError("path", f"{shown(path)}, line {reader.line_num}: {error}") from error
    if not names:
        raise ParameterError("path", f"{shown(path)} is empty; expected a header t,q1,…,qn and rows of numbers")
    table = np.array(values).reshape(-1, len(names))
    if np.abs(table).max(initial=0.0) > _FURTHEST:
        raise ParameterError("path", f"{shown(path)}: has a number beyond {_FURTHEST:g}; s, rad and m are expected")
    return names[1:], table[:, 0].copy(), np.ascontiguousarray(table[:, 1:])


def _header(path: Path, line: int, row: list[str]) -> list[str]:
    names = [cell.strip() for cell in row]
    where = f"{shown(path)}, line {line}"
    foreign = other_separator(",".join(row), path.name)
    if foreign is not None:
        raise ParameterError("path", f"{where}: {foreign}")
    if len(names) > _MOST_COLUMNS:
        raise ParameterError("path", f"{where}: {len(names)} columns, at most {_MOST_COLUMNS} expected")
    given = printable(",".join(names))
    if len(names) < 2 or names[0].lower() not in ("t", "time"):
        raise ParameterError(
            "path", f"{where}: the header is '{given}'; expected t,q1,…,qn, or t and the joints' names"
        )
    if "" in names or len(set(names)) != len(names):
        raise ParameterError("path", f"{where}: a column has no name, or two have the same; name each joint once")
    numbered = [f"q{i}" for i in range(1, len(names))]
    if set(names[1:]) == set(numbered) and names[1:] != numbered:
        raise ParameterError("path", f"{where}: the columns are '{given}'; put them in the order q1,…,qn")
    return names


def _numbers(path: Path, line: int, row: list[str], count: int) -> list[float]:
    where = f"{shown(path)}, line {line}"
    if len(row) != count:
        raise ParameterError("path", f"{where}: {len(row)} value(s), but the header names {count} columns")
    values = []
    for cell in row:
        try:
            value = as_number(cell)
        except ValueError:
            raise ParameterError("path", f"{where}: '{printable(cell.strip())}' is not a number") from None
        if not math.isfinite(value):
            given = printable(cell.strip())
            raise ParameterError("path", f"{where}: '{given}' is not finite; remove the row or fill the gap")
        values.append(value)
    return values
