"""What was taken otherwise than a URDF has it, in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from asmc_pin.arms.bodies.moving_bodies import MovingBody
from asmc_pin.arms.urdf.urdf_reading import Joint, Robot


def remarks_on_loading(
    robot: Robot, joints: Sequence[Joint], bodies: Sequence[MovingBody], locked: Mapping[str, float]
) -> list[str]:
    """What was taken otherwise than written, or is odd about limits and locked joints.

    Args:
        robot: The checked URDF.
        joints: The driven ones.
        bodies: What moves.
        locked: Joints that are locked, and where.
    """
    found = [
        ("position limits", [j.name for j in joints if np.isinf(j.upper - j.lower) and not j.continuous], "no limit"),
        ("effort limits", [j.name for j in joints if np.isinf(j.effort)], "unlimited torque"),
        ("velocity limits", [j.name for j in joints if np.isinf(j.velocity)], "no limit"),
    ]
    warnings = [
        f"zero, missing or endless {what} for {', '.join(names)} in {robot.path.name}: taken as undeclared, {meaning}"
        for what, names, meaning in found
        if names
    ]
    for link in (link for body in bodies for link in body.links):
        own = robot.inertials.get(link)
        if own is not None and own.mass == 0.0 and np.any(own.written):
            warnings.append(f"link '{link}' has a rotational inertia but no mass; both are taken as written")
    sliding = [joint.name for joint in joints if joint.kind == "prismatic"]
    if sliding:
        warnings.append(f"prismatic: {', '.join(sliding)}; m, m/s, N and kg there, not rad, rad/s, N·m and kg·m²")
    for joint in joints:
        if joint.mimic is not None:
            warnings.append(
                f"joint '{joint.name}' mimics '{joint.mimic.joint}' in the URDF; here it has a motor of its own"
            )
        if joint.lower == joint.upper:
            warnings.append(
                f"joint '{joint.name}' has no range, both its limits are {joint.lower:g}; lock it, or mend them"
            )
    for name, value in locked.items():
        joint = robot.joints[name]
        if not joint.lower <= value <= joint.upper:
            warnings.append(
                f"joint '{name}' is locked at {value:g}, outside its limits {joint.lower:g} … {joint.upper:g}"
            )
        follows = joint.mimic is not None and joint.mimic.multiplier != 0.0
        if joint.mimic is not None and follows and joint.mimic.joint not in (*locked, *robot.fixed):
            warnings.append(f"joint '{name}' is locked although it mimics '{joint.mimic.joint}', which moves")
    return warnings
