"""Which arms move, or may move, in a run: what is carried in each phase, and how far the links scatter.

A verdict on "the arm" of an experiment is a verdict on all of them; one that looks at the arm of t = 0 vouches for a
motion that it never saw.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from asmc_pin.arms import Arm
from asmc_pin.plant.plant_parameters import PlantParameters
from asmc_pin.plant.world.spread import END, Spread
from asmc_pin.plant.world.world_parameters import PayloadChange


@dataclass(frozen=True, eq=False)
class MovingArm:
    """One arm that moves, or may move, in a part of a run.

    Attributes:
        arm: With what it carries there.
        start: Control tick from which on it is the one.
        end: Control tick at which another takes over; None to the end.
        period: L, s.
        links: How its links are scattered, in words; empty for those of the URDF.
    """

    arm: Arm
    start: int
    end: int | None
    period: float
    links: str = ""

    @property
    def ticks(self) -> slice:
        """Ticks of the run in which it moves."""
        return slice(self.start, self.end)

    @property
    def span(self) -> tuple[float, float]:
        """The same in s; the end is inf where it is that of the run."""
        return self.start * self.period, math.inf if self.end is None else self.end * self.period

    @property
    def when(self) -> str:
        """The same in words; empty for the whole run."""
        start, end = self.span
        if self.end is None:
            return f"from {start:.6g} s on" if self.start else ""
        return f"from {start:.6g} to {end:.6g} s" if self.start else f"until {end:.6g} s"

    @property
    def words(self) -> str:
        """When, and with which links; empty where it is the one arm of the run."""
        empty = self.arm.payload is None or self.arm.payload.mass == 0.0
        emptied = "carrying nothing" if self.when and empty else ""
        return ", ".join(part for part in (self.when, emptied, self.links) if part)


def moving_arms(plant: PlantParameters, period: float, duration: float) -> list[MovingArm]:
    """Every arm of a run of the plant's first trial, and both ends of its scatter.

    Args:
        plant: What is simulated.
        period: L, s.
        duration: Of the run, s.

    Returns:
        Phase by phase, in order of time: the arm as it is drawn for the trial that is run, and with a `Spread` the arms
        at its two ends.
    """
    arms = {"": plant.arm}
    if plant.spread is not None and plant.spread.moves_links:
        numbers = plant.numbered([0])
        drawn = plant.spread.arms((plant.arm,), plant.seed, numbers)[0]
        arms = {f"links as drawn for trial {numbers[0]}": drawn, **_ends(plant.spread, plant.arm)}
    found = []
    for start, end, changes in _phases(plant, period, round(duration / period)):
        for links, arm in arms.items():
            carrying = arm
            for change in changes:
                carrying = change.arms((carrying,))[0]
            found.append(MovingArm(carrying, start, end, period, links))
    return found


def _ends(spread: Spread, arm: Arm) -> dict[str, Arm]:
    light, heavy = spread.ends(arm)
    about = f"all links {END:g} standard deviations"
    sides = (("lighter", "heavier"), ("smaller", "larger"), ("nearer", "further out"))
    scatters = [pair for pair, size in zip(sides, (spread.mass, spread.inertia, spread.com), strict=True) if size]
    low, high = (" and ".join(pair[end] for pair in scatters) for end in (0, 1))
    return {f"{about} {low}": light, f"{about} {high}": heavy}


def _phases(
    plant: PlantParameters, period: float, ticks: int
) -> Iterator[tuple[int, int | None, tuple[PayloadChange, ...]]]:
    """First tick, tick of the next phase or None, and the changes made so far; a phase that has no tick is left out."""
    at = [round(change.time / period) for change in plant.payload_changes]
    starts = sorted({0, *(tick for tick in at if tick < ticks)})
    for start, end in pairwise([*starts, None]):
        assert start is not None
        made = sum(tick <= start for tick in at)
        yield start, end, plant.payload_changes[:made]
