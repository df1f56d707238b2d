"""With compilation off a law's step is a plain function, and so is what calls it: an address is the function itself.

A pytest plugin, to be loaded before the plant is; it does nothing where compilation is on.
"""

from __future__ import annotations

import os
from typing import Any

from asmc_pin.controllers.one_trial import trial_step


def _run_at(step: Any, tick: Any, law: Any, memory: Any, work: Any, command: Any) -> None:
    step(tick, law, memory, work, command)


if os.environ.get("NUMBA_DISABLE_JIT") == "1":
    trial_step.run_at = _run_at
    trial_step.TrialStep.address = property(lambda step: step.function)  # type: ignore[assignment]
