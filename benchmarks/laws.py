"""What a step of each law costs per trial, beside Pinocchio's forward dynamics of the same batch.

    python benchmarks/laws.py

Laws have the values that their cards suggest, six joints. The ratio is to bare `pin.abaInParallel` of the UR5 on arrays
made beforehand, timed just before and after the law. A step called from Python copies the sample and the state; within
a run the same machine code is called tick by tick without that.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np
import pinocchio as pin

from asmc_pin import load_arm
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.controllers.law_card import cost_per_tick, suggested

BATCHES = (1, 256)


def bare(batch: int, seconds: float = 0.2) -> float:
    """Time of the forward dynamics per trial, s: the best of a few rounds."""
    arm = load_arm("ur5")
    pool = pin.ModelPool(arm.model, 1)
    q, v, torque = (np.asfortranarray(x) for x in np.random.default_rng(0).uniform(-1.0, 1.0, (3, arm.nv, batch)))
    best, end = np.inf, perf_counter() + seconds
    while perf_counter() < end:
        begin = perf_counter()
        for _ in range(10):
            pin.abaInParallel(1, pool, q, v, torque)
        best = min(best, (perf_counter() - begin) / (10 * batch))
    return best


if __name__ == "__main__":
    print("| law | " + " | ".join(f"batch {n}, µs | over bare dynamics" for n in BATCHES) + " |")
    print("| --- |" + " ---: | ---: |" * len(BATCHES))
    for name, law in CONTROLLERS.items():
        cells = []
        for batch in BATCHES:
            before = bare(batch)
            cost = cost_per_tick(suggested(law), batch)
            reference = min(before, bare(batch))
            cells += [f"{1e6 * cost:.2f}", f"{cost / reference:.2f}"]
        print(f"| `{name}` | {' | '.join(cells)} |")
