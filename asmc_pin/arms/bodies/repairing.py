"""Repair on request: tensors of bodies that cannot be are taken to the nearest that can, in the URDF's text itself.

So whoever reads the repaired text by other means, an independent engine or the checker of a certificate, reads the same
arm. What is judged here is a link with what is fixed to it, whatever is locked besides: the repair then does not depend
on the angle at which a joint is locked, and all cases of a certificate have one URDF.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms.bodies.moving_bodies import impossible_link, moving_bodies, number_problems
from asmc_pin.arms.urdf.repair_record import write_repair
from asmc_pin.arms.urdf.rigid_inertia import nearest_inertia, tensor_problem
from asmc_pin.arms.urdf.urdf_document import parsed_again
from asmc_pin.arms.urdf.urdf_reading import Robot, read_robot


def repaired(robot: Robot, model: pin.Model, locked: Collection[str]) -> Robot:
    """A robot whose moving bodies have possible tensors, each the nearest to its own, masses and centres as they were.

    The change goes into the link of the body whose own tensor is furthest from possible: for a tensor is all that is
    added, it is the same about any centre.

    Args:
        robot: As it was read.
        model: Of it, nothing locked.
        locked: Names of the joints that will be.

    Returns:
        The robot of the repaired text, which says what was repaired; the same one where nothing was.
    """
    new: dict[str, Array] = {}
    moves = [False] * model.njoints
    for index, body in enumerate(moving_bodies(robot, model), start=1):
        moves[index] = moves[model.parents[index]] or body.joint.name not in locked
        if not moves[index] or number_problems(robot, body):  # a wrong sign is the user's to mend
            continue
        if not body.mass > 0.0 or not np.all(np.isfinite(body.inertia)) or not tensor_problem(body.mass, body.inertia):
            continue
        link = impossible_link(robot, body)
        own = robot.inertials[link]
        turn = body.poses[body.links.index(link), :3, :3] @ own.turn
        new[link] = own.written + turn.T @ (nearest_inertia(body.inertia) - body.inertia) @ turn
    if not new:
        return robot
    document = parsed_again(robot.path, robot.text, robot.sha256, robot.provisos, robot.mjcf)
    write_repair(document.root, robot.sha256, new)
    new_robot = read_robot(document.rewritten())
    # The user has the file as it was before them: places in messages are in that one.
    joints = {name: replace(joint, where=robot.joints[name].where) for name, joint in new_robot.joints.items()}
    inertials = {name: replace(own, where=robot.inertials[name].where) for name, own in new_robot.inertials.items()}
    return replace(
        new_robot,
        name=robot.name,
        joints=joints,
        inertials=inertials,
        faults=robot.faults,
        densities=robot.densities,
    )
