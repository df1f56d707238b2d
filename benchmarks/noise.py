"""How well the linear map foretells the noise of torque and error that sensors make, beside simulated runs.

    python benchmarks/noise.py

Each row is a run of PPC with the sensor less the same run with a perfect one of the same kind, so that what is left is
noise. Torque limits are lifted: in a drive at its limits the map does not hold. *Moving*: all joints cross counts every
period, at speeds that swing, or are constant, when rounding makes tones and not noise; the RMS of the run, after it has
settled, over the predicted one, by joint. *At rest*: the largest deviation of the run over the bound.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin import Plant, load_arm, rollout
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.controllers import Ppc, Setpoint
from asmc_pin.plant import Friction, Sensor
from asmc_pin.sampled import SampledLoop
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.noise.noise_response import noise_rms, rounding_bound
from asmc_pin.sampled.noise.sensor_model import LoopSensor

UR5 = load_arm("ur5", armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
UR5_MBAR = [0.6228, 0.8771, 0.6488, 0.2616, 0.2080, 0.0198]
UR5_START = [0.0, -1.3, 1.6, -1.2, -1.4, 0.0]
SETTLED = 2.0  # s: what the first, rounded velocity was off by is forgotten like e^(−8 t)


@dataclass(frozen=True)
class Glide:
    """Speeds v from q, both (nv,), that swing by a share of themselves but do not turn."""

    q: Array
    v: Array
    swing: float = 0.0
    duration: float = math.inf

    @property
    def nv(self) -> int:
        """Number of joints."""
        return self.q.size

    def evaluate(self, t: Array) -> Setpoint:
        """Where it is at every time; every joint swings at a rate of its own."""
        rate = 2.0 + 0.7 * np.arange(self.nv)
        phase = np.multiply.outer(t, rate)
        moved = self.v * (t[:, None] + self.swing * (1.0 - np.cos(phase)) / rate)
        return Setpoint(
            self.q + moved, self.v * (1.0 + self.swing * np.sin(phase)), self.v * self.swing * rate * np.cos(phase)
        )


@dataclass(frozen=True)
class Case:
    """A loop, its plant's sensor, and a motion of all joints at one speed."""

    name: str
    arm: Arm
    mbar: ArrayLike
    gain: float
    period: float
    sensor: Sensor
    start: ArrayLike
    speed: float = 0.0
    swing: float = 0.5
    filter_hz: float | None = None
    acceleration: str = "velocity"

    @property
    def seen(self) -> LoopSensor:
        """The sensor as the analysis takes it."""
        nv = self.arm.nv
        noise = (self.sensor.position_noise, self.sensor.velocity_noise, self.sensor.torque_noise)
        return LoopSensor(
            self.sensor.count(nv, np.ones(())),
            *(np.array(np.broadcast_to(x, (nv,))) for x in noise),
            velocity="measured" if self.sensor.velocity == "exact" else "difference",
            velocity_filter_hz=self.sensor.filter_hz if self.sensor.velocity == "filter" else None,
            reading_delay=self.sensor.delay,
        )

    @property
    def loop(self) -> SampledLoop:
        """The loop with it."""
        timing = self.seen.timing
        return SampledLoop(
            np.array(self.mbar), self.gain, self.gain, self.period, self.acceleration, self.filter_hz, **timing
        )  # type: ignore[arg-type]

    def runs(self, seconds: float) -> tuple[Array, Array, Array]:
        """Torque and error that the noise makes at the settled ticks, and the configurations there, each (T, nv)."""
        sensor = self.sensor
        perfect = Sensor(velocity=sensor.velocity, filter_hz=sensor.filter_hz, delay=sensor.delay)
        loop, free = self.loop, {"friction": Friction(0.0, 0.0), "effort_limit": np.full(self.arm.nv, np.inf)}
        law = Ppc(
            mbar=loop.mbar, ks=self.gain, beta=self.gain, period=self.period, acceleration=loop.acceleration,
            filter_hz=loop.filter_hz, pairing="mean" if loop.averages_torque else "last",
        )  # fmt: skip
        # Speeds that are no simple fractions of a count a period.
        speeds = self.speed * np.linspace(1.0, 1.31, self.arm.nv) * (-1.0) ** np.arange(self.arm.nv)
        motion = Glide(np.array(self.start, dtype=np.float64), speeds, self.swing)
        noisy, clean = (
            rollout(Plant(self.arm, sensor=kind, **free), law, motion, seconds, q0=motion.q, v0=motion.v)
            for kind in (sensor, perfect)
        )
        late = noisy.time > SETTLED
        torque, error = noisy.torque[0] - clean.torque[0], clean.q[0] - noisy.q[0]
        return torque[late], error[late], clean.q[0][late]

    def predicted(self, q: Array) -> tuple[Array, Array]:
        """RMS of torque and error along configurations, each (nv,)."""
        some = q[:: max(1, len(q) // 50)]
        stiffness = gravity_stiffness(self.arm, some)
        both = noise_rms(self.arm.mass_matrix(some), self.loop, self.seen, stiffness=stiffness)
        torque, error = (np.sqrt(np.mean(rms**2, axis=0)) for rms in both)
        return torque, error

    def bounds(self, q: Array) -> tuple[Array, Array]:
        """Bounds of torque and error by rounding at a configuration, each (nv,)."""
        mass, stiffness = self.arm.mass_matrix(q), gravity_stiffness(self.arm, q)
        return rounding_bound(mass, self.loop, self.seen.count, stiffness=stiffness)


def cases() -> list[Case]:
    """What is shown."""
    ur5 = {"arm": UR5, "mbar": UR5_MBAR, "gain": 8.0, "start": UR5_START}
    two = {"arm": load_arm("two_link"), "mbar": [0.02, 0.02], "gain": 12.0, "start": [0.3, 0.4]}
    bits = Sensor(bits=17)
    return [
        Case("20 bits, 1 ms", period=1e-3, sensor=Sensor(bits=20), speed=0.2, **ur5),
        Case("17 bits, 0.25 ms", period=2.5e-4, sensor=bits, speed=0.5, **ur5),
        Case("17 bits, 0.25 ms, 50 Hz", period=2.5e-4, sensor=bits, speed=0.5, filter_hz=50.0, **ur5),
        Case("17 bits, v filtered at 60 Hz", period=1e-3, sensor=Sensor(bits=17, velocity="filter", filter_hz=60.0),
             speed=0.3, **ur5),
        Case("17 bits, q̈ from position", period=1e-3, sensor=Sensor(bits=17, velocity="exact"), speed=0.3,
             acceleration="position", **ur5),
        Case("v to 1e-4 rad/s", period=1e-3, sensor=Sensor(velocity="exact", velocity_noise=1e-4), speed=0.2, **ur5),
        Case("torque to 0.1 N·m", period=1e-3, sensor=Sensor(velocity="exact", torque_noise=0.1), speed=0.2, **ur5),
        Case("two_link, 20 bits, 1 ms", period=1e-3, sensor=Sensor(bits=20), speed=0.2, **two),
    ]  # fmt: skip


def main() -> None:
    for swing, name in ((0.5, "moving"), (0.0, "constant speed")):
        print(
            f"| {name}: sensor | torque RMS predicted, N·m | simulated over it | error RMS predicted, µrad | over it |"
        )
        print("| --- | --- | --- | --- | --- |")
        for case in cases():
            if swing or case.sensor.bits is not None:
                print(_moving_row(replace(case, swing=swing)))
        print()
    print("| at rest: sensor | bound of torque, N·m | largest over it | bound of error, µrad | over it |")
    print("| --- | --- | --- | --- | --- |")
    for case in cases():
        if case.sensor.bits is None:
            continue
        still = replace(case, speed=0.0)
        torque, error, q = still.runs(4.0)
        told = []
        for scale, bound, found in zip((1.0, 1e6), still.bounds(q[0]), (torque, error), strict=True):
            told += [_list(scale * bound, ".3g"), _list(np.abs(found).max(axis=0) / bound, ".2f")]
        print(f"| {case.name} | {' | '.join(told)} |")


def _moving_row(case: Case) -> str:
    torque, error, q = case.runs(10.0)
    told = []
    for scale, rms, found in zip((1.0, 1e6), case.predicted(q), (torque, error), strict=True):
        told += [_list(scale * rms, ".3g"), _list(np.sqrt(np.mean(found**2, axis=0)) / rms, ".2f")]
    return f"| {case.name} | {' | '.join(told)} |"


def _list(values: Array, form: str) -> str:
    return ", ".join(f"{value:{form}}" for value in values)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()
