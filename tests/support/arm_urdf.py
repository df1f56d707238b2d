"""Small URDFs for tests: pieces to write one by hand, and hypothesis-made random trees."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from asmc_pin._typing import Array

LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="3"/>'


def inertial(mass: float = 1.0, com: str = "0.1 0 0.02", inertia: Array | None = None, rpy: str = "0 0 0") -> str:
    i = np.diag([0.01, 0.02, 0.015]) if inertia is None else inertia
    entries = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    values = " ".join(f'{k}="{float(v)!r}"' for k, v in entries.items())
    return f'<inertial><origin xyz="{com}" rpy="{rpy}"/><mass value="{mass!r}"/><inertia {values}/></inertial>'


def link(name: str, content: str = "") -> str:
    return f'<link name="{name}">{content}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    axis: str = "0 0 1",
    xyz: str = "0.1 0 0.3",
    rpy: str = "0 0 0",
    extra: str = LIMIT,
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{extra}</joint>'
    )


def robot(*parts: str) -> str:
    return '<robot name="r">\n' + "\n".join(parts) + "\n</robot>\n"


def two_joints(*, first: str = "", second: str = "", tip: str | None = None) -> str:
    """A well-formed arm of two revolute joints; the arguments replace a joint or the last link's content."""
    return robot(
        link("base"),
        link("upper", inertial(2.0)),
        link("lower", inertial() if tip is None else tip),
        first or joint("shoulder", "base", "upper"),
        second or joint("elbow", "upper", "lower", axis="0 1 0"),
    )


def two_arms(joints: int = 7, *, torso: bool = False) -> str:
    """Two arms of some joints each on one base, the second a tenth lighter; on a torso that turns, if asked."""
    parts = [link("base")]
    root = "base"
    if torso:
        parts += [link("torso", inertial(12.0, "0 0 0.2", np.diag([0.3, 0.3, 0.2]))), joint("waist", "base", "torso")]
        root = "torso"
    for side, share in (("left", 1.0), ("right", 0.9)):
        parent = root
        for k in range(joints):
            mass = share * 4.0 * 0.7**k
            body = inertial(mass, "0.02 0 0.1", mass * np.diag([0.008, 0.008, 0.004]))
            axis = "0 0 1" if k % 2 == 0 else "0 1 0"
            placed = f"0 {0.3 if side == 'left' else -0.3} 0.4" if parent == root else f"0 0 {0.25 * 0.9**k}"
            name = f"{side}{k + 1}"
            parts += [link(name, body), joint(f"{name}_joint", parent, name, axis=axis, xyz=placed)]
            parent = name
    return robot(*parts)


def write(folder: Path, text: str, name: str = "arm.urdf") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def _numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


def _triple(low: float, high: float) -> st.SearchStrategy[str]:
    return st.tuples(*[_numbers(low, high)] * 3).map(lambda x: " ".join(map(repr, x)))


_axes = (
    st.tuples(*[_numbers(-1.0, 1.0)] * 3)
    .filter(lambda x: sum(c * c for c in x) > 1e-2)
    .map(lambda x: " ".join(map(repr, x)))
)


@st.composite
def bodies(draw: st.DrawFn) -> str:
    """An inertial whose inertia is that of some cloud of points, so that it is possible."""
    points = np.array(draw(st.lists(st.tuples(*[_numbers(-0.2, 0.2)] * 3), min_size=1, max_size=4)))
    inertia = np.eye(3) * (points**2).sum() - points.T @ points + 1e-3 * np.eye(3)
    return inertial(draw(_numbers(0.1, 5.0)), draw(_triple(-0.3, 0.3)), inertia, draw(_triple(-3.0, 3.0)))


@st.composite
def trees(draw: st.DrawFn, most: int = 6) -> str:
    """A random arm: branches, every kind of joint, any axis, massless and massive links behind fixed joints."""
    parts, ends = [link("base")], ["base"]
    for k in range(draw(st.integers(1, most))):
        name = f"link{k}"
        kind = draw(st.sampled_from(["revolute", "continuous", "prismatic"]))
        # Mostly a chain, sometimes a branch.
        parent = draw(st.sampled_from([ends[-1], ends[-1], draw(st.sampled_from(ends))]))
        parts.append(link(name, draw(bodies())))
        placed = {"xyz": draw(_triple(-0.5, 0.5)), "rpy": draw(_triple(-3.0, 3.0))}
        parts.append(joint(f"joint{k}", parent, name, kind, draw(_axes), **placed))
        ends.append(name)
        if draw(st.booleans()):
            flange = draw(bodies()) if draw(st.booleans()) else ""
            parts.append(link(f"flange{k}", flange))
            placed = {"xyz": draw(_triple(-0.5, 0.5)), "rpy": draw(_triple(-3.0, 3.0))}
            parts.append(joint(f"weld{k}", name, f"flange{k}", "fixed", "0 0 0", **placed))
            ends.append(f"flange{k}")
    return robot(*parts)
