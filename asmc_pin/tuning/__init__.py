"""Fair tuning: gains of every controller searched with the same budget, and judged on draws that none was tuned on.

Takes an experiment with ``[tune]`` and ``[sweep]``; gives the experiment with the best gains, how they were found and a
page (docs/tuning.md). May import all rooms but `reproduction` and `cli`; Optuna lives here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.tuning.tune_result import Tuned as Tuned
    from asmc_pin.tuning.tune_verb import tune as tune

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
