"""Inspecting a URDF: read as other commands read it, refused or not, and doubted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.assembling import Recipe, Unjudged, assemble, put_together
from asmc_pin.arms.bodies.at_a_glance import axes_at_zero
from asmc_pin.arms.loading import recipe_of
from asmc_pin.arms.urdf.urdf_document import parsed_again
from asmc_pin.errors import ArmError
from asmc_pin.inspection.body_doubts import body_doubts
from asmc_pin.inspection.drawn_doubts import drawn_doubts
from asmc_pin.inspection.inspected_joint import InspectedJoint
from asmc_pin.inspection.inspection_page import inspection_page
from asmc_pin.inspection.inspection_report import Inspection
from asmc_pin.inspection.subject_of_doubt import Doubt, SubjectOfDoubt, radii_of, subject_of
from asmc_pin.inspection.unit_doubts import unit_doubts
from asmc_pin.words.text import printable


def inspect(source: str | Path, **options: Any) -> Inspection:
    """Say what is read of a URDF and what is doubtful about it, also where it would be refused.

    Args:
        source: As of `load_arm`.
        **options: Those of `load_arm`.

    Returns:
        The inspection; `Inspection.refusal` says why `load_arm` refuses it, if it does.

    Raises:
        ArmError: The file is no URDF whose joints and links could be told.
        ParameterError: An option at fault.
    """
    recipe = recipe_of(source, **options)
    parts = put_together(recipe)
    refusal, arm = "", None
    try:
        arm = assemble(recipe)
    except ArmError as error:
        refusal = str(error)
    armature = None if arm is None else np.array(arm.model.armature)
    subject = subject_of(parts, armature)
    doubts = [*quick_doubts(subject), *drawn_doubts(subject, recipe.files)]
    entry = recipe.entry
    return Inspection(
        name=entry.name if entry else printable(parts.robot.name),
        source=parts.robot.path,
        sha256=parts.robot.sha256,
        joints=_joints(parts, np.zeros(parts.model.nv) if armature is None else armature),
        standing=_standing(parts),
        locked=dict(parts.locked),
        payload=None if arm is None else arm.payload,
        refusal=refusal,
        doubts=tuple(sorted(doubts, key=lambda doubt: not doubt.serious)),
        notes=() if arm is None else arm.warnings,
        provisos=parts.robot.provisos,
        page=None if arm is None else lambda: inspection_page(arm),
    )


def quick_doubts(subject: SubjectOfDoubt) -> list[Doubt]:
    """All doubts that need no mesh."""
    robot = subject.parts.robot
    root = parsed_again(robot.path, robot.text, robot.sha256, (), None).root
    of_bodies = list(body_doubts(subject, root))
    invented = {link for doubt in of_bodies if doubt.kind == "placeholder" for link in doubt.about}
    return [*unit_doubts(subject, root, invented), *of_bodies]


def serious_doubts(arm: Arm) -> list[Doubt]:
    """What every command that loads an arm says of it: doubts that put M(q) in doubt, and need no mesh.

    Args:
        arm: The arm.
    """
    recipe = Recipe(arm.made_of.robot, arm.files, arm.made_of.entry, arm.made_of.variant)
    subject = subject_of(put_together(recipe), np.array(arm.model.armature))
    return [doubt for doubt in quick_doubts(subject) if doubt.serious]


def _joints(parts: Unjudged, armature: Array) -> list[InspectedJoint]:
    model, (axes, places) = parts.model, axes_at_zero(parts.model)
    found, followed = [], parts.followed.mimics
    without_axis = {name for fault in parts.robot.faults if fault.kind == "axis" for name in fault.about}
    for index, body in enumerate(parts.bodies, start=1):
        joint = body.joint
        found.append(
            InspectedJoint(
                name=joint.name,
                hangs_on="" if model.parents[index] == 0 else parts.bodies[model.parents[index] - 1].joint.name,
                kind="continuous" if joint.continuous else joint.kind,
                follows=followed.get(joint.name),
                axis=np.zeros(3) if joint.name in without_axis else axes[index - 1],
                place=places[index - 1],
                limits=(joint.lower, joint.upper, joint.effort, joint.velocity),
                losses=(joint.friction, joint.damping),
                armature=float(armature[index - 1]),
                links=body.links,
                mass=body.mass,
                com=body.com if body.mass > 0.0 else np.full(3, np.nan),
                inertia=body.inertia,
                radii=radii_of(body),
            )
        )
    return found


def _standing(parts: Unjudged) -> tuple[str, ...]:
    moving = {link for body in parts.bodies for link in body.links}
    return tuple(link for link in parts.robot.links if link not in moving)
