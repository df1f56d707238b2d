"""A MuJoCo model (MJCF) as a URDF: MuJoCo reads it, and what it made of it is written down, joint by joint.

MuJoCo's own reader knows its defaults, units, includes and shapes; whoever loads the result holds its M(q) against
MuJoCo's, see `MjcfModel.samples`.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.rigid_inertia import ENTRIES
from asmc_pin.disk.reading import shown
from asmc_pin.errors import ArmError
from asmc_pin.words.text import printable

_CONFIGURATIONS = 8
_BASE = "world"


@dataclass(frozen=True)
class MassSample:
    """MuJoCo's M at a configuration, armature included.

    Attributes:
        q: Joint to value, rad (m).
        mass: Shape (nv, nv), joints in the order of `q`, kg·m².
    """

    q: Mapping[str, float]
    mass: Array


@dataclass(frozen=True)
class MjcfModel:
    """What a MJCF file comes to.

    Attributes:
        text: The URDF.
        armature: Reflected rotor inertia by joint, kg·m² (kg); a URDF has no place for it.
        samples: MuJoCo's M(q), to hold the URDF against.
        gravity: m/s², in the base frame.
    """

    text: str
    armature: Mapping[str, float]
    samples: tuple[MassSample, ...]
    gravity: tuple[float, float, float]


def can_convert() -> bool:
    """Whether MuJoCo is installed."""
    return find_spec("mujoco") is not None


def converted(path: Path) -> MjcfModel:
    """Read a MJCF file with MuJoCo.

    Args:
        path: The file; meshes are needed only where a body's inertia is computed from them.

    Raises:
        ArmError: MuJoCo refuses it, or it has what a URDF of an arm cannot say; the message names it.
    """
    import mujoco

    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _leave_out_meshes(mujoco, spec)
        model = spec.compile()
    except Exception as error:
        said = printable(" ".join(str(error).split()))
        raise ArmError(path, f"{shown(path)}: MuJoCo cannot read this model: {said}") from None
    names = _Names(mujoco, model)
    followed = _followed(mujoco, model, names, path)
    root = etree.Element("robot", name=printable(spec.modelname or path.stem))
    etree.SubElement(root, "link", name=_BASE)
    for body in range(1, model.nbody):
        _write_body(mujoco, model, names, path, body, root)
    for joint, (master, offset, factor) in followed.items():
        element = root.find(f"joint[@name='{joint}']") if "'" not in joint else None
        if element is not None:
            etree.SubElement(element, "mimic", joint=master, offset=repr(offset), multiplier=repr(factor))
    armature = {
        names.joints[joint]: float(model.dof_armature[model.jnt_dofadr[joint]])
        for joint in range(model.njnt)
        if model.dof_armature[model.jnt_dofadr[joint]] > 0.0
    }
    gravity = tuple(float(each) for each in model.opt.gravity)
    text: str = etree.tostring(root, encoding="unicode", pretty_print=True)
    return MjcfModel(text, armature, _samples(mujoco, model, names), (gravity[0], gravity[1], gravity[2]))


class _Names:
    """Names of bodies and joints; MuJoCo lets them go without, and a URDF does not."""

    def __init__(self, mujoco: Any, model: Any) -> None:
        kind = mujoco.mjtObj
        self.bodies = [_BASE] + [
            mujoco.mj_id2name(model, kind.mjOBJ_BODY, k) or f"body_{k}" for k in range(1, model.nbody)
        ]
        self.joints = [mujoco.mj_id2name(model, kind.mjOBJ_JOINT, k) or f"joint_{k}" for k in range(model.njnt)]


def _leave_out_meshes(mujoco: Any, spec: Any) -> None:
    """Take away the shapes of bodies whose inertia is written, so that their meshes need not be there."""
    kept: set[str] = set()
    for body in spec.bodies:
        for geom in list(body.geoms):
            if body.explicitinertial or body.name == _BASE:
                spec.delete(geom)
            elif geom.type == mujoco.mjtGeom.mjGEOM_MESH:
                kept.add(geom.meshname)
    for mesh in list(spec.meshes):
        if mesh.name not in kept:
            spec.delete(mesh)
    for group in ("textures", "materials", "skins", "hfields", "keys", "sensors", "excludes", "pairs"):
        for each in list(getattr(spec, group, ())):
            if group != "materials" or not kept:
                spec.delete(each)


def _write_body(mujoco: Any, model: Any, names: _Names, path: Path, body: int, root: Any) -> None:
    """A body's link, and the joint or joints between it and its parent."""
    name = names.bodies[body]
    link = etree.SubElement(root, "link", name=name)
    if model.body_mass[body] > 0.0:
        turn = _matrix(mujoco, model.body_iquat[body])
        inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
        inertial = etree.SubElement(link, "inertial")
        etree.SubElement(inertial, "origin", xyz=_triple(model.body_ipos[body]), rpy="0 0 0")
        etree.SubElement(inertial, "mass", value=repr(float(model.body_mass[body])))
        etree.SubElement(
            inertial,
            "inertia",
            {key: repr(float(0.5 * (inertia[at] + inertia[at[::-1]]))) for key, at in ENTRIES.items()},
        )
    turn, place = _matrix(mujoco, model.body_quat[body]), np.array(model.body_pos[body])
    parent = names.bodies[model.body_parentid[body]]
    count = int(model.body_jntnum[body])
    if count > 1:
        raise ArmError(
            path,
            f"{shown(path)}: body '{printable(name)}' has {count} joints, and a link of a URDF has one. Put a body "
            "with an inertia of its own between them",
        )
    if count == 0:
        _write_joint(root, f"{name}__fixed", "fixed", parent, name, place, turn)
        return
    joint = int(model.body_jntadr[body])
    kinds = {int(mujoco.mjtJoint.mjJNT_HINGE): "revolute", int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic"}
    kind = kinds.get(int(model.jnt_type[joint]))
    if kind is None:
        raise ArmError(
            path,
            f"{shown(path)}: joint '{printable(names.joints[joint])}' is a free or a ball joint; these are arms on a "
            "fixed base, with joints of one coordinate: remove it, or write it as hinges",
        )
    axis, anchor, zero = (
        model.jnt_axis[joint],
        np.array(model.jnt_pos[joint]),
        float(model.qpos0[model.jnt_qposadr[joint]]),
    )
    moving = name if not anchor.any() else f"{name}__at_{names.joints[joint]}"
    place = place + turn @ anchor
    if kind == "revolute":
        turned = np.empty(4)
        mujoco.mju_axisAngle2Quat(turned, np.asarray(axis), -zero)
        turn = turn @ _matrix(mujoco, turned)
    else:
        place = place - turn @ (zero * np.asarray(axis))
    limited = bool(model.jnt_limited[joint])
    made = _write_joint(root, names.joints[joint], kind if limited else _endless(kind), parent, moving, place, turn)
    etree.SubElement(made, "axis", xyz=_triple(axis))
    limits = (
        {}
        if not limited
        else {"lower": repr(float(model.jnt_range[joint][0])), "upper": repr(float(model.jnt_range[joint][1]))}
    )
    etree.SubElement(made, "limit", **limits, effort=repr(_effort(mujoco, model, joint)), velocity="0")
    dof = model.jnt_dofadr[joint]
    damping = float(np.ravel(model.dof_damping[dof])[0])
    etree.SubElement(made, "dynamics", damping=repr(damping), friction=repr(float(model.dof_frictionloss[dof])))
    if moving != name:
        etree.SubElement(root, "link", name=moving)
        _write_joint(root, f"{name}__fixed", "fixed", moving, name, -anchor, np.eye(3))


def _endless(kind: str) -> str:
    return "continuous" if kind == "revolute" else kind


def _write_joint(root: Any, name: str, kind: str, parent: str, child: str, place: Array, turn: Array) -> Any:
    joint = etree.SubElement(root, "joint", name=name, type=kind)
    etree.SubElement(joint, "parent", link=parent)
    etree.SubElement(joint, "child", link=child)
    etree.SubElement(joint, "origin", xyz=_triple(place), rpy=_triple(_roll_pitch_yaw(turn)))
    return joint


def _effort(mujoco: Any, model: Any, joint: int) -> float:
    """The largest torque that the actuators and the joint's own limit allow; zero is a URDF's "not declared"."""
    found = []
    if model.jnt_actfrclimited[joint]:
        found.append(float(np.max(np.abs(model.jnt_actfrcrange[joint]))))
    driven = 0.0
    for k in range(model.nu):
        if int(model.actuator_trntype[k]) == int(mujoco.mjtTrn.mjTRN_JOINT) and model.actuator_trnid[k][0] == joint:
            if not model.actuator_forcelimited[k]:
                return min(found, default=0.0)
            driven += float(np.max(np.abs(model.actuator_forcerange[k])) * abs(model.actuator_gear[k][0]))
    return min([*found, driven] if driven else found, default=0.0)


def _followed(mujoco: Any, model: Any, names: _Names, path: Path) -> dict[str, tuple[str, float, float]]:
    """Joints that follow another by an equality: the joint to its master, offset and factor."""
    found: dict[str, tuple[str, float, float]] = {}
    for k in range(model.neq):
        first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        if int(model.eq_type[k]) != int(mujoco.mjtEq.mjEQ_JOINT) or second < 0 or np.any(model.eq_data[k][2:5]):
            raise ArmError(
                path,
                f"{shown(path)}: has an equality that is no joint following another in proportion (a closed loop, a "
                "tendon or a curve); arms are open chains here. Remove it, or use a model without that part",
            )
        offset, factor = (float(each) for each in model.eq_data[k][:2])
        start = model.qpos0[model.jnt_qposadr[first]] - factor * model.qpos0[model.jnt_qposadr[second]]
        found[names.joints[first]] = (names.joints[second], offset + float(start), factor)
    return found


def _samples(mujoco: Any, model: Any, names: _Names) -> tuple[MassSample, ...]:
    data = mujoco.MjData(model)
    generator = np.random.default_rng(0)
    found = []
    for _ in range(_CONFIGURATIONS):
        q = generator.uniform(-np.pi, np.pi, model.njnt)
        data.qpos[model.jnt_qposadr] = q
        mujoco.mj_forward(model, data)
        mass = np.empty((model.nv, model.nv))
        for row, unit in zip(mass, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        order = np.asarray(model.jnt_dofadr)
        found.append(MassSample(dict(zip(names.joints, q.tolist(), strict=True)), mass[np.ix_(order, order)]))
    return tuple(found)


def _matrix(mujoco: Any, quaternion: Array) -> Array:
    unit: Array = np.asarray(quaternion, dtype=np.float64) / np.linalg.norm(quaternion)
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, unit)
    return flat.reshape(3, 3)


def _roll_pitch_yaw(turn: Array) -> Array:
    """Angles about fixed axes, such that they give the same rotation also where pitch is a right angle."""
    yaw = np.arctan2(turn[1, 0], turn[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    pitch = np.arctan2(-turn[2, 0], c * turn[0, 0] + s * turn[1, 0])
    roll = np.arctan2(s * turn[0, 2] - c * turn[1, 2], c * turn[1, 1] - s * turn[0, 1])
    return np.array([roll, pitch, yaw])


def _triple(values: Any) -> str:
    return " ".join(repr(float(each)) for each in itertools.islice(values, 3))
