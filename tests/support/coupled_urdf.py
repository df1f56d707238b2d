"""URDFs with joints that mimic others: a parallelogram, a gripper, and random trees."""

from __future__ import annotations

import numpy as np
from arm_urdf import inertial, joint, link, robot
from scipy.spatial.transform import Rotation

WIDE = '<limit lower="-20" upper="20" effort="50" velocity="30"/>'


def mimic(master: str, multiplier: float = 1.0, offset: float = 0.0, before: str = WIDE) -> str:
    return f'{before}<mimic joint="{master}" multiplier="{multiplier!r}" offset="{offset!r}"/>'


def parallelogram(length: float = 0.4, upper: float = 3.0, fore: float = 2.0, inertia: float = 0.05) -> str:
    """A bar on a level axis, and a second one that a parallelogram keeps from turning; centres at the far ends."""
    body = np.diag([inertia, inertia, inertia])
    return robot(
        link("base"),
        link("upper", inertial(upper, f"{length!r} 0 0", body)),
        link("fore", inertial(fore, "0.3 0 0.1", body)),
        joint("lift", "base", "upper", axis="0 1 0", xyz="0 0 0.5", extra=WIDE),
        joint("level", "upper", "fore", axis="0 1 0", xyz=f"{length!r} 0 0", extra=mimic("lift", -1.0)),
    )


def gripper() -> str:
    """A turning arm with a wrist and two fingers that slide apart, one as far as the other."""
    fine = np.diag([1e-4, 1e-4, 1e-4])
    slide = '<limit lower="0" upper="0.04" effort="20" velocity="0.2"/>'
    return robot(
        link("base"),
        link("arm", inertial(2.0, "0.2 0 0", np.diag([0.01, 0.03, 0.03]))),
        link("hand", inertial(0.7, "0.05 0 0.01", np.diag([2e-3, 1e-3, 2e-3]))),
        link("left", inertial(0.1, "0.02 0 0", fine)),
        link("right", inertial(0.12, "0.02 0 0", fine)),
        joint("lift", "base", "arm", axis="0 1 0", xyz="0 0 0.5"),
        joint("roll", "arm", "hand", axis="1 0 0", xyz="0.4 0 0"),
        joint("left_finger", "hand", "left", "prismatic", axis="0 1 0", xyz="0.1 0 0", extra=slide),
        joint(
            "right_finger",
            "hand",
            "right",
            "prismatic",
            axis="0 -1 0",
            xyz="0.1 0 0",
            extra=mimic("left_finger", before=slide),
        ),
    )


def coupled_tree(
    rng: np.random.Generator, joints: int = 6, followers: int = 2, chained: bool = False, serial: bool = False
) -> str:
    """A random tree, some joints of which follow driven ones (or, `chained`, followers too), before or behind them.

    Of a `serial` one each joint hangs on the last, and follows one that is nearer to the base.
    """
    follow = {int(k) for k in rng.choice(np.arange(1, joints) if serial else joints, followers, replace=False)}
    driven = [k for k in range(joints) if k not in follow]
    leads = list(driven)
    parts = [link("l0")]
    said = {}
    for k in sorted(follow):
        masters = [j for j in leads if j < k or not serial]
        said[k] = mimic(f"j{rng.choice(masters)}", float(rng.choice([-1.0, 0.5, 2.0, 1.3])), float(rng.normal()) * 0.3)
        if chained:
            leads.append(k)
    for k in range(joints):
        mass = float(10.0 ** rng.uniform(-0.5, 0.7))
        com = " ".join(repr(float(x)) for x in rng.normal(size=3) * 0.15)
        body = mass * np.diag(rng.uniform(0.01, 0.015, 3))
        axis = " ".join(repr(float(x)) for x in rng.normal(size=3))
        xyz = " ".join(repr(float(x)) for x in rng.normal(size=3) * 0.3)
        rpy = " ".join(repr(float(x)) for x in Rotation.random(rng=rng).as_euler("xyz"))
        parent = k if serial or rng.random() < 0.75 else int(rng.integers(0, k + 1))
        kind = "prismatic" if rng.random() < 0.25 else "revolute"
        parts.append(link(f"l{k + 1}", inertial(mass, com, body)))
        extra = said.get(k, '<limit lower="-3" upper="3" effort="50" velocity="3"/>')
        parts.append(joint(f"j{k}", f"l{parent}", f"l{k + 1}", kind, axis=axis, xyz=xyz, rpy=rpy, extra=extra))
    return robot(*parts)
