"""How joints of a URDF follow others, from its decimals: value = ratio · coordinate + offset, composed along the way.

A certificate names the joints that have a coordinate, and all that move. What follows what is read from the URDF alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, ctx

from asmc_pin.condition.checker.reading.urdf_text import Description, Unreadable
from asmc_pin.words.text import printable

_BITS = 512
_LARGEST = 1e6
"""Of a ratio or its inverse: beyond it one of the two joints hardly moves."""


@dataclass(frozen=True, eq=False)
class Following:
    """All joints that move, and the coordinate that each follows; a joint with one of its own with ratio 1.

    Attributes:
        joints: Names of the joints that have a coordinate.
        moving: Names of all that move.
        coordinate: Number of the coordinate of each of `moving`.
        ratio: By how much each follows it, in balls.
        offset: And from where, rad (m), in balls.
    """

    joints: tuple[str, ...]
    moving: tuple[str, ...]
    coordinate: tuple[int, ...]
    ratio: tuple[arb, ...]
    offset: tuple[arb, ...]

    @property
    def follows(self) -> bool:
        """Whether any joint follows another."""
        return len(self.moving) > len(self.joints)

    @property
    def leader(self) -> tuple[int, ...]:
        """Where in `moving` the joint of each coordinate stands."""
        return tuple(self.moving.index(name) for name in self.joints)

    def mimics(self) -> dict[str, tuple[str, float, float]]:
        """Each follower with what it follows, ratio and offset as the nearest floats."""
        rows = zip(self.moving, self.coordinate, self.ratio, self.offset, strict=True)
        own = set(self.joints)
        return {
            name: (self.joints[c], float(ratio.mid()), float(offset.mid()))
            for name, c, ratio, offset in rows
            if name not in own
        }


def following(robot: Description, joints: Sequence[str], moving: Sequence[str]) -> Following:
    """Read what follows what.

    Args:
        robot: The robot.
        joints: Names of the joints with a coordinate.
        moving: Names of all that move, base first; empty where none follows another.

    Returns:
        The joints and what they follow.

    Raises:
        Unreadable: A joint neither has a coordinate nor follows one that has, or one that has follows another.
    """
    moving = tuple(moving) or tuple(joints)
    written = {joint.name: joint for below in robot.children.values() for joint in below}
    number = {name: i for i, name in enumerate(joints)}
    if not set(number) <= set(moving):
        raise Unreadable("a joint with a coordinate is not among those that move")
    coordinates, ratios, offsets = [], [], []
    with ctx.workprec(_BITS):
        for name in moving:
            at, ratio, offset, way = name, arb(1), arb(0), {name}
            while at not in number:
                joint = written.get(at)
                if joint is None or joint.mimic is None or at not in moving:
                    raise Unreadable(f"joint '{printable(at)}' has no coordinate and follows no joint that has one")
                offset += ratio * arb(joint.mimic.offset)
                ratio *= arb(joint.mimic.multiplier)
                at = joint.mimic.joint
                if at in way:
                    raise Unreadable(f"joint '{printable(name)}' of the URDF follows others in a ring")
                way.add(at)
            joint = written.get(at)
            if joint is not None and joint.mimic is not None:
                raise Unreadable(f"joint '{printable(at)}' of the URDF follows another joint")
            if not 1.0 / _LARGEST <= abs(float(ratio.mid())) <= _LARGEST:
                raise Unreadable(f"joint '{printable(name)}' of the URDF follows another by a ratio not read here")
            coordinates.append(number[at])
            ratios.append(ratio)
            offsets.append(offset)
    return Following(tuple(joints), moving, tuple(coordinates), tuple(ratios), tuple(offsets))
