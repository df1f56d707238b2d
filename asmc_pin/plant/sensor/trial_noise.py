"""Random numbers that belong to a trial, not to the batch it happens to run in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from asmc_pin._typing import Array

# What a stream of random numbers is for. Part of the seed, so that a new kind never shifts the numbers of another.
SENSOR, DISTURBANCE, SPREAD, START, SWEEP = range(5)

# Ticks drawn at once. A generator gives the same numbers in whatever portions they are drawn.
BLOCK = 64


def generator(seed: int, trial: int, *stream: int) -> np.random.Generator:
    """The generator of one trial and one purpose.

    Args:
        seed: Seed of the experiment.
        trial: Number of the trial in the study, whatever the batch or worker it runs in.
        stream: What it is for: one of the constants of this module, and any further numbers.
    """
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(trial, *stream)))


class NormalNoise:
    """Standard normal numbers, one row per trial and tick.

    Args:
        seed: Seed of the experiment.
        trials: Number of each trial of the batch.
        width: Numbers per trial and tick.
        stream: What they are for, see `generator`.
    """

    def __init__(self, seed: int, trials: Sequence[int], width: int, *stream: int) -> None:
        self._generators = [generator(seed, trial, *stream) for trial in trials]
        self._block = np.empty((len(self._generators), BLOCK, width))
        self._used = BLOCK

    def next(self) -> Array:
        """The numbers of the next tick, shape (batch, width)."""
        return self.ahead(1)[:, 0]

    def ahead(self, ticks: int) -> Array:
        """The numbers of the next ticks, shape (batch, ticks, width)."""
        batch, _, width = self._block.shape
        numbers = np.empty((batch, ticks, width))
        done = 0
        while done < ticks:
            if self._used == BLOCK:
                for source, rows in zip(self._generators, self._block, strict=True):
                    source.standard_normal(out=rows)
                self._used = 0
            part = min(ticks - done, BLOCK - self._used)
            numbers[:, done : done + part] = self._block[:, self._used : self._used + part]
            done, self._used = done + part, self._used + part
        return numbers
