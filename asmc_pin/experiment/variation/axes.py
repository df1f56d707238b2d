"""The axes of a sweep: one key of the experiment each, drawn at random, on a grid, or scanned up to failure."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from asmc_pin.experiment.variation.draws import Distribution, draw_generator, is_finite
from asmc_pin.experiment.variation.key_paths import MISSING, Parts, value_at, with_value


@dataclass(frozen=True)
class VariedKey:
    """One key that varies.

    Attributes:
        path: Of the key, as ``[sweep]`` has it.
        parts: The same, taken apart.
        factor: Whether what varies multiplies the file's own value.
        draw: Its distribution; None where it is no random axis.
        values: Of a grid; empty where it is none.
        follows: Path of the grid whose steps this one goes along with; None for a grid of its own.
        scan: Ends of a scan; None where it is none.
        until: Metric -> figure beyond which a run of the scan counts as failed, beside one that diverged.
    """

    path: str
    parts: Parts
    factor: bool = False
    draw: Distribution | None = None
    values: tuple[Any, ...] = ()
    follows: str | None = None
    scan: tuple[float, float] | None = None
    until: Mapping[str, float] = field(default_factory=dict)

    @property
    def numeric(self) -> bool:
        """Whether results have a column of numbers for it."""
        return all(is_finite(value) for value in self.values)

    @property
    def leading(self) -> bool:
        """Whether it is a grid that spans points of its own."""
        return bool(self.values) and self.follows is None

    def concerns(self, label: str) -> bool:
        """Whether what a controller does may depend on it; a key of one controller is nothing to the others."""
        return self.parts[0] != "controllers" or self.parts[1:2] == (label,)

    def rest(self, data: Mapping[str, Any]) -> Any:
        """What it stands at where it does not vary: the factor 1, or the file's own value."""
        return 1.0 if self.factor else value_at(data, self.parts)

    def drawn(self, data: Mapping[str, Any], seed: int, number: int) -> Any:
        """What a draw gives.

        Raises:
            ValueError: hardly any draw lies within the bounds.
        """
        assert self.draw is not None
        own = value_at(data, self.parts)
        listed = isinstance(own, list) and (self.draw.each or (self.draw.centre is None and not self.factor))
        about = [1.0] * len(own) if listed and self.factor else own if listed else [1.0 if self.factor else own]
        if self.draw.centre is not None:
            about = [0.0] * len(about)  # the file's own value has no part in it, and may be missing
        found = self.draw.numbers(draw_generator(seed, number, self.path), about)
        if found is None:
            at = "" if self.draw.centre is not None else f", at the file's own value {own!r}"
            raise ValueError(f"of 10000 draws none lies within its bounds{at}")
        return found if listed else found[0]

    def placed(self, data: Mapping[str, Any], quantity: Any) -> Any:
        """The tables with a quantity of this axis in its place."""
        value = _times(value_at(data, self.parts), quantity) if self.factor else quantity
        return with_value(data, self.parts, value)


def _times(value: Any, factor: Any) -> Any:
    if isinstance(factor, list):
        return [_times(item, number) for item, number in zip(value, factor, strict=True)]
    return [_times(item, factor) for item in value] if isinstance(value, list) else value * factor


@dataclass(frozen=True)
class Variation:
    """All axes of an experiment, and the points that its grids and scans span.

    Point by point: the grids' product first, the last grid running fastest, then one for each scan, where the grids
    stand at rest. A trial is one draw at one point: ``trial = draw · points + point``, so that more draws add trials
    and renumber none. A draw has the same random numbers at every point.

    Attributes:
        data: The experiment's tables, without ``[sweep]``.
        axes: In the order of the file.
        seed: Seed of the experiment.
    """

    data: Mapping[str, Any]
    axes: tuple[VariedKey, ...]
    seed: int

    @property
    def grids(self) -> tuple[VariedKey, ...]:
        """Grids with points of their own."""
        return tuple(axis for axis in self.axes if axis.leading)

    @property
    def scans(self) -> tuple[VariedKey, ...]:
        """Axes that are scanned up to failure."""
        return tuple(axis for axis in self.axes if axis.scan is not None)

    @property
    def grid_points(self) -> int:
        """Points of the grids' product; 1 without a grid."""
        return math.prod(len(axis.values) for axis in self.grids)

    @property
    def points(self) -> int:
        """All points, those of the scans too."""
        return self.grid_points + len(self.scans)

    def place_of(self, trial: int) -> tuple[int, int]:
        """Point and draw of a trial."""
        draw, point = divmod(trial, self.points)
        return point, draw

    def scan_at(self, point: int) -> VariedKey | None:
        """The axis that is scanned at a point; None at one of the grids."""
        return self.scans[point - self.grid_points] if point >= self.grid_points else None

    def quantities(self, trial: int) -> dict[str, Any]:
        """What every axis stands at in a trial, by path; the start of a scan for the axis that is scanned there.

        Raises:
            ValueError: a draw finds no value within its bounds; says of which key.
        """
        point, draw = self.place_of(trial)
        scanned = self.scan_at(point)
        steps: dict[str, int] = {}
        if scanned is None:
            ranges = [range(len(axis.values)) for axis in self.grids]
            index = next(itertools.islice(itertools.product(*ranges), point, None))
            steps = {axis.path: step for axis, step in zip(self.grids, index, strict=True)}
        found: dict[str, Any] = {}
        for axis in self.axes:
            if axis.draw is not None:
                try:
                    found[axis.path] = axis.drawn(self.data, self.seed, draw)
                except ValueError as error:
                    raise ValueError(f'sweep."{axis.path}": {error}') from None
            elif axis is scanned and axis.scan is not None:
                found[axis.path] = axis.scan[0]
            elif (leader := axis.follows or axis.path) in steps:
                found[axis.path] = axis.values[steps[leader]]
            else:
                found[axis.path] = axis.rest(self.data)
        return found

    def tables(self, quantities: Mapping[str, Any]) -> dict[str, Any]:
        """The experiment's tables with these quantities in their places."""
        data = dict(self.data)
        for axis in self.axes:
            value = quantities[axis.path]
            if value is not MISSING and not (axis.factor and value == 1.0):
                data = axis.placed(data, value)
        return data


def as_column(axis: VariedKey, quantity: Any, joints: int) -> Sequence[float] | Sequence[str | None]:
    """A quantity as results show it, one value for each joint.

    A number stands in every joint's row, a list with one for each joint in its own. A list of another length is no
    figure of a joint: NaN. What is not all numbers is text, None where the file has no value of its own.
    """
    if not axis.numeric:
        if quantity is MISSING:
            return [None] * joints
        return [quantity if isinstance(quantity, str) else json.dumps(quantity, ensure_ascii=False)] * joints
    if isinstance(quantity, list):
        return [float(item) for item in quantity] if len(quantity) == joints else [math.nan] * joints
    return [float(quantity) if is_finite(quantity) else math.nan] * joints
