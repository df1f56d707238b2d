"""Configurations per second at which ‖I − M⁻¹M̄‖₂ is evaluated, over those of the plain loop.

    python benchmarks/sampling.py [--arm ur5] [--configurations 100000] [--threads 1 2] [--repeats 5]

The plain loop is what one would write first: `pin.crba`, then `numpy.linalg.norm(I − solve(M, M̄), 2)`. Both work on
the same configurations in one process, in turn; of each the best repeat counts, the one that other programs disturbed
least. The kernels are compiled before the clock starts. BLAS is held to one thread in both.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import platform
from time import perf_counter

import numpy as np
import pinocchio as pin

from asmc_pin import load_arm
from asmc_pin.arms import Arm
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.search.samples import figures_at, sample_box


def plain_loop(arm: Arm, mbar: np.ndarray, q: np.ndarray) -> np.ndarray:
    data, eye, diagonal = arm.model.createData(), np.eye(arm.nv), np.diag(mbar)
    return np.array([np.linalg.norm(eye - np.linalg.solve(pin.crba(arm.model, data, one), diagonal), 2) for one in q])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--arm", default="ur5")
    parser.add_argument("--configurations", type=int, default=100_000)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()

    arm = load_arm(options.arm)
    q = sample_box(resolve_box(arm), options.configurations, seed=0)
    # Any M̄ costs the same; a fifth of the smallest diagonal is about what Lemma 1 allows.
    mbar = 0.2 * np.diagonal(arm.mass_matrix(q[:1000]), axis1=1, axis2=2).min(axis=0)
    few = q[: max(1, options.configurations // 20)]
    expected, found = plain_loop(arm, mbar, few), figures_at(compiled_norms.LEMMA1, arm.tree, few, mbar)
    plain = np.inf
    ours = dict.fromkeys(options.threads, np.inf)
    for _ in range(options.repeats):
        start = perf_counter()
        plain_loop(arm, mbar, few)
        plain = min(plain, (perf_counter() - start) / len(few))
        for threads in options.threads:
            start = perf_counter()
            figures_at(compiled_norms.LEMMA1, arm.tree, q, mbar, threads=threads)
            ours[threads] = min(ours[threads], (perf_counter() - start) / len(q))

    print(f"{arm.name}, {arm.nv} joints, {len(q)} configurations ({len(few)} for the plain loop)")
    print(
        f"Python {platform.python_version()}, Pinocchio {pin.__version__}, {platform.machine()}, {os.cpu_count()} cores"
    )
    print(f"largest difference of the norm, relative: {np.max(np.abs(found - expected) / expected):.1e}")
    print(f"{'plain loop':<14} {plain * 1e6:8.2f} µs   {1 / plain:12,.0f} /s")
    for threads, seconds in ours.items():
        name, times = f"{threads} thread{'s' if threads > 1 else ''}", plain / seconds
        print(f"{name:<14} {seconds * 1e6:8.2f} µs   {1 / seconds:12,.0f} /s   {times:6.1f} times the plain loop")


if __name__ == "__main__":
    main()
