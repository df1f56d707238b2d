"""Sixty small URDFs, one a kind: what people have, and what is to be said of each. All are made here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from arm_urdf import LIMIT, inertial, joint, link, robot, two_arms

from asmc_pin._typing import Array

MASSES = (4.0, 3.5, 3.0, 2.0, 1.5, 1.0, 0.5)
LENGTHS = (0.30, 0.32, 0.28, 0.24, 0.16, 0.10, 0.08)
AXES = ("0 0 1", "0 1 0", "0 0 1", "0 -1 0", "0 0 1", "0 1 0", "0 0 1")
FRICTION = LIMIT + '<dynamics damping="0.4" friction="0.2"/>'


def rod(mass: float, length: float, radius: float = 0.05) -> Array:
    """Tensor of a uniform cylinder along z about its centre."""
    across = mass * (radius**2 / 4.0 + length**2 / 12.0)
    return np.diag([across, across, mass * radius**2 / 2.0])


def box(size: str = "0.1 0.1 0.3", at: str = "0 0 0.15") -> str:
    return f'<visual><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></visual>'


def mesh(name: str) -> str:
    return f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'


Tensor = Callable[[int, float, float], Array]


def serial(
    count: int = 3,
    *,
    tensor: Tensor = lambda _k, mass, length: rod(mass, length),
    mass: Callable[[int], float] = lambda k: MASSES[k],
    centre: Callable[[int], str] = lambda k: f"0 0 {LENGTHS[k] / 2}",
    scale: float = 1.0,
    limit: str = FRICTION,
    kinds: Sequence[str] = ("revolute",) * 7,
    axes: Sequence[str] = AXES,
    rpy: str = "0 0 0",
    visual: Callable[[int], str] = lambda _k: "",
    base: str = "",
    extra: Sequence[str] = (),
) -> str:
    """A chain of rods, link1 … on j1 …; the arguments change one thing about all its links or joints."""
    parts = [link("base", base)]
    for k in range(count):
        parent = f"link{k}" if k else "base"
        body = inertial(mass(k), centre(k), tensor(k, mass(k), LENGTHS[k]))
        parts.append(link(f"link{k + 1}", body + visual(k)))
        place = f"0 0 {scale * (LENGTHS[k - 1] if k else 0.1):g}"
        parts.append(joint(f"j{k + 1}", parent, f"link{k + 1}", kinds[k], axes[k], place, rpy, limit))
    return robot(*parts, *extra)


def fixed(name: str, parent: str, body: str = "", xyz: str = "0 0 0.05") -> str:
    return link(name, body) + joint(f"{name}_mount", parent, name, "fixed", xyz=xyz)


def on(parent: str, name: str, body: str, kind: str = "revolute", **changes: Any) -> str:
    return link(name, body) + joint(f"{name}_joint", parent, name, kind, **{"extra": FRICTION, **changes})


DUMMY = inertial(1e-8, "0 0 0", np.diag([0.0, 0.0, 1e-8]))
HAND = inertial(0.4, "0 0 0.04", rod(0.4, 0.1, 0.04))
FINGER = inertial(0.05, "0 0 0.03", rod(0.05, 0.06, 0.01))
SLIDE = '<limit lower="0" upper="0.04" effort="20" velocity="0.1"/>'
IMPOSSIBLE = inertial(1.0, "0 0 0.1", np.diag([0.01, 0.01, 0.05]))
MIMIC = '<mimic joint="finger_a_joint"/>'


def limits(lower: str = "-2", upper: str = "2", effort: str = "50", velocity: str = "3") -> str:
    ends = f'lower="{lower}" upper="{upper}" effort="{effort}" velocity="{velocity}"'
    return f'<limit {ends}/><dynamics damping="0.4"/>'


def gripping(mimic: str = "") -> str:
    """Three joints and a hand with two fingers."""
    hand = fixed("hand", "link3", HAND)
    fingers = on("hand", "finger_a", FINGER, "prismatic", axis="0 1 0", extra=SLIDE)
    return serial(
        extra=[hand, fingers, on("hand", "finger_b", FINGER, "prismatic", axis="0 -1 0", extra=SLIDE + mimic)]
    )


@dataclass(frozen=True)
class Kind:
    """One kind of URDF.

    Attributes:
        text: The file.
        doubts: Kinds of the serious doubts, all of them.
        remarks: Kinds of the others, all of them.
        refused: What the refusal says; empty where it loads.
        unreadable: Whether it is refused before there is anything to inspect.
        options: What it is loaded with.
        nv: Moving joints where it loads.
    """

    text: str
    doubts: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    refused: str = ""
    unreadable: bool = False
    options: dict[str, Any] = field(default_factory=dict)
    nv: int = 3


def _unit(power: int) -> str:
    return serial(tensor=lambda _k, mass, length: rod(mass, length) * 10.0**power)


def _seven_joints() -> str:
    """A seven-joint arm with a flange and a massless tool frame, as many are."""
    flange = fixed("flange", "link7", inertial(0.1, "0 0 0.01", rod(0.1, 0.02, 0.03))) + fixed("tool0", "flange")
    return serial(7, extra=[flange])


def _torso(dummies: str = "") -> str:
    """A torso on one joint with two arms of seven: 15 joints."""
    return two_arms(7, torso=True).replace(LIMIT, FRICTION).replace("</robot>", dummies + "</robot>")


KINDS: dict[str, Kind] = {
    # What is normal, and what is normal in its way.
    "seven joints": Kind(_seven_joints(), nv=7),
    "torso with two arms": Kind(_torso(), nv=15),
    "one arm of a torso": Kind(_torso(), options={"chain": ("torso", "left7")}, nv=7),
    "torso, one arm locked by pattern": Kind(_torso(), options={"lock": {"right*": 0.0}}, nv=8),
    "two arms on one base": Kind(two_arms(3).replace(LIMIT, FRICTION), nv=6),
    "two arms, one with an impossible dummy": Kind(_torso(fixed("camera", "left7", DUMMY)), nv=15),
    "gantry": Kind(
        serial(kinds=("prismatic",) * 3, axes=("1 0 0", "0 1 0", "0 0 1"), limit=limits("-0.5", "0.5")),
    ),
    "scara": Kind(
        serial(4, kinds=("revolute", "revolute", "revolute", "prismatic"), axes=("0 0 1",) * 4, rpy="0 0.3 0"), nv=4
    ),
    "rail": Kind(serial(kinds=("prismatic", "revolute", "revolute"), axes=("1 0 0", "0 0 1", "0 1 0"))),
    "endless joints": Kind(serial(kinds=("continuous",) * 3, limit=limits())),
    "one joint": Kind(serial(1, axes=("0 1 0",)), nv=1),
    "boxes that fit": Kind(serial(visual=lambda k: box(f"0.1 0.1 {LENGTHS[k]}", f"0 0 {LENGTHS[k] / 2}"))),
    "gripper locked": Kind(gripping(), options={"lock": {"grippers": 0.0}}),
    "gripper that mimics": Kind(gripping(MIMIC), nv=4),
    "gripper of two motors": Kind(gripping(), nv=5),
    "point masses": Kind(serial(tensor=lambda *_: np.zeros((3, 3)), axes=("0 1 0",) * 3)),
    "flat plates": Kind(serial(tensor=lambda _k, m, a: m * a**2 / 12.0 * np.diag([1.0, 1.0, 2.0]))),
    "tilted axes of any length": Kind(serial(axes=("0 3 4", "1 2 2", "10 20 20"))),
    "joint and link of one name": Kind(serial().replace('"j1"', '"link1"')),
    "names with spaces": Kind(serial().replace('"j1"', '"joint one"')),
    "namespace of its tool": Kind(
        serial().replace('<robot name="r">', '<robot name="r" xmlns="http://drake.mit.edu">')
    ),
    # What does not move does not matter.
    "root without mass": Kind(serial()),
    "root with an impossible tensor": Kind(serial(base=inertial(5.0, "0 0 0", np.diag([0.1, 0.1, 1.0])))),
    "root with a negative mass": Kind(serial(base=inertial(-5.0))),
    "stand fixed to the root, impossible": Kind(serial(extra=[fixed("stand", "base", IMPOSSIBLE)])),
    "dummy on a link": Kind(serial(extra=[fixed("camera", "link3", DUMMY)])),
    "massless frame on a link": Kind(serial(extra=[fixed("tool0", "link3")])),
    "mass only behind a fixed joint": Kind(
        serial().replace("</robot>", on("link3", "adapter", "") + fixed("tool", "adapter", HAND) + "</robot>"), nv=4
    ),
    "impossible finger, locked": Kind(
        serial(extra=[on("link3", "finger", inertial(0.01, "0 0 0", np.diag([0.0, 0.0, 1e-5])))]),
        options={"lock": {"grippers": 0.0}},
    ),
    "zeros with a sign": Kind(serial(tensor=lambda *_: np.diag([-1e-20, 1e-21, 0.0]), axes=("0 1 0",) * 3)),
    # Numbers in other units.
    "tensors in g·mm²": Kind(_unit(9), ("tensor unit",)),
    "tensors in g·cm²": Kind(_unit(7), ("tensor unit",)),
    "tensors in kg·mm²": Kind(_unit(6), ("tensor unit",)),
    "tensors in kg·cm²": Kind(_unit(4), ("tensor unit",)),
    "one tensor in kg·mm²": Kind(
        serial(tensor=lambda k, mass, length: rod(mass, length) * (1e6 if k == 1 else 1.0)), ("tensor unit",)
    ),
    "masses in g": Kind(serial(mass=lambda k: 1000.0 * MASSES[k]), ("masses",)),
    "lengths in mm": Kind(serial(scale=1000.0, centre=lambda k: f"0 0 {500.0 * LENGTHS[k]}"), ("lengths",)),
    "centres in mm": Kind(serial(centre=lambda k: f"0 {500.0 * LENGTHS[k]} 0"), ("lengths",)),
    "one centre in mm": Kind(serial(centre=lambda k: "0 9 0.1" if k == 2 else "0 0 0.1"), ("centres",)),
    "limits in degrees": Kind(serial(limit=limits("-170", "170")), ("limits",)),
    "angles in degrees": Kind(serial(rpy="0 0 90"), ("angles",)),
    # Numbers that nobody measured.
    "radii far beyond the links": Kind(
        serial(tensor=lambda _k, mass, length: 40.0 * rod(mass, length)), ("radius of gyration",)
    ),
    "unit tensors": Kind(serial(tensor=lambda *_: np.eye(3)), ("placeholder",)),
    "tensors of 0.01": Kind(serial(tensor=lambda *_: 0.01 * np.eye(3)), ("placeholder",)),
    "one tensor at all masses": Kind(serial(tensor=lambda *_: rod(1.0, 0.3)), ("placeholder",)),
    "like links": Kind(serial(tensor=lambda *_: rod(2.0, 0.3), mass=lambda _k: 2.0)),
    "centre outside the box": Kind(
        serial(centre=lambda k: "0 0.3 0.1" if k == 1 else f"0 0 {LENGTHS[k] / 2}", visual=lambda _k: box()),
        ("centre outside",),
    ),
    "mesh in mm": Kind(serial(visual=lambda k: box("90 90 300", "0 0 150")), (), ("mesh unit",)),
    "meshes missing": Kind(serial(visual=lambda k: mesh(f"package://nowhere/link{k}.stl")), (), ("meshes missing",)),
    "mass on the last axis": Kind(
        serial(
            tensor=lambda k, m, a: rod(m, a) if k < 2 else 1e-9 * np.eye(3), centre=lambda k: f"0 0 {LENGTHS[k] / 2}"
        ),
        ("unresisted",),
    ),
    "effort zero": Kind(serial(limit=limits(effort="0")), (), ("zero effort",)),
    "velocity zero": Kind(serial(limit=limits(velocity="0")), (), ("zero velocity",)),
    "no friction": Kind(serial(limit=LIMIT), (), ("friction",)),
    "no limits at all": Kind(serial(limit='<dynamics damping="1"/>')),
    # What is refused, and why.
    "impossible links": Kind(
        serial(tensor=lambda *_: np.diag([0.01, 0.01, 0.05])),
        ("placeholder",),
        refused="3 faults of what moves",
    ),
    "impossible links, repaired": Kind(
        serial(tensor=lambda k, mass, _a: mass * np.diag([0.01, 0.01, 0.05 + 0.01 * k])), options={"repair": True}
    ),
    "negative mass": Kind(serial(mass=lambda k: -1.0 if k == 2 else MASSES[k]), refused="correct the sign"),
    "no inertia on a moving link": Kind(serial(extra=[on("link3", "wrist", "")]), refused="carries no inertia", nv=4),
    "nothing resists the last joint": Kind(
        serial(tensor=lambda k, m, a: rod(m, a) if k < 2 else np.zeros((3, 3))),
        ("unresisted",),
        refused="nothing resists",
    ),
    "more than 32 joints": Kind(two_arms(17).replace(LIMIT, FRICTION), refused="at most 32"),
    "floating base": Kind(
        serial().replace("</robot>", link("world") + joint("free", "world", "base", "floating") + "</robot>"),
        refused="a floating base",
        unreadable=True,
    ),
    "closed loop": Kind(serial(extra=[joint("strut", "base", "link3")]), refused="a closed loop", unreadable=True),
    "xacro": Kind(serial().replace("0 0 0.1", "0 0 ${height}"), refused="xacro", unreadable=True),
    "SDF": Kind("<sdf version='1.7'/>", refused="SDF", unreadable=True),
}
