"""What a rollout costs over bare dynamics: the processor time of a run over that of as many `pin.abaInParallel` calls.

    python benchmarks/rollout.py [--repeats 7] [--scaling] [--readme]

A run is a UR5 under a law at 1 kHz with one integration step per period, every tick logged: law, torque limits, check
for divergence, dynamics, friction, integration, log, and all that a `rollout` does before and after. The baseline calls
Pinocchio's forward dynamics alone, on arrays made beforehand, once per tick and trial. Both are measured in one process
on one thread, in processor time, which other programs disturb less than the clock; of each the best repeat counts.

"numpy law" is the same law with its adaptation written in numpy, as a user's own would be, asked tick by tick. "full"
has a Stribeck curve, drives with delay, current loop and speed limits, and encoders with noise, a filter and a delay.

Beside them stand MuJoCo's on the same arm, without friction and law: a Python loop round `mj_step`, and its `rollout`
in C, open loop; and Drake's `Simulator` with a `LeafSystem` in Python. They are left out, and that is said, where they
are not installed.

With ``--scaling``: cost against batch, horizon, joints and log rate, drawn into docs/images/rollout_scaling.png, and
what a second thread brings; that by the clock, so it wants idle processors. ``--readme`` writes the tables, and says
that they were measured on idle processors.
"""

from __future__ import annotations

import argparse
import platform
import re
from pathlib import Path

import numpy as np
import pinocchio as pin
from rollout_parts.cases import PERIOD, bare, ours, step_alone
from rollout_parts.peers import drake_loop, mujoco_loop, mujoco_rollout
from rollout_parts.scaling import drawn, scaling, scaling_lines, threads_gain

from asmc_pin.errors import MissingDependencyError

README = Path(__file__).with_name("README.md")
FIGURE = README.parent.parent / "docs" / "images" / "rollout_scaling.png"
GOALS = {
    **{("frictionless", "baek2016", batch): goal for batch, goal in ((1, 1.0), (16, 0.7), (256, 0.65), (1024, 0.65))},
    **{("friction", "baek2016", batch): goal for batch, goal in ((1, 1.2), (16, 0.8), (256, 0.8), (1024, 0.85))},
    **{("friction", "numpy law", batch): goal for batch, goal in ((1, 11.0), (16, 1.9), (256, 0.8))},
    ("full", "baek2016", 256): 1.3,
}
"""The largest ratio that a row is to have."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument(
        "--scaling", action="store_true", help="cost against batch, horizon, joints, log rate, threads too"
    )
    parser.add_argument("--readme", action="store_true", help="replace the tables of benchmarks/README.md")
    options = parser.parse_args()
    repeats = options.repeats

    print(f"UR5, 1 step of {PERIOD * 1e3:g} ms per period; processor time, best of {repeats};", end=" ")
    print(f"pin {pin.__version__}, numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    print(
        "{:>14} {:>10} {:>6} {:>14} {:>13} {:>6}".format(
            "plant", "law", "batch", "µs/trial/tick", "bare aba, µs", "ratio"
        )
    )
    rows = [(plant, "baek2016", batch) for batch in (1, 16, 256, 1024) for plant in ("frictionless", "friction")]
    rows += [("friction", "numpy law", batch) for batch in (1, 16, 256)]
    rows += [("full", "baek2016", batch) for batch in (1, 16, 256)]
    table = [
        "| plant | law | batch | µs per trial and tick | baseline, µs | ratio | goal |",
        "| --- | --- | ----: | --------------------: | -----------: | ----: | ---: |",
    ]
    for plant, law, batch in rows:
        base = bare(batch, repeats)
        cost = ours(plant, law, batch, repeats)
        base = min(base, bare(batch, repeats))
        print(f"{plant:>14} {law:>10} {batch:>6} {cost:>14.2f} {base:>13.2f} {cost / base:>6.2f}", flush=True)
        goal = f"{GOALS[plant, law, batch]:g}" if (plant, law, batch) in GOALS else ""
        table.append(f"| {plant} | {law} | {batch} | {cost:.2f} | {base:.2f} | {cost / base:.2f} | {goal} |")
        if law == "numpy law":
            alone = step_alone(batch, repeats)
            print(f"{'':>14} its step {batch:>7} {alone:>14.2f} {'':>13} {alone / base:>6.2f}", flush=True)
            table.append(f"| none | its step alone | {batch} | {alone:.2f} | {base:.2f} | {alone / base:.2f} |  |")
    try:
        loop, rolled = mujoco_loop(repeats), mujoco_rollout(256, repeats)
        one, many = loop / bare(1, repeats), rolled / bare(256, repeats)
        print(f"Python loop round mj_step: {loop:.2f} µs per tick, {one:.2f} of bare aba at batch 1")
        print(f"mujoco.rollout, open loop, 256: {rolled:.2f} µs, {many:.2f} of bare aba there")
        table += [
            f"| none | MuJoCo, Python loop round `mj_step` | 1 | {loop:.2f} | {loop / one:.2f} | {one:.2f} |  |",
            f"| none | MuJoCo, `rollout` in C, open loop | 256 | {rolled:.2f} | {rolled / many:.2f} | {many:.2f} |  |",
        ]
    except MissingDependencyError as error:
        print(f"MuJoCo left out: {error}")
    try:
        loop = drake_loop(repeats)
        one = loop / bare(1, repeats)
        print(f"Drake, Simulator with a Python LeafSystem: {loop:.2f} µs per tick, {one:.2f} of bare aba at batch 1")
        row = f"| {loop:.2f} | {loop / one:.2f} | {one:.2f} |  |"
        table.append(f"| none | Drake, `Simulator` with a Python `LeafSystem` | 1 {row}")
    except ImportError as error:
        print(f"Drake left out, it is not installed: {error}")
    if options.readme:
        write_readme("rollout", table)
    if options.scaling:
        found = scaling(repeats)
        lines = scaling_lines(found, threads_gain(repeats))
        print(*lines, sep="\n")
        drawn(found, FIGURE)
        print(f"drawn: {FIGURE}")
        if options.readme:
            write_readme("rollout-scaling", lines)


def write_readme(name: str, lines: list[str]) -> None:
    """Replace what stands between two marks."""
    pattern = re.compile(rf"(<!-- from here: {name} -->\n).*?(<!-- to here: {name} -->)", re.DOTALL)
    text, rows = README.read_text(encoding="utf-8"), "\n".join(lines)
    README.write_text(pattern.sub(lambda found: f"{found[1]}{rows}\n{found[2]}", text), encoding="utf-8")


if __name__ == "__main__":
    main()
