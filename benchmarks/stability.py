"""How well the linear map of the sampled loop foretells simulated runs: where they diverge, and how they track.

    python benchmarks/stability.py

First table: the factor on β = k_s = 1 1/s at which runs of the plant near a configuration begin to grow, by bisection
to 0.1 %, over the one at which the map's spectral radius reaches 1. Second table: the RMS tracking error of rollouts of
PPC on a motion of all joints, over the predicted one, by joint. Third: the time that the answers take.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from asmc_pin import Plant, load_arm, rollout
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.controllers import Ppc, Setpoint
from asmc_pin.plant import Friction
from asmc_pin.references import Multisine
from asmc_pin.sampled import SampledLoop, closed_loop, predict_tracking, stability
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.gain_warnings import gain_warnings

PERIOD = 1e-3  # s
UR5 = load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
UR5_MBAR = [0.6228, 0.8771, 0.6488, 0.2616, 0.2080, 0.0198]
UR5_MOTION = Multisine(
    offset=[0.0, -1.3, 1.6, -1.2, -1.4, 0.0],
    amplitude=[0.7, 0.35, 0.4, 0.5, 0.5, 0.8],
    frequency=[0.3, 0.4, 0.5, 0.35, 0.45, 0.6],
    rise=1.0,
)


@dataclass(frozen=True)
class Hold:
    """A set-point q, (nv,)."""

    q: Array
    duration: float = math.inf

    @property
    def nv(self) -> int:
        """Number of joints."""
        return self.q.size

    def evaluate(self, t: Array) -> Setpoint:
        """The set-point at every time."""
        zero = np.zeros((t.size, self.nv))
        return Setpoint(zero + self.q, zero, zero)


def law(loop: SampledLoop) -> Ppc:
    return Ppc(
        mbar=loop.mbar,
        ks=loop.ks,
        beta=float(loop.beta[0]),
        period=loop.period,
        acceleration=loop.acceleration,
        filter_hz=loop.filter_hz,
        pairing=loop.pairing,
    )


def grows(arm: Arm, q: Array, loop: SampledLoop) -> bool:
    plant = Plant(arm, friction=Friction(0.0, 0.0), effort_limit=np.full(arm.nv, np.inf))
    run = rollout(plant, law(loop), Hold(q), 2.0, q0=q + 1e-6)
    if run.status[0] == "diverged":
        return True
    angle, velocity = run.q[0] - q, run.v[0]
    size = np.sum(angle**2 / np.mean(angle**2) + velocity**2 / np.mean(velocity**2), axis=1)
    half = len(size) // 2
    early, late = np.mean(size[half // 2 : half]), np.mean(size[half:])
    return bool(late > early and late > 1e-8 * size.max())


def bisect(unstable: object, low: float, high: float) -> float:
    while high / low > 1.001:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if unstable(middle) else (middle, high)  # type: ignore[operator]
    return math.sqrt(low * high)


def boundary_row(arm: Arm, q: list[float], mbar: object, timing: dict[str, object]) -> str:
    loop, at = SampledLoop(np.broadcast_to(mbar, (arm.nv,)), 1.0, 1.0, PERIOD, **timing), np.array(q)
    mass, stiffness = arm.mass_matrix(at), gravity_stiffness(arm, at)

    def map_is_unstable(x: float) -> bool:
        return float(closed_loop(mass, loop.scaled(ks=x, beta=x), stiffness=stiffness).spectral_radius()) >= 1.0

    predicted = bisect(map_is_unstable, 4.0, 1e4)
    simulated = bisect(lambda x: grows(arm, at, loop.scaled(ks=x, beta=x)), 0.5 * predicted, 2.0 * predicted)
    figures = f"{predicted:.2f} | {simulated:.2f} | {simulated / predicted:.4f}"
    return f"| {arm.name} | {q} | {timing or 'velocity'} | {figures} |"


def tracking_row(arm: Arm, loop: SampledLoop, motion: Multisine, coulomb: list[float], viscous: list[float]) -> str:
    plant = Plant(arm, friction=Friction(coulomb, viscous), effort_limit=np.full(arm.nv, np.inf))
    run = rollout(plant, law(loop), motion, 8.0)
    predicted = predict_tracking(arm, loop, motion, 8.0, coulomb=coulomb, viscous=viscous)
    actual = np.sqrt(np.mean((run.q_ref - run.q[0]) ** 2, axis=0))
    ratios = ", ".join(f"{x:.3f}" for x in actual / predicted.rms)
    return f"| {arm.name} | {coulomb} | {', '.join(f'{x:.3f}' for x in np.rad2deg(actual))} | {ratios} |"


def main() -> None:
    two_link = load_arm("two_link")
    print("| arm | q | estimate | predicted | simulated | ratio |\n| --- | --- | --- | --- | --- | --- |")
    for q in ([0.4, 0.0], [1.5, 0.3], [-1.2, 2.0]):
        print(boundary_row(two_link, q, 0.01, {}))
    by_position = {"acceleration": "position"}
    for timing in ({}, by_position | {"pairing": "last"}, by_position, {"filter_hz": 100.0}):
        print(boundary_row(UR5, [0.0, -1.3, 1.6, -1.2, -1.4, 0.0], UR5_MBAR, timing))

    print("\n| arm | Coulomb, N·m | RMS error of the rollout, deg | over the predicted |\n| --- | --- | --- | --- |")
    loop = SampledLoop(np.array(UR5_MBAR), 8.0, 8.0, PERIOD)
    still, rubbing = [0.0] * 6, [8.0, 8.0, 5.0, 2.0, 2.0, 1.0]
    print(tracking_row(UR5, loop, UR5_MOTION, still, still))
    print(tracking_row(UR5, loop, UR5_MOTION, rubbing, [1.0, 1.0, 1.0, 0.2, 0.2, 0.1]))
    swing = Multisine(offset=[0.3, 0.0], amplitude=[1.0, 0.7], frequency=[0.3, 0.4], rise=1.0)
    for coulomb in (0.0, 5.0, 50.0):
        two = SampledLoop(np.full(2, 0.01), 10.0, 10.0, PERIOD)
        print(tracking_row(two_link, two, swing, [coulomb] * 2, [0.0, 0.0]))

    print("\n| answer | s |\n| --- | --- |")
    uneven = [8.0, 8.0, 8.0, 10.0, 10.0, 10.0]
    answers = {
        "stability, one k_s": lambda: stability(UR5, UR5_MBAR, 8.0, 8.0, PERIOD),
        "stability, k_s per joint": lambda: stability(UR5, UR5_MBAR, uneven, 8.0, PERIOD),
        "suggest_gains": lambda: suggest_gains(UR5, UR5_MBAR, PERIOD),
        "gain_warnings": lambda: gain_warnings(UR5, {"PPC": law(loop)}),
    }
    for name, answer in answers.items():
        began = perf_counter()
        answer()
        print(f"| {name} | {perf_counter() - began:.2f} |")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()
