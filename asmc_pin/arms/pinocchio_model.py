"""From a checked URDF to a Pinocchio model with one coordinate per joint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms.payload import Payload
from asmc_pin.arms.urdf.urdf_reading import JOINT_PREFIX, Joint, Robot
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.rigid_body.coupling import Coupling
from asmc_pin.words.nearest_name import nearest

# Joint angles at which M(q) is examined; any spread will do, it only has to be the same every time.
_SAMPLES = 16

# kg·m² (kg): below it the inverse of M, squared, leaves the range of a double.
_LEAST = 1e-100
# m²: a radius of gyration of less than 1e-10 m is the rounding of a mass on the axis.
_NO_RADIUS = 1e-20
# Relative: a few roundings of rotations that are composed along a chain.
_MUJOCO_AGREES = 1e-12
# m²: a payload's radius of gyration about an axis, squared, below which it is on the axis: a micrometre.
_ON_AXIS = 1e-12


def whole_model(robot: Robot) -> pin.Model:
    """The robot as its URDF has it, `JOINT_PREFIX` before every joint's name, nothing locked.

    Raises:
        ArmError: Pinocchio refuses the file.
    """
    try:
        return pin.buildModelFromXML(robot.xml)
    except ValueError as error:
        raise ArmError(robot.path, f"{robot.path}: Pinocchio cannot build this arm ({error})") from None


def bare_model(robot: Robot, model: pin.Model, locked: Mapping[str, float]) -> pin.Model:
    """The arm: locked joints merged into their parents, every joint with its own name.

    Args:
        robot: The URDF.
        model: What `whole_model` made of it; may be changed.
        locked: Joint to value, rad (m).

    Raises:
        ArmError: Nothing moves.
    """
    if locked:
        q = pin.neutral(model)
        indices = [model.getJointId(JOINT_PREFIX + name) for name in locked]
        for index, value in zip(indices, locked.values(), strict=True):
            q[model.joints[index].idx_q] = value
        model = pin.buildReducedModel(model, indices, q)
    for index, name in enumerate(model.names):
        model.names[index] = name.removeprefix(JOINT_PREFIX)
    for frame in model.frames:
        frame.name = frame.name.removeprefix(JOINT_PREFIX)
    if model.nv == 0:
        raise ArmError(robot.path, f"{robot.path}: nothing movable, every joint is locked; free one")
    return model


def link_frame(robot: Robot, model: pin.Model, link: str) -> pin.Frame:
    """Frame of a link that moves.

    Raises:
        ParameterError: No such link, or it stands still.
    """
    if link not in robot.links:
        raise ParameterError("payload.link", f"no link '{link}' in {robot.path.name}; {nearest(link, robot.links)}")
    frame = model.frames[model.getFrameId(link, pin.FrameType.BODY)]
    if frame.parentJoint == 0:
        raise ParameterError(
            "payload.link", f"link '{link}' does not move, so a payload on it changes nothing; name one that does"
        )
    return frame


def last_link(robot: Robot, model: pin.Model) -> str:
    """Child link of the last moving joint.

    Raises:
        ParameterError: The arm branches, so there is no last link.
    """
    parents = set(model.parents[1:])
    tips = [index for index in range(1, model.njoints) if index not in parents]
    if len(tips) > 1:
        ends = ", ".join(robot.joints[model.names[index]].child for index in tips)
        raise ParameterError(
            "payload.link", f"the arm has {len(tips)} ends ({ends}); name the link that carries the payload"
        )
    return robot.joints[model.names[tips[0]]].child


def carry(robot: Robot, model: pin.Model, payload: Payload) -> None:
    """Add a payload, whose link is named, to the body that carries it."""
    frame = link_frame(robot, model, payload.link or last_link(robot, model))
    body = pin.Inertia(payload.mass, np.array(payload.com), payload.inertia_matrix)
    # Not `+=`: the vector hands out references, and the sum is to stand in the model.
    model.inertias[frame.parentJoint] = model.inertias[frame.parentJoint] + frame.placement.act(body)


def loads_in_vain(robot: Robot, model: pin.Model, coupling: Coupling, payload: Payload) -> list[str]:
    """Joints that a payload cannot load, in plain words: beyond the link that carries it, or with it on their axis.

    Args:
        robot: The checked URDF.
        model: The arm, with or without the payload.
        coupling: How its joints follow its coordinates.
        payload: With its link named.
    """
    if payload.mass == 0.0:
        return []
    frame = link_frame(robot, model, str(payload.link))
    body = frame.placement.act(pin.Inertia(payload.mass, np.array(payload.com), payload.inertia_matrix))
    alone = model.copy()
    for index in range(1, alone.njoints):
        alone.inertias[index] = body if index == frame.parentJoint else pin.Inertia.Zero()
    alone.armature = np.zeros(alone.nv)
    data, generator = alone.createData(), np.random.default_rng(0)
    felt = np.zeros(coupling.nv)
    for q in generator.uniform(-np.pi, np.pi, (_SAMPLES, coupling.nv)):
        felt = np.maximum(felt, np.diag(coupling.form(pin.crba(alone, data, coupling.joints(q)))))
    names = [str(model.names[int(leader) + 1]) for leader in coupling.leader]
    unfelt = [bool(value <= _ON_AXIS * payload.mass) for value in felt]
    beyond, on_axis = [], []
    carrying, outer = set(model.supports[frame.parentJoint]), set(model.subtrees[frame.parentJoint])
    for k, leader in enumerate(coupling.leader):
        if unfelt[k] and int(leader) + 1 in carrying:
            on_axis.append(names[k])
        elif unfelt[k] and int(leader) + 1 in outer:
            beyond.append(names[k])
    said = []
    if beyond:
        said.append(
            f"the payload is on link '{payload.link}' and does not load {_joints(beyond)} beyond it; name the link "
            "that carries it"
        )
    if on_axis:
        said.append(
            f"the payload is a point on the axis of {_joints(on_axis)}, which it does not load; give its centre of "
            "mass (com) or its inertia, if it has any"
        )
    return said


def _joints(names: list[str]) -> str:
    listed = ", ".join(f"'{name}'" for name in names)
    return f"joint{'s' if len(names) > 1 else ''} {listed}"


def set_limits(model: pin.Model, joints: list[Joint]) -> None:
    """Write the limits as read, so that whoever takes the Pinocchio model finds ±inf and not our placeholder."""
    model.lowerPositionLimit = np.array([joint.lower for joint in joints])
    model.upperPositionLimit = np.array([joint.upper for joint in joints])
    for name, values in (("velocityLimit", [j.velocity for j in joints]), ("effortLimit", [j.effort for j in joints])):
        setattr(model, name, np.array(values))


def mass_matrix_problem(robot: Robot, model: pin.Model, coupling: Coupling) -> str:
    """Say of an arm that its M(q) is not positive definite, or nothing.

    M is scaled to a unit diagonal first, so that a light wrist on a heavy arm, or metres next to radians, do not count
    as singular.

    Returns:
        A sentence with the joint that feels no inertia, and the configuration; empty where M(q) is fine.
    """
    data = model.createData()
    generator = np.random.default_rng(0)
    for q in np.vstack([np.zeros(coupling.nv), generator.uniform(-np.pi, np.pi, (_SAMPLES, coupling.nv))]):
        mass: Array = coupling.form(pin.crba(model, data, coupling.joints(q)))
        diagonal = np.diag(mass)
        comparable = bool(np.all(diagonal > max(1e-16 * diagonal.max(), _LEAST)))
        if comparable:
            scale = 1.0 / np.sqrt(diagonal)
            values, vectors = np.linalg.eigh(mass * scale[:, None] * scale)
            if values[0] > 8.0 * coupling.nv * np.finfo(float).eps:
                continue
            weak = int(np.argmax(np.abs(vectors[:, 0])))
        else:
            weak = int(np.argmin(diagonal))
        return _singular(robot, model, q, mass, weak, int(coupling.leader[weak]), comparable)
    return ""


def _where(q: Array) -> str:
    return f"q = {np.round(q, 3).tolist()}" if np.any(q) else "q = 0"


def check_against_mujoco(robot: Robot) -> None:
    """Hold the URDF of a MJCF file against the M(q) that MuJoCo had for the file itself.

    Raises:
        ArmError: They differ by more than `_MUJOCO_AGREES`, relative to the largest entry.
    """
    if robot.mjcf is None:
        return
    model = pin.buildModelFromXML(robot.xml)
    data = model.createData()
    names = [name.removeprefix(JOINT_PREFIX) for name in model.names[1:]]
    armature = np.diag([robot.mjcf.armature.get(name, 0.0) for name in names])
    for sample in robot.mjcf.samples:
        order = [list(sample.q).index(name) for name in names]
        mass: Array = pin.crba(model, data, np.array([sample.q[name] for name in names])) + armature
        off = float(np.max(np.abs(mass - sample.mass[np.ix_(order, order)])) / np.max(np.abs(sample.mass)))
        if not off <= _MUJOCO_AGREES:
            raise ArmError(
                robot.path,
                f"{robot.path}: this is a MuJoCo model (MJCF), and as a URDF its M(q) differs from MuJoCo's by "
                f"{off:.2g} of the largest entry, so it is not used. Use the URDF that its maker publishes",
            )


def _singular(robot: Robot, model: pin.Model, q: Array, mass: Array, weak: int, number: int, comparable: bool) -> str:
    """Why M(q) is not positive definite: a joint without inertia, or masses that are too far apart or too small."""
    joint = robot.joints[model.names[number + 1]]
    carried = [number + 1]
    for index in range(number + 2, model.njoints):
        if model.parents[index] in carried:
            carried.append(index)
    weight = sum(model.inertias[index].mass for index in carried)
    if not comparable and mass[weak, weak] > _NO_RADIUS * weight:
        heaviest = max(range(1, model.njoints), key=lambda index: model.inertias[index].mass)
        link = robot.joints[model.names[heaviest]].child
        return (
            f"{joint.where}: M(q) is no matrix that can be computed with at {_where(q)}: what hangs "
            f"on this joint has a mass of {weight:.3g} kg and feels {mass[weak, weak]:.3g} kg·m² (kg), while link "
            f"'{link}', with what is fixed to it, has {model.inertias[heaviest].mass:.3g} kg. Check these masses"
        )
    smallest = float(np.linalg.eigvalsh(mass)[0])
    return (
        f"{joint.where}: the mass matrix is not positive definite at {_where(q)} (smallest "
        f"eigenvalue {smallest:.3g}), because nothing resists this joint: link '{joint.child}' and what hangs on "
        "it have their mass on its axis and no rotational inertia about it, or another joint moves them just so. "
        f"Give link '{joint.child}' its inertia, or joint '{joint.name}' an armature"
    )
