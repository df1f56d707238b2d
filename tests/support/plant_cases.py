"""Small systems with known answers, shared by the tests of the plant."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin.arms import Arm, load_arm
from asmc_pin.controllers import Sample, Setpoint

G = 9.81


def slider(folder: Path, mass: float, slope: float = 0.0) -> Arm:
    """A mass on a rail that rises at `slope` rad; q is the way up the rail, m."""
    path = folder / f"slider_{mass:g}_{slope:g}.urdf"
    path.write_text(
        f"""<robot name="slider"><link name="rail"/>
        <link name="mass"><inertial><mass value="{mass!r}"/>
          <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
        <joint name="slide" type="prismatic"><parent link="rail"/><child link="mass"/>
          <axis xyz="{float(np.cos(slope))!r} 0 {float(np.sin(slope))!r}"/>
          <limit lower="-1000" upper="1000" effort="100000" velocity="1000"/></joint></robot>"""
    )
    return load_arm(path)


@dataclass(frozen=True)
class Still:
    """A reference that stays at q."""

    q: np.ndarray
    duration: float = np.inf

    @property
    def nv(self) -> int:
        return len(self.q)

    def evaluate(self, t: np.ndarray) -> Setpoint:
        q = np.tile(np.asarray(self.q, dtype=float), (len(t), 1))
        return Setpoint(q, 0.0 * q, 0.0 * q)


@dataclass(frozen=True)
class Accelerating:
    """A reference under constant acceleration a from rest at 0."""

    a: np.ndarray
    duration: float = np.inf

    @property
    def nv(self) -> int:
        return len(self.a)

    def evaluate(self, t: np.ndarray) -> Setpoint:
        t = t[:, None]
        return Setpoint(0.5 * self.a * t**2, self.a * t, self.a + 0.0 * t)


@dataclass(frozen=True)
class Waving:
    """A reference that swings about q with an amplitude and a frequency per joint."""

    q: np.ndarray
    amplitude: float = 0.4
    rate: float = 2.0
    duration: float = np.inf

    @property
    def nv(self) -> int:
        return len(self.q)

    def evaluate(self, t: np.ndarray) -> Setpoint:
        w = self.rate * (1.0 + 0.1 * np.arange(self.nv))
        x = w * t[:, None]
        return Setpoint(
            self.q + self.amplitude * (1.0 - np.cos(x)),
            self.amplitude * w * np.sin(x),
            self.amplitude * w**2 * np.cos(x),
        )


@dataclass(frozen=True)
class OpenLoop:
    """A law that plays torque(t), whatever happens; its state is the number of ticks taken."""

    torque: Any
    period: float
    seen: list[Sample] = field(default_factory=list)

    def init(self, sample: Sample) -> int:
        return 0

    def step(self, state: int, sample: Sample, setpoint: Setpoint) -> tuple[np.ndarray, int]:
        self.seen.append(sample)
        return np.broadcast_to(self.torque(state * self.period), sample.q.shape).astype(float), state + 1
