"""The rigid bodies that move: a joint's link with all that fixed and locked joints fasten to it, judged as a whole.

What stands still, such as the root and all that is fixed to it, is not judged: it takes no part in the dynamics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array
from asmc_pin.arms.urdf.rigid_inertia import TENSOR_REMEDY, LinkInertia, mass_problem, size_problem, tensor_problem
from asmc_pin.arms.urdf.urdf_reading import JOINT_PREFIX, Joint, Robot
from asmc_pin.rigid_body.coupling import Coupling
from asmc_pin.words.interface import flag_words
from asmc_pin.words.text import printable


@dataclass(frozen=True, eq=False)
class MovingBody:
    """What moves with one joint, up to the next ones.

    Attributes:
        joint: The joint that carries it.
        links: Its links, the joint's own child first.
        poses: Of each link in the joint's frame, shape (n, 4, 4), m.
        mass: kg.
        com: Centre of mass in the joint's frame, shape (3,), m.
        inertia: About that centre, in the joint's axes, shape (3, 3), kg·m².
    """

    joint: Joint
    links: tuple[str, ...]
    poses: Array
    mass: float
    com: Array
    inertia: Array


def moving_bodies(robot: Robot, model: pin.Model) -> list[MovingBody]:
    """The bodies of a model, in the order of its joints.

    Args:
        robot: The URDF.
        model: Of it; locked joints are merged already.
    """
    frames: list[list[pin.Frame]] = [[] for _ in range(model.njoints)]
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            frames[frame.parentJoint].append(frame)
    found = []
    for index in range(1, model.njoints):
        body = model.inertias[index]
        found.append(
            MovingBody(
                joint=robot.joints[model.names[index].removeprefix(JOINT_PREFIX)],
                links=tuple(frame.name for frame in frames[index]),
                poses=np.array([frame.placement.homogeneous for frame in frames[index]]),
                mass=float(body.mass),
                com=np.array(body.lever),
                inertia=np.array(body.inertia),
            )
        )
    return found


def body_problems(robot: Robot, body: MovingBody, led_mass: float) -> list[str]:
    """All that makes a body impossible, each with its place; a tensor's only where nothing is wrong with the numbers.

    Args:
        robot: The URDF.
        body: One of its bodies.
        led_mass: kg, of all that follows the same coordinate: where a mimicking joint has some, others need none.
    """
    problems = number_problems(robot, body)
    if problems:
        return problems
    if not body.mass > 0.0:
        return [] if led_mass > 0.0 else [_without_mass(body)]
    if not np.all(np.isfinite(body.inertia)):
        return [f"{body.joint.where}: what it carries has an inertia beyond all numbers; correct masses and origins"]
    return [_impossible(robot, body)] if tensor_problem(body.mass, body.inertia) else []


def number_problems(robot: Robot, body: MovingBody) -> list[str]:
    """Masses and entries of a body's links that are wrong by themselves, whatever they are fixed to."""
    found = ((own.where, mass_problem(own.mass) or size_problem(own.written)) for own in _written(robot, body))
    return [f"{place}: {problem}" for place, problem in found if problem]


def problems_of_bodies(robot: Robot, bodies: Sequence[MovingBody], coupling: Coupling) -> tuple[list[str], str]:
    """What bodies cannot be for.

    Args:
        robot: The URDF.
        bodies: What moves of it.
        coupling: Which coordinate each of them follows.

    Returns:
        A sentence for each, with links or joints, their lines, and what is wrong; and how to mend tensors, if any.
    """
    masses = np.array([body.mass for body in bodies])
    led = [float(masses[coupling.coordinate == coordinate].sum()) for coordinate in coupling.coordinate]
    found = [(body, body_problems(robot, body, mass)) for body, mass in zip(bodies, led, strict=True)]
    bare = [body for body, problems in found if problems and not body.mass > 0.0 and not number_problems(robot, body)]
    # Where all of a robot's links lack it, one sentence for each would say the same six times.
    together = len(bare) > 1
    problems = [each for body, own in found for each in own if not (together and body in bare)]
    problems += [_all_without_mass(robot, bare)] if together else []
    tensors = any(
        body.mass > 0.0 and not number_problems(robot, body) and tensor_problem(body.mass, body.inertia)
        for body in bodies
        if np.all(np.isfinite(body.inertia))
    )
    repair = f"{flag_words('repair')} takes the nearest that is possible, and says by how much it differs"
    return problems, f"{TENSOR_REMEDY}; {repair}" if tensors else ""


def impossible_link(robot: Robot, body: MovingBody) -> str:
    """The link of an impossible body whose own tensor is furthest from a possible one's.

    Sums of possible bodies are possible, so there is always one.
    """

    def least(link: str) -> float:
        moments = np.linalg.eigvalsh(robot.inertials[link].written)
        return float(0.5 * moments.sum() - moments[2])

    return min((link for link in body.links if link in robot.inertials), key=least)


def _written(robot: Robot, body: MovingBody) -> list[LinkInertia]:
    return [robot.inertials[link] for link in body.links if link in robot.inertials]


def _impossible(robot: Robot, body: MovingBody) -> str:
    worst = impossible_link(robot, body)
    own = robot.inertials[worst]
    others = [link for link in body.links if link != worst and link in robot.inertials]
    said = f"{own.where}: {tensor_problem(own.mass, own.written) or tensor_problem(body.mass, body.inertia)}"
    if others:
        moments = ", ".join(f"{moment:.6g}" for moment in np.linalg.eigvalsh(body.inertia))
        said += f"; nor does what moves together with it ({_some(others)}) make it possible: {moments} kg·m²"
    return said


def _without_mass(body: MovingBody) -> str:
    first, *others = body.links
    return (
        f"{body.joint.where}: moves link '{first}', which carries no inertia"
        + (f", nor does anything fixed to it ({_some(others)})" if others else "")
        + f"; add <inertial> with a mass above zero to link '{first}', or lock the joint; or have it estimated "
        "from its shapes and a mass: --estimate-inertia KG (estimate_inertia= in Python)"
    )


def _all_without_mass(robot: Robot, bodies: Sequence[MovingBody]) -> str:
    file = f" in {printable(robot.path.name)}"
    who = [f"'{body.links[0]}' (on {body.joint.where.replace(file, '')})" for body in bodies[:8]]
    more = f" and {len(bodies) - 8} more" if len(bodies) > 8 else ""
    return (
        f"{len(bodies)} moving links{file} carry no inertia, nor does anything fixed to them: {', '.join(who)}{more}; "
        "add <inertial> with a mass above zero to each, or lock the joints; or have it estimated from their shapes and "
        "a mass: --estimate-inertia KG (estimate_inertia= in Python)"
    )


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
