"""The table of docs/export.md: every law on every target that the C goes to, and how far that is from Python at most.

    python benchmarks/export_targets.py            # prints it, and puts it into docs/export.md

Needs gcc, g++, clang and the extra agree (MuJoCo). On the demo's arm; differences are of torques, N·m, at any tick.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import asmc_pin
from asmc_pin import CONTROLLERS, Experiment, Sample, Setpoint
from asmc_pin.agreement.mujoco_model import Twin
from asmc_pin.disk.files import write_whole

ROOT = Path(__file__).resolve().parent.parent
STUBS = ROOT / "tests" / "codegen" / "ros2_stubs"
BEGIN, END = "<!-- targets: python benchmarks/export_targets.py -->\n", "<!-- end of targets -->"
EXACT = ["-O2", "-ffp-contract=off"]
TICKS = 250
HEAD = ["law", "gcc", "clang", "C++", "float", "Python", "MuJoCo", "ros2_control stub"]


def runner(folder: Path, *compiler: str) -> float:
    """Largest difference that the runner of an export finds along its recorded ticks."""
    files = ["demo_it.c", "demo_it_runner.c"]
    subprocess.run([*compiler, *EXACT, *files, "-o", "run", "-xnone", "-lm"], cwd=folder, check=True)
    done = subprocess.run(["./run", "demo_it_vectors.csv"], cwd=folder, check=True, capture_output=True, text=True)
    return float(done.stdout.split()[-1])


def stub(folder: Path) -> float:
    """Largest difference of the plugin's commands from those of the C alone, in the stand-ins of the tests."""
    text = (STUBS / "drive.cpp").read_text().replace("short_it", "demo_it").replace("SHORT_IT", "DEMO_IT")
    (folder / "drive.cpp").write_text(text)
    subprocess.run(["gcc", "-std=c99", *EXACT, "-c", "demo_it.c"], cwd=folder, check=True)
    sources = ["demo_it_controller.cpp", "drive.cpp", "demo_it.o"]
    subprocess.run(["g++", "-std=c++17", *EXACT, f"-I{STUBS}", "-I.", *sources, "-o", "drive"], cwd=folder, check=True)
    said = subprocess.run(["./drive"], cwd=folder, check=True, capture_output=True, text=True).stdout
    return float(next(line for line in said.splitlines() if line.startswith("largest")).split()[1])


def in_our_plant(experiment: Experiment, law: Any) -> np.ndarray:
    """Torques of the first ticks in the plant of every comparison."""
    duration = (TICKS - 1) * experiment.period
    run = asmc_pin.rollout(experiment.build_plant(), law, experiment.build_reference(), duration)
    return np.asarray(run.torque[0])


def in_mujoco(experiment: Experiment, command: Callable[..., np.ndarray]) -> np.ndarray:
    """Torques along the experiment's motion in MuJoCo, frictionless."""
    twin, (_, wanted) = Twin(experiment.build_arm()), experiment.setpoints()
    limit = experiment.build_plant().effort_limit
    q, v, torques = wanted.q[0], wanted.v[0], []
    tau = twin.arm.gravity(q)
    for k in range(TICKS):
        tau = np.clip(command(q, v, tau, wanted.q[k], wanted.v[k], wanted.a[k]), -limit, limit)
        torques.append(tau)
        steps = twin.run(q, v, np.array([tau, tau]), 0.5 * experiment.period)
        q, v = steps[0][-1], steps[1][-1]
    return np.array(torques)


def called(law: Any) -> Callable[..., np.ndarray]:
    """A law of the package as a callable of one arm, as an export is one."""
    kept: list[Any] = []

    def command(q: Any, v: Any, tau: Any, *wanted: Any) -> np.ndarray:
        sample = Sample(*(np.array([x]) for x in (q, v, tau)))
        state = kept.pop() if kept else law.init(sample)
        torque, state = law.step(state, sample, Setpoint(*(np.array([x]) for x in wanted)))
        kept.append(state)
        return np.asarray(torque[0])

    return command


def row(experiment: Experiment, folder: Path) -> list[float]:
    """Largest differences of a law on all targets, in the order of the table."""
    asmc_pin.export(experiment, "It", folder / "c", target="ros2_control", torque_rate=np.inf, ramp=0.02)
    asmc_pin.export(experiment, "It", folder / "f", real="float", torque_rate=np.inf)
    law = experiment.build_controllers()["It"]
    found = [runner(folder / "c", "gcc", "-std=c99"), runner(folder / "c", "clang", "-std=c99")]
    found += [runner(folder / "c", "g++", "-xc++", "-std=c++17"), runner(folder / "f", "gcc", "-std=c99")]
    plants = in_our_plant(experiment, law), in_our_plant(experiment, asmc_pin.load_exported(folder / "c"))
    others = in_mujoco(experiment, called(law)), in_mujoco(experiment, asmc_pin.load_exported(folder / "c"))
    return [*found, *(float(np.nanmax(np.abs(a - b))) for a, b in (plants, others)), stub(folder / "c")]


def main() -> None:
    """Print the table and put it into the page."""
    demo = asmc_pin.load_experiment("demo")
    lines = ["| " + " | ".join(HEAD) + " |", "| --- |" + " ---: |" * (len(HEAD) - 1)]
    for law, kind in CONTROLLERS.items():
        own = next((c for c in demo.controllers.values() if c["law"] == law), {"law": law, **kind.typical})
        folder = Path(tempfile.mkdtemp())
        cells = row(demo.replace(controllers={"It": own}), folder)
        shutil.rmtree(folder)
        lines.append(f"| `{law}` | " + " | ".join(f"{x:.1e}" if x else "0" for x in cells) + " |")
        print(lines[-1], flush=True)
    page = ROOT / "docs" / "export.md"
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    write_whole(page, before + BEGIN + "\n" + "\n".join(lines) + "\n\n" + END + rest.split(END, 1)[1])


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()
