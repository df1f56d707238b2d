"""Logs of the simulated plant, friction, drives and sensors on, of which every parameter is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import asmc_pin
from asmc_pin import Arm, Drive, Friction, Plant, Sensor, Setpoint
from asmc_pin._typing import Array
from asmc_pin.logs import JointLog

PERIOD = 0.002


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What a simulated arm has, and a log of it shows."""

    arm: str
    payload: float
    com: tuple[float, float, float]
    armature: Array
    coulomb: Array
    viscous: Array
    breakaway: Array
    stribeck_velocity: Array
    offset: Array
    scale: Array
    torque_noise: Array
    mbar: Array
    centre: Array
    reach: Array
    seconds: float = 30.0
    gain: float = 12.0

    @property
    def nominal(self) -> Arm:
        return asmc_pin.load_arm(self.arm)

    @property
    def laden(self) -> Arm:
        return asmc_pin.load_arm(
            self.arm, payload={"mass": self.payload, "com": self.com}, armature=list(self.armature)
        )


UR5 = Truth(
    arm="ur5",
    payload=1.6,
    com=(0.02, -0.03, 0.07),
    armature=np.array([0.5, 0.5, 0.3, 0.05, 0.05, 0.05]),
    coulomb=np.array([8.0, 8.0, 5.0, 2.0, 2.0, 1.0]),
    viscous=np.array([6.0, 6.0, 4.0, 1.0, 1.0, 0.6]),
    breakaway=np.array([11.0, 11.0, 7.0, 2.8, 2.8, 1.5]),
    stribeck_velocity=np.full(6, 0.12),
    offset=np.array([0.3, -0.5, 0.2, 0.1, -0.1, 0.05]),
    scale=np.array([1.0, 1.05, 0.95, 1.0, 1.08, 1.0]),
    torque_noise=np.array([1.5, 1.5, 1.0, 0.4, 0.4, 0.25]),
    mbar=np.array([0.623, 0.877, 0.649, 0.262, 0.208, 0.0198]),
    centre=np.array([0.0, -1.3, 1.6, -1.2, -1.4, 0.0]),
    reach=np.array([1.0, 0.6, 0.8, 1.0, 1.0, 1.2]),
)

SO101 = Truth(
    arm="so101",
    payload=0.12,
    com=(0.0, 0.01, -0.05),
    armature=np.full(5, 0.028),
    coulomb=np.array([0.06, 0.08, 0.07, 0.05, 0.05]),
    viscous=np.array([0.06, 0.06, 0.06, 0.05, 0.05]),
    breakaway=np.array([0.09, 0.115, 0.10, 0.075, 0.075]),
    stribeck_velocity=np.full(5, 0.15),
    offset=np.array([0.01, -0.02, 0.01, 0.005, -0.005]),
    scale=np.array([1.0, 1.1, 0.95, 1.0, 1.0]),
    torque_noise=np.full(5, 0.04),
    mbar=np.full(5, 0.02),
    centre=np.array([0.0, -0.2, 0.2, 0.2, 0.0]),
    reach=np.array([1.2, 1.0, 1.0, 1.0, 1.6]),
    gain=10.0,
)


class SlowThenFast:
    """A motion run slowly, for friction, and then fast, for inertia."""

    duration = np.inf

    def __init__(self, motion: asmc_pin.Reference, slow: float, fast: float, turn: float) -> None:
        self.motion, self.slow, self.fast, self.turn = motion, slow, fast, turn
        self.nv = motion.nv

    def evaluate(self, t: Array) -> Setpoint:
        t = np.asarray(t, dtype=np.float64)
        x = np.clip((t - self.turn + 1.0) / 2.0, 0.0, 1.0)
        blend, slope = x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2 / 2.0
        area = 2.0 * (x**6 - 3 * x**5 + 2.5 * x**4) + np.maximum(t - self.turn - 1.0, 0.0)
        rate, change = self.slow + (self.fast - self.slow) * blend, (self.fast - self.slow) * slope
        at = self.motion.evaluate(self.slow * t + (self.fast - self.slow) * area)
        rate, change = rate[:, None], change[:, None]
        return Setpoint(at.q, at.v * rate, at.a * rate**2 + at.v * change)


def excitation(truth: Truth) -> asmc_pin.Reference:
    """A motion in which every joint swings at several frequencies, slowly at first."""
    rng = np.random.default_rng(5)
    nv = truth.centre.size
    frequency = rng.uniform(0.08, 0.14, nv)[:, None] * np.array([1.0, 2.3, 4.1])
    amplitude = truth.reach[:, None] * np.array([0.6, 0.3, 0.12])
    sines = asmc_pin.REFERENCES["multisine"](
        offset=truth.centre, amplitude=amplitude, frequency=frequency, phase=rng.uniform(0, 6.28, (nv, 3)), rise=1.0
    )
    return SlowThenFast(sines, 0.45, 1.7, 0.5 * truth.seconds)


def simulated_logs(truth: Truth, trials: range, *, delay: float = 0.0) -> list[JointLog]:
    """One log for each trial, which differ by the noise of their sensors alone."""
    friction = Friction(
        truth.coulomb, truth.viscous, breakaway=truth.breakaway, stribeck_velocity=truth.stribeck_velocity
    )
    plant = Plant(
        truth.laden,
        substeps=4,
        friction=friction,
        effort_limit=np.full(truth.centre.size, np.inf),
        drive=Drive(delay=delay, current_hz=400.0),
        sensor=Sensor(bits=20, position_noise=2e-6, velocity="filter", filter_hz=60.0, torque_noise=truth.torque_noise),
        seed=7,
    )
    # A law that hears nothing of the torque's noise: what a law feeds back moves the arm, and is no noise any more.
    law = asmc_pin.BASELINES["computed_torque"](
        arm=truth.nominal.replace(armature=list(truth.armature)),
        ks=truth.gain,
        beta=truth.gain,
        coulomb=0.9 * truth.coulomb,
        viscous=0.8 * truth.viscous,
        period=PERIOD,
    )
    motion, size = excitation(truth), len(trials)
    run = asmc_pin.rollout(plant, law, motion, truth.seconds, batch=size, trials=trials)
    assert set(run.status) == {"ok"}
    names = truth.nominal.joint_names
    return [
        JointLog(
            name=f"trial {trial}",
            joint_names=names,
            time=run.time,
            q=run.q_measured[i],
            v=run.v_measured[i],
            torque=truth.scale * run.torque_measured[i] + truth.offset,
            torque_side="motor",
            found=(),
        )
        for i, trial in enumerate(trials)
    ]


def true_parameters(truth: Truth) -> dict[str, float]:
    """What `identify` should find, by its names."""
    wanted: dict[str, float] = {"payload.mass": truth.payload, "delay": -0.5 * PERIOD}
    wanted |= {f"payload.com.{axis}": x for axis, x in zip("xyz", truth.com, strict=True)}
    columns = {
        "coulomb": truth.coulomb,
        "viscous": truth.viscous,
        "breakaway": truth.breakaway,
        "stribeck_velocity": truth.stribeck_velocity,
        "armature": truth.armature,
        "torque_constant": truth.scale,
        "torque_offset": truth.offset,
    }
    for kind, values in columns.items():
        wanted |= {f"{kind}.{name}": float(x) for name, x in zip(truth.nominal.joint_names, values, strict=True)}
    return wanted
