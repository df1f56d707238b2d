"""Random serial chains as URDF text, for the tests of the condition."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from asmc_pin.arms import Arm, load_arm
from asmc_pin.condition import DesignReport, design


@cache
def explained_two_link_design() -> DesignReport:
    """The design of the two-link arm with its explanation, made once for all that look at it."""
    return design(load_arm("two_link"), objective="bandwidth")


UR5_MBAR = (
    0.14832641607830951,
    0.16745534835366926,
    0.15042781767398009,
    0.08106526290068174,
    0.09334419114818981,
    0.017136950741091284,
)
"""An M̄ that satisfies Lemma 1 on the bare UR5 with a norm of 0.968."""


def chain_urdf(seed: int, joints: int, prismatic: bool = False) -> str:
    """A serial chain with random axes, offsets and full inertia tensors that a real body could have."""
    rng = np.random.default_rng(seed)
    parts = ['<robot name="chain"><link name="base"/>']
    for i in range(joints):
        mass = rng.uniform(0.3, 4.0)
        # The inertia of a cloud of points always satisfies the triangle inequality.
        cloud = rng.normal(size=(6, 3)) * rng.uniform(0.02, 0.15, size=3)
        cloud -= cloud.mean(axis=0)
        inertia = mass / 6.0 * (np.sum(cloud**2) * np.eye(3) - cloud.T @ cloud)
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        kind = "prismatic" if prismatic and i == joints // 2 else "revolute"
        limit = 0.4 if kind == "prismatic" else 2.5
        c, o, r = rng.uniform(-0.2, 0.2, 3), rng.uniform(-0.4, 0.4, 3), rng.uniform(-3.0, 3.0, 3)
        parts.append(
            f'<link name="l{i}"><inertial><origin xyz="{c[0]} {c[1]} {c[2]}"/><mass value="{mass}"/>'
            f'<inertia ixx="{inertia[0, 0]}" ixy="{inertia[0, 1]}" ixz="{inertia[0, 2]}" iyy="{inertia[1, 1]}" '
            f'iyz="{inertia[1, 2]}" izz="{inertia[2, 2]}"/></inertial></link>'
            f'<joint name="j{i}" type="{kind}"><parent link="{"base" if i == 0 else f"l{i - 1}"}"/>'
            f'<child link="l{i}"/><origin xyz="{o[0]} {o[1]} {o[2]}" rpy="{r[0]} {r[1]} {r[2]}"/>'
            f'<axis xyz="{axis[0]} {axis[1]} {axis[2]}"/>'
            f'<limit lower="{-limit}" upper="{limit}" effort="50" velocity="3"/></joint>'
        )
    return "".join(parts) + "</robot>"


def chain(folder: Path, seed: int, joints: int, prismatic: bool = False) -> Arm:
    """The same as an arm."""
    path = folder / f"chain_{seed}_{joints}_{prismatic}.urdf"
    path.write_text(chain_urdf(seed, joints, prismatic), encoding="utf-8")
    return load_arm(path)


@st.composite
def masses_and_mbars(draw: st.DrawFn, largest: int = 7) -> tuple[np.ndarray, np.ndarray]:
    """A symmetric positive definite M of condition up to 1e4, and an M̄ that may or may not suit it."""
    n = draw(st.integers(1, largest))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    basis, _ = np.linalg.qr(rng.normal(size=(n, n)))
    mass = basis @ np.diag(10.0 ** rng.uniform(-2.0, 2.0, n)) @ basis.T
    mbar = np.diag(mass) * rng.uniform(0.05, 1.5) * rng.uniform(0.5, 1.5, n)
    if draw(st.booleans()):
        mbar = mbar * 1.6 * np.linalg.eigvalsh(mass)[0] / mbar.max()
    return 0.5 * (mass + mass.T), mbar
