"""Which joints of a robot a user means: by name, by pattern, as grippers, or as all that is not on one chain."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fnmatch import fnmatchcase

import numpy as np

from asmc_pin.arms.urdf.urdf_reading import Joint, Robot
from asmc_pin.errors import ParameterError
from asmc_pin.words.interface import chain_words
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.text import printable

LockValue = float | str | None

GRIPPERS = "grippers"
"""Stands for all joints of grippers at once, where no joint has this name."""

_FINGER = re.compile(
    r"gripper|finger|thumb|knuckle|jaw|claw|pinky|(?:^|[_-])(?:index|middle|ring|little|palm)(?:[_-]|\d|$)",
    re.IGNORECASE,
)


def named_locks(
    robot: Robot, default: Mapping[str, float], lock: Mapping[str, LockValue], chain: tuple[str, str] | None
) -> dict[str, LockValue]:
    """Locks joint by joint: an exact name goes before a pattern, a later pattern before an earlier one.

    A joint that mimics another locked one is not locked by a pattern or a chain: it follows.

    Args:
        robot: The URDF.
        default: Locks that the arm has of its own.
        lock: As the user gave it: names, patterns with ``*``, ``?`` and ``[…]``, or `GRIPPERS`.
        chain: Links (base, tip): joints that are not between them are locked where they are nearest to zero.

    Returns:
        Value by joint, as the user gave it. What is neither a joint nor a pattern stays as it is, for a message.

    Raises:
        ParameterError: A pattern that matches no joint that could move, no gripper, or no such chain.
    """
    wide: dict[str, LockValue] = {}
    if chain is not None:
        between = _between(robot, chain)
        wide = {name: _near(joint, 0.0) for name, joint in robot.joints.items() if name not in between | set(default)}
    exact: dict[str, LockValue] = {}
    for name, value in lock.items():
        if name in robot.joints or name in robot.fixed:
            exact[name] = value
        elif name == GRIPPERS:
            wide |= {found: _placed(robot.joints[found], value) for found in gripper_joints(robot)}
        elif any(sign in name for sign in "*?["):
            wide |= dict.fromkeys(_matching(robot, name), value)
        else:
            exact[name] = value
    held = {name for name, value in ({**default, **wide, **exact}).items() if value is not None and value != "free"}
    follows = {name for name, joint in robot.joints.items() if joint.mimic is not None and joint.mimic.joint in held}
    return {name: value for name, value in wide.items() if name not in follows or value == "free"} | exact


def gripper_joints(robot: Robot) -> list[str]:
    """Joints of grippers: what is named like a part of one, or mimics and is mimicked, with nothing else beyond.

    Raises:
        ParameterError: There is none, or nothing else moves.
    """
    coupled = {joint.mimic.joint for joint in robot.joints.values() if joint.mimic is not None}
    looks = {
        name
        for name, joint in robot.joints.items()
        if joint.mimic is not None or name in coupled or _FINGER.search(name) or _FINGER.search(joint.child)
    }
    # A joint that carries another one which is no part of a gripper is none itself.
    carries = {above for name in robot.joints if name not in looks for above in _above(robot, robot.joints[name].child)}
    found = [name for name in robot.joints if name in looks and name not in carries]
    if not found or len(found) == len(robot.joints):
        what = "no joint looks like a gripper's" if not found else "all its joints look like a gripper's"
        raise ParameterError("lock", f"'{GRIPPERS}': {what} in {robot.path.name}; {_known(robot)}")
    return found


def longest_chain(robot: Robot) -> tuple[str, str]:
    """The base and the link with most moving joints above it: an example of a chain."""
    tip = max(robot.links, key=lambda link: len(_above(robot, link)))
    base = next(link for link in robot.links if link not in robot.carried)
    return base, tip


def _matching(robot: Robot, pattern: str) -> list[str]:
    found = [name for name in robot.joints if fnmatchcase(name, pattern)]
    if not found:
        fixed = any(fnmatchcase(name, pattern) for name in robot.fixed)
        why = "matches fixed joints only" if fixed else "matches no joint"
        raise ParameterError("lock", f"'{printable(pattern)}' {why} of {robot.path.name}; {_known(robot)}")
    return found


def _known(robot: Robot) -> str:
    names = list(robot.joints)
    more = f" and {len(names) - 12} more" if len(names) > 12 else ""
    return f"its moving joints are {', '.join(names[:12])}{more}"


def _placed(joint: Joint, value: LockValue) -> LockValue:
    """A value that is meant for several joints, within the range of one of them."""
    return _near(joint, float(value)) if isinstance(value, int | float) else value


def _near(joint: Joint, value: float) -> float:
    return float(np.clip(value, joint.lower, joint.upper))


def _above(robot: Robot, link: str) -> list[str]:
    """The moving joints between the base and a link, the link's own first."""
    found = []
    while link in robot.carried:
        joint, link = robot.carried[link]
        if joint in robot.joints:
            found.append(joint)
    return found


def _between(robot: Robot, chain: tuple[str, str]) -> set[str]:
    base, tip = chain
    for link in chain:
        if link not in robot.links:
            raise ParameterError("chain", _no_link(robot, link))
    found: list[str] = []
    link = tip
    while link != base:
        if link not in robot.carried and tip in _links_above(robot, base):
            raise ParameterError(
                "chain", f"link '{tip}' carries link '{base}', not the other way round: {chain_words(tip, base)}"
            )
        if link not in robot.carried:
            above = ", ".join(_links_above(robot, tip)[:8])
            raise ParameterError(
                "chain",
                f"link '{tip}' does not hang on link '{base}'; from '{tip}' to the base there are {above}: one of them "
                f"begins a chain, as in {chain_words(link, tip)}",
            )
        joint, link = robot.carried[link]
        found.append(joint)
    moving = {name for name in found if name in robot.joints}
    if not moving:
        raise ParameterError(
            "chain", f"no joint moves between link '{base}' and link '{tip}'; name links further apart"
        )
    return moving


def _links_above(robot: Robot, link: str) -> list[str]:
    found = []
    while link in robot.carried:
        _, link = robot.carried[link]
        found.append(link)
    return found


def _no_link(robot: Robot, name: str) -> str:
    given = printable(name)
    if name in robot.joints:
        return f"'{given}' is a joint; a chain is between two links: its own is '{robot.joints[name].child}'"
    return f"no link '{given}' in {robot.path.name}; {nearest(name, robot.links)}"
