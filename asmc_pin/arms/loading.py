"""Loading an arm: from a name or a path to an `Arm`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from asmc_pin.arms.arm import Arm
from asmc_pin.arms.arm_options import (
    GRAVITY,
    Armature,
    ChainEnds,
    Gravity,
    Load,
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
    check_against_mujoco,
    last_link,
    loads_in_vain,
    mass_matrix_problem,
    set_limits,
    whole_model,
)
from asmc_pin.arms.pinocchio_tree import tree_of
from asmc_pin.arms.registry import ArmEntry, find, package_shares
from asmc_pin.arms.sources.carried import CarriedUrdf
from asmc_pin.arms.sources.reading_options import Packages, Reading, XacroArguments, read_packages, read_xacro
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.estimated_inertia import EstimateInertia, read_estimate, with_estimated_inertia
from asmc_pin.arms.urdf.faults import refused
from asmc_pin.arms.urdf.magnitudes import MOVING_JOINTS
from asmc_pin.arms.urdf.mimicking import Followed, settle_mimics
from asmc_pin.arms.urdf.urdf_document import read_document
from asmc_pin.arms.urdf.urdf_reading import Robot, read_robot
from asmc_pin.disk.reading import shown
from asmc_pin.words.interface import chain_words, lock_words
from asmc_pin.words.text import printable


def load_arm(
    source: str | Path,
    *,
    payload: Load | None = None,
    armature: Armature | None = None,
    lock: Lock | None = None,
    gravity: Gravity | None = None,
    repair: bool = False,
    chain: ChainEnds | None = None,
    xacro: XacroArguments | None = None,
    package: Packages | None = None,
    estimate_inertia: EstimateInertia | None = None,
    run_xacro: bool = True,
) -> Arm:
    """Load an arm.

    Args:
        source: Name of a known arm (`arm_names`), or of one of robot_descriptions where that is installed; or path of a
            URDF or a xacro file. Meshes are not needed.
        payload: What it carries: a mass in kg, as a point at the frame of the last moving link; a text ``2@tool0``, as
            a point at that link's frame; or a `Payload`, or a mapping with its fields, with centre, inertia and link.
        armature: Reflected rotor inertia (rotor inertia times gear ratio squared), kg·m² (kg where prismatic), on the
            diagonal of M: one value, one per joint, or joint to value. Takes the place of what the arm's entry has.
            ``"published"``: what is published of a named arm, see `published_armature`.
        lock: Joint to value, rad (m): the joint is rigid there. A pattern such as ``left_*`` stands for all joints that
            it matches, an exact name goes before it; ``grippers`` for all joints of grippers. Added to the entry's
            default locks; None or ``"free"`` frees one.
        gravity: Acceleration of gravity in the base frame, m/s²; default (0, 0, −9.81). (0, 0, 9.81) hangs the arm
            from a ceiling.
        repair: Whether inertia tensors that no rigid body has are taken to the nearest that one has. `Arm.provisos`
            says which, and by how much; `Arm.urdf_text` is the repaired URDF.
        chain: Links (base, tip): only joints between them move; the others are locked where they are nearest to zero,
            unless `lock` says otherwise.
        xacro: Values of a xacro file's arguments.
        package: ROS package to the folder where it lies, for a xacro file's ``$(find …)`` and for meshes.
        estimate_inertia: A mass, kg, that links without inertia share by their volume; or link to mass, for these
            links alone. Their shapes, meshes included, are then needed. `Arm.provisos` says what was estimated.
        run_xacro: Whether a xacro file may be expanded; it is a program. Without it such a file is refused.

    Returns:
        The arm. `Arm.warnings` says what was taken otherwise than written.

    Raises:
        ArmError: Unknown name, or a URDF at fault.
        ParameterError: An option at fault.
    """
    options: dict[str, Any] = {
        "payload": payload,
        "armature": armature,
        "lock": lock,
        "gravity": gravity,
        "repair": repair,
    }
    reading: dict[str, Any] = {"estimate_inertia": estimate_inertia, "run_xacro": run_xacro}
    return assemble(recipe_of(source, xacro, package, **reading, chain=chain, **options))


def recipe_of(
    source: str | Path,
    xacro: XacroArguments | None = None,
    package: Packages | None = None,
    estimate_inertia: EstimateInertia | None = None,
    run_xacro: bool = True,
    **options: Any,
) -> Recipe:
    """What `load_arm` makes an arm of, read and not judged; arguments as there."""
    path, entry = find(source)
    variant = read_variant(**options)
    files = RobotFiles(path.resolve().parent, read_packages(package), package_shares())
    arguments = {**(entry.xacro if entry else {}), **read_xacro(xacro)}
    document = read_document(path, Reading(files, arguments, run_xacro))
    masses = read_estimate(estimate_inertia)
    if masses is not None:
        document = with_estimated_inertia(document, masses, files)
    robot = read_robot(document)
    check_against_mujoco(robot)
    return Recipe(robot, files, entry, variant)


def load_carried(
    source: Path,
    carried: CarriedUrdf,
    *,
    package: Packages | None = None,
    **options: Any,
) -> Arm:
    """The arm of a result that came from a xacro file, without running that file again.

    Args:
        source: The xacro file, which need not be there any more; its name and folder count.
        carried: What the result has of it.
        package: As for `load_arm`, for meshes; folders that are gone are left out.
        options: Payload, armature, lock and gravity, as for `load_arm`.

    Returns:
        The arm as it was computed with.

    Raises:
        ArmError: The URDF that went along is at fault.
        ParameterError: An option at fault.
    """
    there = {name: folder for name, folder in (package or {}).items() if Path(folder).is_dir()}
    files = RobotFiles(source.resolve().parent, read_packages(there), package_shares())
    document = read_document(carried.path, Reading(files, run_xacro=False))
    document = replace(document, path=source, sha256=carried.sha256, provisos=carried.provisos, expanded=True)
    return assemble(Recipe(read_robot(document), files, None, read_variant(**options)))


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
    followed: Followed


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
