"""Loading an arm: from a name or a path to an `Arm`."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from asmc_pin.arms.arm import Arm
from asmc_pin.arms.arm_options import (
    Armature,
    ChainEnds,
    Gravity,
    Load,
    Lock,
    read_variant,
)
from asmc_pin.arms.assembling import Recipe, assemble
from asmc_pin.arms.pinocchio_model import (
    check_against_mujoco,
)
from asmc_pin.arms.registry import find, package_shares
from asmc_pin.arms.sources.carried import CarriedUrdf
from asmc_pin.arms.sources.reading_options import Packages, Reading, XacroArguments, read_packages, read_xacro
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.estimated_inertia import EstimateInertia, read_estimate, with_estimated_inertia
from asmc_pin.arms.urdf.urdf_document import read_document
from asmc_pin.arms.urdf.urdf_reading import read_robot
from asmc_pin.errors import ArmError


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
    if not isinstance(source, str | os.PathLike):
        raise ArmError(str(source), f"{source!r} given, an arm's name or the path of a URDF expected")
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
