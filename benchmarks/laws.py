"""What a step of each law costs per trial, beside Pinocchio's forward dynamics of the same batch.

    python benchmarks/laws.py [--seconds 0.2] [--readme]

Laws have the values that their cards suggest, six joints; those that know the model have that of the UR5. The ratio is
to bare `pin.abaInParallel` of the UR5 on arrays made beforehand, timed just before and after the law. A step called
from Python copies the sample and the state; within a run the same machine code is called tick by tick without that.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import numba
import numpy as np
import pinocchio as pin

from asmc_pin import load_arm
from asmc_pin.baselines import BASELINES, MARK
from asmc_pin.baselines.model_card import suggested_model_law
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.controllers.law_card import cost_per_tick, suggested

BATCHES = (1, 256)
ARM = load_arm("ur5")
README = Path(__file__).with_name("README.md")


def bare(batch: int, seconds: float) -> float:
    """Processor time of the forward dynamics per trial, s: the best of a few rounds."""
    pool = pin.ModelPool(ARM.model, 1)
    q, v, torque = (np.asfortranarray(x) for x in np.random.default_rng(0).uniform(-1.0, 1.0, (3, ARM.nv, batch)))
    best, end = np.inf, process_time() + seconds
    while process_time() < end:
        begin = process_time()
        for _ in range(10):
            pin.abaInParallel(1, pool, q, v, torque)
        best = min(best, (process_time() - begin) / (10 * batch))
    return best


def laws() -> Iterator[tuple[str, Any]]:
    """Every law of the package by what the table calls it."""
    for name, law in CONTROLLERS.items():
        yield f"`{name}`", suggested(law)
    for name in BASELINES:
        yield f"`{name}` ({MARK})", suggested_model_law(name, ARM)


def row(law: Any, seconds: float) -> list[str]:
    """Time in µs and ratio, for each batch."""
    cells = []
    for batch in BATCHES:
        before = bare(batch, seconds)
        cost = cost_per_tick(law, batch, ARM.nv, seconds)
        reference = min(before, bare(batch, seconds))
        cells += [f"{1e6 * cost:.2f}", f"{cost / reference:.2f}"]
    return cells


def main() -> None:
    """Measure, print, and with --readme replace the table of benchmarks/README.md."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=0.2, help="length of a round")
    parser.add_argument("--readme", action="store_true", help="replace the table of benchmarks/README.md")
    options = parser.parse_args()
    lines = [
        "| law | " + " | ".join(f"batch {n}, µs | over bare dynamics" for n in BATCHES) + " |",
        "| --- |" + " ---: | ---: |" * len(BATCHES),
    ]
    print(*lines, sep="\n", flush=True)
    for name, law in laws():
        lines.append(f"| {name} | {' | '.join(row(law, options.seconds))} |")
        print(lines[-1], flush=True)
    if options.readme:
        state = (
            f"State ({os.cpu_count()} cores, {platform.machine()}, load {os.getloadavg()[0]:.0f}; processor time, best "
            f"of the rounds of {options.seconds:g} s; numba {numba.__version__}):"
        )
        made = "\n".join(["<!-- from here: laws -->", state, "", *lines, "<!-- to here: laws -->"])
        text = README.read_text(encoding="utf-8")
        pattern = re.compile(r"<!-- from here: laws -->.*?<!-- to here: laws -->", re.DOTALL)
        README.write_text(pattern.sub(lambda _: made, text), encoding="utf-8")


if __name__ == "__main__":
    main()
