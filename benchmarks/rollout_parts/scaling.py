"""How the cost of a rollout grows: against batch, horizon, joints and log rate; and what a second thread brings."""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from asmc_pin import Arm, Plant, load_arm, rollout
from asmc_pin.controllers import Ppc
from asmc_pin.plant import Friction
from asmc_pin.references import Multisine
from rollout_parts.cases import ARM, FRICTION, LAWS, PERIOD, REFERENCE, best, ours


def chain(joints: int, folder: Path) -> Arm:
    """A chain of equal links that turn about x, y, z and so on."""
    axes = ("1 0 0", "0 1 0", "0 0 1")
    text = '<link name="link0"/>'
    for k in range(joints):
        text += (
            f'<link name="link{k + 1}"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>'
            '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
            f'<joint name="joint{k}" type="continuous"><origin xyz="0 0 0.2"/><parent link="link{k}"/>'
            f'<child link="link{k + 1}"/><axis xyz="{axes[k % 3]}"/></joint>'
        )
    path = folder / f"chain{joints}.urdf"
    path.write_text(f'<robot name="chain">{text}</robot>')
    return load_arm(path)


LOGGED = "log_every, batch 256"


def scaling(repeats: int) -> dict[str, dict[int, float]]:
    """How the cost grows, µs per trial and tick: against batch, horizon in ticks, joints, and ticks to a logged one."""
    found = {"batch": {b: ours("friction", "baek2016", b, repeats) for b in (1, 4, 16, 64, 256, 1024)}}
    world = Plant(ARM, substeps=1, friction=FRICTION)
    found["ticks, batch 1"] = {}
    for ticks in (250, 1000, 4000, 16000):
        span = (ticks - 1) * PERIOD
        seconds = best(lambda span=span: rollout(world, LAWS["baek2016"], REFERENCE, span), repeats)
        found["ticks, batch 1"][ticks] = 1e6 * seconds / ticks
    found["joints, batch 16"] = {}
    with tempfile.TemporaryDirectory() as folder:
        for joints in (2, 4, 7, 12, 20, 30):
            arm = chain(joints, Path(folder))
            law = Ppc(mbar=0.01, ks=5.0, beta=5.0, period=PERIOD)
            still = Multisine(offset=np.zeros(joints), amplitude=np.full(joints, 1e-3), frequency=np.ones(joints))
            plant = Plant(arm, substeps=1, friction=Friction(0.1, 0.1))
            seconds = best(lambda p=plant, r=still, law=law: rollout(p, law, r, 0.4, batch=16), repeats)
            found["joints, batch 16"][joints] = 1e6 * seconds / 401 / 16
    found[LOGGED] = {}
    for every in (1, 2, 5, 10, 100):
        seconds = best(
            lambda n=every: rollout(world, LAWS["baek2016"], REFERENCE, 0.999, batch=256, log_every=n), repeats
        )
        found[LOGGED][every] = 1e6 * seconds / 1000 / 256
    return found


def scaling_lines(found: dict[str, dict[int, float]], gain: float) -> list[str]:
    """The same as lines of a Markdown table, and what two threads brought."""
    lines = ["| against | µs per trial and tick |", "| --- | --- |"]
    for name, costs in found.items():
        lines.append(f"| {name} | " + ", ".join(f"{n:,}: {cost:.2f}" for n, cost in costs.items()) + " |")
    return [*lines, "", f"Two threads were {gain:.2f} times as fast as one, batch 1024, by the clock."]


def threads_gain(repeats: int) -> float:
    """How much faster two threads are than one, batch 1024, by the clock."""
    clocked = {}
    for threads in (1, 2):
        world = Plant(ARM, substeps=1, friction=FRICTION, threads=threads)
        clocked[threads] = best(
            lambda w=world: rollout(w, LAWS["baek2016"], REFERENCE, 0.2, batch=1024), repeats, perf_counter
        )
    return clocked[1] / clocked[2]


def drawn(found: dict[str, dict[int, float]], path: Path) -> None:
    """The scaling as a figure; where joints vary, the line is proportional to the first cost times joints."""
    import matplotlib.pyplot as plt

    from asmc_pin.pages.figure_style import GREY, PAGE, paper_style

    with paper_style():
        figure, axes = plt.subplots(1, len(found), figsize=(PAGE, 2.0), layout="constrained")
        for axis, (name, costs) in zip(axes, found.items(), strict=True):
            axis.loglog(list(costs), list(costs.values()), "o-", color="#1F77B4", markersize=3)
            axis.set_xlabel(name)
            if name.startswith("joints"):
                first = next(iter(costs))
                axis.loglog(list(costs), [costs[first] * n / first for n in costs], "--", color=GREY, label="linear")
                axis.legend()
            axis.set_ylim(0.1, 20.0)
            axis.set_xticks(list(costs), [f"{n:,}" for n in costs])
            axis.set_yticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
            axis.minorticks_off()
        axes[0].set_ylabel("µs per trial and tick")
        figure.savefig(path, metadata={"Software": None})
