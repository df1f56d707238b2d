"""The joint box that a statement speaks of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.arms.urdf.magnitudes import LIMIT
from asmc_pin.condition.hypotheses import WHOLE_TURN
from asmc_pin.errors import ParameterError
from asmc_pin.words.text import quoted
from asmc_pin.words.units import check_range

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

BoxLike: TypeAlias = Mapping[str, Sequence[float]] | tuple[Array, Array] | None
"""{joint: (lo, hi)}, the other joints keeping the arm's own range; or (lower, upper), each (nv,); or the arm's own."""

FULL_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Box:
    """A joint box, each revolute range cut to one turn.

    Attributes:
        lower: Shape (nv,), rad (m where prismatic).
        upper: The same.
        periodic: Joints whose range is a full turn, so that its ends are the same configuration; none whose followers
            would be elsewhere.
        idle: Joints that M does not depend on: those on the base, which move all that hangs on them as a whole.
    """

    lower: Array
    upper: Array
    periodic: BoolArray
    idle: BoolArray

    @property
    def free(self) -> BoolArray:
        """Joints that a search has to vary, shape (nv,)."""
        return ~self.idle & (self.upper > self.lower)

    @property
    def centre(self) -> Array:
        """The middle of the box, shape (nv,)."""
        return 0.5 * (self.lower + self.upper)

    def of(self, joints: IntArray) -> Box:
        """The box of some of the joints."""
        return Box(self.lower[joints], self.upper[joints], self.periodic[joints], self.idle[joints])

    def wrap(self, q: Array) -> Array:
        """The configuration of the box that is q up to whole turns of periodic joints; others are clipped."""
        turned = self.lower + np.mod(q - self.lower, FULL_TURN)
        return np.clip(np.where(self.periodic, turned, q), self.lower, self.upper)


def idle_note(arm: Arm, box: Box) -> str:
    """What to say of the joints that M does not depend on; empty where there is none."""
    names = [quoted(name) for name, idle in zip(arm.joint_names, box.idle, strict=True) if idle]
    if not names:
        return ""
    if len(names) == 1:
        return f"M(q) does not depend on joint {names[0]}, which carries the whole arm"
    return f"M(q) does not depend on joints {', '.join(names)}: each hangs on the base and moves its branch as a whole"


def asked_box(arm: Arm, box: BoxLike) -> BoxLike:
    """The box that somebody asks about, as it was given.

    Raises:
        ParameterError: As of `resolve_box`, or its angles look like degrees.
    """
    if box is not None:
        resolve_box(arm, box)
        check_range("box", arm, *(box if isinstance(box, tuple) else _named(arm, box)))
    return box


def resolve_box(arm: Arm, box: BoxLike = None) -> Box:
    """The box of a statement about an arm.

    Args:
        arm: The arm; joints that are not named keep its own range (continuous and undeclared revolute: one turn).
        box: See `BoxLike`.

    Returns:
        The box, each revolute range cut to one turn around its middle.

    Raises:
        ParameterError: Unknown joint, not two finite numbers, numbers too large to compute with, or an empty range.
        ArmError: A prismatic joint has no declared range and none is given.
    """
    kinds = np.array([kind == "revolute" for kind in arm.joint_kinds], dtype=np.bool_)
    if isinstance(box, tuple):
        lower, upper = (np.array(end, dtype=np.float64) for end in box)
        if lower.shape != (arm.nv,) or upper.shape != (arm.nv,):
            raise ParameterError("box", f"ends of shapes {lower.shape}, {upper.shape} given, ({arm.nv},) expected")
    else:
        lower, upper = _named(arm, box or {})
    for name, lo, hi in zip(arm.joint_names, lower, upper, strict=True):
        if not (np.isfinite(lo) and np.isfinite(hi)):
            raise ParameterError("box", f"the range {lo:g}:{hi:g} of joint '{name}' is not finite")
        if lo > hi:
            raise ParameterError(
                "box", f"the range {lo:g}:{hi:g} of joint '{name}' is empty: lower end above upper end"
            )
        if max(-lo, hi) > LIMIT:
            raise ParameterError(
                "box", f"the range {lo:g}:{hi:g} given for joint '{name}', ends within ±{LIMIT:g} expected"
            )
    periodic = kinds & (upper - lower >= WHOLE_TURN) & arm.returns
    middle = 0.5 * (lower + upper)
    lower = np.where(periodic, middle - np.pi, lower)
    upper = np.where(periodic, middle + np.pi, upper)
    coordinate = arm.tree.coupling.coordinate
    idle = np.array([bool(np.all(arm.tree.parent[coordinate == i] < 0)) for i in range(arm.nv)], dtype=np.bool_)
    return Box(lower, upper, periodic, idle)


def _named(arm: Arm, box: Mapping[str, Sequence[float]]) -> tuple[Array, Array]:
    if not isinstance(box, Mapping):
        raise ParameterError("box", f"{box!r} given, joint to (lower, upper) expected, as a dictionary")
    given: dict[int, tuple[float, float]] = {}
    for joint, ends in box.items():
        if joint not in arm.joint_names:
            raise ParameterError(
                "box", f"'{joint}' is not a joint of {arm.name}; its joints: {', '.join(arm.joint_names)}"
            )
        try:
            lo, hi = (float(end) for end in ends)
        except (TypeError, ValueError):
            raise ParameterError("box", f"{ends!r} given for joint '{joint}', (lower, upper) expected") from None
        if not (np.isfinite(lo) and np.isfinite(hi)):
            raise ParameterError("box", f"the range {lo:g}:{hi:g} of joint '{joint}' is not finite")
        given[arm.joint_names.index(joint)] = (lo, hi)
    lower, upper = arm.lower.copy(), arm.upper.copy()
    for i, (lo, hi) in given.items():
        lower[i], upper[i] = lo, hi
    # With the given ranges in place of the limits, the arm only complains of a prismatic joint that has neither.
    return replace(arm, lower=lower, upper=upper).box
