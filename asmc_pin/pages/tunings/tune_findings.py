"""What a tuning found, in the form that its page, tables and figures are made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.experiment import Experiment
from asmc_pin.statistics.paired_ratio import RatioInterval
from asmc_pin.statistics.pairwise import PairedComparison


@dataclass(frozen=True, eq=False)
class TunedController:
    """One controller: what was tried of it, what won, and how that did.

    The figure of a trial is the geometric mean over the joints, SI; +∞ where the run failed.

    Attributes:
        label: Of the file.
        shown: As results show it.
        law: Name of its law.
        start: The gains that are searched, as the file has them.
        setting: The same as they won.
        ranges: Lowest and largest factor on the start by name; empty where nothing could be searched.
        errors: Objective of each candidate on the training draws, in the order of the search; the first is the file's.
        chatters: Torque variation of each, N·m/s (N/s).
        within: Whether each kept the limits in every training trial, and failed in none.
        winner: Number of the candidate that won.
        refused: Candidates that were not run: the law takes no such gains, or they are outside the stable region.
        held_out: Objective of the winner in each held-out trial.
        held_out_start: That of the file's gains in the same trials.
        held_out_chatter: Torque variation of the winner there.
        over: Held-out trials in which the winner exceeds a limit or fails.
        over_start: The same of the file's gains.
        change: Objective of the winner over that of the file's gains, on the held-out trials.
        sensitivity: Gain -> factors on the winner's value, and the objective there over the winner's, training draws.
    """

    label: str
    shown: str
    law: str
    start: Mapping[str, Any]
    setting: Mapping[str, Any]
    ranges: Mapping[str, tuple[float, float]]
    errors: Array
    chatters: Array
    within: BoolArray
    winner: int
    refused: int
    held_out: Array
    held_out_start: Array
    held_out_chatter: Array
    over: int
    over_start: int
    change: RatioInterval
    sensitivity: Mapping[str, tuple[Array, Array]]

    @property
    def trials(self) -> int:
        """Candidates that were tried: the budget, or one where there is nothing to search."""
        return len(self.errors)

    @property
    def keeps_limits(self) -> bool:
        """Whether the winner kept the limits in training."""
        return bool(self.within[self.winner])

    @property
    def failed(self) -> int:
        """Held-out trials in which the winner failed."""
        return int(np.sum(~np.isfinite(self.held_out)))

    def front(self) -> Array:
        """Numbers of the candidates that no other beats in both error and chatter, by rising chatter."""
        order = np.lexsort((self.errors, self.chatters))
        kept, least = [], np.inf
        for i in order:
            if self.errors[i] < least:
                kept.append(int(i))
                least = self.errors[i]
        return np.array(kept, dtype=np.int64)

    def convergence(self) -> Array:
        """Least error among the candidates within the limits up to each; +∞ before the first of them."""
        return np.asarray(np.minimum.accumulate(np.where(self.within, self.errors, np.inf)))


@dataclass(frozen=True, eq=False)
class TuneFindings:
    """The figures of a complete tuning.

    Attributes:
        experiment: As tuned.
        objective: What was made small, and the limits, in words.
        budget: Candidates of each controller.
        points: Trials of a draw.
        controllers: In the order of the file.
        comparisons: Pairs of tuned controllers on the held-out draws; a draw counts once.
        kinds: Of the joints, ``"revolute"`` and ``"prismatic"``.
    """

    experiment: Experiment
    objective: str
    budget: int
    points: int
    controllers: Sequence[TunedController]
    comparisons: Sequence[PairedComparison]
    kinds: frozenset[str]
