"""Loading an arm: from a name or a path to an `Arm`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms.arm import Arm, Variant
from asmc_pin.arms.build import bare_model, carry, check_mass_matrix, last_link, set_limits
from asmc_pin.arms.document import Document, read_document
from asmc_pin.arms.options import Lock, resolve_armature, resolve_gravity, resolve_locks
from asmc_pin.arms.payload import Payload, as_payload
from asmc_pin.arms.reading import Joint, Robot, read_robot
from asmc_pin.arms.registry import ArmEntry, find, package_dirs
from asmc_pin.arms.tree import tree_of
from asmc_pin.errors import ArmError


def load_arm(
    source: str | Path,
    *,
    payload: float | Payload | Mapping[str, Any] | None = None,
    armature: float | Sequence[float] | Array | Mapping[str, float] | None = None,
    lock: Lock | None = None,
    gravity: Sequence[float] | Array | None = None,
) -> Arm:
    """Load an arm.

    Args:
        source: Name of a known arm (`arm_names`), or path of a URDF. Meshes are not needed.
        payload: What it carries: a mass in kg, as a point at the frame of the last moving link; or a `Payload`, or a mapping with
            its fields, with centre, inertia and link.
        armature: Reflected rotor inertia (rotor inertia times gear ratio squared), kg·m² (kg where prismatic), added to the diagonal of
            M: one value, one per joint, or joint to value. Takes the place of what the arm's entry has.
        lock: Joint to value, rad (m): the joint is rigid there. Added to the entry's default locks; None or ``"free"`` frees one.
        gravity: Acceleration of gravity in the base frame, m/s²; default (0, 0, −9.81). (0, 0, 9.81) hangs the arm from a ceiling.

    Returns:
        The arm. `Arm.warnings` says what was taken otherwise than written.

    Raises:
        ArmError: Unknown name, or a URDF at fault.
        ParameterError: An option at fault.
    """
    path, entry = find(source)
    return _build(source, read_document(path), entry, Variant(payload, armature, lock, gravity))


def rebuild(arm: Arm, variant: Variant) -> Arm:
    """The same URDF with other options."""
    path, entry = find(arm.given)
    return _build(arm.given, read_document(path), entry, variant)


def _build(source: str | Path, document: Document, entry: ArmEntry | None, variant: Variant) -> Arm:
    robot = read_robot(document)
    locked = resolve_locks(robot, entry.locks if entry else {}, variant.lock)
    model = bare_model(robot, locked)
    names = tuple(model.names[1:])
    joints = [robot.joints[name] for name in names]
    _check_mimics(robot, joints, variant.lock or {})
    model.armature = resolve_armature(names, entry.armature if entry else {}, variant.armature)
    model.gravity.linear = resolve_gravity(variant.gravity)
    set_limits(model, joints)
    payload = as_payload(variant.payload)
    if payload is not None:
        payload = replace(payload, link=payload.link or last_link(robot, model))
        carry(robot, model, payload)
    check_mass_matrix(robot, model)
    return Arm(
        name=entry.name if entry else document.path.stem,
        joint_names=names,
        joint_kinds=tuple(joint.kind for joint in joints),
        continuous=_frozen([joint.continuous for joint in joints], bool),
        lower=_frozen([joint.lower for joint in joints]),
        upper=_frozen([joint.upper for joint in joints]),
        effort_limit=_frozen([joint.effort for joint in joints]),
        velocity_limit=_frozen([joint.velocity for joint in joints]),
        friction=_frozen([joint.friction for joint in joints]),
        damping=_frozen([joint.damping for joint in joints]),
        armature=_frozen(model.armature),
        gravity_vector=_frozen(model.gravity.linear),
        link_names=tuple(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY),
        locked=MappingProxyType(dict(locked)),
        payload=payload,
        warnings=(*robot.warnings, *_warnings(robot, joints, locked)),
        source=document.path,
        sha256=document.sha256,
        urdf_text=document.text,
        package_dirs=package_dirs(document.path),
        model=model,
        tree=tree_of(model),
        given=source,
        variant=variant,
    )


def _frozen(values: Any, dtype: type = float) -> Any:
    array = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array


def _check_mimics(robot: Robot, joints: Sequence[Joint], lock: Lock) -> None:
    for joint in joints:
        if joint.mimic is not None and joint.name not in lock:
            raise ArmError(
                robot.document.path,
                f"{joint.where}: it mimics joint '{joint.mimic.joint}', and coupled joints are not supported. Lock both "
                f"(lock '{joint.mimic.joint}' and this one follows), or free both (\"free\") to treat them as two motors",
            )


def _warnings(robot: Robot, joints: Sequence[Joint], locked: Mapping[str, float]) -> list[str]:
    def listed(what: str, found: list[str], meaning: str) -> list[str]:
        return (
            [f"{what} for {', '.join(found)} ({robot.document.path.name}): taken as undeclared, {meaning}"]
            if found
            else []
        )

    warnings = listed(
        "zero or missing position limits",
        [j.name for j in joints if np.isinf(j.lower) and not j.continuous],
        "no limit",
    )
    warnings += listed(
        "zero or missing effort limits", [j.name for j in joints if np.isinf(j.effort)], "unlimited torque"
    )
    warnings += listed("zero or missing velocity limits", [j.name for j in joints if np.isinf(j.velocity)], "no limit")
    sliding = [j.name for j in joints if j.kind == "prismatic"]
    if sliding:
        warnings.append(
            f"prismatic: {', '.join(sliding)}; metres, N and kg there, where turning joints have rad, N·m and kg·m²"
        )
    for name, value in locked.items():
        joint = robot.joints[name]
        if not joint.lower <= value <= joint.upper:
            warnings.append(
                f"joint '{name}' is locked at {value:g}, outside its limits {joint.lower:g} … {joint.upper:g}"
            )
    return warnings
