"""What an arm carries in all: the payload that it was loaded with, and the one that its log adds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, Payload
from asmc_pin.errors import ParameterError
from asmc_pin.identification.estimates import Estimate, around
from asmc_pin.identification.identification_report import Identification
from asmc_pin.words.text import quoted

_LEAST = 1e-6  # kg; less is nothing


@dataclass(frozen=True)
class MeasuredLoad:
    """A payload with intervals, on the link that the last joint moves.

    Attributes:
        mass: kg.
        com: Centre of mass in the link's frame, m; None where it is that frame's origin.
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre, kg·m²; None of a point.
        link: The link.
    """

    mass: Estimate
    com: tuple[Estimate, Estimate, Estimate] | None
    inertia: tuple[float, ...] | None
    link: str

    def payload(self) -> Payload:
        """At its values."""
        com = (0.0, 0.0, 0.0) if self.com is None else tuple(each.value for each in self.com)
        return Payload(self.mass.value, com, self.inertia or (0.0,) * 6, self.link)  # type: ignore[arg-type]


def measured_load(found: Identification) -> MeasuredLoad | None:
    """The payload in all, with intervals of 95 %; None where no payload was estimated, or all of it is below nothing.

    Raises:
        ParameterError: The arm was loaded with a payload that another joint carries: no arm has two.
    """
    added = found.parameters.get("payload.mass")
    if added is None or found.fit is None:
        return None
    link, own = link_of_last_joint(found.arm), found.arm.payload
    fit, model = found.fit, found.fit.model
    own_mass, own_moment, own_inertia = (0.0, np.zeros(3), np.zeros((3, 3))) if own is None else _of(found.arm, own)
    mass = added.value + own_mass
    if mass <= _LEAST:
        return None
    places = [model.index(f"payload.moment.{axis}") for axis in "xyz"]
    moment = fit.values[places]
    com = None
    if own is not None or any(f"payload.com.{axis}" in found.parameters for axis in "xyz"):
        # An axis that the log cannot tell has no spread: it stands where the fit had it, at no moment.
        centre = (own_moment + moment) / mass
        at = model.index("payload.mass")
        com = tuple(
            around(float(x), _spread(fit.covariance, place, at, float(x), mass))
            for x, place in zip(centre, places, strict=True)
        )
    return MeasuredLoad(
        Estimate(max(added.low + own_mass, 0.0), mass, added.high + own_mass),
        com,  # type: ignore[arg-type]
        None if own is None else _about_the_centre(own_inertia, added.value, moment, mass, own_moment + moment),
        link,
    )


def link_of_last_joint(arm: Arm) -> str:
    """The link that the last joint moves: in its frame the centre of mass stands."""
    last = arm.model.njoints - 1
    frames = [frame for frame in arm.model.frames if frame.parentJoint == last and frame.name in arm.link_names]
    return next(str(frame.name) for frame in frames if np.allclose(frame.placement.homogeneous, np.eye(4)))


def measured_arm(found: Identification) -> tuple[Arm, list[str]]:
    """The arm with payload and armature at their estimates, and what of them it cannot have, a sentence each."""
    load, told = measured_load(found), []
    mass = found.parameters.get("payload.mass")
    if load is None and mass is not None:
        told.append(
            f"the log asks for a payload of {mass.value:.3g} kg, and no arm carries less than nothing: M(q) is that "
            "of the URDF's masses"
        )
    armature = measured_armature(found)
    changes: dict[str, object] = {"armature": [each.value for each in armature]}
    if load is not None:
        changes["payload"] = load.payload()
    return found.arm.replace(**changes), told  # type: ignore[arg-type]


def measured_armature(found: Identification) -> list[Estimate]:
    """Armature of each joint in all, kg·m²: what the arm was loaded with, and what the log adds."""
    nothing = Estimate(0.0, 0.0, 0.0)
    added = [found.parameters.get(f"armature.{name}", nothing) for name in found.arm.joint_names]
    return [
        Estimate(*(float(own) + max(end, 0.0) for end in (each.low, each.value, each.high)))
        for own, each in zip(found.arm.armature, added, strict=True)
    ]


def estimated(parameters: Mapping[str, Estimate], kind: str) -> bool:
    """Whether a quantity of the joints was estimated of any."""
    return any(name.startswith(f"{kind}.") for name in parameters)


def _of(arm: Arm, own: Payload) -> tuple[float, Array, Array]:
    """Mass, moment and inertia of a payload about the last joint's frame."""
    frame = next(each for each in arm.model.frames if each.name == own.link)
    if frame.parentJoint != arm.model.njoints - 1:
        raise ParameterError(
            "payload",
            f"the arm was loaded with one on {quoted(str(own.link))}, which the last joint does not carry, and the "
            "log's stands on the last link; no arm has two. Put it into the URDF, or hold it with --fix payload",
        )
    turn, place = np.asarray(frame.placement.rotation), np.asarray(frame.placement.translation)
    centre = turn @ np.asarray(own.com) + place
    about = turn @ own.inertia_matrix @ turn.T + own.mass * _of_a_point(centre)
    return own.mass, own.mass * centre, about


def _of_a_point(place: Array) -> Array:
    return np.asarray(place @ place * np.eye(3) - np.outer(place, place))


def _about_the_centre(own: Array, added: float, moment: Array, mass: float, whole: Array) -> tuple[float, ...]:
    point = _of_a_point(moment) / added if abs(added) > _LEAST else np.zeros((3, 3))
    about = own + point - _of_a_point(whole) / mass
    return tuple(float(about[i, j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


def _spread(covariance: Array, moment: int, mass: int, centre: float, total: float) -> float:
    slope = np.array([1.0, -centre]) / total
    both = covariance[np.ix_([moment, mass], [moment, mass])]
    return float(slope @ both @ slope)
