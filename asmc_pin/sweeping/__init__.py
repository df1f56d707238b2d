"""Sweeps: many trials of an experiment, whose plants, motions and gains vary as ``[sweep]`` says (docs/sweeps.md).

Takes an experiment and a number of draws; gives rows in Parquet, comparisons and a page. May import all rooms but
`reproduction` and `cli`; processes for the workers are started here alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.sweeping.sweep_result import Sweep as Sweep
    from asmc_pin.sweeping.sweep_verb import sweep as sweep

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
