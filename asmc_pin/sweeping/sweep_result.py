"""What `sweep` hands back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from asmc_pin.experiment import Experiment


@dataclass(frozen=True)
class Sweep:
    """A complete sweep, and where it lies."""

    experiment: Experiment
    out: Path
    trials: int
