"""Where the linear map says the loop becomes unstable, simulated runs of the plant do."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.controllers import CONTROLLERS, Setpoint
from asmc_pin.engine import rollout
from asmc_pin.plant import Drive, Friction, Plant, Sensor
from asmc_pin.sampled import SampledLoop, closed_loop
from asmc_pin.sampled.frozen_arms import gravity_stiffness

ONE_JOINT = """<robot name="turntable"><link name="base"/><link name="table"><inertial>
<mass value="2"/><inertia ixx="0.8" iyy="0.8" izz="0.8" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.fixture(scope="module")
def turntable(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    path: Path = tmp_path_factory.mktemp("arm") / "turntable.urdf"
    path.write_text(ONE_JOINT)
    return load_arm(path)


@dataclass(frozen=True)
class Hold:
    """A set-point."""

    q: Array
    duration: float = math.inf

    @property
    def nv(self) -> int:
        return self.q.size

    def evaluate(self, t: Array) -> Setpoint:
        zero = np.zeros((t.size, self.nv))
        return Setpoint(zero + self.q, zero, zero)


def grows(arm: Arm, q: Array, loop: SampledLoop, seconds: float) -> bool:
    """Whether a run that starts a microradian away from its set-point is further away later on than earlier."""
    law = CONTROLLERS["ppc"](
        mbar=loop.mbar, ks=loop.ks, beta=float(loop.beta[0]), period=loop.period,
        acceleration=loop.acceleration, filter_hz=loop.filter_hz, pairing="mean" if loop.averages_torque else "last",
    )  # fmt: skip
    drive = Drive(delay=loop.delay)
    sensor = Sensor(velocity="exact" if loop.velocity == "measured" else "difference", delay=loop.reading_delay)
    free = {"friction": Friction(0.0, 0.0), "effort_limit": np.full(arm.nv, np.inf)}
    plant = Plant(arm, **free, drive=drive, sensor=sensor)
    run = rollout(plant, law, Hold(q), seconds, q0=q + 1e-6)
    if run.status[0] == "diverged":
        return True
    # Angle and velocity together, the velocity in proportion, so that the size does not swing within an oscillation.
    angle, velocity = run.q[0] - q, run.v[0]
    size = np.sum(angle**2 / np.mean(angle**2) + velocity**2 / np.mean(velocity**2), axis=1)
    half = len(size) // 2
    early, late = np.mean(size[half // 2 : half]), np.mean(size[half:])
    return bool(late > early and late > 1e-8 * size.max())  # below that it is rounding that lives on


def simulated_boundary(arm: Arm, q: Array, loop: SampledLoop, low: float, high: float, seconds: float) -> float:
    """The factor on β and K_s at which runs begin to grow, to 0.3 %."""
    assert not grows(arm, q, loop.scaled(ks=low, beta=low), seconds)
    assert grows(arm, q, loop.scaled(ks=high, beta=high), seconds)
    while high / low > 1.003:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if grows(arm, q, loop.scaled(ks=middle, beta=middle), seconds) else (middle, high)
    return math.sqrt(low * high)


def predicted_boundary(arm: Arm, q: Array, loop: SampledLoop, low: float, high: float) -> float:
    mass, stiffness = arm.mass_matrix(q), gravity_stiffness(arm, q)
    while high / low > 1.0001:
        middle = math.sqrt(low * high)
        radius = closed_loop(mass, loop.scaled(ks=middle, beta=middle), stiffness=stiffness).spectral_radius()
        low, high = (low, middle) if radius >= 1.0 else (middle, high)
    return math.sqrt(low * high)


@pytest.mark.parametrize(
    ("a", "timing"),
    [
        (0.0114, {}),
        (1.9, {}),
        (0.3, {"acceleration": "position"}),
        (0.3, {"filter_hz": 60.0}),
        (0.05, {"acceleration": "position", "filter_hz": 200.0}),
        (0.3, {"delay": 0.6}),
        (0.3, {"delay": 3.0}),
        (0.3, {"acceleration": "position", "pairing": "last"}),
        (0.3, {"velocity": "difference"}),
        (1.9, {"velocity": "difference"}),
        (0.3, {"velocity": "difference", "pairing": "last", "reading_delay": 1.0}),
    ],
    ids=str,
)
def test_boundary_on_a_constant_inertia_within_2_percent_of_the_map(turntable: Arm, a: float, timing: dict) -> None:
    q = np.array([0.3])
    loop = SampledLoop(a * 0.8, 1.0, 1.0, 0.001, **timing)
    predicted = predicted_boundary(turntable, q, loop, 0.1, 1e4)
    simulated = simulated_boundary(turntable, q, loop, 0.5 * predicted, 2.1 * predicted, seconds=1.0)
    assert simulated == pytest.approx(predicted, rel=0.02)


@pytest.mark.parametrize(
    ("q", "gravity"),
    [((0.4, 0.0), None), ((1.5, 0.3), None), ((-1.2, 2.0), None), ((0.4, 0.0), (0.0, 0.0, 0.0))],
    ids=str,
)
def test_boundary_on_two_link_near_a_configuration_within_5_percent(
    q: tuple[float, float], gravity: tuple[float, ...] | None
) -> None:
    arm = load_arm("two_link", gravity=gravity)
    loop = SampledLoop([0.01, 0.01], 1.0, 1.0, 0.001)
    predicted = predicted_boundary(arm, np.array(q), loop, 4.0, 1e4)
    simulated = simulated_boundary(arm, np.array(q), loop, 0.6 * predicted, 1.7 * predicted, seconds=1.0)
    assert simulated == pytest.approx(predicted, rel=0.05)


def test_the_printed_gains_let_the_upright_arm_fall_away_under_gravity() -> None:
    # β = k_s = 1, M̄ = 0.01, L = 1 ms of Section III: stable for the inertia alone, not with gravity's negative spring.
    arm, q = load_arm("two_link"), np.array([0.5 * math.pi, 0.0])
    loop = SampledLoop([0.01, 0.01], 1.0, 1.0, 0.001)
    mass = arm.mass_matrix(q)
    assert closed_loop(mass, loop).spectral_radius() < 1.0
    assert closed_loop(mass, loop, stiffness=gravity_stiffness(arm, q)).spectral_radius() > 1.0
    assert grows(arm, q, loop, seconds=6.0)
    assert not grows(arm.replace(gravity=(0.0, 0.0, 0.0)), q, loop, seconds=6.0)
