"""From a checked URDF and its options to an `Arm`: bodies merged and judged, limits, rotors and payload set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from asmc_pin.arms.arm import Arm
from asmc_pin.arms.arm_options import (
    GRAVITY,
    Lock,
    Variant,
    published_for,
    read_variant,
    resolve_armature,
    resolve_locks,
)
from asmc_pin.arms.bodies.moving_bodies import MovingBody, moving_bodies, problems_of_bodies
from asmc_pin.arms.bodies.repairing import repaired
from asmc_pin.arms.joint_choice import longest_chain, named_locks
from asmc_pin.arms.loading_remarks import remarks_on_loading
from asmc_pin.arms.pinocchio_model import (
    bare_model,
    carry,
    last_link,
    loads_in_vain,
    mass_matrix_problem,
    set_limits,
    whole_model,
)
from asmc_pin.arms.pinocchio_tree import tree_of
from asmc_pin.arms.registry import ArmEntry
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.faults import refused
from asmc_pin.arms.urdf.magnitudes import MOVING_JOINTS
from asmc_pin.arms.urdf.mimicking import SettledMimics, settle_mimics
from asmc_pin.arms.urdf.urdf_reading import Robot
from asmc_pin.disk.reading import shown
from asmc_pin.words.interface import chain_words, lock_words
from asmc_pin.words.text import printable


@dataclass(frozen=True)
class Recipe:
    """What an arm is made of.

    Attributes:
        robot: The checked URDF.
        files: Where its packages and meshes are looked for.
        entry: The registry's entry, where the arm was asked for by name.
        variant: The options.
    """

    robot: Robot
    files: RobotFiles
    entry: ArmEntry | None
    variant: Variant

    def assemble(self) -> Arm:
        """The arm."""
        return assemble(self)

    def vary(self, arm: Arm, changes: Mapping[str, Any]) -> Arm:
        """The arm with some options replaced, see `vary`."""
        return vary(arm, changes)


@dataclass(frozen=True, eq=False)
class Unjudged:
    """A robot and its moving bodies, before anything is refused of them.

    Attributes:
        robot: The URDF, repaired where that was asked for.
        model: Pinocchio's, locked joints merged; neither armature nor payload in it.
        bodies: What moves, one a joint.
        locked: Joints that were locked, and where.
        followed: What follows what, with the limits and friction that this leaves.
    """

    robot: Robot
    model: pin.Model
    bodies: list[MovingBody]
    locked: dict[str, float]
    followed: SettledMimics


def put_together(recipe: Recipe) -> Unjudged:
    """Merge what fixed and locked joints hold together.

    Raises:
        ArmError: Pinocchio refuses the file, or nothing moves.
        ParameterError: A lock or a chain at fault.
    """
    robot, entry, variant = recipe.robot, recipe.entry, recipe.variant
    asked = _asked_locks(robot, entry, variant)
    locked = resolve_locks(robot, entry.locks if entry else {}, asked)
    whole = whole_model(robot)
    if variant.repair:
        robot = repaired(robot, whole, locked)
        whole = whole_model(robot)
    model = bare_model(robot, whole, locked)
    bodies = moving_bodies(robot, model)
    return Unjudged(robot, model, bodies, locked, settle_mimics(robot, [body.joint for body in bodies], asked))


def assemble(recipe: Recipe) -> Arm:
    """Make the arm that a checked URDF and its options stand for.

    Args:
        recipe: What it is made of.

    Returns:
        The arm.

    Raises:
        ArmError: The URDF and the options together make no arm.
        ParameterError: An option at fault.
    """
    parts = put_together(recipe)
    robot, model, bodies, locked, followed = parts.robot, parts.model, parts.bodies, parts.locked, parts.followed
    entry, variant = recipe.entry, recipe.variant
    joints = [body.joint for body in bodies]
    driven, coupling = followed.driven, followed.coupling
    names = tuple(joint.name for joint in driven)
    faults = [*robot.faults, *followed.faults]
    problems = [fault.text for fault in faults]
    if len(joints) > MOVING_JOINTS:
        problems.append(
            f"{shown(robot.path)}: has {len(joints)} moving joints, and at most {MOVING_JOINTS} are computed with. "
            f"Keep one arm of it, {chain_words(*longest_chain(robot))}, or lock some, by name or pattern as in "
            f"{lock_words({'left_*': 0.0})}"
        )
    of_bodies, remedy = problems_of_bodies(robot, bodies, coupling)
    if of_bodies or len(joints) > MOVING_JOINTS or any(fault.hides_mass for fault in faults):
        raise refused(robot.path, [*problems, *of_bodies], "" if problems else " of what moves", remedy)
    name = entry.name if entry else printable(robot.name)
    provisos, armature = robot.provisos, variant.armature
    if isinstance(armature, str):
        armature, proviso = published_for(entry, name, names)
        provisos = provisos if proviso.text in (known.text for known in provisos) else (*provisos, proviso)
    every = (*names, *followed.mimics)
    rotors = resolve_armature(names, _own_armature(recipe), armature, tuple(followed.mimics))
    model.armature = rotors[[every.index(joint.name) for joint in joints]]
    own = robot.mjcf.gravity if robot.mjcf is not None else GRAVITY
    model.gravity.linear = np.array(own) if variant.gravity is None else variant.gravity
    set_limits(model, joints)
    payload, vain = variant.payload, []
    if payload is not None:
        payload = replace(payload, link=payload.link or last_link(robot, model))
        vain = loads_in_vain(robot, model, coupling, payload)
        carry(robot, model, payload)
    singular = mass_matrix_problem(robot, model, coupling)
    if singular or problems:
        raise refused(robot.path, [*problems, *([singular] if singular else [])])
    tree = tree_of(model, coupling)
    return Arm(
        name=name,
        joint_names=names,
        joint_kinds=tuple(joint.kind for joint in driven),
        continuous=_frozen([joint.continuous for joint in driven], np.bool_),
        lower=_frozen([joint.lower for joint in driven]),
        upper=_frozen([joint.upper for joint in driven]),
        effort_limit=_frozen([joint.effort for joint in driven]),
        velocity_limit=_frozen([joint.velocity for joint in driven]),
        friction=_frozen([joint.friction for joint in driven]),
        damping=_frozen([joint.damping for joint in driven]),
        armature=tree.armature,
        gravity_vector=_frozen(model.gravity.linear),
        link_names=tuple(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY),
        locked=MappingProxyType(locked),
        mimics=MappingProxyType(dict(followed.mimics)),
        payload=payload,
        warnings=(*remarks_on_loading(robot, driven, bodies, locked), *followed.notes, *vain),
        provisos=provisos,
        source=robot.path,
        sha256=robot.sha256,
        urdf_text=robot.text,
        files=recipe.files,
        model=model,
        tree=tree,
        made_of=recipe,
    )


def vary(arm: Arm, changes: Mapping[str, Any]) -> Arm:
    """The same URDF with some options replaced.

    Args:
        arm: The arm.
        changes: Options as `load_arm` takes them.

    Returns:
        A new arm; a joint that the new locks hold loses its armature.
    """
    robot, entry, variant = arm.made_of.robot, arm.made_of.entry, arm.made_of.variant
    asked = read_variant(**changes)
    # A payload stays on its link even where the new locks make another link the last one.
    new = replace(replace(variant, payload=arm.payload), **{name: getattr(asked, name) for name in changes})
    given = variant.armature is not None and not isinstance(variant.armature, str)
    if "lock" in changes and "armature" not in changes and given:
        held = resolve_locks(robot, entry.locks if entry else {}, _asked_locks(robot, entry, new))
        asked_for = variant.armature
        kept = asked_for if isinstance(asked_for, dict) else dict(zip(arm.joint_names, arm.armature, strict=True))
        new = replace(new, armature={name: float(value) for name, value in kept.items() if name not in held})
    return assemble(Recipe(robot, arm.files, entry, new))


def _own_armature(recipe: Recipe) -> Mapping[str, float]:
    """What the file or the registry's entry says; a URDF has no place for it."""
    if recipe.robot.mjcf is not None:
        return recipe.robot.mjcf.armature
    return recipe.entry.armature if recipe.entry else {}


def _asked_locks(robot: Robot, entry: ArmEntry | None, variant: Variant) -> Lock:
    return named_locks(robot, entry.locks if entry else {}, variant.lock or {}, variant.chain)


def _frozen(values: Any, dtype: Any = np.float64) -> Any:
    array = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array
