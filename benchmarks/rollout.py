"""Wall time of a rollout over that of the bare dynamics: as many `pin.abaInParallel` calls on the same batch.

    python benchmarks/rollout.py [--batches 1 16 256] [--threads 1] [--repeats 7]

The rollout is a UR5 under the proposed law with two substeps per control period of 1 ms: law, torque limits, check for
divergence, dynamics, mass matrix, friction solver, integration and log. "friction" has Coulomb and viscous friction in
every joint and ideal drives and sensors; "full" has a Stribeck curve too, drives with delay, current loop and speed
limits, and encoders with noise, a filter and a delay. The baseline calls Pinocchio alone, on arrays made beforehand, as
often as the rollout does. Both are timed in turn in one process, and of each the best repeat counts: the one that other
programs disturbed least.
"""

from __future__ import annotations

import argparse
import platform
from time import perf_counter

import numpy as np
import pinocchio as pin

from asmc_pin import Plant, Rollout, load_arm, rollout
from asmc_pin.controllers import Baek2016
from asmc_pin.plant import Drive, Friction, Sensor
from asmc_pin.references import Multisine

PERIOD = 1e-3  # s
SUBSTEPS = 2
ARM = load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
FRICTION = Friction(coulomb=[8.0, 8.0, 5.0, 2.0, 2.0, 1.0], viscous=[1.0, 1.0, 1.0, 0.2, 0.2, 0.1])
PLANTS = {
    "friction": {"friction": FRICTION},
    "full": {
        "friction": Friction(FRICTION.coulomb, FRICTION.viscous, breakaway=1.4 * FRICTION.coulomb),
        "drive": Drive(delay=0.6, current_hz=400.0, velocity_limit=4.0, corner_speed=3.5, no_load_speed=5.0),
        "sensor": Sensor(
            bits=20, position_noise=1e-7, velocity="filter", filter_hz=200.0, torque_noise=0.01, delay=0.25
        ),
    },
}
LAW = Baek2016(
    mbar=[0.6228, 0.8771, 0.6488, 0.2616, 0.2080, 0.0198],
    ks=8.0,
    beta=8.0,
    period=PERIOD,
    phi=800.0,
    alpha=0.03,
    epsilon=0.01,
)
REFERENCE = Multisine(
    offset=[0.0, -1.3, 1.6, -1.2, -1.4, 0.0],
    amplitude=[0.7, 0.35, 0.4, 0.5, 0.5, 0.8],
    frequency=[0.5, 0.6, 0.5, 0.7, 0.6, 0.8],
)


def bare_dynamics(run: Rollout, calls: int, threads: int) -> float:
    """Seconds that Pinocchio takes for `calls` forward dynamics of the batch, at the run's last states."""
    q, v, torque = (np.ascontiguousarray(x[:, -1]) for x in (run.q, run.v, run.torque))
    out = np.empty_like(q)
    pool = pin.ModelPool(ARM.model, threads)
    start = perf_counter()
    for _ in range(calls):
        pin.abaInParallel(threads, pool, q.T, v.T, torque.T, out.T)
    return perf_counter() - start


def measure(plant: Plant, batch: int, threads: int, repeats: int) -> tuple[float, float]:
    """Microseconds per step of a rollout, and of the bare dynamics."""
    duration = 0.8 if batch < 64 else 0.25
    threads = max(1, min(threads, batch // 8))
    taken, bare = [], []
    for _ in range(repeats):
        start = perf_counter()
        run = rollout(plant, LAW, REFERENCE, duration, batch=batch)
        taken.append(perf_counter() - start)
        assert set(run.status) == {"ok"}
        steps = SUBSTEPS * len(run.time)
        bare.append(bare_dynamics(run, steps, threads))
    return 1e6 * min(taken) / steps, 1e6 * min(bare) / steps


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--batches", type=int, nargs="+", default=[1, 16, 256])
    parser.add_argument("--threads", type=int, default=1, help="for Pinocchio, in both")
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()

    plants = {name: Plant(ARM, substeps=SUBSTEPS, threads=options.threads, **parts) for name, parts in PLANTS.items()}
    for plant in plants.values():
        rollout(plant, LAW, REFERENCE, 0.05, batch=2)  # compile, or load from the cache
    print(f"UR5, {SUBSTEPS} substeps of {PERIOD / SUBSTEPS * 1e3:g} ms, {options.threads} thread(s);", end=" ")
    print(f"pin {pin.__version__}, numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    print("Baseline: the same number of bare pin.abaInParallel calls, in the same run. Best of", options.repeats)
    header = ("plant", "batch", "rollout, µs/step", "baseline, µs/step", "ratio", "µs/step/trial")
    print("{:>9} {:>6} {:>17} {:>18} {:>6} {:>14}".format(*header))
    for name, plant in plants.items():
        for batch in options.batches:
            step, base = measure(plant, batch, options.threads, options.repeats)
            print(f"{name:>9} {batch:>6} {step:>17.1f} {base:>18.1f} {step / base:>6.2f} {step / batch:>14.2f}")


if __name__ == "__main__":
    main()
